"""Machines around cylindrical cams: a slide, an arm, a roller.

Frame: the origin lies on the cam's axis, which is z; x points along the roller's axis, and ρ is the
distance along it from the cam's axis. The follower moves towards larger z as q grows.
"""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Mapping, Sequence
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.fields import Dimension, ends
from synthesis.machines.spatial.machine import (
    LEFT,
    RIGHT,
    CrownRadius,
    DwellOn,
    Hand,
    MeshAngle,
    Rollers,
    Seat,
    SpatialMachine,
    TurretMachine,
    length,
    six_digits,
)
from synthesis.machines.spatial.size_constraints import (
    ArmPressureAngle,
    SizeConstraint,
    critical_places,
)
from synthesis.numerics.geometry.charts import Chart, Drum
from synthesis.numerics.geometry.swept_roller import Joint, SweptRoller
from synthesis.numerics.piecewise import Array
from synthesis.spec.schedule import check_closed
from synthesis.units import DEGREE, MotionUnits, Travel

X, Y, Z = np.eye(3)
RIGHT_ANGLE = 0.5 * math.pi  # rad


class CylindricalMachine(SpatialMachine, ABC):
    """A machine whose grooves are cut into a cylinder; frame as in this module."""

    size_fields: ClassVar[tuple[str, ...]] = ("cylinder_radius_mm", "roller_radius_mm")
    size_field: ClassVar[str] = "cylinder_radius_mm"
    developable: ClassVar[bool] = True

    cylinder_radius_mm: Dimension = None
    roller_radius_mm: Dimension = None
    roller_width_mm: float = length("Roller's width, all of which reaches into the cam.", most=1e5)
    crown_radius_mm: CrownRadius = None

    @model_validator(mode="after")
    def _check_rollers(self) -> Self:
        width, largest = self.roller_width_mm, ends(self.cylinder_radius_mm)[1]
        if width >= largest:
            raise PydanticCustomError(
                "roller_reaches_axis",
                "A roller with roller_width_mm = {width} reaches through a cylinder of radius "
                "{radius} mm to its axis. Increase cylinder_radius_mm, or reduce roller_width_mm.",
                {"width": width, "radius": largest},
            )
        return self

    def chart(self, sizes: Mapping[str, float]) -> Chart:
        return Drum()

    def wall_radii(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        return sizes["cylinder_radius_mm"] - self.roller_width_mm, sizes["cylinder_radius_mm"]

    def _swept(
        self, sizes: Mapping[str, float], joint: Joint, origin: Array, hand: int
    ) -> SweptRoller:
        """The kinematics of the roller, at ``origin`` where q = 0, against the cam.

        ``hand`` is +1 where the cam turns about z as θ grows, −1 about −z.
        """
        roller = self._roller(sizes, self.wall_radii(sizes)[0])
        return SweptRoller(0.0 * X, Z, joint, origin, X, roller, hand)

    def _swept_on_pivot(
        self, sizes: Mapping[str, float], length: float, distance: float, hand: int
    ) -> SweptRoller:
        """The same on a pivot across the cam's axis, ``distance`` from it [mm].

        At q = 0 the arm of this ``length`` is perpendicular to the cam's axis.
        """
        return self._swept(sizes, Joint.pivot(distance * Y, -X), (distance - length) * Y, hand)

    def _largest_offset(self, cylinder: float) -> float:
        """Largest distance of the roller's axis from the cam's at which it meets the cylinder."""
        floor = cylinder - self.roller_width_mm
        return math.sqrt(max(cylinder**2 - floor**2, 0.0))

    def _check_offset(self, arm: float, distance: float, angles: Sequence[float]) -> None:
        """Refuse a roller whose axis passes beside even the largest cylinder.

        ``arm`` is from roller to pivot, ``distance`` from pivot to the cam's axis [mm]; the arm
        moves between ``angles`` [rad].
        """
        largest = ends(self.cylinder_radius_mm)[1]
        if math.isinf(largest):
            return
        least, most = min(angles), max(angles)
        nearest = min(max(0.0, least), most)
        allowed = self._largest_offset(largest)
        offset = max((distance - arm * math.cos(at) for at in (least, nearest, most)), key=abs)
        if abs(offset) >= allowed:
            raise PydanticCustomError(
                "roller_beside_cylinder",
                "The roller's axis passes {offset} mm beside the cam's axis, but a roller {width} "
                "mm wide reaches into a cylinder of radius {radius} mm only within {allowed} mm. "
                "Change the distance of the arm's pivot or the turret from the cam's axis, or "
                "increase cylinder_radius_mm.",
                {"offset": six_digits(abs(offset)), "width": self.roller_width_mm,
                 "radius": largest, "allowed": six_digits(allowed)},
            )  # fmt: skip


class CylindricalFollower(CylindricalMachine, ABC):
    """A follower that returns: one roller in a groove, or two rollers on both sides of a rib."""

    roller_distance_mm: float | None = length(
        "Distance between the axes of two rollers on both sides of a rib; left out: one roller "
        "in a groove.",
        None,
    )

    @model_validator(mode="after")
    def _check_rib(self) -> Self:
        distance, smallest = self.roller_distance_mm, ends(self.roller_radius_mm)[0]
        if distance is not None and distance <= 2.0 * smallest:
            raise PydanticCustomError(
                "rollers_touch",
                "Rollers of radius {radius} mm whose axes are {distance} mm apart leave no rib "
                "between them. Make roller_distance_mm larger than twice roller_radius_mm.",
                {"radius": smallest, "distance": distance},
            )
        return self

    def mesh_range(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        return -math.inf, math.inf

    def check_travel(self, gain: float, lowest: float, highest: float) -> None:
        check_closed(gain, highest - lowest, MotionUnits(self.travel))

    def dwell_rib(self, sizes: Mapping[str, float]) -> float:
        distance = self.roller_distance_mm
        return math.inf if distance is None else distance - 2.0 * sizes["roller_radius_mm"]


def roller_seats(rest: float, spacing: float | None) -> tuple[Seat, ...]:
    """One roller in a groove, or two ``spacing`` apart with a rib between them [rad or mm]."""
    if spacing is None:
        return (Seat(1, rest),)
    return Seat(1, rest + 0.5 * spacing, (LEFT,)), Seat(2, rest - 0.5 * spacing, (RIGHT,))


class CylindricalTranslating(CylindricalFollower):
    """A slide along the cam's axis; the roller's axis crosses the cam's at a right angle.

    Frame as in ``cylindrical``; s is z of the roller, or of the midpoint between two rollers.
    """

    kind: Literal["cylindrical_translating"] = "cylindrical_translating"
    title: ClassVar[str] = "cylindrical cam, follower on a slide"
    travel: ClassVar[Travel] = Travel()

    def swept_roller(self, sizes: Mapping[str, float], rotation: int) -> SweptRoller:
        return self._swept(sizes, Joint.guide(Z), 0.0 * Z, rotation)

    def seats(self) -> tuple[Seat, ...]:
        return roller_seats(0.0, self.roller_distance_mm)

    def pressure_angle_rows(
        self, sizes: Mapping[str, float], slope: float
    ) -> tuple[LinearInequality, ...]:
        """|s'| ≤ t (R − depth) at each critical depth, with t the remaining tan α there."""
        return tuple(
            LinearInequality((0.0, sign, 0.0, 0.0), (-left,), -left * (self.roller_width_mm - foot))
            for foot, left in critical_places(self._roller(sizes, 0.0), slope, 0.0)
            for sign in (1.0, -1.0)
        )


class CylindricalOscillating(CylindricalFollower):
    """A swinging arm; its pivot's axis and its roller's axis are perpendicular to the cam's.

    Frame as in ``cylindrical``; the pivot is parallel to x, at y = pivot distance and z = 0. The
    arm's angle is 0 where the arm is perpendicular to the cam's axis.
    """

    kind: Literal["cylindrical_oscillating"] = "cylindrical_oscillating"
    title: ClassVar[str] = "cylindrical cam, follower on an arm"
    travel: ClassVar[Travel] = Travel("deg", DEGREE)

    arm_mm: float = length(
        "Length of the arm: from the pivot to the roller, or to the midpoint between two."
    )
    pivot_distance_mm: float | None = length(
        "Distance between the pivot's axis and the cam's; left out: the arm's length, so that the "
        "axis of a single roller meets the cam's axis where the arm is perpendicular to it.",
        None,
    )
    initial_angle_deg: float = Field(
        0.0,
        gt=-90.0,
        lt=90.0,
        description="Angle of the arm at the start of the program, measured from the perpendicular "
        "to the cam's axis and growing with the motion. Minus half the swing makes the swing "
        "symmetric.",
    )

    def swept_roller(self, sizes: Mapping[str, float], rotation: int) -> SweptRoller:
        return self._swept_on_pivot(sizes, *self._lengths, rotation)

    @property
    def _lengths(self) -> tuple[float, float]:
        """Pivot to roller, and pivot to the cam's axis [mm]."""
        arm = math.hypot(self.arm_mm, 0.5 * (self.roller_distance_mm or 0.0))
        return arm, self.pivot_distance_mm or self.arm_mm

    def seats(self) -> tuple[Seat, ...]:
        rest, distance = self.initial_angle_deg * DEGREE, self.roller_distance_mm
        spacing = None if distance is None else 2.0 * math.atan2(0.5 * distance, self.arm_mm)
        return roller_seats(rest, spacing)

    def check_travel(self, gain: float, lowest: float, highest: float) -> None:
        super().check_travel(gain, lowest, highest)
        starts = [seat.start for seat in self.seats()]
        least, most = min(starts) + lowest, max(starts) + highest
        if least <= -RIGHT_ANGLE or most >= RIGHT_ANGLE:
            raise PydanticCustomError(
                "arm_along_cam",
                "A roller on the arm swings from {least}° to {most}° about the perpendicular to "
                "the cam's axis; at 90° the arm is parallel to the cam's axis and the cam cannot "
                "drive it. Change initial_angle_deg, or reduce the swing.",
                {"least": six_digits(least / DEGREE), "most": six_digits(most / DEGREE)},
            )
        self._check_offset(*self._lengths, (least, most))

    @property
    def can_be_sized(self) -> bool:
        # The pressure angle of a crowned roller whose axis passes beside the cam's has no closed
        # form in the motion and the cylinder's radius.
        return self.crown_radius_mm is None

    def length_scale(self, sizes: Mapping[str, float]) -> float:
        return self._lengths[0]

    def pressure_angle_curves(
        self, sizes: Mapping[str, float], slope: float, rotation: int
    ) -> tuple[SizeConstraint, ...]:
        starts, inner = tuple(seat.start for seat in self.seats()), self.roller_width_mm
        arm = self._lengths[0]
        return (ArmPressureAngle("pressure_angle", arm, starts, rotation, inner, slope),)


class CylindricalIndexer(TurretMachine, CylindricalMachine):
    """A turret whose axis and rollers are perpendicular to the cam's axis, at a distance from it.

    Frame as in ``cylindrical``; the turret's axis is parallel to x, at y = centre distance and
    z = 0. A roller's angle is 0 where it is nearest to the cam's axis, seen along the turret's.
    It is not sized yet: its rollers' axes pass beside the cam's, so that the pressure angle has no
    closed form in the motion and the radius.
    """

    kind: Literal["cylindrical_indexer"] = "cylindrical_indexer"
    title: ClassVar[str] = "cylindrical (barrel) indexer"
    size_field: ClassVar[str] = ""

    rollers: Rollers
    hand: Hand = "right"
    dwell_on: DwellOn = "rib"
    turret_radius_mm: float = length("Radius of the circle through the rollers' axes.")
    centre_distance_mm: float | None = length(
        "Distance between the turret's axis and the cam's; left out: turret_radius_mm.", None
    )
    mesh_angle_deg: MeshAngle = None

    @model_validator(mode="after")
    def _check_turret(self) -> CylindricalIndexer:
        self._check_offset(*self._lengths, (0.0,))
        return self

    def swept_roller(self, sizes: Mapping[str, float], rotation: int) -> SweptRoller:
        return self._swept_on_pivot(sizes, *self._lengths, self.thread_sign)

    @property
    def _lengths(self) -> tuple[float, float]:
        """Turret's axis to the rollers, and to the cam's axis [mm]."""
        return self.turret_radius_mm, self.centre_distance_mm or self.turret_radius_mm

    def mesh_range(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        low, high = super().mesh_range(sizes)
        radius, distance = self._lengths
        lowest = distance - self._largest_offset(sizes["cylinder_radius_mm"])
        leaves = math.acos(min(max(lowest / radius, -1.0), 1.0))
        return max(low, -leaves), min(high, leaves)
