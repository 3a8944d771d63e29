"""ArmSpec: a palletising arm, its limits, its load, and the poses of its tool."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from synthesis.catalogue.fields import Name
from synthesis.catalogue.ranges import Range
from synthesis.machines.linkages.arm.geometry import Arm, Joints, Place, Posture
from synthesis.machines.linkages.arm.limits import Limits, Span
from synthesis.machines.linkages.arm.statics import Weight
from synthesis.units import DEGREE

LARGEST = 1e6
MOST_POSES, MOST_MASSES = 500, 50
WIDEST = 360.0


class Body(BaseModel):
    """A part of the request."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


Length = Annotated[float, Field(ge=1e-6, le=LARGEST)]
Offset = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Angle = Annotated[float, Field(ge=-720.0, le=720.0)]
Swing = Annotated[float, Field(ge=-180.0, le=180.0)]


class JointLimits(Range):
    """Range of a joint [deg]."""

    min: Annotated[float, Field(ge=-720.0, le=720.0, description="Smallest angle [deg].")]
    max: Annotated[float, Field(ge=-720.0, le=720.0, description="Largest angle [deg].")]

    def span(self) -> Span:
        """Both ends [rad]."""
        return self.min * DEGREE, self.max * DEGREE


class SwingLimits(JointLimits):
    """Range of an arm [deg]."""

    min: Annotated[float, Field(ge=-180.0, le=180.0, description="Smallest angle [deg].")]
    max: Annotated[float, Field(ge=-180.0, le=180.0, description="Largest angle [deg].")]


class OpeningLimits(Range):
    """Range of the upper arm's angle minus the forearm's; an end may be open."""

    min: Annotated[
        float | None, Field(ge=-360.0, le=360.0, description="Smallest difference [deg].")
    ] = None
    max: Annotated[
        float | None, Field(ge=-360.0, le=360.0, description="Largest difference [deg].")
    ] = None

    def span(self) -> Span:
        """Both ends [rad]."""
        low = -math.inf if self.min is None else self.min * DEGREE
        return low, math.inf if self.max is None else self.max * DEGREE


class ArmMass(Body):
    """The mass of a part, and where its centre lies.

    In the double parallelogram every part's centre is a distance along the upper arm and a distance
    along the forearm from the shoulder. A driving rod behind the elbow has a negative forearm_mm.
    """

    name: Annotated[Name, Field(description="Name of the part.")] = ""
    mass_kg: Annotated[float, Field(ge=0.0, le=1e6, description="Mass [kg].")]
    upper_arm_mm: Annotated[
        Offset,
        Field(description="Distance of its centre along the upper arm, from the shoulder [mm]."),
    ] = 0.0
    forearm_mm: Annotated[
        Offset, Field(description="Distance of its centre along the forearm, from the elbow [mm].")
    ] = 0.0

    def weight(self) -> Weight:
        """The mass as ``statics`` takes it."""
        return Weight(self.mass_kg, self.upper_arm_mm, self.forearm_mm)


class ArmTask(Body):
    """A pose of the tool, by joint angles or by its place."""

    name: Annotated[Name, Field(description="Shown in reports and files.")] = ""

    @abstractmethod
    def place(self, arm: Arm) -> Place:
        """The place of the tool."""

    @abstractmethod
    def postures(self, arm: Arm, limits: Limits) -> Iterator[Posture]:
        """Postures that reach it, brought within the limits by whole turns where possible."""


class JointPose(ArmTask):
    """Joint angles, for which the place of the tool is asked."""

    kind: Literal["joints"] = "joints"
    base_deg: Annotated[Angle, Field(description="Axis 1 [deg].")] = 0.0
    upper_arm_deg: Annotated[
        Swing, Field(description="Axis 2: of the upper arm from the vertical, forwards [deg].")
    ]
    forearm_deg: Annotated[
        Swing, Field(description="Axis 3: of the forearm below the horizontal [deg].")
    ]
    tool_deg: Annotated[Angle, Field(description="Axis 6: of the tool [deg].")] = 0.0

    def _joints(self) -> Joints:
        angles = (self.base_deg, self.upper_arm_deg, self.forearm_deg, self.tool_deg)
        base, upper, fore, tool = (DEGREE * angle for angle in angles)
        return Joints(base, upper, fore, tool)

    def place(self, arm: Arm) -> Place:
        return arm.place(self._joints())

    def postures(self, arm: Arm, limits: Limits) -> Iterator[Posture]:
        joints = self._joints()
        over = arm.radius(joints.upper, joints.fore) < 0.0
        down = math.cos(joints.opening) < 0.0
        yield Posture("over" if over else "front", "down" if down else "up", joints)


