"""Answers as lines and tables on a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.table import Table

if TYPE_CHECKING:
    from synthesis.certify.second import Confirmation
    from synthesis.design.analysis import Analysis, Peak, Remedy
    from synthesis.design.design import ForcePeak, Forces
    from synthesis.machines.dynamics import TrainResponse
    from synthesis.machines.spatial.design import SpatialDesign
    from synthesis.studies.measured import ProfileAnalysis

VERDICTS = {
    "confirmed": "every line of the certificate agrees",
    "contradicted": "the certificate is wrong in what is marked NO",
    "incomplete": "what could be measured agrees; lines marked – could not be",
}


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """A table, its first column to the left and the others, of numbers, to the right."""
    drawn = Table(title=title, title_justify="left", box=SIMPLE_HEAD)
    for i, column in enumerate(columns):
        drawn.add_column(column, justify="left" if i == 0 else "right", no_wrap=True)
    for row in rows:
        drawn.add_row(*row)
    return drawn


def number(value: float | None) -> str:
    """A value to six digits, a dash where there is none."""
    return "–" if value is None else f"{value:.6g}"


def sizes(dimensions: Mapping[str, float]) -> str:
    """Dimensions in one line."""
    return ", ".join(f"{name} {value:.4f}" for name, value in dimensions.items())


def analysis_lines(analysis: Analysis) -> Iterator[str]:
    """The verdict, then undercut or cusp, then far parts of the profile that cross."""
    verdict = "every limit holds" if analysis.holds else f"violated: {', '.join(analysis.violated)}"
    yield f"{verdict}; {sizes(analysis.dimensions)}"
    undercut, crossing = analysis.undercut, analysis.self_crossing
    if undercut is None:
        yield "No undercut."
    else:
        flank = f" of the {undercut.flank} flank" if undercut.flank else ""
        yield (
            f"{undercut.kind.capitalize()}{flank} at {undercut.angle_deg:.4f}°: the pitch curve's "
            f"radius is {undercut.pitch_radius_mm:.4f} mm, the roller's "
            f"{undercut.roller_radius_mm:.4f} mm."
        )
    if crossing is None:
        yield "The profile does not cross itself."
    else:
        yield (
            f"The {crossing.flank or 'profile'} crosses itself: at {crossing.roller_deg:.4f}° the "
            f"roller cuts {crossing.depth_mm:.4f} mm deep into the profile of "
            f"{crossing.profile_deg:.4f}°."
        )


def analysis_tables(analysis: Analysis) -> Iterator[Table]:
    """Limits, curves, jumps, and what would mend the cam: those that have something to say."""
    yield table(
        "Limits", ("limit", "value", "unit", "at °", "allowed", "margin", ""),
        [(e.limit, number(e.value), e.unit, f"{e.angle_deg:.3f}", number(e.bound),
          number(e.margin), "holds" if e.holds else "BROKEN") for e in analysis.extremes],
    )  # fmt: skip
    yield table(
        "Curves", ("curve", "over", "unit", "largest", "at °", "smallest", "at °"),
        [(c.curve, c.over, c.unit, *_peak(c.largest), *_peak(c.smallest)) for c in analysis.curves],
    )  # fmt: skip
    if analysis.jumps:
        yield table(
            "Jumps", ("curve", "at °", "unit", "before", "after", "jump"),
            [(j.curve, f"{j.angle_deg:.3f}", j.unit, number(j.before), number(j.after),
              number(j.jump)) for j in analysis.jumps],
        )  # fmt: skip
    if analysis.remedy is not None:
        columns = ("change", "to", "by", "unit")
        yield table("What would mend it", columns, _remedies(analysis.remedy))


def _peak(peak: Peak | None) -> tuple[str, str]:
    if peak is None:
        return "–", "–"
    sides = {"left": "−", "right": "+", "both": ""}
    return number(peak.value), f"{peak.angle_deg:.3f}{sides[peak.side]}"


def _remedies(remedy: Remedy) -> Iterator[tuple[str, ...]]:
    for size in remedy.sizes:
        name = f"base radius, follower's place {size.offset}"
        if not size.dimensions:
            yield name, "no size helps", "", ""
            continue
        radius = number(size.dimensions["base_radius_mm"])
        yield name, radius, number(size.base_radius_change_mm), "mm"
        for each, by in size.changes.items():
            plain, _, unit = each.rpartition("_")
            value = number(size.dimensions[each])
            yield f"  with {plain.replace('_', ' ')}", value, number(by), unit
    for alone in remedy.relaxations:
        if alone.needed is not None:
            change = number(alone.needed - alone.requested)
            yield f"{alone.field} alone", number(alone.needed), change, alone.unit


def confirmation_line(confirmation: Confirmation) -> str:
    """The verdict in one line."""
    return f"{confirmation.verdict}: {VERDICTS[confirmation.verdict]} ({confirmation.bits} bits)"


def confirmation_table(confirmation: Confirmation) -> Table:
    """Line by line: value to 25 digits, how far the certificate is from it, whether it agrees."""
    words = {True: "yes", False: "NO", None: "–"}
    return table(
        "Certificate", ("limit", "value", "unit", "certificate less value", "holds", "agrees"),
        [(line.limit, line.value or "–", line.unit,
          "–" if line.difference is None else f"{-line.difference:.1e}",
          words[line.holds], words[line.agrees]) for line in confirmation.lines],
    )  # fmt: skip


def profile_line(analysis: ProfileAnalysis) -> str:
    """What was read from a profile, in one line."""
    fit = analysis.fit
    return (
        f"{fit.points} points, scatter {1e3 * fit.rms_mm:.3g} µm rms and "
        f"{1e3 * fit.largest_mm:.3g} µm at most; {sizes(analysis.dimensions)}"
    )


def profile_tables(analysis: ProfileAnalysis) -> Iterator[Table]:
    """Extremes, dwells, and what the follower does not reach: those that have something to say."""
    yield table(
        "Motion", ("curve", "unit", "largest", "at °", "smallest", "at °", "hidden by tolerance"),
        [(p.curve, p.unit, number(p.largest), f"{p.largest_deg:.2f}", number(p.smallest),
          f"{p.smallest_deg:.2f}", "–" if p.error is None else f"±{p.error:.3g}")
         for p in analysis.peaks],
    )  # fmt: skip
    if analysis.dwells:
        yield table(
            "Dwells", ("from °", "over °", f"at {analysis.spline.unit}"),
            [(f"{d.start_deg:.1f}", f"{d.angle_deg:.1f}", f"{d.s:.4f}") for d in analysis.dwells],
        )  # fmt: skip
    if analysis.unreached_hollows:
        yield table(
            "Not touched", ("at °", "hollow radius", "roller radius", "gap mm", "x mm", "y mm"),
            [(f"{n.angle_deg:.3f}", number(n.hollow_radius_mm), number(n.roller_radius_mm),
              number(n.gap_mm), f"{n.x_mm:.4f}", f"{n.y_mm:.4f}")
             for n in analysis.unreached_hollows],
        )  # fmt: skip
    if analysis.contact_off_face:
        yield table(
            "Off the face", ("side", "from °", "to °", "beyond mm", "at °"),
            [(o.side, f"{o.from_deg:.2f}", f"{o.to_deg:.2f}", number(o.excess_mm),
              f"{o.worst_deg:.2f}") for o in analysis.contact_off_face],
        )  # fmt: skip


def spatial_line(design: SpatialDesign) -> str:
    """The status of a spatial cam, its broken limits and its dimensions."""
    broken = ", ".join(each.quantity for each in design.extremes if not each.holds)
    verdict = f"{design.status}, violated: {broken}" if broken else design.status
    return f"{verdict}; {sizes(design.dimensions)}"


def spatial_tables(design: SpatialDesign) -> Iterator[Table]:
    """Walls, and what was measured of them."""
    yield table(
        "Walls", ("wall", "from °", "to °"),
        [(wall.name, f"{arc.start_deg:.3f}", f"{arc.end_deg:.3f}")
         for wall in design.walls for arc in wall.arcs],
    )  # fmt: skip
    columns = ("quantity", "value", "unit", "at °", "wall", "rho mm", "allowed", "margin", "")
    yield table(
        "Measured", columns,
        [(e.quantity, number(e.value), e.unit,
          "–" if e.angle_deg is None else f"{e.angle_deg:.3f}",
          f"{e.roller}{e.side}" if e.side else "–", number(e.rho_mm), number(e.bound),
          number(e.margin), "" if e.bound is None else "holds" if e.holds else "BROKEN")
         for e in design.extremes],
    )  # fmt: skip


def response_table(response: TrainResponse) -> Table:
    """The periodic response of a follower train, speed by speed."""
    return table(
        "Periodic response",
        ("rpm", "output error mm", "left in dwells mm", "contact force N", ""),
        [(f"{each.speed_rpm:g}",
          f"{each.output_error_min.value:.4g} to {each.output_error_max.value:.4g}",
          ", ".join(f"{dwell.amplitude:.3g}" for dwell in each.dwells),
          f"{each.contact_force_min_n.value:.4g} to {each.contact_force_max_n.value:.4g}",
          "FLOATS" if each.floats else "") for each in response.speeds],
    )  # fmt: skip


def force_lines(forces: Forces) -> Iterator[str]:
    """Flank by flank, then the shaft, float and rollers."""
    for each in forces.flanks:
        name = f" {each.flank}" if each.flank else ""
        line = (
            f"contact force{name} {_force(each.smallest_n, 'N')} to {_force(each.largest_n, 'N')}"
        )
        if each.largest_pressure_mpa is not None:
            line += f", Hertz pressure {_force(each.largest_pressure_mpa, 'MPa')}"
        yield line
    torque = forces.torque
    yield (
        f"torque {_force(torque.smallest_n_m, 'N m')} to {_force(torque.largest_n_m, 'N m')}, "
        f"mean {torque.mean_n_m:.4g}, rms {torque.rms_n_m:.4g} N m, {torque.power_w:.4g} W"
    )
    for arc in forces.floats:
        yield f"floats from {arc.start_deg:.5g}° to {arc.end_deg:.5g}°: {arc.lowest_n:.4g} N"
    if forces.float_onset_rpm is not None:
        yield f"floats from {forces.float_onset_rpm:.6g} rpm on"
    if forces.changes_flank_deg:
        angles = ", ".join(f"{angle:.5g}°" for angle in forces.changes_flank_deg)
        yield f"changes flank at {angles}"
    for roller in forces.rollers:
        name = f" {roller.path}" if roller.path else ""
        life = "" if roller.life_hours is None else f", L10 {roller.life_hours:.4g} h"
        yield f"roller{name} {roller.mean_speed_rpm:.4g} rpm in the mean{life}"


def _force(peak: ForcePeak | None, unit: str) -> str:
    return "without end" if peak is None else f"{peak.value:.4g} {unit} at {peak.angle_deg:.5g}°"
