"""A profile read back, as tables for a terminal."""

from __future__ import annotations

from collections.abc import Iterator

from rich.box import SIMPLE_HEAD
from rich.table import Table

from synthesis.studies.measured import ProfileAnalysis


def tables(found: ProfileAnalysis) -> Iterator[Table]:
    """Extremes, dwells, and what the follower does not reach: those that have something to say."""
    yield _table(
        "Motion", ("curve", "unit", "largest", "at °", "smallest", "at °", "hidden by tolerance"),
        [(p.curve, p.unit, _number(p.largest), f"{p.largest_deg:.2f}", _number(p.smallest),
          f"{p.smallest_deg:.2f}", "–" if p.error is None else f"±{p.error:.3g}")
         for p in found.peaks],
    )  # fmt: skip
    if found.dwells:
        yield _table(
            "Dwells", ("from °", "over °", f"at {found.spline.unit}"),
            [(f"{d.start_deg:.1f}", f"{d.angle_deg:.1f}", f"{d.s:.4f}") for d in found.dwells],
        )  # fmt: skip
    if found.unreached_hollows:
        yield _table(
            "Not touched", ("at °", "hollow radius", "roller radius", "gap mm", "x mm", "y mm"),
            [(f"{n.angle_deg:.3f}", "–" if n.hollow_radius_mm is None else
              _number(n.hollow_radius_mm), _number(n.roller_radius_mm), _number(n.gap_mm),
              f"{n.x_mm:.4f}", f"{n.y_mm:.4f}") for n in found.unreached_hollows],
        )  # fmt: skip
    if found.contact_off_face:
        yield _table(
            "Off the face", ("side", "from °", "to °", "beyond mm", "at °"),
            [(o.side, f"{o.from_deg:.2f}", f"{o.to_deg:.2f}", _number(o.excess_mm),
              f"{o.worst_deg:.2f}") for o in found.contact_off_face],
        )  # fmt: skip


def headline(found: ProfileAnalysis) -> str:
    """What was read, in one line."""
    sizes = ", ".join(f"{name} {value:.4f}" for name, value in found.dimensions.items())
    fit = found.fit
    return (
        f"{fit.points} points, scatter {1e3 * fit.rms_mm:.3g} µm rms and "
        f"{1e3 * fit.largest_mm:.3g} µm at most; {sizes}"
    )


def _table(title: str, columns: tuple[str, ...], rows: list[tuple[str, ...]]) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD)
    for i, column in enumerate(columns):
        table.add_column(column, justify="left" if i == 0 else "right", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    return table


def _number(value: float) -> str:
    return f"{value:.6g}"
