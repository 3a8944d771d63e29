"""An analysis as tables for a terminal."""

from __future__ import annotations

from collections.abc import Iterator

from rich.box import SIMPLE_HEAD
from rich.table import Table

from synthesis.design.analysis import Analysis, Peak, Remedy

WIDTH = 110  # what the widest table needs


def tables(found: Analysis) -> Iterator[Table]:
    """Limits, curves, jumps, and what would mend the cam: those that have something to say."""
    yield _limits(found)
    yield _curves(found)
    if found.jumps:
        yield _jumps(found)
    if found.remedy is not None:
        yield _mend(found.remedy)


def headline(found: Analysis) -> str:
    """The answer in one line."""
    sizes = ", ".join(f"{name} {value:.4f}" for name, value in found.dimensions.items())
    verdict = "every limit holds" if found.holds else f"violated: {', '.join(found.violated)}"
    return f"{verdict}; {sizes}"


def undercut(found: Analysis) -> str:
    """Undercut or cusp in one line."""
    worst = found.undercut
    if worst is None:
        return "No undercut."
    flank = f" of the {worst.flank} flank" if worst.flank else ""
    return (
        f"{worst.kind.capitalize()}{flank} at {worst.angle_deg:.4f}°: the pitch curve's radius is "
        f"{worst.pitch_radius_mm:.4f} mm, the roller's {worst.roller_radius_mm:.4f} mm."
    )


def self_crossing(found: Analysis) -> str:
    """Far parts of the profile that cross, in one line."""
    worst = found.self_crossing
    if worst is None:
        return "The profile does not cross itself."
    which = worst.flank or "profile"
    return (
        f"The {which} crosses itself: at {worst.roller_deg:.4f}° the roller cuts "
        f"{worst.depth_mm:.4f} mm deep into the profile of {worst.profile_deg:.4f}°."
    )


def headed(title: str, *columns: str) -> Table:
    """An empty table, its first column to the left and numbers to the right."""
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD)
    for i, column in enumerate(columns):
        table.add_column(column, justify="left" if i == 0 else "right", no_wrap=True)
    return table


def _limits(found: Analysis) -> Table:
    table = headed("Limits", "limit", "value", "unit", "at °", "allowed", "margin", "")
    for e in found.extremes:
        table.add_row(
            e.limit, number(e.value), e.unit, f"{e.angle_deg:.3f}", number(e.bound),
            number(e.margin), "holds" if e.holds else "BROKEN",
        )  # fmt: skip
    return table


def _curves(found: Analysis) -> Table:
    table = headed("Curves", "curve", "over", "unit", "largest", "at °", "smallest", "at °")
    for c in found.curves:
        table.add_row(c.curve, c.over, c.unit, *_peak(c.largest), *_peak(c.smallest))
    return table


def _peak(peak: Peak | None) -> tuple[str, str]:
    if peak is None:
        return "–", "–"
    sides = {"left": "−", "right": "+", "both": ""}
    return number(peak.value), f"{peak.angle_deg:.3f}{sides[peak.side]}"


def _jumps(found: Analysis) -> Table:
    table = headed("Jumps", "curve", "at °", "unit", "before", "after", "jump")
    for j in found.jumps:
        values = (number(value) for value in (j.before, j.after, j.jump))
        table.add_row(j.curve, f"{j.angle_deg:.3f}", j.unit, *values)
    return table


def _mend(mend: Remedy) -> Table:
    table = headed("What would mend it", "change", "to", "by", "unit")
    for size in mend.sizes:
        name = f"base radius, follower's place {size.offset}"
        if not size.dimensions:
            table.add_row(name, "no size helps", "", "")
            continue
        table.add_row(
            name, number(size.dimensions["base_radius_mm"]),
            number(size.base_radius_change_mm), "mm",
        )  # fmt: skip
        for each, by in size.changes.items():
            plain, _, unit = each.rpartition("_")
            value = number(size.dimensions[each])
            table.add_row(f"  with {plain.replace('_', ' ')}", value, number(by), unit)
    for alone in mend.relaxations:
        if alone.needed is not None:
            change = number(alone.needed - alone.requested)
            table.add_row(f"{alone.field} alone", number(alone.needed), change, alone.unit)
    return table


def number(value: float | None) -> str:
    """A value to six digits, a dash where there is none."""
    return "–" if value is None else f"{value:.6g}"
