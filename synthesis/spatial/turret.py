"""What turrets of indexing cams share: where their rollers stand, and by how much they go on."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.ranges import Dimension, ends
from synthesis.spatial.machine import Seat
from synthesis.units import DEGREE, FULL_TURN

WHOLE = 1e-9  # of a spacing: a gain that is a whole number of rollers

Rollers = Annotated[int, Field(ge=3, le=64, description="Rollers on the turret.")]
Hand = Annotated[Literal["left", "right"], Field(description="Hand of the cam's thread.")]
DwellOn = Annotated[
    Literal["rib", "groove"],
    Field(
        description="What lies on the common perpendicular while the turret rests: a rib "
        "between two rollers, or a groove with one roller in it."
    ),
]
MeshAngle = Annotated[
    float | None,
    Field(
        gt=0.0,
        le=90.0,
        description="A roller meets the cam up to so far from the common perpendicular; left "
        "out: from where one that rests beside it gets to within one index.",
    ),
]


def spacing(rollers: int) -> float:
    """Angle from roller to roller [rad]."""
    return FULL_TURN / rollers


def thread(hand: Literal["left", "right"]) -> int:
    """χ of a cam with a thread of this hand, its axis e along the way of rollers as q grows.

    A screw with a right-hand thread that turns about its axis, and may not move along it, sends
    its nut the other way: rollers that move along e ask for a cam that turns about −e. Which way
    it is seen to turn, ccw or cw, is a matter of the side one looks from.
    """
    return -1 if hand == "right" else 1


def seats(rollers: int, dwell_on: Literal["rib", "groove"]) -> tuple[Seat, ...]:
    """All rollers of a turret, each behind the one before."""
    first = 0.5 * spacing(rollers) if dwell_on == "rib" else 0.0
    return tuple(Seat(i + 1, first - i * spacing(rollers)) for i in range(rollers))


def check_room(rollers: int, inner: Dimension, radius: Dimension) -> None:
    """Refuse radial rollers that overlap on their turret, even the smallest ones, farthest out.

    Raises:
        PydanticCustomError: two neighbours meet in the plane between them.
    """
    largest, least = ends(inner)[1], ends(radius)[0]
    room = largest * math.tan(0.5 * spacing(rollers))
    if least >= room:
        raise PydanticCustomError(
            "rollers_overlap",
            "Rollers of {radius} mm overlap on a turret of {rollers}: at roller_inner_mm = {inner} "
            "there is room for {room} mm. Make the rollers thinner or fewer, or roller_inner_mm "
            "larger.",
            {"radius": least, "rollers": rollers, "inner": largest, "room": float(f"{room:.6g}")},
        )


def gap(rollers: int, inner: float, radius: float) -> float:
    """What is between two neighbouring radial rollers, at their inner ends [mm]."""
    half = 0.5 * spacing(rollers)
    return 2.0 * (inner * math.sin(half) - radius * math.cos(half))


def mesh(rollers: int, asked: float | None) -> tuple[float, float]:
    """Places between which rollers meet the cam [rad], of the angle asked for [deg]."""
    most = min(1.5 * spacing(rollers), 0.5 * math.pi) if asked is None else asked * DEGREE
    return -most, most


def check_index(gain: float, rollers: int) -> None:
    """Refuse an index by ``gain`` [rad] that is no whole number of rollers, or none.

    Raises:
        PydanticCustomError: the next turn would find its rollers elsewhere.
    """
    steps = gain / spacing(rollers)
    if round(steps) == 0 or abs(steps - round(steps)) > WHOLE:
        raise PydanticCustomError(
            "index_not_whole",
            "The program turns the turret by {gain}° in a turn of the cam, which is {rollers} "
            "times the {spacing}° between two of {count} rollers. Make the lifts of the "
            "program sum to a whole number of these, and not to none.",
            {
                "gain": float(f"{gain / DEGREE:.9g}"),
                "rollers": float(f"{steps:.9g}"),
                "spacing": float(f"{spacing(rollers) / DEGREE:.9g}"),
                "count": rollers,
            },
        )