class PointPose(ArmTask):
    """A place of the tool, for which the joint angles are asked."""

    kind: Literal["point"] = "point"
    x_mm: Annotated[Offset, Field(description="x: forwards at base angle 0 [mm].")]
    y_mm: Annotated[Offset, Field(description="y: to the left [mm].")] = 0.0
    z_mm: Annotated[Offset, Field(description="z: above the floor [mm].")]
    yaw_deg: Annotated[Angle, Field(description="Angle of the tool about the vertical [deg].")] = (
        0.0
    )

    def place(self, arm: Arm) -> Place:
        return Place(self.x_mm, self.y_mm, self.z_mm, self.yaw_deg * DEGREE)

    def postures(self, arm: Arm, limits: Limits) -> Iterator[Posture]:
        for posture in arm.postures(self.place(arm)):
            for joints in limits.equivalent_angles(posture.joints):
                yield Posture(posture.base, posture.elbow, joints)


Pose = Annotated[JointPose | PointPose, Field(discriminator="kind")]


class ArmSpec(Body):
    """A palletising arm with two parallelograms that keep its tool upright.

    Axis 1 is vertical through the origin on the floor. Both arm angles are absolute: that of the
    upper arm is measured from the vertical, forwards, that of the forearm from the horizontal,
    downwards.
    """

    name: Annotated[Name, Field(description="Shown in reports and files.")] = ""
    shoulder_height_mm: Annotated[
        Offset, Field(description="Height of axis 2 above the floor [mm].")
    ]
    shoulder_offset_mm: Annotated[Offset, Field(description="Distance of axis 2 from axis 1 [mm].")]
    upper_arm_mm: Annotated[Length, Field(description="Length from axis 2 to the elbow [mm].")]
    forearm_mm: Annotated[Length, Field(description="Length from the elbow to the wrist [mm].")]
    wrist_offset_mm: Annotated[
        Offset, Field(description="Distance of the tool's axis from the wrist, forwards [mm].")
    ] = 0.0
    tool_mm: Annotated[Offset, Field(description="Tool point below the wrist [mm].")] = 0.0
    base_deg: Annotated[JointLimits, Field(description="Limits of axis 1.")] = JointLimits(
        min=-180.0, max=180.0
    )
    upper_arm_deg: Annotated[SwingLimits, Field(description="Limits of axis 2.")]
    forearm_deg: Annotated[SwingLimits, Field(description="Limits of axis 3.")]
    opening_deg: Annotated[
        OpeningLimits,
        Field(
            description="Limits of the upper arm's angle minus the forearm's, set by the "
            "parallelograms: at ±90° the arms are in line."
        ),
    ] = OpeningLimits()
    tool_deg: Annotated[JointLimits, Field(description="Limits of axis 6.")] = JointLimits(
        min=-360.0, max=360.0
    )
    masses: Annotated[
        list[ArmMass], Field(max_length=MOST_MASSES, description="Masses of the links.")
    ] = []
    payload_kg: Annotated[
        float, Field(ge=0.0, le=1e6, description="Load at the tool, including the tool [kg].")
    ] = 0.0
    poses: Annotated[
        list[Pose],
        Field(max_length=MOST_POSES, description="Joint angles, or places of the tool."),
    ] = []
    time_budget_s: Annotated[
        float | None, Field(gt=0.0, le=3600.0, description="Stop after this long.")
    ] = None

    @property
    def arm(self) -> Arm:
        """The arm's lengths."""
        return Arm(
            self.shoulder_height_mm, self.shoulder_offset_mm, self.upper_arm_mm, self.forearm_mm,
            self.wrist_offset_mm, self.tool_mm,
        )  # fmt: skip

    @property
    def limits(self) -> Limits:
        """The joint limits."""
        return Limits(
            self.base_deg.span(), self.upper_arm_deg.span(), self.forearm_deg.span(),
            self.opening_deg.span(), self.tool_deg.span(),
        )  # fmt: skip

    @property
    def weights(self) -> list[Weight]:
        """Weights of links and load."""
        load = Weight(self.payload_kg, self.upper_arm_mm, self.forearm_mm)
        return [*(mass.weight() for mass in self.masses), load]
