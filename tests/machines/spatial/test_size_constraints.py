"""Limits on pressure angle and walls as formulations know them, against contacts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from synthesis.catalogue.constraints import MotionSizeBox
from synthesis.machines.spatial.cylindrical import CylindricalOscillating
from synthesis.machines.spatial.machine import LEFT, RIGHT
from synthesis.machines.spatial.size_constraints import SizeConstraint
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics.geometry.swept_roller import FollowerState
from tests.machines.spatial.sizes import globoidal, pressure_angle

ALPHA = math.radians(43.7)
MOVED, BENT = 1.31, 4.1  # q' and q'' [rad/rad^k]


def states(count: int) -> np.ndarray:
    """q, q', q'' and q''' of an index, none like the other: (4, n)."""
    rng = np.random.default_rng(11)
    q = rng.uniform(0.0, math.pi / 3.0, count)
    return np.stack([q, rng.uniform(-MOVED, MOVED, count),
                     rng.uniform(-BENT, BENT, count), 0.0 * q])  # fmt: skip


def spec_of(**machine: Any) -> SpatialCamSpec:
    return SpatialCamSpec.model_validate(globoidal(pressure_angle(43.7), **machine))


def curves(spec: SpatialCamSpec) -> tuple[SizeConstraint, dict[str, float]]:
    sizes = {"roller_inner_mm": 71.3, "roller_radius_mm": 11.2}
    (pressure,) = spec.machine.pressure_angle_curves(sizes, math.tan(ALPHA), 1)
    return pressure, sizes


def least(curve: SizeConstraint, state: np.ndarray, length: float) -> np.ndarray:
    (planes,) = curve.half_planes(length * state)
    return -planes.upper


@pytest.mark.parametrize("machine", [
    {"hand": "left"}, {"hand": "right", "dwell_on": "groove"}, {"rollers": 7, "lift": 360 / 7},
    {"crown_radius_mm": 187.0}, {"crown_radius_mm": 187.0, "hand": "left", "rollers": 12},
])  # fmt: skip
def test_the_least_centre_distance_is_where_contacts_lean_as_far_as_they_may(
    machine: dict[str, Any],
) -> None:
    spec = spec_of(**machine)
    curve, sizes = curves(spec)
    length = spec.machine.length_scale(sizes)
    rho = np.linspace(71.3, 101.0, 129)
    state = states(24)
    for k, c in enumerate(least(curve, state, length)):
        swept = spec.machine.swept_roller({**sizes, "centre_distance_mm": float(c)}, 1)
        at = state[:, k : k + 1]
        angles = [
            swept.contacts(FollowerState(seat.start + at[0] + turn, at[1], at[2]), rho, side)
            for seat in spec.machine.seats()
            for turn in (0.0, 2.0 * math.pi)
            if abs(math.remainder(seat.start + float(at[0, 0]), 2.0 * math.pi)) < 1.4
            for side in (LEFT, RIGHT)
        ]
        most = max(float(found.pressure_angle.max()) for found in angles)
        assert most == pytest.approx(ALPHA, abs=2e-6)


@pytest.mark.parametrize("machine", [{}, {"rollers": 9, "lift": 40.0}, {"mesh_angle_deg": 47.0}])
def test_what_walls_have_left_is_what_contacts_say(machine: dict[str, Any]) -> None:
    spec = spec_of(**machine)
    _, sizes = curves(spec)
    (curve,) = spec.machine.wall_radius_curves(sizes, 3.1)
    length, state = spec.machine.length_scale(sizes), states(60)
    larger = {**sizes, "roller_radius_mm": 11.2 + 3.1}
    mesh = spec.machine.mesh_range(sizes)[1]
    touched = 0
    for k, c in enumerate(least(curve, state, length)):
        swept = spec.machine.swept_roller({**larger, "centre_distance_mm": float(c)}, 1)
        at = state[:, k : k + 1]
        places = [math.remainder(seat.start + float(at[0, 0]), 2.0 * math.pi)
                  for seat in spec.machine.seats()]  # fmt: skip
        left = min(
            float(swept.contacts(FollowerState(np.array([p]), at[1], at[2]),
                                 np.array([71.3, 101.0]), side).regular.min())
            for p in places if abs(p) <= mesh for side in (LEFT, RIGHT)
        )  # fmt: skip
        assert left > -1e-7
        touched += left < 1e-7
        wider = np.array([1.03, 1.1, 1.4, 3.0]) * c
        assert all(curve.excess(length * at, (size,))[0] < 1e-9 for size in wider)
    assert touched > 12  # elsewhere rollers on their way in are the hardest, or none is hard


@pytest.mark.parametrize("turns", [1, -1])
@pytest.mark.parametrize("machine", [{}, {"roller_distance_mm": 31.3, "pivot_distance_mm": 93.0}])
def test_an_arm_s_least_cylinder_is_where_contacts_lean_as_far_as_they_may(
    machine: dict[str, Any], turns: int
) -> None:
    question = {"arm_mm": 97.3, "initial_angle_deg": -9.1, "cylinder_radius_mm": 80.0,
             "roller_radius_mm": 8.9, "roller_width_mm": 13.7} | machine  # fmt: skip
    arm = CylindricalOscillating.model_validate(question)
    sizes = {"roller_radius_mm": 8.9}
    (curve,) = arm.pressure_angle_curves(sizes, math.tan(ALPHA), turns)
    state = states(24) * np.array([0.4, 0.6, 1.0, 1.0])[:, None]
    (planes,) = curve.half_planes(arm.length_scale(sizes) * state)
    for k, radius in enumerate(-planes.upper):
        swept = arm.swept_roller({**sizes, "cylinder_radius_mm": float(radius)}, turns)
        at, rho = state[:, k : k + 1], np.linspace(swept.roller.inner, swept.roller.outer, 9)
        most = max(
            float(swept.contacts(FollowerState(seat.start + at[0], at[1], at[2]), rho, side)
                  .pressure_angle.max())
            for seat in arm.seats() for side in (LEFT, RIGHT)
        )  # fmt: skip
        assert most == pytest.approx(ALPHA, abs=1e-9)


def test_chords_refuse_no_law_and_tangents_none_that_is_broken() -> None:
    spec = spec_of(dwell_on="groove")
    curve, sizes = curves(spec)
    length = spec.machine.length_scale(sizes)
    state, rng = length * states(300), np.random.default_rng(12)
    wide = length * rng.uniform(0.0, 0.3, 300)
    everywhere = np.full(300, math.inf)
    within = MotionSizeBox(
        state[0] - wide, state[0] + 0.7 * wide, -everywhere, everywhere, ((0.0, 1e3),)
    )
    exact = least(curve, state / length, length)
    for cuts in curve.linear_relaxation(within, None):
        needed = np.sum(cuts.coefficients * state, axis=0) - cuts.upper
        assert np.all(needed <= exact + 1e-9)
    about = state + length * np.stack([rng.uniform(-0.2, 0.2, 300), *np.zeros((3, 300))])
    needed = [
        np.sum(cuts.coefficients * state, axis=0) - cuts.upper
        for cuts in curve.linear_relaxation(within, (about, (150.0,)))
    ]
    assert np.all(np.max(needed, axis=0) >= exact - 1e-9)
    assert np.min(np.max(needed, axis=0) - exact) < 1.0  # and asks for little more
