"""The cam motion for a given output: the exact response to it is that output."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthesis.catalogue.motion import Motion
from synthesis.errors import InputError
from synthesis.machines.dynamics.chain import Chain
from synthesis.machines.dynamics.polydyne import factors, polydyne
from synthesis.machines.dynamics.response import Steps, from_rest
from synthesis.units import DEGREE
from tests.machines.dynamics.test_residual_limit import FIRST, LIFT, spec

OMEGA = 29.3


def chain(n: int) -> Chain:
    rng = np.random.default_rng(n)
    return Chain(
        1e-3 * rng.uniform(0.5, 2.0, n), rng.uniform(90.0, 200.0, n), np.zeros(n),
        rng.uniform(0.0, 3.0, n), rng.uniform(0.0, 0.004, n), 20.0,
    )  # fmt: skip


def output(law: str) -> Motion:
    return Motion.of(spec(laws=(law, law), base_radius_mm=80.0).placed_segments())


@pytest.mark.parametrize(("n", "law"), [(1, "polynomial_4_5_6_7"), (2, "polynomial_6_7_8_9_10_11")])
def test_the_output_moves_as_asked(n: int, law: str) -> None:
    of, wanted = chain(n), output(law)
    by_angle = factors(of) * OMEGA ** np.arange(2 * n + 1)
    cam = replace(wanted, curve=wanted.curve.combine_derivatives(by_angle))
    theta = np.array([0.13, 0.71, 1.9, 2.6, 4.0])
    found = polydyne(of, wanted, OMEGA, theta)
    assert found == pytest.approx(cam.derivatives(theta, 2), rel=1e-9, abs=1e-9)
    (turn,) = from_rest(of, Steps.of(cam, 300), OMEGA, 1)
    moved = turn.deflection[-1] + turn.steps.s[0]
    assert moved == pytest.approx(wanted.derivatives(turn.steps.theta, 0)[0], abs=1e-8 * LIFT)
    assert turn.free_amplitudes(FIRST * DEGREE).max() < 1e-8 * LIFT
    assert np.abs(turn.steps.s[0] - moved).max() > 0.01 * LIFT  # it is another motion


def test_one_mass_is_the_classic_formula() -> None:
    of = chain(1)
    k, kg, cg, m = (float(v[0]) for v in (
        of.springs, of.ground_springs, of.ground_dampers, of.masses))  # fmt: skip
    assert factors(of) == pytest.approx([1.0 + kg / k, cg / k, m / k], rel=1e-14)


@pytest.mark.parametrize(
    ("law", "n", "words"),
    [("cycloidal", 1, "jerk of the output jumps"), ("polynomial_4_5_6_7", 2, "snap of the output"),
     ("parabolic", 1, "acceleration of the output jumps at")],
)  # fmt: skip
def test_an_output_must_be_smooth(law: str, n: int, words: str) -> None:
    with pytest.raises(InputError, match=words):
        polydyne(chain(n), output(law), OMEGA, np.zeros(1))


def test_dampers_in_links_are_refused() -> None:
    damped = replace(chain(2), dampers=np.array([0.0, 0.01]))
    with pytest.raises(InputError, match="without dampers"):
        polydyne(damped, output("polynomial_6_7_8_9_10_11"), OMEGA, np.zeros(1))
