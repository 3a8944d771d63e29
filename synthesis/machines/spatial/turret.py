"""What turrets of indexing cams share: fields, positions of the rollers, and checks."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.ranges import Dimension, ends
from synthesis.machines.spatial.machine import Seat, six_digits
from synthesis.units import DEGREE, FULL_TURN

WHOLE = 1e-9  # of a spacing: rounding of a sum of lifts that is a whole number of rollers

Rollers = Annotated[int, Field(ge=3, le=64, description="Rollers on the turret.")]
Hand = Annotated[Literal["left", "right"], Field(description="Hand of the cam's thread.")]
DwellOn = Annotated[
    Literal["rib", "groove"],
    Field(
        description="What lies on the common perpendicular while the turret dwells: a rib "
        "between two rollers, or a groove with one roller in it."
    ),
]
MeshAngle = Annotated[
    float | None,
    Field(
        gt=0.0,
        le=90.0,
        description="Largest angle from the common perpendicular at which a roller meshes with "
        "the cam; left out: 1.5 roller spacings, at most 90°.",
    ),
]


def spacing(rollers: int) -> float:
    """Angle from roller to roller [rad]."""
    return FULL_TURN / rollers


def thread_sign(hand: Literal["left", "right"]) -> int:
    """χ of a cam whose thread has this hand: +1 where it turns about its axis e, −1 about −e.

    e points the way the rollers move as q grows. A right-hand screw that turns about its axis and
    is fixed along it moves its nut backwards, so that rollers moving along e need a cam that turns
    about −e. Whether that is seen as ccw or cw depends on the side one looks from.
    """
    return -1 if hand == "right" else 1


def seats(rollers: int, dwell_on: Literal["rib", "groove"]) -> tuple[Seat, ...]:
    """All rollers of a turret, each one spacing behind the one before."""
    first = 0.5 * spacing(rollers) if dwell_on == "rib" else 0.0
    return tuple(Seat(i + 1, first - i * spacing(rollers)) for i in range(rollers))


def check_overlap(rollers: int, inner: Dimension, radius: Dimension) -> None:
    """Refuse radial rollers that overlap even with their least radius at the largest inner end.

    Raises:
        PydanticCustomError: two neighbours reach the plane midway between them.
    """
    largest, least = ends(inner)[1], ends(radius)[0]
    allowed = largest * math.tan(0.5 * spacing(rollers))
    if least >= allowed:
        raise PydanticCustomError(
            "rollers_overlap",
            "{rollers} rollers of radius {radius} mm overlap on their turret: at roller_inner_mm = "
            "{inner} the radius must be below {allowed} mm. Reduce roller_radius_mm or rollers, or "
            "increase roller_inner_mm.",
            {
                "radius": least,
                "rollers": rollers,
                "inner": largest,
                "allowed": six_digits(allowed),
            },
        )


def gap(rollers: int, inner: float, radius: float) -> float:
    """Distance between two neighbouring radial rollers at their inner ends [mm]."""
    half = 0.5 * spacing(rollers)
    return 2.0 * (inner * math.sin(half) - radius * math.cos(half))


def mesh_range(rollers: int, mesh_angle_deg: float | None) -> tuple[float, float]:
    """Positions between which rollers mesh with the cam [rad]; the angle as in ``MeshAngle``."""
    if mesh_angle_deg is None:
        most = min(1.5 * spacing(rollers), 0.5 * math.pi)
    else:
        most = mesh_angle_deg * DEGREE
    return -most, most


def check_index(gain: float, rollers: int) -> None:
    """Refuse a gain in one turn [rad] that is zero or no whole number of roller spacings.

    Raises:
        PydanticCustomError: in the next turn no roller would stand where one stood in this turn.
    """
    steps = gain / spacing(rollers)
    if round(steps) == 0 or abs(steps - round(steps)) > WHOLE:
        raise PydanticCustomError(
            "index_not_whole",
            "The program turns the turret by {gain}° in one turn of the cam, which is {rollers} "
            "times the {spacing}° between two of {count} rollers. Make the lifts of the "
            "program sum to a whole number of spacings other than 0.",
            {
                "gain": float(f"{gain / DEGREE:.9g}"),
                "rollers": float(f"{steps:.9g}"),
                "spacing": float(f"{spacing(rollers) / DEGREE:.9g}"),
                "count": rollers,
            },
        )
