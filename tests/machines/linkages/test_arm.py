"""The arm: round trips, regions against a grid, torques against the change of energy."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from pydantic import ValidationError

from synthesis.errors import InputError
from synthesis.machines.linkages.arm import ArmSpec, analyse_arm
from synthesis.machines.linkages.arm.geometry import (
    Arm,
    G,
    Joints,
    Limits,
    Place,
    holding_torques,
    regions,
    static_moments,
    wrap_angle,
)

IRB660 = Arm(800.0, 300.0, 1280.0, 1350.0, 260.0, 247.0)
ODD = Arm(311.3, -41.7, 517.9, 263.1, 87.3, -19.7)


def degrees(*spans: tuple[float, float]) -> Limits:
    return Limits(*((math.radians(low), math.radians(high)) for low, high in spans))


MAKERS = degrees((-180, 180), (-42, 85), (-20, 120), (-80, 70), (-300, 300))
BOTH_ELBOWS = degrees((-180, 180), (-42, 85), (-20, 120), (-400, 70), (-300, 300))


@pytest.mark.parametrize("arm", [IRB660, ODD], ids=["IRB 660", "odd"])
def test_round_trip(arm: Arm) -> None:
    """Every posture found is at the place; one of them is the posture that the place came from."""
    size = arm.upper + arm.fore
    for base, upper, fore, tool in np.random.default_rng(7).uniform(-3.1, 3.1, (200, 4)):
        joints = Joints(base, upper, fore, tool)
        place, found = arm.place(joints), list(arm.postures(arm.place(joints)))
        for one in found:
            again = arm.place(one.joints)
            apart = math.dist((place.x, place.y, place.z), (again.x, again.y, again.z))
            assert apart <= 1e-12 * size
            assert abs(wrap_angle(again.yaw - place.yaw)) <= 1e-12
        off = min(
            max(abs(wrap_angle(getattr(one.joints, n) - getattr(joints, n))) for n in vars(joints))
            for one in found
        )
        assert off <= 1e-12 / abs(math.cos(joints.opening)) + 1e-12


def test_every_posture_is_named_once() -> None:
    names = {(one.base, one.elbow) for one in IRB660.postures(Place(1100.0, 300.0, 800.0, 0.2))}
    assert names == {(base, elbow) for base in ("front", "over") for elbow in ("up", "down")}
    assert not list(IRB660.postures(Place(4500.0, 0.0, 9.0, 0.0)))


def on_grid(arm: Arm, limits: Limits, elbow: str, box: tuple[float, ...], n: int) -> float:
    """Area by counting the cells whose middle has a posture within the limits."""
    left, right, low, high = box
    cell = (right - left) * (high - low) / n**2
    count = 0
    for r in left + (right - left) * (np.arange(n) + 0.5) / n:
        for z in low + (high - low) * (np.arange(n) + 0.5) / n:
            for one in arm.postures(Place(abs(r), 0.0, z, 0.0)):
                if one.elbow == elbow and (one.base == "front") == (r >= 0.0):
                    joints = Joints(0.0, one.joints.upper_arm, one.joints.forearm, 0.0)
                    count += not limits.exceeded(next(limits.equivalent_angles(joints)))
    return count * cell


@pytest.mark.parametrize(
    ("arm", "limits"),
    [(IRB660, BOTH_ELBOWS), (ODD, degrees((0, 90), (-97, 61), (-83, 151), (-131, 71), (0, 1)))],
    ids=["IRB 660", "odd"],
)
def test_area_is_that_of_a_grid(arm: Arm, limits: Limits) -> None:
    found = regions(arm, limits)
    assert {one.elbow for one in found} == {"up", "down"}
    for region in found:
        r, z = region.farthest(1)[0], region.farthest(1j)[0]
        box = (-region.farthest(-1)[0], r, -region.farthest(-1j)[0], z)
        assert region.area == pytest.approx(on_grid(arm, limits, region.elbow, box, 70), rel=1e-2)


def test_moment_is_that_of_the_polygon_through_the_border() -> None:
    """∫ r dA by the trapezoid rule over points of the border."""
    (region,) = regions(IRB660, MAKERS)
    points = [arc.point(s) for arc in region.border for s in np.linspace(0, 1, 400)[:-1]]
    moment = sum(0.5 * (a.real**2 + b.real**2) / 2 * (b.imag - a.imag)
                 for a, b in pairwise([*points, points[0]]))  # fmt: skip
    assert region.moment == pytest.approx(abs(moment), rel=1e-5)


def test_borders_are_closed_and_lie_on_limits() -> None:
    for region in regions(IRB660, BOTH_ELBOWS):
        for arc, following in pairwise([*region.border, region.border[0]]):
            assert arc.point(1.0) == pytest.approx(following.point(0.0), abs=1e-9)
            for share in (0.0, 0.3, 1.0):
                angles = arc.angles(share)
                assert arc.point(share) == pytest.approx(IRB660.tool_point(*angles), abs=1e-9)


def test_reach_of_the_irb_660_is_the_makers() -> None:
    (region,) = regions(IRB660, MAKERS)
    reach, (upper, fore) = region.farthest(1)
    assert reach == pytest.approx(3150.0, abs=0.5)
    assert math.degrees(upper - fore) == pytest.approx(70.0, abs=1e-9)
    assert not MAKERS.singular_segments()
    ((first, last),) = BOTH_ELBOWS.singular_segments()
    for corner in (first, last):
        assert corner[0] - corner[1] == pytest.approx(-0.5 * math.pi, abs=1e-12)


def test_torques_are_the_change_of_energy() -> None:
    parts = [(181.0, 611.0, 0.0), (143.0, 1280.0, 521.0), (29.0, 640.0, -287.0),
             (250.0, 1280.0, 1350.0)]  # fmt: skip

    def energy(upper: float, fore: float) -> float:
        heights = (mass * (p * math.cos(upper) - w * math.sin(fore)) for mass, p, w in parts)
        return G * 1e-3 * sum(heights)

    h = 1e-5
    for upper, fore in ((0.3, 0.7), (-0.5, 1.9), (1.4, -0.2)):
        found = holding_torques(static_moments(parts), upper, fore)
        by_upper = (energy(upper + h, fore) - energy(upper - h, fore)) / (2.0 * h)
        by_fore = (energy(upper, fore + h) - energy(upper, fore - h)) / (2.0 * h)
        assert found == pytest.approx((by_upper, by_fore), rel=1e-8)


SPEC = {
    "shoulder_height_mm": 800, "shoulder_offset_mm": 300, "upper_arm_mm": 1280,
    "forearm_mm": 1350, "wrist_offset_mm": 260, "tool_mm": 247,
    "upper_arm_deg": {"min": -42, "max": 85}, "forearm_deg": {"min": -20, "max": 120},
    "opening_deg": {"min": -80, "max": 70}, "tool_deg": {"min": -300, "max": 300},
    "masses": [{"name": "upper arm", "mass_kg": 180, "upper_arm_mm": 600}],
}  # fmt: skip


def test_poses() -> None:
    poses = [
        {"kind": "joints", "upper_arm_deg": 20, "forearm_deg": 30, "base_deg": 33},
        {"kind": "point", "x_mm": 2500, "y_mm": -600, "z_mm": 900, "yaw_deg": 100},
        {"kind": "point", "x_mm": 4500, "z_mm": 9},
        {"kind": "joints", "upper_arm_deg": 80, "forearm_deg": -10},
    ]
    given = ArmSpec.model_validate({**SPEC, "payload_kg": 231.0, "poses": poses})
    found = analyse_arm(given)
    there, point, far, wide = found.poses
    assert [pose.reachable for pose in found.poses] == [True, True, False, False]
    assert found.status == "infeasible"
    back = {"kind": "point", "x_mm": there.x_mm, "y_mm": there.y_mm, "z_mm": there.z_mm}
    again = analyse_arm(ArmSpec.model_validate({**SPEC, "poses": [{**back, "yaw_deg": 33}]})).poses[
        0
    ]
    best = again.solutions[0]
    angles = best.base_deg, best.upper_arm_deg, best.forearm_deg
    assert angles == pytest.approx((33, 20, 30), abs=1e-10)
    tools = {one.tool_deg for one in point.solutions if not one.beyond}
    assert max(tools) - min(tools) == pytest.approx(360.0)  # ±300° hold both
    assert far.note.startswith("The wrist would be 3977.38 mm from the shoulder")
    assert [each.joint for each in wide.solutions[0].beyond] == ["opening"]
    assert wide.solutions[0].beyond[0].excess_deg == pytest.approx(20.0)
    held = there.solutions[0]
    upper = -9.80665 * (231.0 * 1.28 + 180.0 * 0.6) * math.sin(math.radians(20.0))
    assert held.torque_upper_nm == pytest.approx(upper, rel=1e-12)
    assert held.torque_forearm_nm == pytest.approx(
        -9.80665 * 231.0 * 1.35 * math.cos(math.radians(30.0)), rel=1e-12
    )
    assert [(t.axis, t.angle_deg) for t in found.torques] == [("upper_arm", 85), ("forearm", 0)]


def test_gravity_is_a_field() -> None:
    """Torques are in proportion to it: a book's g gives the book's."""
    body = SPEC | {"poses": [{"kind": "joints", "upper_arm_deg": 20, "forearm_deg": 30}]}
    standard, other, none = (
        analyse_arm(ArmSpec.model_validate(body | more))
        for more in ({}, {"gravity_m_per_s2": 9.81}, {"gravity_m_per_s2": 0.0})
    )
    for one, by_book in zip(standard.torques, other.torques, strict=True):
        assert by_book.torque_nm == pytest.approx(one.torque_nm * 9.81 / 9.80665, rel=1e-14)
    held, by_book = (each.poses[0].solutions[0] for each in (standard, other))
    assert by_book.torque_upper_nm * 9.80665 == pytest.approx(held.torque_upper_nm * 9.81)
    assert by_book.torque_forearm_nm * 9.80665 == pytest.approx(held.torque_forearm_nm * 9.81)
    assert [one.torque_nm for one in none.torques] == [0.0, 0.0]


def test_limits_that_exclude_each_other_are_refused() -> None:
    spec = ArmSpec.model_validate({**SPEC, "opening_deg": {"min": 110}})
    with pytest.raises(InputError, match="No arm angles are left") as refused:
        analyse_arm(spec)
    assert refused.value.field == "/opening_deg"
    with pytest.raises(ValidationError, match=r"min = 80.0 is above max = 70.0"):
        ArmSpec.model_validate({**SPEC, "opening_deg": {"min": 80, "max": 70}})
