"""Answers as they are printed: lines and tables, those that have something to say.

Lengths stand in mm; `display.in_inches` converts what is printed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from service.commands.display import Cell, Table
from synthesis.design.warnings import labelled_status

if TYPE_CHECKING:
    from synthesis.certify.second import Confirmation
    from synthesis.design.analysis import Analysis, Peak, Remedy, Sensitivities
    from synthesis.design.cam_set import CamSet
    from synthesis.design.design import Design, ForcePeak, Forces
    from synthesis.design.warnings import DesignWarning
    from synthesis.machines.dynamics import TrainResponse
    from synthesis.machines.spatial.design import SpatialDesign
    from synthesis.studies.measured import ProfileAnalysis

VERDICTS = {
    "confirmed": "every line of the certificate agrees",
    "contradicted": "the certificate is wrong in what is marked NO",
    "incomplete": "what could be measured agrees; lines marked – could not be",
}


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[Cell]]) -> Table:
    """A table of these rows."""
    return Table(title, columns, list(rows))


def sizes(dimensions: Mapping[str, float]) -> str:
    """Dimensions in one line."""
    return ", ".join(f"{name} {value:.4f}" for name, value in dimensions.items())


def describe_analysis(analysis: Analysis) -> Iterator[str | Table]:
    """The verdict, undercut, crossings, limits, curves, jumps, and what would mend the cam."""
    verdict = "every limit holds" if analysis.holds else f"violated: {', '.join(analysis.violated)}"
    yield f"{labelled_status(verdict, analysis.severity)}; {sizes(analysis.dimensions)}"
    yield from _warnings(analysis.warnings)
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
    yield table(
        "Limits", ("limit", "value", "unit", "at °", "allowed", "margin", ""),
        [(e.limit, e.value, e.unit, f"{e.angle_deg:.3f}", e.bound, e.margin,
          "holds" if e.holds else "BROKEN") for e in analysis.extremes],
    )  # fmt: skip
    yield table(
        "Curves", ("curve", "over", "unit", "largest", "at °", "smallest", "at °"),
        [(c.curve, c.over, c.unit, *_peak(c.largest), *_peak(c.smallest)) for c in analysis.curves],
    )  # fmt: skip
    if analysis.jumps:
        yield table(
            "Jumps", ("curve", "at °", "unit", "before", "after", "jump"),
            [(j.curve, f"{j.angle_deg:.3f}", j.unit, j.before, j.after, j.jump)
             for j in analysis.jumps],
        )  # fmt: skip
    if analysis.remedy is not None:
        columns = ("change", "to", "by", "unit")
        yield table("What would mend it", columns, _remedies(analysis.remedy))


def _peak(peak: Peak | None) -> tuple[Cell, Cell]:
    if peak is None:
        return None, None
    sides = {"left": "−", "right": "+", "both": ""}
    return peak.value, f"{peak.angle_deg:.3f}{sides[peak.side]}"


def _remedies(remedy: Remedy) -> Iterator[tuple[Cell, ...]]:
    for size in remedy.sizes:
        name = f"base radius, follower's place {size.offset}"
        if not size.dimensions:
            yield name, "no size helps", "", ""
            continue
        yield name, size.dimensions["base_radius_mm"], size.base_radius_change_mm, "mm"
        for each, by in size.changes.items():
            plain, _, unit = each.rpartition("_")
            yield f"  with {plain.replace('_', ' ')}", size.dimensions[each], by, unit
    for alone in remedy.relaxations:
        if alone.needed is not None:
            change = alone.needed - alone.requested
            yield f"{alone.field} alone", alone.needed, change, alone.unit


def describe_confirmation(confirmation: Confirmation) -> Iterator[str | Table]:
    """The verdict; line by line the value to 25 digits, the certificate's distance from it."""
    verdict = confirmation.verdict
    yield f"{verdict}: {VERDICTS[verdict]} ({confirmation.bits} bits)"
    words = {True: "yes", False: "NO", None: "–"}
    yield table(
        "Certificate", ("limit", "value", "unit", "certificate less value", "holds", "agrees"),
        [(line.limit, line.value, line.unit,
          None if line.difference is None else f"{-line.difference:.1e}",
          words[line.holds], words[line.agrees]) for line in confirmation.lines],
    )  # fmt: skip


