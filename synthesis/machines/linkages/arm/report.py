"""PalletisingArm: the response body, and how it is put together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from pydantic import Field

from synthesis.catalogue.fields import AnswerModel, doc
from synthesis.design.identity import engine_version, question_id
from synthesis.errors import InputError
from synthesis.machines.linkages.arm import geometry
from synthesis.machines.linkages.arm.geometry import Base, Corner, Edge, Elbow, Joint, Region
from synthesis.machines.linkages.arm.spec import ArmSpec, Pose
from synthesis.units import DEGREE, FULL_TURN

KIND = "palletising arm"
Axis = Literal["upper_arm", "forearm"]


class BorderArc(AnswerModel):
    """A piece of a region's border: an arc of a circle in the plane (r, z)."""

    keeps: Edge = doc("The angle that is constant along it: at one of its limits.")
    centre_mm: tuple[float, float] = doc("Its centre [r, z].")
    radius_mm: float = doc("Its radius.")
    start_deg: float = doc("Angle of its start at the centre, from r towards z.")
    sweep_deg: float = doc("Angle that it covers, negative clockwise.")
    from_mm: tuple[float, float] = doc("Its start [r, z].")
    to_mm: tuple[float, float] = doc("Its end [r, z], where the next one starts.")


class ArmFarthest(AnswerModel):
    """A largest or smallest coordinate of the tool and the arm angles there."""

    value_mm: float = doc("The coordinate.")
    upper_arm_deg: float = doc("Angle of the upper arm there.")
    forearm_deg: float = doc("Angle of the forearm there.")


class WorkRegion(AnswerModel):
    """What the tool reaches with the elbow on one side, in the plane (r, z) through axis 1."""

    elbow: Elbow = doc("up: upper arm less forearm between −90° and 90°; down: beyond.")
    border: list[BorderArc] = doc("Arcs in order, each starting where the one before ends.")
    area_mm2: float = doc("Area, exact by Green's theorem over the arcs.")
    volume_mm3: float | None = doc(
        "Volume swept as the base turns, by Pappus's theorem; null where the region crosses axis 1 "
        "or the base turns by more than 360°."
    )
    r_max: ArmFarthest = doc("Largest distance from axis 1.")
    r_min: ArmFarthest = doc("Smallest distance from axis 1, negative behind it.")
    z_max: ArmFarthest = doc("Highest place.")
    z_min: ArmFarthest = doc("Lowest place.")


class ArmsInLine(AnswerModel):
    """Arm angles inside the limits at which the arms are in line: singular."""

    opening_deg: float = doc("Upper arm less forearm there.")
    from_deg: tuple[float, float] = doc("Angles of upper arm and forearm at its start.")
    to_deg: tuple[float, float] = doc("The same at its end.")


class ArmTorque(AnswerModel):
    """The largest torque with which an axis holds the weights, within the limits."""

    axis: Axis = doc("Which axis.")
    torque_nm: float = doc("Torque against the weights, positive in the direction of the angle.")
    angle_deg: float = doc("Angle of this axis there; that of the other has no influence.")


class BeyondLimit(AnswerModel):
    """A limit that a posture exceeds."""

    joint: Joint = doc("Which joint.")
    excess_deg: float = doc("By how much.")


class ArmSolution(AnswerModel):
    """One posture that reaches a place."""

    base: Base = doc("front: turned towards the place; over: turned away, reaching back.")
    elbow: Elbow = doc("up: upper arm less forearm between −90° and 90°; down: beyond.")
    base_deg: float = doc("Axis 1.")
    upper_arm_deg: float = doc("Axis 2.")
    forearm_deg: float = doc("Axis 3.")
    tool_deg: float = doc("Axis 6.")
    beyond: list[BeyondLimit] = doc("Limits that it exceeds; empty: the posture is allowed.")
    in_line: float = doc(
        "Sine of the angle between the arms, ±1 at best: at 0 they are in line (singular), and the "
        "tool can move along one line only."
    )
    torque_upper_nm: float = doc("Holding torque of axis 2, positive along its angle.")
    torque_forearm_nm: float = doc("Holding torque of axis 3, positive along its angle.")


