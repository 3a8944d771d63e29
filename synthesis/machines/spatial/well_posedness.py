"""Checks that a spec with free dimensions or laws has a best cam, for every machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import atan

from pydantic_core import PydanticCustomError

from synthesis.catalogue.limits import Limit
from synthesis.catalogue.ranges import ends
from synthesis.machines.spatial.limits import SpatialPressureAngle
from synthesis.machines.spatial.machine import SpatialMachine
from synthesis.machines.spatial.roller import crown_slope
from synthesis.units import DEGREE


def check_well_posed(machine: SpatialMachine, limits: Sequence[Limit], free_laws: bool) -> None:
    """Refuse a spec whose minimum does not exist or is not bounded away from zero.

    Args:
        machine, limits: as in the spec. free_laws: whether some law is left free.

    Raises:
        PydanticCustomError: the machine is not sized, nothing bounds the cam from below, rollers
            may vanish, or crowned rollers break the limit on the pressure angle even at rest.
    """
    ranges = {name: ends(given) for name, given in machine.sizes().items()}
    free = [name for name, (low, high) in ranges.items() if low != high]
    keeps_large = any(limit.bounds_size_below for limit in limits)
    if not free and not free_laws:
        return
    if not machine.can_be_sized:
        raise PydanticCustomError(
            "machine_in_full",
            "A {kind} of this form can be measured but not sized yet, and {what} is left free. "
            "Give the number, or name the law.",
            {"kind": machine.kind, "what": free[0] if free else "a law"},
        )
    if (free_laws or machine.size_field in free) and not keeps_large:
        raise PydanticCustomError(
            "nothing_keeps_large",
            "{what} is left free, and no limit bounds the size of the cam from below. Add a limit "
            "on pressure_angle, or give the number or the law.",
            {"what": machine.size_field if machine.size_field in free else "A law"},
        )
    _check_rollers(machine, ranges)
    _check_crown(machine, limits, ranges)


def _check_rollers(machine: SpatialMachine, ranges: Mapping[str, tuple[float, float]]) -> None:
    """Refuse rollers whose radius, or radius and inner end together, may go to zero."""
    open_below = [name for name in ranges if name != machine.size_field and ranges[name][0] <= 0.0]
    if machine.inner_end_field in open_below and machine.radius_field in open_below:
        raise PydanticCustomError(
            "rollers_vanish",
            "{place} and {radius} are both left free without a min: the cam becomes smaller "
            "without end as the rollers become smaller and move towards the turret's axis. Give "
            "one of them a number or a min.",
            {"place": machine.inner_end_field, "radius": machine.radius_field},
        )
    crowned = machine.swept_roller(dict.fromkeys(ranges, 1.0), 1).roller.crown > 0.0
    if machine.radius_field in open_below and crowned:
        raise PydanticCustomError(
            "rollers_vanish",
            "{radius} of crowned rollers is left free without a min: below a certain radius the "
            "crown meets the roller's axis before its ends. Give it a number or a min.",
            {"radius": machine.radius_field},
        )


def _check_crown(
    machine: SpatialMachine,
    limits: Sequence[Limit],
    ranges: Mapping[str, tuple[float, float]],
) -> None:
    """Refuse a limit on the pressure angle that a crown's ends break even at rest."""
    sizes = {name: low if low > 0.0 else 1.0 for name, (low, _) in ranges.items()}
    slope = crown_slope(machine.swept_roller(sizes, 1).roller)
    for position, limit in enumerate(limits):
        if isinstance(limit, SpatialPressureAngle) and slope >= limit.max_slope:
            raise PydanticCustomError(
                "crown_leans",
                "limits/{position} allows a pressure angle of at most {bound}°, but at the ends of "
                "the crowned rollers it is larger even at rest. Increase crown_radius_mm, reduce "
                "roller_width_mm, or raise the limit.",
                {"position": position, "bound": float(f"{atan(limit.max_slope) / DEGREE:.9g}")},
            )