def describe_profile(analysis: ProfileAnalysis) -> Iterator[str | Table]:
    """What was read from a profile: scatter, extremes, dwells, what the follower cannot reach."""
    fit = analysis.fit
    yield (
        f"{fit.points} points, scatter {1e3 * fit.rms_mm:.3g} µm rms and "
        f"{1e3 * fit.largest_mm:.3g} µm at most; {sizes(analysis.dimensions)}"
    )
    yield table(
        "Motion", ("curve", "unit", "largest", "at °", "smallest", "at °", "hidden by tolerance"),
        [(p.curve, p.unit, p.largest, f"{p.largest_deg:.2f}", p.smallest,
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
            "Not touched",
            ("at °", "hollow radius mm", "roller radius mm", "gap mm", "x mm", "y mm"),
            [(f"{n.angle_deg:.3f}", n.hollow_radius_mm, n.roller_radius_mm, n.gap_mm,
              f"{n.x_mm:.4f}", f"{n.y_mm:.4f}") for n in analysis.unreached_hollows],
        )  # fmt: skip
    if analysis.contact_off_face:
        yield table(
            "Off the face", ("side", "from °", "to °", "beyond mm", "at °"),
            [(o.side, f"{o.from_deg:.2f}", f"{o.to_deg:.2f}", o.excess_mm,
              f"{o.worst_deg:.2f}") for o in analysis.contact_off_face],
        )  # fmt: skip


def describe_spatial_cam(design: SpatialDesign) -> Iterator[str | Table]:
    """Status, broken limits, dimensions, walls, and what was measured of them."""
    broken = ", ".join(each.quantity for each in design.extremes if not each.holds)
    status = labelled_status(design.status, design.severity)
    yield f"{status}{f', violated: {broken}' if broken else ''}; {sizes(design.dimensions)}"
    yield from _warnings(design.warnings)
    yield table(
        "Walls", ("wall", "from °", "to °"),
        [(wall.name, f"{arc.start_deg:.3f}", f"{arc.end_deg:.3f}")
         for wall in design.walls for arc in wall.arcs],
    )  # fmt: skip
    yield table(
        "Measured",
        ("quantity", "value", "unit", "at °", "wall", "rho mm", "allowed", "margin", ""),
        [(e.quantity, e.value, e.unit, None if e.angle_deg is None else f"{e.angle_deg:.3f}",
          f"{e.roller}{e.side}" if e.side else None, e.rho_mm, e.bound, e.margin,
          "" if e.bound is None else "holds" if e.holds else "BROKEN")
         for e in design.extremes],
    )  # fmt: skip


def describe_response(response: TrainResponse) -> Iterator[str | Table]:
    """The modes of a follower train, its periodic response by speed, and where it floats."""
    modes = (f"{m.natural_frequency_hz:.4g} Hz (ζ {m.damping_ratio:.3g})" for m in response.modes)
    yield f"Modes: {', '.join(modes)}"
    yield table(
        "Periodic response",
        ("rpm", "output error mm", "left in dwells mm", "contact force N", ""),
        [(f"{each.speed_rpm:g}",
          f"{each.output_error_min.value:.4g} to {each.output_error_max.value:.4g}",
          ", ".join(f"{dwell.amplitude:.3g}" for dwell in each.dwells),
          f"{each.contact_force_min_n.value:.4g} to {each.contact_force_max_n.value:.4g}",
          "FLOATS" if each.floats else "") for each in response.speeds],
    )  # fmt: skip
    if response.float_onset_rpm is not None:
        yield f"Contact is lost from {response.float_onset_rpm:.4g} rpm on."


def describe_linkage(result: Any, quantities: Mapping[str, float]) -> Iterator[str]:
    """The status and quantities of a linkage; what conflicts, a line each."""
    yield ", ".join([result.status, *(f"{name} {value:.6g}" for name, value in quantities.items())])
    conflict = getattr(result, "conflict", None)
    for each in [] if conflict is None else conflict.relaxations:
        if each.needed is not None:
            needed = f"{each.needed:.6g} {each.unit} needed"
            yield f"  {each.limit}: {each.requested:g} requested, {needed}"
    for pose in getattr(result, "poses", []):
        if not pose.reachable:
            yield f"  {pose.name or 'pose'}: {pose.note}"


def describe_sensitivities(result: Sensitivities) -> Iterator[str]:
    """What each limit costs, what is not confirmed, and where it is from."""
    yield from (each.sentence for each in result.sensitivities)
    yield from (f"{pointer}: not confirmed" for pointer in result.unconfirmed)
    yield f"Evidence: {result.evidence}."


def describe_cam_set(cams: CamSet) -> Iterator[str]:
    """The status of a set, then cam by cam."""
    status = labelled_status(cams.status, cams.severity)
    yield f"{status}, {1e3 * cams.seconds:.0f} ms: {len(cams.cams)} cams on one shaft"
    for cam in cams.cams:
        dimensions = sizes(cam.design.dimensions)
        status = labelled_status(cam.design.status, cam.design.severity)
        yield (
            f"  {cam.name}: {status}, phase {cam.phase_deg:g}°, keyway at "
            f"{cam.keyway_deg:g}°{': ' if dimensions else ''}{dimensions}"
        )


def describe_design(design: Design, seconds: float) -> Iterator[str | Table]:
    """Status, warnings, sizes, forces, the free parameters as they were chosen, the summary."""
    gap = "" if design.certificate.gap is None else f", gap {100.0 * design.certificate.gap:.2f} %"
    status = labelled_status(design.status, design.severity)
    yield f"{status}{gap}, {1e3 * seconds:.0f} ms: {sizes(design.dimensions)}"
    yield from _warnings(design.warnings)
    yield from design.assumptions
    if design.forces is not None:
        yield from _forces(design.forces)
    if design.free_parameters:
        values = (f"{name} {value:.6g}" for name, value in design.free_parameters.items())
        yield f"Chosen: {', '.join(values)}"
    yield from _summary(design)


def _summary(design: Design) -> Iterator[Table]:
    """Peaks, coefficients beside those of the usual law, and the cam as a body."""
    from synthesis.exporters.drawing.summary_table import (
        coefficient_table,
        derivatives,
        geometry_figures,
    )

    if design.motion_summary is not None:
        yield table(
            "Motion", ("", "unit", "largest", "at °", "smallest", "at °", "rms", "jumps"),
            [(name, each.unit, each.largest.value, f"{each.largest.angle_deg:.3f}",
              each.smallest.value, f"{each.smallest.angle_deg:.3f}",
              "infinite" if each.rms is None else each.rms, str(each.jumps))
             for name, each in derivatives(design, design.motion_summary)],
        )  # fmt: skip
        coefficients = coefficient_table(design, design.motion_summary)
        yield table(coefficients.title, coefficients.head, coefficients.rows)
    if design.geometry is not None:
        yield table(
            "Geometry", ("", "value", "unit", "at °"),
            [(each.name, each.value, each.unit,
              None if each.angle_deg is None else f"{each.angle_deg:.3f}")
             for each in geometry_figures(design.geometry)],
        )  # fmt: skip


def _warnings(warnings: Iterable[DesignWarning]) -> Iterator[str]:
    """A line for each, the most severe first."""
    for one in warnings:
        word = one.severity.upper() if one.severity == "stop" else one.severity
        yield f"  {word} ({one.code}, {one.field}): {one.sentence} {one.remedy}"


def _forces(forces: Forces) -> Iterator[str]:
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
