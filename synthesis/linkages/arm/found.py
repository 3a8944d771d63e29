"""What is found of a palletising arm: the response body."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from synthesis.design import Part, told
from synthesis.linkages.arm.geometry import Base, Elbow
from synthesis.linkages.arm.spec import ArmSpec


class BorderArc(Part):
    """A piece of a region's border: an arc of a circle in the plane (r, z)."""

    keeps: Literal["upper_arm", "forearm", "opening"] = told(
        "Which limit it belongs to: the angle that stands still along it."
    )
    centre_mm: tuple[float, float] = told("Its centre [r, z].")
    radius_mm: float = told("Its radius.")
    start_deg: float = told("Angle of its beginning at the centre, from r, towards z.")
    sweep_deg: float = told("How far it runs, negative clockwise.")
    from_mm: tuple[float, float] = told("Its beginning [r, z].")
    to_mm: tuple[float, float] = told("Its end [r, z]: where the next begins.")


class ArmFarthest(Part):
    """A largest or smallest coordinate of the tool and the arm angles there."""

    value_mm: float = told("The coordinate.")
    upper_arm_deg: float = told("Angle of the upper arm there.")
    forearm_deg: float = told("Angle of the forearm there.")


class WorkRegion(Part):
    """What the tool reaches with the elbow on one side, in the plane (r, z) through axis 1."""

    elbow: Elbow = told("up: upper arm less forearm between −90° and 90°; down: beyond.")
    border: list[BorderArc] = told("Arcs, in order, each beginning where the one before ends.")
    area_mm2: float = told("Area, exact by Green's theorem over the arcs.")
    volume_mm3: float | None = told(
        "Volume that it sweeps as the base turns, by Pappus; null where the region crosses axis 1 "
        "or the base turns further than once."
    )
    r_max: ArmFarthest = told("ArmFarthest from axis 1.")
    r_min: ArmFarthest = told("Nearest to it, negative behind it.")
    z_max: ArmFarthest = told("Highest.")
    z_min: ArmFarthest = told("Lowest.")


class ArmsInLine(Part):
    """Arm angles inside the limits at which the arms are in line: singular."""

    opening_deg: float = told("Upper arm less forearm there.")
    from_deg: tuple[float, float] = told("Angles of upper arm and forearm where it begins.")
    to_deg: tuple[float, float] = told("The same where it ends.")


class ArmTorque(Part):
    """The largest torque that an axis holds within the limits."""

    axis: Literal["upper_arm", "forearm"] = told("Which axis.")
    torque_nm: float = told("ArmTorque against the weights, positive along the angle.")
    angle_deg: float = told("Angle of this axis there; the other's does not count.")


class BeyondLimit(Part):
    """A limit that a posture exceeds."""

    joint: Literal["base", "upper_arm", "forearm", "opening", "tool"] = told("Which.")
    by_deg: float = told("By how much.")


class ArmSolution(Part):
    """One way of being at a place."""

    base: Base = told("front: turned towards the place; over: away from it, reaching back.")
    elbow: Elbow = told("up: upper arm less forearm between −90° and 90°; down: beyond.")
    base_deg: float = told("Axis 1.")
    upper_arm_deg: float = told("Axis 2.")
    forearm_deg: float = told("Axis 3.")
    tool_deg: float = told("Axis 6.")
    beyond: list[BeyondLimit] = told("Limits that it exceeds; empty: it can be taken.")
    in_line: float = told(
        "Sine of the angle between the arms, ±1 at best: at 0 they are in line, and the tool moves "
        "along one line only."
    )
    torque_upper_nm: float = told("ArmTorque that axis 2 holds, positive along its angle.")
    torque_forearm_nm: float = told("ArmTorque that axis 3 holds, positive along its angle.")


class ArmPose(Part):
    """What became of one pose."""

    name: str = told("Name from the spec.")
    x_mm: float = told("The tool's place.")
    y_mm: float = told("The tool's place.")
    z_mm: float = told("The tool's place.")
    yaw_deg: float = told("How the tool is turned about the upright.")
    reachable: bool = told("Whether one of the solutions keeps every limit.")
    solutions: list[ArmSolution] = told("Every way of being there, those within the limits first.")
    note: str = told("Why there is none, or what is special; empty: nothing.")


class PalletisingArm(Part):
    """A palletising arm: where it gets, how, and what that takes."""

    id: str = told("Hash of the spec and the engine's version.")
    name: str = told("Name from the spec.")
    engine_version: str = told("Version of Camwright that made it.")
    status: Literal["feasible", "infeasible"] = told("Whether every pose can be taken.")
    spec: ArmSpec = told("What was asked.")
    reach_mm: float = told("Largest distance of the tool from axis 1.")
    regions: list[WorkRegion] = told("What is reached; those of the two elbows may overlap.")
    singular: list[ArmsInLine] = told("Where the arms are in line within the limits.")
    over_axis: bool = told("Whether the tool gets over axis 1, where the base may stand anyhow.")
    torques: list[ArmTorque] = told("The largest torques within the limits.")
    poses: list[ArmPose] = told("The poses, in the spec's order.")
    links: dict[str, str] = Field({}, description="Where it and its files are.")
