"""Walls of cylindrical cams against formulas, and against rollers that know only their axes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.spatial import KDTree

from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.machines.spatial.spec import SpatialCamSpec
from tests.machines.spatial.drums import (
    APART,
    ARM_SIZES,
    INNER,
    OUTER,
    RADIUS,
    SAMPLES,
    SIZES,
    SLIDE,
    SWING_ARM,
    Array,
    cam_points,
    designed,
    least_gap,
    program,
)

RHO = np.linspace(INNER + 0.1, OUTER - 0.1, 4)
CROWN = 83.0


def angles(wall: Wall, count: int) -> Array:
    return np.concatenate([np.linspace(a, b, count)[1:-1] for a, b in wall.spans])


def wall_points(cam: SpatialCam, wall: Wall, theta: Array) -> Array:
    return cam_points(cam, wall, theta, RHO).reshape(3, -1)


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("crown", [0.0, CROWN])
@pytest.mark.parametrize("name", SAMPLES)
def test_no_roller_comes_closer_than_its_radius(name: str, crown: float, rotation: str) -> None:
    """Over a full turn, and every point of the wall is touched by one."""
    sample, turns = SAMPLES[name], 1 if rotation == "ccw" else -1
    crowned = {"crown_radius_mm": crown} if crown else {}
    cam = sample.cam(**sample.turning(rotation, **crowned))
    for wall in cam.walls:
        gap = least_gap(sample, wall_points(cam, wall, angles(wall, 23)), turns, crown)
        assert gap.min() > -1e-9
        assert gap.max() < 2e-3  # between two of the angles tried


@pytest.mark.parametrize("name", SAMPLES)
def test_nothing_moves_along_the_normal(name: str) -> None:
    cam = SAMPLES[name].cam()
    for wall in cam.walls:
        found = cam.contacts(wall, angles(wall, 41), RHO)
        assert np.abs((found.normal * found.slip).sum(axis=0)).max() < 1e-12 * OUTER


@pytest.mark.parametrize("name", SAMPLES)
def test_r_is_the_wall_ahead_of_the_roller(name: str) -> None:
    cam = SAMPLES[name].cam()
    for wall in cam.walls:
        theta = angles(wall, 41)
        found = cam.contacts(wall, theta, RHO)
        ahead = (found.normal * cam.swept.joint.velocity_per_q(found.point)).sum(axis=0)
        assert np.all(wall.side * ahead > 0.0)


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("name", ["slide in a groove", "arm in a groove", "turret"])
def test_the_pressure_angle_is_that_of_the_formula(name: str, rotation: str) -> None:
    """tan α = |s'|/ρ on a slide, |Lψ' ∓ ρ sin ψ|/(ρ cos ψ) on an arm of length L."""
    sample = SAMPLES[name]
    machine = sample.body["machine"]
    cam = sample.cam(**sample.turning(rotation))
    length = machine.get("arm_mm", machine.get("turret_radius_mm"))
    turns = 1 if rotation == "ccw" else -1
    for wall in cam.walls:
        theta = angles(wall, 57)
        q, q1, _ = cam.place(wall.seat, theta)
        if length is None:
            tangent = np.abs(q1)[:, None] / RHO
        else:
            sin, cos = np.sin(q)[:, None], np.cos(q)[:, None]
            tangent = np.abs(length * q1[:, None] - turns * RHO * sin) / (RHO * cos)
        found = cam.contacts(wall, theta, RHO).pressure_angle
        assert np.abs(found - np.arctan(tangent)).max() < 1e-13


def test_at_a_turning_point_a_wall_is_undercut_as_its_development_is() -> None:
    """There the wall is not twisted: 1 ∓ Rr s''/ρ² of the unrolled roller's path is exact."""
    sample = SAMPLES["slide in a groove"]
    steps = program("mm", 33.7)[::2]
    for step, angle in zip(steps, (157.0, 203.0), strict=True):
        step |= {"angle_deg": angle, "law": {"kind": "simple_harmonic"}}
    top = math.radians(157.0)
    bend = -0.5 * 33.7 * (math.pi / top) ** 2
    for radius in (8.7, 0.99 * RHO[0] ** 2 / -bend, 1.01 * RHO[0] ** 2 / -bend):
        cam = sample.cam(program=steps, machine=sample.body["machine"] | {
            "roller_radius_mm": radius})  # fmt: skip
        for wall in cam.walls:
            found = cam.contacts(wall, np.array([top - 1e-12]), RHO).regular
            assert found[0] == pytest.approx(1.0 - wall.side * radius * bend / RHO**2, abs=1e-9)


