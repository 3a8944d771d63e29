"""What may be left free of a spatial cam: rules that hold for every machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import atan

from pydantic_core import PydanticCustomError

from synthesis.limits import Limit
from synthesis.ranges import ends
from synthesis.spatial.leverage import steepest
from synthesis.spatial.machine import SpatialMachine
from synthesis.units import DEGREE


def check_free(machine: SpatialMachine, limits: Sequence[Limit], laws: bool) -> None:
    """Refuse a question that has no best answer.

    Args:
        laws: whether some law is left free.

    Raises:
        PydanticCustomError: nothing keeps the cam large, or its rollers from vanishing.
    """
    ranges = {name: ends(given) for name, given in machine.sizes().items()}
    free = [name for name, (low, high) in ranges.items() if low != high]
    keeps_large = any(limit.keeps_large for limit in limits)
    if not free and not laws:
        return
    if not machine.sizable:
        raise PydanticCustomError(
            "machine_in_full",
            "Such a {kind} is measured, and not sized yet: {what} is left free. Give the number, "
            "or name the law.",
            {"kind": machine.kind, "what": free[0] if free else "a law"},
        )
    if (laws or machine.sought in free) and not keeps_large:
        raise PydanticCustomError(
            "nothing_keeps_large",
            "{what} is left free, and no limit keeps the cam large. Add a limit on pressure_angle, "
            "or give the number or the law.",
            {"what": machine.sought if machine.sought in free else "A law"},
        )
    _check_rollers(machine, ranges)
    _check_crown(machine, limits, ranges)


def _check_rollers(machine: SpatialMachine, ranges: Mapping[str, tuple[float, float]]) -> None:
    """Rollers that may be as small as one likes, and as near to the turret's axis."""
    open_below = [name for name in ranges if name != machine.sought and ranges[name][0] <= 0.0]
    if machine.place_field in open_below and machine.roller_field in open_below:
        raise PydanticCustomError(
            "rollers_vanish",
            "{place} and {radius} are both left free without a least value: the smaller the "
            "rollers and the nearer to the turret's axis, the smaller the cam. Give one of them a "
            "number or a min.",
            {"place": machine.place_field, "radius": machine.roller_field},
        )
    crowned = machine.swept(dict.fromkeys(ranges, 1.0), 1).roller.crown > 0.0
    if machine.roller_field in open_below and crowned:
        raise PydanticCustomError(
            "rollers_vanish",
            "{radius} of crowned rollers is left free without a least value. Give it a number or "
            "a min: smaller ones come to a point at their ends.",
            {"radius": machine.roller_field},
        )


def _check_crown(
    machine: SpatialMachine,
    limits: Sequence[Limit],
    ranges: Mapping[str, tuple[float, float]],
) -> None:
    """A crowned roller leans at its ends, even where the follower rests."""
    sizes = {name: low if low > 0.0 else 1.0 for name, (low, _) in ranges.items()}
    lean = steepest(machine.swept(sizes, 1).roller)
    for position, limit in enumerate(limits):
        if lean >= limit.steepest:
            raise PydanticCustomError(
                "crown_leans",
                "limits/{position} asks for a pressure angle of {bound}° at most, but at the ends "
                "of rollers so crowned the walls lean more than that even at rest. Make "
                "crown_radius_mm larger, the rollers narrower, or the limit wider.",
                {"position": position, "bound": float(f"{atan(limit.steepest) / DEGREE:.9g}")},
            )
