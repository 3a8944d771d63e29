"""SpatialMachine and TurretMachine: what specs, measurement, sizing and files ask of a machine.

Symbols: q the follower's position [rad or mm], θ the cam angle, ρ the place on a roller's axis, α
the pressure angle. ``sizes`` maps names of dimension fields to numbers in mm throughout.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.fields import Dimension, ends
from synthesis.machines.spatial.size_constraints import SizeConstraint
from synthesis.numerics.geometry.charts import Chart
from synthesis.numerics.geometry.swept_roller import Roller, SweptRoller
from synthesis.units import DEGREE, FULL_TURN, Travel

LEFT, RIGHT = -1, 1  # the two walls of a groove, or the two flanks of a rib
LARGEST = 1e6  # mm: the largest dimension that a spec may name, and that sizing chooses
ROLLER_RADIUS = "roller_radius_mm"  # field of every machine
WHOLE = 1e-9  # of a spacing: rounding of a sum of lifts that is a whole number of rollers

CrownRadius = Annotated[
    float | None,
    Field(
        gt=0.0,
        le=1e7,
        description="Radius of the crowned roller's outline; left out: a cylindrical roller.",
    ),
]


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


@dataclass(frozen=True)
class Seat:
    """One roller of the follower, numbered from 1, at its start where q = 0 [rad or mm].

    ``sides`` of it touch the cam; +1 is the side in the direction of growing q.
    """

    number: int
    start: float
    sides: tuple[int, ...] = (LEFT, RIGHT)


class SpatialMachine(BaseModel, ABC):
    """A follower with one or several rollers, and its position relative to the cam.

    Attributes:
        period: of q, after which a roller is back at its place [rad or mm]; infinite for none.
        size_fields: fields of the dimensions that may be left free.
        size_field: field of the one that sizing minimises; empty: the machine is not sized.
        inner_end_field: field of the place of the rollers' inner ends; empty: no such dimension.
        developable: whether the cam's walls are cut by cylinders about the cam's axis.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    kind: str
    title: ClassVar[str]
    travel: ClassVar[Travel]
    period: ClassVar[float] = math.inf
    size_fields: ClassVar[tuple[str, ...]]
    size_field: ClassVar[str] = ""
    inner_end_field: ClassVar[str] = ""
    developable: ClassVar[bool] = False

    if TYPE_CHECKING:  # fields of every machine, declared by each at its place in the order
        roller_radius_mm: Dimension
        roller_width_mm: float
        crown_radius_mm: CrownRadius

    @model_validator(mode="after")
    def _check_sizes(self) -> Self:
        for name, (low, high) in self.ranges().items():
            if high <= 0.0 or low > LARGEST:
                given = high if high <= 0.0 else low
                raise PydanticCustomError(
                    "no_such_size",
                    "{name} is {given} mm, but dimensions are above 0 and at most {largest} mm. "
                    "Give such a length.",
                    {"name": name, "given": given, "largest": LARGEST},
                )
        return self

    @model_validator(mode="after")
    def _check_crown(self) -> Self:
        crown, half = self.crown_radius_mm, 0.5 * self.roller_width_mm
        if crown is None:
            return self
        if crown <= half or crown - math.sqrt(crown**2 - half**2) >= ends(self.roller_radius_mm)[1]:
            raise PydanticCustomError(
                "crown_too_round",
                "With crown_radius_mm = {crown} the outline of a roller {width} mm wide meets the "
                "roller's axis before its ends. Increase crown_radius_mm, or reduce the width.",
                {"crown": crown, "width": self.roller_width_mm},
            )
        return self

    def _roller(self, sizes: Mapping[str, float], inner: float) -> Roller:
        """The roller whose inner end is at ρ = ``inner`` [mm]."""
        outer = inner + self.roller_width_mm
        return Roller(sizes[ROLLER_RADIUS], inner, outer, self.crown_radius_mm or 0.0)

    def ranges(self) -> Mapping[str, tuple[float, float]]:
        """Least and largest value of the dimensions that may be left free, by field name [mm].

        An end left open above is ``LARGEST``.
        """
        fields = {name: ends(getattr(self, name)) for name in self.size_fields}
        return {name: (low, min(high, max(low, LARGEST))) for name, (low, high) in fields.items()}

    @abstractmethod
    def swept_roller(self, sizes: Mapping[str, float], rotation: int) -> SweptRoller:
        """Kinematics of the roller against the cam.

        Args:
            sizes: a number for each name in ``size_fields`` [mm].
            rotation: +1 where the cam turns ccw, −1 where it turns cw.
        """

    def dimensions(self, sizes: Mapping[str, float]) -> Mapping[str, float]:
        """Dimensions that the answer reports: ``sizes`` and those derived from them [mm]."""
        return sizes

    def clearances(self, sizes: Mapping[str, float]) -> Mapping[str, float]:
        """Lengths other than those of walls that must be positive, by name [mm]."""
        return {}

    @abstractmethod
    def seats(self) -> tuple[Seat, ...]:
        """The rollers that can meet the cam during one turn of it."""

    @abstractmethod
    def mesh_range(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        """Least and largest position q of a roller where the blank still has a wall [rad or mm]."""

    def end_faces(self) -> tuple[float, float]:
        """Positions of the cam's end faces along its axis, from its centre [mm]; infinite: none."""
        return -math.inf, math.inf

    def wall_radii(self, sizes: Mapping[str, float]) -> tuple[float, float] | None:
        """Radii of cylinders about the axis that cut the walls [mm]; None: not developable."""
        return None

    @abstractmethod
    def chart(self, sizes: Mapping[str, float]) -> Chart:
        """Coordinates (angle, depth, place across) that suit the blank."""

    @abstractmethod
    def check_travel(self, gain: float, lowest: float, highest: float) -> None:
        """Refuse a program that moves the follower by ``gain`` in one turn [rad or mm].

        The next turn would not find a roller where this turn ended, or the follower cannot be at
        its least and largest position, ``lowest`` and ``highest`` from the start of the turn.
        """

    @property
    def can_be_sized(self) -> bool:
        """Whether a dimension or a law may be left free."""
        return bool(self.size_field)

    def dwell_rib(self, sizes: Mapping[str, float]) -> float:
        """Thickness of the thinnest rib while the follower dwells; infinite where it has none [mm].

        ``sizes``: the rollers' radius, and the place of their inner ends where it is a dimension.
        """
        return math.inf

    def length_scale(self, sizes: Mapping[str, float]) -> float:
        """Length that stands for one unit of q in the optimiser, near the rollers' path [mm]."""
        return 1.0

    def pressure_angle_rows(
        self, sizes: Mapping[str, float], slope: float
    ) -> tuple[LinearInequality, ...]:
        """|tan α| ≤ slope, where it is linear in the motion and the minimised dimension.

        ``sizes`` are the other dimensions.
        """
        return ()

    def pressure_angle_curves(
        self, sizes: Mapping[str, float], slope: float, rotation: int
    ) -> tuple[SizeConstraint, ...]:
        """The same where it is not linear; the motion is ``length_scale`` times q."""
        return ()

    def wall_radius_curves(
        self, sizes: Mapping[str, float], least: float
    ) -> tuple[SizeConstraint, ...]:
        """Radius of convex wall parts ≥ ``least`` [mm]; 0 excludes undercut.

        () where no closed form is known: then the cam is enlarged until sampled walls keep it.
        """
        return ()


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

        e points in the direction in which the rollers move as q grows. A right-hand screw that
        turns about its axis and is fixed along it moves its nut backwards, so that rollers moving
        along e need a cam that turns about −e. Seen from the other side, ccw is cw.
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

    def check_travel(self, gain: float, lowest: float, highest: float) -> None:
        steps = gain / self.spacing
        if round(steps) == 0 or abs(steps - round(steps)) > WHOLE:
            raise PydanticCustomError(
                "index_not_whole",
                "The program turns the turret by {gain}° in one turn of the cam, which is "
                "{rollers} times the {spacing}° between two of {count} rollers. Make the lifts of "
                "the program sum to a whole number of spacings other than 0.",
                {"gain": float(f"{gain / DEGREE:.9g}"), "rollers": float(f"{steps:.9g}"),
                 "spacing": float(f"{self.spacing / DEGREE:.9g}"), "count": self.rollers},
            )  # fmt: skip


def length(description: str, default: Any = ..., most: float = LARGEST) -> Any:
    """A field with a length above 0 [mm]; required unless it has a default."""
    return Field(default, gt=0.0, le=most, description=description)


def six_digits(value: float) -> float:
    """A number with the digits that messages show."""
    return float(f"{value:.6g}")