class ArmPose(AnswerModel):
    """One pose and the postures that reach it."""

    name: str = doc("Name from the spec.")
    x_mm: float = doc("Coordinate of the tool.")
    y_mm: float = doc("Coordinate of the tool.")
    z_mm: float = doc("Coordinate of the tool.")
    yaw_deg: float = doc("Angle of the tool about the vertical.")
    reachable: bool = doc("Whether one of the solutions keeps all limits.")
    solutions: list[ArmSolution] = doc(
        "Every posture that reaches it, those within the limits first."
    )
    note: str = doc("Why it is not reached, or what is special; empty: nothing.")


class PalletisingArm(AnswerModel):
    """A palletising arm: its workspace, postures and torques."""

    id: str = doc("Hash of the spec and the engine's version.")
    name: str = doc("Name from the spec.")
    engine_version: str = doc("Version of Camwright that made it.")
    status: Literal["feasible", "infeasible"] = doc(
        "feasible: every pose is reachable; infeasible: one is not."
    )
    spec: ArmSpec = doc("The request.")
    reach_mm: float = doc("Largest distance of the tool from axis 1.")
    regions: list[WorkRegion] = doc(
        "The workspace; regions of the two elbow positions may overlap."
    )
    singular: list[ArmsInLine] = doc("Arm angles within the limits at which the arms are in line.")
    over_axis: bool = doc("Whether the tool reaches axis 1, where any base angle will do.")
    torques: list[ArmTorque] = doc("The largest torques within the limits.")
    poses: list[ArmPose] = doc("The poses, in the spec's order.")
    links: dict[str, str] = Field({}, description="Links to it and its files.")


def analyse_arm(spec: ArmSpec, deadline: float | None = None) -> PalletisingArm:
    """Workspace, postures, torques and singularities; takes milliseconds, whatever the deadline.

    Raises:
        InputError: the joint limits leave no arm angles.
    """
    limits = spec.limits
    workspace = geometry.regions(spec.arm, limits)
    if not workspace:
        openings = [upper - fore for upper in limits.upper_arm for fore in limits.forearm]
        raise InputError(
            "/opening_deg", [angle / DEGREE for angle in limits.opening],
            "No arm angles are left: within upper_arm_deg and forearm_deg the difference runs from "
            f"{min(openings) / DEGREE:g}° to {max(openings) / DEGREE:g}°.",
            "Widen opening_deg, upper_arm_deg or forearm_deg.",
        )  # fmt: skip
    poses = [_pose(spec, task) for task in spec.poses]
    parts = [_region(region, limits.base[1] - limits.base[0]) for region in workspace]
    nearest = min(part.r_min.value_mm for part in parts)
    farthest = max(part.r_max.value_mm for part in parts)
    return PalletisingArm(
        id=question_id(spec, KIND),
        name=spec.name,
        engine_version=engine_version(),
        status="feasible" if all(pose.reachable for pose in poses) else "infeasible",
        spec=spec,
        reach_mm=max(farthest, -nearest),
        regions=parts,
        singular=[
            ArmsInLine(opening_deg=round(first[0] - first[1], 9), from_deg=first, to_deg=last)
            for first, last in (map(_degrees, ends) for ends in limits.singular_segments())
        ],
        over_axis=nearest <= 0.0 <= farthest,
        torques=_largest_torques(spec, workspace),
        poses=poses,
    )


def _degrees(corner: Corner) -> Corner:
    return corner[0] / DEGREE, corner[1] / DEGREE


def _region(region: Region, base_range: float) -> WorkRegion:
    """The answer about one region; ``base_range``: by how much the base turns [rad]."""
    extremes = {}
    for name, way in (("r_max", 1.0), ("r_min", -1.0), ("z_max", 1j), ("z_min", -1j)):
        value, corner = region.farthest(way)
        upper, fore = _degrees(corner)
        value *= way.real + way.imag
        extremes[name] = ArmFarthest(value_mm=value, upper_arm_deg=upper, forearm_deg=fore)
    # Pappus: a region that the axis does not cut, turned about it at most once.
    once = base_range <= FULL_TURN + geometry.ROUNDING and extremes["r_min"].value_mm >= 0.0
    return WorkRegion(
        elbow=region.elbow,
        border=[
            BorderArc(
                keeps=arc.keeps, centre_mm=_pair(arc.centre), radius_mm=arc.radius,
                start_deg=arc.start / DEGREE, sweep_deg=arc.sweep / DEGREE,
                from_mm=_pair(arc.point(0.0)), to_mm=_pair(arc.point(1.0)),
            )
            for arc in region.border
        ],
        area_mm2=region.area,
        volume_mm3=base_range * region.moment if once else None,
        **extremes,
    )  # fmt: skip


