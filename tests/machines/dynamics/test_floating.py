"""A train that leaves its cam, against a spring that cannot pull."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from synthesis.catalogue.motion import Motion
from synthesis.machines.dynamics.chain import Chain
from synthesis.machines.dynamics.floating import simulate_flights
from synthesis.machines.dynamics.response import Steps, from_rest
from synthesis.numerics.piecewise import Array
from tests.machines.dynamics.test_residual_limit import spec

TURNS = 1
CHAIN = Chain(
    1e-3 * np.array([0.41, 0.93]), np.array([71.0, 113.0]), np.array([0.0, 0.011]),
    np.array([0.0, 1.7]), np.array([0.0003, 0.0]), 35.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def cam() -> Motion:
    return Motion.of(
        spec(laws=("modified_sine", "cycloidal"), base_radius_mm=80.0).placed_segments()
    )


def test_a_spring_that_cannot_pull(cam: Motion) -> None:
    omega = 33.0
    found = simulate_flights(CHAIN, cam, omega, TURNS)
    assert found is not None
    free = CHAIN.preload / CHAIN.springs[0]

    def rate(t: float, x: Array) -> Array:
        s, v, a = cam.derivatives([omega * t], 2)[:, 0]
        force = CHAIN.stiffness @ x[:2] + CHAIN.damping @ x[2:]
        force += CHAIN.ground_springs * s + CHAIN.ground_dampers * v * omega
        force[0] -= CHAIN.springs[0] * max(x[0] - free, 0.0)
        return np.concatenate([x[2:], -force / CHAIN.masses - a * omega**2])

    end = TURNS * 2.0 * pi / omega
    checked: Any = solve_ivp(rate, (0.0, end), np.zeros(4), method="DOP853", rtol=1e-7, atol=1e-7,
                             max_step=end / 500, dense_output=True)  # fmt: skip
    times = np.linspace(0.0, end, 20001)
    gap = checked.sol(times)[0] - free
    assert found.losses == np.count_nonzero((gap[1:] > 0.0) & (gap[:-1] <= 0.0))
    assert found.losses >= 2
    assert 0.05 < found.separated_share < 0.9
    assert found.output_error_end == pytest.approx(
        checked.y[1, -1], abs=max(20.0 * found.uncertainty, 1e-5)
    )
    assert found.largest_gap == pytest.approx(gap.max(), rel=2e-3)
    assert found.separated_share == pytest.approx(np.mean(gap > 0.0), abs=2e-3)
    assert found.first_separation_turn is not None
    turn, angle = found.first_separation_turn, np.radians(found.first_separation_deg)
    first = times[np.argmax(gap > 0.0)] * omega
    assert turn * 2.0 * pi + angle == pytest.approx(first, abs=2e-3)


def test_on_the_cam_it_is_the_linear_train(cam: Motion) -> None:
    """With a damper in the contact too, and up to where contact is lost."""
    chain = replace(CHAIN, dampers=np.array([0.004, 0.011]))
    found = simulate_flights(chain, cam, 14.0, 1)
    assert found is not None
    (turn,) = from_rest(chain, Steps.of(cam, 720), 14.0, 1)
    assert found.first_separation_turn is None
    assert found.output_error_end == pytest.approx(turn.deflection[-1, -1], abs=1e-6)
    assert found.contact_force_max_n == pytest.approx(turn.contact_force.max(), rel=1e-3)
    fast = simulate_flights(chain, cam, 33.0, 1)
    assert fast is not None
    (linear,) = from_rest(chain, Steps.of(cam, 1440), 33.0, 1)
    leaves = linear.steps.theta[np.argmax(linear.contact_force < 0.0)]
    assert fast.first_separation_deg is not None
    assert np.radians(fast.first_separation_deg) == pytest.approx(leaves, abs=6e-3)
    assert fast.largest_gap > 0.0


def test_what_swings_too_fast_is_left_alone(cam: Motion) -> None:
    stiff = replace(CHAIN, springs=CHAIN.springs * 1e9)
    assert simulate_flights(stiff, cam, 33.0, TURNS) is None
