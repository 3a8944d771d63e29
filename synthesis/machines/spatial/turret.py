"""TurretMachine: what machines with an indexing turret share; positions of the turret's rollers."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.machines.spatial.machine import Seat, SpatialMachine
from synthesis.units import DEGREE, FULL_TURN, Travel

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


class TurretMachine(SpatialMachine, ABC):
    """A turret that is indexed by a whole number of its rollers in each turn of the cam."""

    travel: ClassVar[Travel] = Travel("deg", DEGREE)
    period: ClassVar[float] = FULL_TURN

    if TYPE_CHECKING:  # declared by each machine at its place in the order of fields
        rollers: Rollers
        hand: Hand
        dwell_on: DwellOn
        mesh_angle_deg: MeshAngle

    @property
    def spacing(self) -> float:
        """Angle from roller to roller [rad]."""
        return FULL_TURN / self.rollers

    @property
    def thread_sign(self) -> int:
        """χ of the cam: +1 where it turns about its axis e, −1 about −e.

        e points the way the rollers move as q grows. A right-hand screw that turns about its axis
        and is fixed along it moves its nut backwards, so that rollers moving along e need a cam
        that turns about −e. Whether that is seen as ccw or cw depends on the side one looks from.
        """
        return -1 if self.hand == "right" else 1

    def seats(self) -> tuple[Seat, ...]:
        """All rollers of the turret, each one spacing behind the one before."""
        first = 0.5 * self.spacing if self.dwell_on == "rib" else 0.0
        return tuple(Seat(i + 1, first - i * self.spacing) for i in range(self.rollers))

    def mesh_range(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        if self.mesh_angle_deg is None:
            most = min(1.5 * self.spacing, 0.5 * math.pi)
        else:
            most = self.mesh_angle_deg * DEGREE
        return -most, most

    def check_gain(self, gain: float) -> None:
        steps = gain / self.spacing
        if round(steps) == 0 or abs(steps - round(steps)) > WHOLE:
            raise PydanticCustomError(
                "index_not_whole",
                "The program turns the turret by {gain}° in one turn of the cam, which is "
                "{rollers} times the {spacing}° between two of {count} rollers. Make the lifts of "
                "the program sum to a whole number of spacings other than 0.",
                {
                    "gain": float(f"{gain / DEGREE:.9g}"),
                    "rollers": float(f"{steps:.9g}"),
                    "spacing": float(f"{self.spacing / DEGREE:.9g}"),
                    "count": self.rollers,
                },
            )
