"""P6: a palletising arm, against formulas that the product does not use.

Places by a chain of matrices, angles by two circles that cut, areas by integrating the Jacobian
over the angles, and torques by the free bodies of its six links.
"""

from __future__ import annotations

import runpy
from itertools import pairwise
from math import asin, cos, degrees, dist, hypot, pi, radians, sin, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from service.contract.examples import examples
from synthesis.machines.linkages.arm import ArmSpec, PalletisingArm, analyse_arm

Array = NDArray[np.float64]
DOCS = Path(__file__).resolve().parents[2] / "docs" / "reference"
D1, A1, A2, A3, A4, TOOL = 800.0, 300.0, 1280.0, 1350.0, 260.0, 247.0
UPPER, FORE, Q = (-42.0, 85.0), (-20.0, 120.0), (-80.0, 70.0)
LEVER = 300.0  # behind the elbow, where the driving rod takes hold
G = 9.80665


def solve(**changes: Any) -> PalletisingArm:
    value = examples("linkages/palletising-arms")["irb-660"]["value"]
    return analyse_arm(ArmSpec.model_validate(value | changes))


@pytest.fixture(scope="module")
def p6() -> PalletisingArm:
    return solve()


def moved(x: float, z: float) -> Array:
    found = np.eye(4)
    found[0, 3], found[2, 3] = x, z
    return found


def turned(axis: int, angle: float) -> Array:
    """About an axis by a right-handed angle."""
    found, (i, j) = np.eye(4), ((axis + 1) % 3, (axis + 2) % 3)
    found[[i, i, j, j], [i, j, i, j]] = cos(angle), -sin(angle), sin(angle), cos(angle)
    return found


def chain(base: float, upper: float, fore: float, tool: float) -> Array:
    """Joint by joint; a parallelogram turns back what its arm has turned."""
    return (
        turned(2, base) @ moved(A1, D1)
        @ turned(1, upper) @ moved(0.0, A2) @ turned(1, -upper)
        @ turned(1, fore) @ moved(A3, 0.0) @ turned(1, -fore)
        @ moved(A4, -TOOL) @ turned(2, tool)
    )  # fmt: skip


def test_every_way_of_being_at_a_pose_is_there_by_the_chain(p6: PalletisingArm) -> None:
    for pose in p6.poses:
        for one in pose.solutions:
            joints = (one.base_deg, one.upper_arm_deg, one.forearm_deg, one.tool_deg)
            there = chain(*(radians(each) for each in joints))
            assert there[:3, 3] == pytest.approx((pose.x_mm, pose.y_mm, pose.z_mm), abs=1e-9)
            upright = turned(2, radians(pose.yaw_deg))
            assert np.abs(there[:3, :3] - upright[:3, :3]).max() < 1e-14


def test_the_angles_are_those_of_two_circles_that_cut(p6: PalletisingArm) -> None:
    (pick,) = (pose for pose in p6.poses if pose.name == "pick")
    x, z = hypot(pick.x_mm, pick.y_mm) - A1 - A4, pick.z_mm - D1 + TOOL
    away = hypot(x, z)
    along = (A2**2 - A3**2 + away**2) / (2.0 * away)
    beside = sqrt(A2**2 - along**2)
    elbows = [((along * x - s * beside * z) / away, (along * z + s * beside * x) / away)
              for s in (1.0, -1.0)]  # fmt: skip
    for one, elbow in zip(pick.solutions, elbows, strict=True):
        upper, fore = radians(one.upper_arm_deg), radians(one.forearm_deg)
        assert (A2 * sin(upper), A2 * cos(upper)) == pytest.approx(elbow, abs=1e-9)
        wrist = elbow[0] + A3 * cos(fore), elbow[1] - A3 * sin(fore)
        assert dist(wrist, (x, z)) < 1e-9


def test_the_stated_reach_implies_70_degrees(p6: PalletisingArm) -> None:
    """a1 + a4 + √(a2² + a3² + 2 a2 a3 sin q) = 3150 mm at q = 69.98°."""
    q = degrees(asin(((3150.0 - A1 - A4) ** 2 - A2**2 - A3**2) / (2.0 * A2 * A3)))
    assert q == pytest.approx(69.9817, abs=5e-5)
    found = solve(opening_deg={"min": -80.0, "max": q})
    assert found.reach_mm == pytest.approx(3150.0, rel=1e-13)
    assert p6.reach_mm == pytest.approx(3150.0, abs=0.1)
    free = solve(opening_deg={})
    stretched = A1 + A4 + A2 * sin(radians(85.0)) + A3  # A2 stops it, the forearm is level
    assert free.reach_mm == pytest.approx(stretched, rel=1e-13)
    assert [one.opening_deg for one in free.singular] == [-90.0, 90.0]


