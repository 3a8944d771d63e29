"""Forces of a design in a few lines."""

from __future__ import annotations

from collections.abc import Iterator

from synthesis.catalogue.forces.report import ForcePeak, Forces


def force_lines(forces: Forces) -> Iterator[str]:
    """Flank by flank, then the shaft, float and rollers."""
    for each in forces.flanks:
        name = f" {each.flank}" if each.flank else ""
        parts = [
            f"contact force{name} {_peak(each.smallest_n, 'N')} to {_peak(each.largest_n, 'N')}"
        ]
        if each.largest_pressure_mpa is not None:
            parts.append(f"Hertz pressure {_peak(each.largest_pressure_mpa, 'MPa')}")
        yield ", ".join(parts)
    torque = forces.torque
    yield (
        f"torque {_peak(torque.smallest_n_m, 'N m')} to {_peak(torque.largest_n_m, 'N m')}, "
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


def _peak(peak: ForcePeak | None, unit: str) -> str:
    return "without end" if peak is None else f"{peak.value:.4g} {unit} at {peak.angle_deg:.5g}°"