def test_a_turret_s_roller_leaves_where_its_inner_end_passes_beside_the_cylinder() -> None:
    cam = SAMPLES["turret"].cam()
    ((_, end),) = next(wall.spans for wall in cam.walls if wall.name == "1L")
    y, _ = SAMPLES["turret"].ways(np.array([end]))[0]
    assert y**2 + INNER**2 == pytest.approx(OUTER**2)


def test_a_rib_has_one_wall_of_each_roller() -> None:
    assert [wall.name for wall in SAMPLES["slide astride a rib"].cam().walls] == ["1L", "2R"]


def test_the_rib_s_thickness_is_the_least_distance_of_its_walls() -> None:
    design = designed("arm astride a rib")
    cam = design.cam
    reported = next(each for each in design.extremes if each.quantity == "rib_thickness")
    theta, rho = np.linspace(0.0, 2.0 * math.pi, 1501), np.linspace(INNER, OUTER, 9)
    one, other = (cam_points(cam, wall, theta, rho).reshape(3, -1).T for wall in cam.walls)
    away = KDTree(one).query(other)[0].min()
    assert reported.value == pytest.approx(away, abs=2e-3)
    assert reported.value < APART - 2.0 * RADIUS


REFUSED: list[tuple[str, dict[str, Any], str]] = [
    (SLIDE, {"roller_width_mm": 61.3}, r"radius 61.3 mm to its axis. Increase cylinder_radius_mm"),
    (SLIDE, {"roller_distance_mm": 17.4}, r"17.4 mm apart leave no rib between them"),
    (SLIDE, {"crown_radius_mm": 6.9}, r"crown_radius_mm = 6.9 the outline of a roller 13.9"),
    (
        SWING_ARM,
        ARM_SIZES | {"initial_angle_deg": 68.7},
        r"from 68.7° to 90.0° about the perpendicular",
    ),
]


@pytest.mark.parametrize(("kind", "changes", "reported"), REFUSED)
def test_what_no_machine_can_do_is_refused(
    kind: str, changes: dict[str, Any], reported: str
) -> None:
    steps = program("mm", 33.7) if kind == SLIDE else program("deg", 21.3)
    with pytest.raises(ValidationError, match=reported):
        SpatialCamSpec(program=steps, machine={"kind": kind, **SIZES, **changes})


def test_a_follower_that_stands_still_is_refused() -> None:
    with pytest.raises(ValidationError, match="never moves"):
        SpatialCamSpec(
            program=[{"kind": "dwell", "angle_deg": 360.0}], machine={"kind": SLIDE, **SIZES}
        )


def test_a_follower_that_does_not_come_back_is_refused() -> None:
    steps = [*program("mm", 33.7)[:2], {"kind": "dwell", "angle_deg": 211.0}]
    with pytest.raises(ValidationError, match=r"ends 33.7 mm away from where it began"):
        SpatialCamSpec(program=steps, machine={"kind": SLIDE, **SIZES})


@pytest.mark.parametrize("crown", [None, CROWN])
def test_rows_of_the_pressure_angle_are_kept_up_to_it(crown: float | None) -> None:
    """Where the walls' largest is the limit, the tightest row is met."""
    sample = SAMPLES["slide in a groove"]
    spec = sample.spec(machine=sample.body["machine"] | {"crown_radius_mm": crown})
    cam = sample.cam(machine=sample.body["machine"] | {"crown_radius_mm": crown})
    theta, rho = np.array([0.6, 1.03]), np.linspace(INNER, OUTER, 4001)
    slope = np.tan(cam.contacts(cam.walls[0], theta, rho).pressure_angle.max(axis=1))
    for limit, speed in zip(slope, cam.motion.derivatives(theta, 1)[1], strict=True):
        rows = spec.machine.pressure_angle_rows({"roller_radius_mm": RADIUS}, float(limit))
        spare = [row.upper - row.coefficients[1] * speed - row.size[0] * OUTER for row in rows]
        assert min(spare) == pytest.approx(0.0, abs=1e-9 if crown is None else 2e-2)
