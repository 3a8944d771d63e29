"""What machines around cylindrical cams share: the frame, rules, and rollers astride a rib.

The frame has its origin on the cam's axis, which is z; x is along the roller's axis and ρ the
distance along it from the cam's. The follower moves towards growing z with growing q.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.geometry.swept_roller import Joint, Pivot, SweptRoller
from synthesis.numerics.piecewise import Array
from synthesis.ranges import Dimension, Range, ends
from synthesis.spatial import roller
from synthesis.spatial.machine import LEFT, RIGHT, Seat
from synthesis.units import Travel

RETURNED = 1e-9  # mm or deg: what a follower that ends where it began may be away from there
EVERYWHERE = (-math.inf, math.inf)
X, Y, Z = np.eye(3)

RollerDistance = Annotated[
    float | None,
    Field(
        gt=0.0,
        le=1e6,
        description="Distance between the axes of two rollers astride a rib; left out: one "
        "roller in a groove.",
    ),
]
Sizes = Mapping[str, float]


def swept(
    sizes: Sizes, joint: Joint, origin: Array, width: float, crown: float | None, hand: int
) -> SweptRoller:
    """The machine with its dimensions settled; the cam's axis points along z.

    Args:
        sizes: ``cylinder_radius_mm`` and ``roller_radius_mm``.
        joint, origin: what the follower moves on, and its roller's place at q = 0.
        width: of the roller, up to the cylinder [mm]. crown: of its outline [mm].
        hand: +1 where the cam turns about z as θ grows, −1 about −z.
    """
    inner = sizes["cylinder_radius_mm"] - width
    kept = roller.of(sizes["roller_radius_mm"], inner, width, crown)
    return SweptRoller(0.0 * X, Z, joint, origin, X, kept, hand)


def cylinder(sizes: Sizes, width: float) -> tuple[float, float]:
    """Radii of the grooves' floor and of the cylinder [mm]."""
    return sizes["cylinder_radius_mm"] - width, sizes["cylinder_radius_mm"]


def arm(length: float, distance: float) -> tuple[Pivot, Array]:
    """A pivot across the cam's axis, ``distance`` away, and where its roller is at q = 0 [mm].

    There the arm stands square to the cam's axis.
    """
    return Pivot(distance * Y, -X), (distance - length) * Y


def beside(sizes: Sizes, width: float) -> float:
    """How far beside the cam's axis a roller's axis may pass to reach into the cylinder [mm]."""
    floor, top = cylinder(sizes, width)
    return math.sqrt(max(top**2 - floor**2, 0.0))


def check_beside(
    arm_mm: float, distance: float, angles: Sequence[float], cylinder: Dimension, width: float
) -> None:
    """Refuse a roller whose axis passes beside the cylinder.

    Args:
        arm_mm, distance: roller to pivot, and pivot to the cam's axis [mm].
        angles: of the arm, least and largest [rad].

    Raises:
        PydanticCustomError: even the largest cylinder is not met all along.
    """
    largest = ends(cylinder)[1]
    if math.isinf(largest):
        return
    least, most = min(angles), max(angles)
    nearest = min(max(0.0, least), most)
    room = beside({"cylinder_radius_mm": largest}, width)
    away = max((distance - arm_mm * math.cos(at) for at in (least, nearest, most)), key=abs)
    if abs(away) >= room:
        raise PydanticCustomError(
            "roller_beside_cylinder",
            "The roller's axis passes {away} mm beside the cam's, but a roller {width} mm wide "
            "reaches into a cylinder of radius {radius} mm only within {room} mm. Change how far "
            "the arm's pivot or the turret is from the cam's axis, or make the cylinder larger.",
            {
                "away": figure(abs(away)),
                "width": width,
                "radius": largest,
                "room": figure(room),
            },
        )


def seats(rest: float, apart: float | None) -> tuple[Seat, ...]:
    """One roller in a groove, or two ``apart`` with a rib between them [rad or mm]."""
    if apart is None:
        return (Seat(1, rest),)
    return Seat(1, rest + 0.5 * apart, (LEFT,)), Seat(2, rest - 0.5 * apart, (RIGHT,))


def figure(value: float) -> float:
    """A number as messages tell it."""
    return float(f"{value:.6g}")


def check_return(gain: float, travel: Travel) -> None:
    """Refuse a follower that goes on by ``gain`` [mm or rad] in a turn.

    Raises:
        PydanticCustomError: it does not end where it began.
    """
    rest = gain / travel.per_unit
    if abs(rest) > RETURNED:
        raise PydanticCustomError(
            "program_lift",
            "The follower ends {rest} {unit} away from where it began. "
            "Make the lifts of rises and returns sum to zero.",
            {"rest": float(f"{rest:.9g}"), "unit": travel.unit},
        )


def check_moves(lowest: float, highest: float) -> None:
    """Refuse a follower that stands still all the turn.

    Raises:
        PydanticCustomError: it does.
    """
    if lowest == highest:
        raise PydanticCustomError(
            "program_still",
            "The follower never moves: program holds no rise and no return. Add both.",
            {},
        )


def check_room(cylinder: Dimension, width: float) -> None:
    """Refuse a roller that reaches to the cam's axis.

    Raises:
        PydanticCustomError: it is as wide as the largest cylinder.
    """
    largest = ends(cylinder)[1]
    if width >= largest:
        raise PydanticCustomError(
            "roller_reaches_axis",
            "A roller of roller_width_mm = {width} reaches through a cylinder of radius {radius} "
            "mm to its axis. Make the cylinder larger, or the roller narrower.",
            {"width": width, "radius": largest},
        )


def check_rib(distance: float | None, radius: float | Range | None) -> None:
    """Refuse two rollers that leave no rib between them.

    Raises:
        PydanticCustomError: they touch each other, even the smallest ones allowed.
    """
    smallest = ends(radius)[0]
    if distance is not None and distance <= 2.0 * smallest:
        raise PydanticCustomError(
            "rollers_touch",
            "Rollers of {radius} mm whose axes are {distance} mm apart leave no rib between them. "
            "Make roller_distance_mm larger than twice the rollers' radius.",
            {"radius": smallest, "distance": distance},
        )