def over_angles(low: float, high: float) -> tuple[float, float]:
    """∬ |J| and 2π ∬ r |J| with J = a2 a3 cos q, over angles with q within limits [deg]."""
    breaks = {UPPER[0], UPPER[1], *(fore + q for fore in FORE for q in (low, high))}
    edges = sorted(each for each in breaks if UPPER[0] <= each <= UPPER[1])
    nodes, weights = np.polynomial.legendre.leggauss(16)
    area = moment = 0.0
    for first, last in pairwise(edges):
        for node, weight in zip(nodes, weights, strict=True):
            upper = 0.5 * (first + last + (last - first) * node)
            down, up = max(FORE[0], upper - high), min(FORE[1], upper - low)
            if up <= down:
                continue
            fore = 0.5 * (down + up + (up - down) * nodes)
            cell = 0.25 * (last - first) * (up - down) * radians(1.0) ** 2 * weight * weights
            q = np.radians(upper - fore)
            patch = cell * A2 * A3 * np.abs(np.cos(q))
            r = A1 + A4 + A2 * sin(radians(upper)) + A3 * np.cos(np.radians(fore))
            area += float(patch.sum())
            moment += float((patch * r).sum())
    return area, 2.0 * pi * moment


def test_area_and_volume_are_the_jacobian_s_integrals(p6: PalletisingArm) -> None:
    (region,) = p6.regions
    area, volume = over_angles(*Q)
    assert region.area_mm2 == pytest.approx(area, rel=1e-12)
    assert region.volume_mm3 == pytest.approx(volume, rel=1e-12)


def test_areas_without_limits_of_the_opening_too() -> None:
    parts = [(-200.0, -90.0), (-90.0, 90.0), (90.0, 200.0)]
    found = solve(opening_deg={}).regions
    assert [one.elbow for one in found] == ["down", "up", "down"]
    for one, limits in zip(found, parts, strict=True):
        assert one.area_mm2 == pytest.approx(over_angles(*limits)[0], rel=1e-11)


def held(upper: float, fore: float, payload: float, links: float, beside: float) -> list[float]:
    """Torques of axes 2 and 3 [N·m]: 18 equations of six links, moments about the shoulder.

    The links: upper arm, forearm, the crank and the rod that drive it, the tilting frame at the
    elbow and the wrist, both kept upright by tie rods beside the arms.
    """
    u, f = np.array([sin(upper), cos(upper)]), np.array([cos(fore), -sin(fore)])
    elbow, wrist, shoulder = A2 * u, A2 * u + A3 * f, np.zeros(2)
    arm, forearm, crank, rod, frame, tool = range(6)
    ground = None
    pins = [
        (shoulder, arm, ground), (shoulder, crank, ground), (-LEVER * f, rod, crank),
        (elbow - LEVER * f, forearm, rod), (elbow, forearm, arm), (elbow, frame, arm),
        (wrist, tool, forearm),
    ]  # fmt: skip
    lower_tie, upper_tie = np.array([-230.0, 110.0]), np.array([90.0, 170.0])
    columns: list[list[tuple[int | None, Array, Array, float]]] = []
    for point, first, second in pins:
        for push in np.eye(2):
            columns.append([(first, point, push, 0.0), (second, point, -push, 0.0)])
    columns.append([(frame, elbow + lower_tie, u, 0.0)])
    columns.append([(tool, wrist + upper_tie, f, 0.0), (frame, elbow + upper_tie, -f, 0.0)])
    columns += [[(body, shoulder, shoulder, -1.0)] for body in (arm, crank)]  # clockwise positive
    loads = [
        (arm, 600.0 * u, links * 180.0), (forearm, elbow + 520.0 * f, links * 140.0),
        (rod, 0.5 * A2 * u - LEVER * f, links * 30.0),
        (tool, wrist + np.array([A4 + beside, -TOOL]), payload),
    ]  # fmt: skip
    columns.append([(body, at, np.array([0.0, -G * mass]), 0.0) for body, at, mass in loads])
    matrix = np.zeros((18, len(columns)))
    for k, acting in enumerate(columns):
        for body, (x, z), (right, up), moment in acting:
            if body is not None:
                matrix[3 * body : 3 * body + 3, k] += right, up, x * up - z * right + moment
    return list(1e-3 * np.linalg.solve(matrix[:, :18], -matrix[:, 18])[-2:])


@pytest.mark.parametrize("beside", [0.0, 410.0])
@pytest.mark.parametrize(("payload", "links"), [(250.0, 0.0), (0.0, 1.0), (250.0, 1.0)])
def test_torques_are_those_of_the_free_bodies(payload: float, links: float, beside: float) -> None:
    """A load beside the tool's axis is held by the tie rods: it changes no torque."""
    changes = {} if links else {"masses": []}
    found = solve(payload_kg=payload, **changes)
    for pose in found.poses:
        for one in pose.solutions:
            angles = radians(one.upper_arm_deg), radians(one.forearm_deg)
            true = held(*angles, payload, links, beside)
            mine = one.torque_upper_nm, one.torque_forearm_nm
            assert mine == pytest.approx(true, rel=1e-10, abs=1e-8)


def test_the_page_is_what_its_command_prints(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(DOCS / "p6.py"), run_name="__main__")
    page = (DOCS / "p6.md").read_text(encoding="utf-8")
    tables = capsys.readouterr().out.strip().split("\n\n")
    assert len(tables) == 6
    for table in tables:
        assert table in page, "docs/reference/p6.md is out of date: python docs/reference/p6.py"
