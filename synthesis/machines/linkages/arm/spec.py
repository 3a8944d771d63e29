"""ArmSpec: a palletising arm, its limits, its load, and the poses of its tool."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from synthesis.catalogue.fields import FiniteModel, Name, Range, ends
from synthesis.machines.linkages.arm import geometry
from synthesis.machines.linkages.arm.geometry import Arm, Joints, Limits, Place, Posture
from synthesis.units import DEGREE

LARGEST = 1e6  # mm and kg: far beyond any arm, so that products stay finite
MAX_POSES, MAX_MASSES = 500, 50  # so that an answer stays small and takes milliseconds
Length = Annotated[float, Field(ge=1e-6, le=LARGEST)]
Offset = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Angle = Annotated[float, Field(ge=-720.0, le=720.0)]
Swing = Annotated[float, Field(ge=-180.0, le=180.0)]
Opening = Annotated[float | None, Field(ge=-360.0, le=360.0)]


class JointLimits(Range):
    """Range of a joint [deg]."""

    min: Angle = Field(description="Smallest angle [deg].")
    max: Angle = Field(description="Largest angle [deg].")


class SwingLimits(Range):
    """Range of an arm [deg]."""

    min: Swing = Field(description="Smallest angle [deg].")
    max: Swing = Field(description="Largest angle [deg].")


class OpeningLimits(Range):
    """Range of the upper arm's angle minus the forearm's; an end may be open."""

    min: Opening = Field(None, description="Smallest difference [deg].")
    max: Opening = Field(None, description="Largest difference [deg].")


class ArmMass(FiniteModel):
    """The mass of a part, and where its centre lies.

    In the double parallelogram every part's centre is a distance along the upper arm and a distance
    along the forearm from the shoulder. A driving rod behind the elbow has a negative forearm_mm.
    """

    name: Name = Field("", description="Name of the part.")
    mass_kg: float = Field(ge=0.0, le=LARGEST, description="Mass [kg].")
    upper_arm_mm: Offset = Field(
        0.0, description="Distance of its centre along the upper arm, from the shoulder [mm]."
    )
    forearm_mm: Offset = Field(
        0.0, description="Distance of its centre along the forearm, from the elbow [mm]."
    )


class ArmTask(FiniteModel):
    """A pose of the tool, by joint angles or by its place."""

    name: Name = Field("", description="Shown in reports and files.")


class JointPose(ArmTask):
    """Joint angles, for which the place of the tool is asked."""

    kind: Literal["joints"] = "joints"
    base_deg: Angle = Field(0.0, description="Axis 1 [deg].")
    upper_arm_deg: Swing = Field(
        description="Axis 2: of the upper arm from the vertical, forwards [deg]."
    )
    forearm_deg: Swing = Field(description="Axis 3: of the forearm below the horizontal [deg].")
    tool_deg: Angle = Field(0.0, description="Axis 6: of the tool [deg].")

    def _joints(self) -> Joints:
        angles = (self.base_deg, self.upper_arm_deg, self.forearm_deg, self.tool_deg)
        return Joints(*(DEGREE * angle for angle in angles))

    def place(self, arm: Arm) -> Place:
        """The place of the tool."""
        return arm.place(self._joints())

    def postures(self, arm: Arm, limits: Limits) -> Iterator[Posture]:
        """Postures that reach it, brought within the limits by whole turns where possible."""
        joints = self._joints()
        over = arm.tool_point(joints.upper_arm, joints.forearm).real < 0.0
        down = math.cos(joints.opening) < 0.0
        yield Posture("over" if over else "front", "down" if down else "up", joints)


class PointPose(ArmTask):
    """A place of the tool, for which the joint angles are asked."""

    kind: Literal["point"] = "point"
    x_mm: Offset = Field(description="x: forwards at base angle 0 [mm].")
    y_mm: Offset = Field(0.0, description="y: to the left [mm].")
    z_mm: Offset = Field(description="z: above the floor [mm].")
    yaw_deg: Angle = Field(0.0, description="Angle of the tool about the vertical [deg].")

    def place(self, arm: Arm) -> Place:
        return Place(self.x_mm, self.y_mm, self.z_mm, self.yaw_deg * DEGREE)

    def postures(self, arm: Arm, limits: Limits) -> Iterator[Posture]:
        for posture in arm.postures(self.place(arm)):
            for joints in limits.equivalent_angles(posture.joints):
                yield Posture(posture.base, posture.elbow, joints)


Pose = Annotated[JointPose | PointPose, Field(discriminator="kind")]


class ArmSpec(FiniteModel):
    """A palletising arm with two parallelograms that keep its tool upright.

    Axis 1 is vertical through the origin on the floor. Both arm angles are absolute: that of the
    upper arm is measured from the vertical, forwards, that of the forearm from the horizontal,
    downwards.
    """

    name: Name = Field("", description="Shown in reports and files.")
    shoulder_height_mm: Offset = Field(description="Height of axis 2 above the floor [mm].")
    shoulder_offset_mm: Offset = Field(description="Distance of axis 2 from axis 1 [mm].")
    upper_arm_mm: Length = Field(description="Length from axis 2 to the elbow [mm].")
    forearm_mm: Length = Field(description="Length from the elbow to the wrist [mm].")
    wrist_offset_mm: Offset = Field(
        0.0, description="Distance of the tool's axis from the wrist, forwards [mm]."
    )
    tool_mm: Offset = Field(0.0, description="Tool point below the wrist [mm].")
    base_deg: JointLimits = Field(
        JointLimits(min=-180.0, max=180.0), description="Limits of axis 1."
    )
    upper_arm_deg: SwingLimits = Field(description="Limits of axis 2.")
    forearm_deg: SwingLimits = Field(description="Limits of axis 3.")
    opening_deg: OpeningLimits = Field(
        OpeningLimits(),
        description="Limits of the upper arm's angle minus the forearm's, set by the "
        "parallelograms: at ±90° the arms are in line.",
    )
    tool_deg: JointLimits = Field(
        JointLimits(min=-360.0, max=360.0), description="Limits of axis 6."
    )
    masses: list[ArmMass] = Field([], max_length=MAX_MASSES, description="Masses of the links.")
    payload_kg: float = Field(
        0.0, ge=0.0, le=LARGEST, description="Load at the tool, including the tool [kg]."
    )
    gravity_m_per_s2: float = Field(
        geometry.G, ge=0.0, le=1e3,
        description="Acceleration by which masses weigh; left out: standard gravity, 9.80665.",
    )  # fmt: skip
    poses: list[Pose] = Field(
        [], max_length=MAX_POSES, description="Joint angles, or places of the tool."
    )
    time_budget_s: float | None = Field(
        None, gt=0.0, le=3600.0, description="Stop after this long."
    )

    @property
    def arm(self) -> Arm:
        """The arm's lengths."""
        return Arm(
            self.shoulder_height_mm, self.shoulder_offset_mm, self.upper_arm_mm, self.forearm_mm,
            self.wrist_offset_mm, self.tool_mm,
        )  # fmt: skip

    @property
    def limits(self) -> Limits:
        """The joint limits; an open end is infinite."""
        ranges = (ends(getattr(self, f"{name}_deg")) for name in geometry.JOINTS)
        return Limits(*((DEGREE * low, DEGREE * high) for low, high in ranges))

    @property
    def static_moments(self) -> tuple[float, float]:
        """Torques of axes 2 and 3 with both arms horizontal, of links and load [N·m]."""
        load = (self.payload_kg, self.upper_arm_mm, self.forearm_mm)
        parts = ((each.mass_kg, each.upper_arm_mm, each.forearm_mm) for each in self.masses)
        return geometry.static_moments([*parts, load], self.gravity_m_per_s2)
