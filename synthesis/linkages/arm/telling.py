"""A palletising arm as the answer tells it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from synthesis.design import engine_version, question_id
from synthesis.errors import InputError
from synthesis.linkages.arm import found as wire
from synthesis.linkages.arm import statics, workspace
from synthesis.linkages.arm.geometry import Arm, Place, Posture
from synthesis.linkages.arm.limits import Corner, Span
from synthesis.linkages.arm.spec import ArmSpec, Asked
from synthesis.units import DEGREE, FULL_TURN

KIND = "palletising arm"
AXIS = 1e-9  # of the reach: nearer to axis 1 the tool is on it
RIGHT = 0.5 * math.pi


def told(spec: ArmSpec) -> wire.PalletisingArm:
    """Everything that is known of an arm.

    Raises:
        InputError: the limits exclude each other.
    """
    arm, limits = spec.arm, spec.limits
    regions = workspace.regions(arm, limits)
    if not regions:
        openings = [upper - fore for upper in limits.upper for fore in limits.fore]
        raise InputError(
            "/opening_deg", [angle / DEGREE for angle in limits.opening],
            "No arm angle is left: with upper_arm_deg and forearm_deg the difference runs from "
            f"{min(openings) / DEGREE:g} to {max(openings) / DEGREE:g}°, and a region needs room.",
            "Widen opening_deg, or the limits of an arm.",
        )  # fmt: skip
    corners = [corner for region in regions for corner in region.corners]
    poses = [_pose(spec, asked) for asked in spec.poses]
    nearest = min(-region.farthest(-1.0, 0.0)[0] for region in regions)
    reach = max(region.farthest(1.0, 0.0)[0] for region in regions)
    return wire.PalletisingArm(
        id=question_id(spec, KIND),
        name=spec.name,
        engine_version=engine_version(),
        status="feasible" if all(pose.reachable for pose in poses) else "infeasible",
        spec=spec,
        reach_mm=max(reach, -nearest),
        regions=[_region(region, limits.base) for region in regions],
        singular=[_in_line(*ends) for ends in workspace.in_line(limits)],
        over_axis=nearest <= 0.0 <= reach,
        torques=_torques(spec, corners),
        poses=poses,
    )


def _region(region: workspace.Region, base: Span) -> wire.WorkRegion:
    ends = {
        name: _farthest(region, across, up)
        for name, across, up in (
            ("r_max", 1.0, 0.0), ("r_min", -1.0, 0.0), ("z_max", 0.0, 1.0), ("z_min", 0.0, -1.0),
        )
    }  # fmt: skip
    turns = base[1] - base[0]
    once = turns <= FULL_TURN * (1.0 + 1e-12) and ends["r_min"].value_mm >= 0.0
    return wire.WorkRegion(
        elbow=region.elbow,
        border=[_arc(arc) for arc in region.border],
        area_mm2=region.area,
        volume_mm3=turns * region.moment if once else None,
        **ends,
    )


def _farthest(region: workspace.Region, across: float, up: float) -> wire.ArmFarthest:
    value, (upper, fore) = region.farthest(across, up)
    return wire.ArmFarthest(
        value_mm=value * (across + up), upper_arm_deg=upper / DEGREE, forearm_deg=fore / DEGREE
    )


def _arc(arc: workspace.Arc) -> wire.BorderArc:
    return wire.BorderArc.model_validate(
        {
            "keeps": arc.keeps,
            "centre_mm": (arc.x, arc.y),
            "radius_mm": arc.radius,
            "start_deg": arc.start / DEGREE,
            "sweep_deg": arc.sweep / DEGREE,
            "from_mm": arc.point(0.0),
            "to_mm": arc.point(1.0),
        }
    )


def _in_line(first: Corner, last: Corner) -> wire.ArmsInLine:
    def degrees(corner: Corner) -> tuple[float, float]:
        return corner[0] / DEGREE, corner[1] / DEGREE

    return wire.ArmsInLine(
        opening_deg=round((first[0] - first[1]) / DEGREE, 9),
        from_deg=degrees(first),
        to_deg=degrees(last),
    )


def _torques(spec: ArmSpec, corners: Sequence[Corner]) -> list[wire.ArmTorque]:
    """The largest |τ| of either axis, each a wave of its own angle."""
    first, second = statics.moments(spec.weights)
    uppers, fores = zip(*corners, strict=True)
    told = (
        ("upper_arm", first, math.sin, uppers, RIGHT),
        ("forearm", second, math.cos, fores, 0.0),
    )
    found = []
    for axis, moment, wave, angles, crest in told:
        at = _crest(min(angles), max(angles), crest, wave)
        torque = {"axis": axis, "torque_nm": 0.0 - moment * wave(at), "angle_deg": at / DEGREE}
        found.append(wire.ArmTorque.model_validate(torque))
    return found


def _crest(low: float, high: float, crest: float, wave: Callable[[float], float]) -> float:
    """Where between two angles a wave is farthest from 0."""
    inside = (crest + k * math.pi for k in range(-3, 4))
    return max(
        (low, high, *(at for at in inside if low <= at <= high)), key=lambda at: abs(wave(at))
    )


def _pose(spec: ArmSpec, asked: Asked) -> wire.ArmPose:
    arm, limits = spec.arm, spec.limits
    place = asked.place(arm)
    solutions = [_solution(spec, one) for one in asked.postures(arm, limits)]
    solutions.sort(key=lambda one: sum(each.by_deg for each in one.beyond))
    reachable = any(not one.beyond for one in solutions)
    return wire.ArmPose(
        name=asked.name,
        x_mm=place.x,
        y_mm=place.y,
        z_mm=place.z,
        yaw_deg=place.yaw / DEGREE,
        reachable=reachable,
        solutions=solutions,
        note=_note(arm, place, solutions),
    )


def _solution(spec: ArmSpec, one: Posture) -> wire.ArmSolution:
    joints = one.joints
    holds = statics.holding(spec.weights, joints.upper, joints.fore)
    beyond = [
        wire.BeyondLimit.model_validate({"joint": name, "by_deg": by / DEGREE})
        for name, by in spec.limits.broken(joints)
    ]
    return wire.ArmSolution(
        base=one.base,
        elbow=one.elbow,
        base_deg=joints.base / DEGREE,
        upper_arm_deg=joints.upper / DEGREE,
        forearm_deg=joints.fore / DEGREE,
        tool_deg=joints.tool / DEGREE,
        beyond=beyond,
        in_line=math.cos(joints.opening),
        torque_upper_nm=holds.upper,
        torque_forearm_nm=holds.fore,
    )


def _note(arm: Arm, place: Place, solutions: Sequence[wire.ArmSolution]) -> str:
    """Why a place cannot be reached and what would help, or that the base may stand anyhow."""
    away = math.hypot(place.x, place.y)
    if not solutions:
        far = math.hypot(away - arm.shoulder - arm.wrist, place.z - arm.height + arm.tool)
        least, most = abs(arm.upper - arm.fore), arm.upper + arm.fore
        way = f"{far - most:.6g} mm nearer" if far > most else f"{least - far:.6g} mm farther away"
        return (
            f"The wrist would be {far:.6g} mm from the shoulder; the arms reach from {least:.6g} "
            f"to {most:.6g} mm. Choose a place {way}, or longer arms."
        )
    if all(one.beyond for one in solutions):
        best = solutions[0]
        broken = ", ".join(f"{each.joint} by {each.by_deg:.6g}°" for each in best.beyond)
        return (
            f"Every way there exceeds a limit; {best.base} with the elbow {best.elbow} comes "
            f"nearest: {broken}. Widen that, or choose another place."
        )
    if away <= AXIS * (arm.upper + arm.fore):
        return "The tool is on axis 1: the base may stand anyhow."
    return ""