def _pair(point: complex) -> tuple[float, float]:
    return point.real, point.imag


def _largest_torques(spec: ArmSpec, workspace: Sequence[Region]) -> list[ArmTorque]:
    """The largest |τ| of either axis: at a crest of its sine or cosine, or at an end."""
    corners = [end for each in workspace for arc in each.border for end in (arc.first, arc.last)]
    torques = []
    axes: tuple[tuple[Axis, float], ...] = (("upper_arm", geometry.RIGHT_ANGLE), ("forearm", 0.0))
    for k, (axis, crest) in enumerate(axes):
        angles = [corner[k] for corner in corners]
        low, high = min(angles), max(angles)
        crests = (crest + turn * math.pi for turn in (-1, 0, 1))
        places = np.array([low, high, *(at for at in crests if low <= at <= high)])
        shares = geometry.holding_torques((1.0, 1.0), places, places)[k]
        at = float(places[np.argmax(np.abs(shares))])
        torque = float(geometry.holding_torques(spec.static_moments, at, at)[k])
        torques.append(ArmTorque(axis=axis, torque_nm=torque, angle_deg=at / DEGREE))
    return torques


def _pose(spec: ArmSpec, task: Pose) -> ArmPose:
    place = task.place(spec.arm)
    solutions = [_solution(spec, one) for one in task.postures(spec.arm, spec.limits)]
    solutions.sort(key=lambda one: sum(each.excess_deg for each in one.beyond))
    return ArmPose(
        name=task.name,
        x_mm=place.x,
        y_mm=place.y,
        z_mm=place.z,
        yaw_deg=place.yaw / DEGREE,
        reachable=any(not one.beyond for one in solutions),
        solutions=solutions,
        note=_note(spec.arm, place, solutions),
    )


def _solution(spec: ArmSpec, posture: geometry.Posture) -> ArmSolution:
    joints, exceeded = posture.joints, spec.limits.exceeded(posture.joints)
    torques = geometry.holding_torques(spec.static_moments, joints.upper_arm, joints.forearm)
    return ArmSolution(
        base=posture.base,
        elbow=posture.elbow,
        **{f"{name}_deg": angle / DEGREE for name, angle in vars(joints).items()},
        beyond=[BeyondLimit(joint=name, excess_deg=by / DEGREE) for name, by in exceeded],
        in_line=math.cos(joints.opening),
        torque_upper_nm=float(torques[0]),
        torque_forearm_nm=float(torques[1]),
    )


def _note(arm: geometry.Arm, place: geometry.Place, solutions: Sequence[ArmSolution]) -> str:
    """Why a place cannot be reached and what would help, or that any base angle will do."""
    away = math.hypot(place.x, place.y)
    if not solutions:
        far = abs(complex(away, place.z) - arm.origin)
        least, most = abs(arm.upper - arm.fore), arm.upper + arm.fore
        way = f"{far - most:.6g} mm nearer" if far > most else f"{least - far:.6g} mm farther away"
        return (
            f"The wrist would be {far:.6g} mm from the shoulder, but the arms reach from "
            f"{least:.6g} to {most:.6g} mm. Choose a place {way}, or longer arms."
        )
    best = solutions[0]
    if best.beyond:  # sorted: then all of them exceed a limit
        broken = ", ".join(f"{each.joint} by {each.excess_deg:.6g}°" for each in best.beyond)
        return (
            f"Every posture there exceeds a limit; the nearest is {best.base} with the elbow "
            f"{best.elbow}, which exceeds {broken}. Widen these limits, or choose another place."
        )
    if away <= geometry.ROUNDING * (arm.upper + arm.fore):
        return "The tool is on axis 1: any base angle will do."
    return ""
