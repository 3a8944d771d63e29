"""The lower bound over all laws: never above the optimum, close to it, whatever the multipliers."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.dual_bound.bound import Bound, dual_bound
from synthesis.optimise.dual_bound.lagrangian import sums_at_start
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import ObjectiveCap, Problem
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.conic.test_convex import CASES as STATED
from tests.optimise.scenes import (
    LIFT,
    acceleration,
    angles,
    direct,
    dwell,
    fall,
    jerk,
    problem,
    rise,
    scene,
    velocity,
)

ALL_LAWS = "all motion laws"
BETA = 71.7 * pi / 180.0
SYMMETRIC = (rise(71.7), dwell(23.9), fall(71.7), dwell(192.7))
TURN = (rise(71.7), fall(71.7), dwell(216.6))

# further than the statements go: held to the bound only
MORE: dict[str, DesignSpec] = {
    "size at a fixed radius's edge": scene(
        SYMMETRIC, angles(33.0, 44.0), jerk(51.0, 71.7), offset=4.7, base={"min": 5.0}
    ),
    "size, everything free, turning": scene(
        (rise(131.7), fall(97.3), rise(71.0, 11.3), fall(60.0, 11.3)),
        angles(23.0, 33.0), jerk(88.0, 60.0, 11.3),
    ),
    "peak acceleration under a jerk cap": scene(
        SYMMETRIC, jerk(60.0, 71.7), objective="peak_acceleration"
    ),
    "peak jerk, everything free": scene((rise(180.0), fall(180.0)), objective="peak_jerk"),
    "rms jerk, everything free": scene((rise(160.0), fall(200.0)), objective="rms_jerk"),
    "rms jerk, capped": scene(SYMMETRIC, jerk(47.0, 71.7), objective="rms_jerk"),
}  # fmt: skip
CASES = {**STATED, **MORE}
# what caps no derivative is bounded in its family only
FAMILY = {
    "size, velocity", "size, no motion limit", "size, offset to the wrong side",
    "size, named beside spline", "size, turning on a named law",
}  # fmt: skip


def found(question: Problem, intervals: int) -> tuple[float, Bound]:
    """The optimum on equal intervals, and the bound from its multipliers."""
    grids = [uniform_grid(segment, intervals) for segment in question.free]
    answer = direct(question, grids)
    return answer.value, dual_bound(answer.model, answer.solution)


@pytest.mark.parametrize("name", CASES)
def test_below_the_optimum_on_much_finer_knots(name: str) -> None:
    question = problem(CASES[name])
    _, coarse = found(question, 12)
    fine, lower = found(question, 160)
    assert lower.value <= fine * (1.0 + 1e-9)
    assert coarse.valid_for.startswith(ALL_LAWS) == (name not in FAMILY)
    if name not in FAMILY:
        assert coarse.value <= fine * (1.0 + 1e-9)
        assert coarse.value > 0.0
        assert len(coarse.switching) == len(question.free)


def test_of_given_laws_the_bound_is_the_optimum() -> None:
    law = "cycloidal"
    program = rise(71.7, law=law), dwell(23.9), fall(83.3, law=law), dwell(181.1)
    value, lower = found(problem(scene(program, angles(29.0, 37.0))), 12)
    assert lower.value == pytest.approx(value, rel=1e-6)
    assert lower.value <= value
    assert (lower.switching, lower.controls) == ((), ())


@pytest.mark.parametrize("name", [name for name in CASES if name not in FAMILY])
def test_the_gap_closes_with_knots(name: str) -> None:
    """As the knots' distance squared; only as the distance where no jerk is capped."""
    question = problem(CASES[name])
    gaps, lower = [], None
    for intervals in (16, 144):
        value, lower = found(question, intervals)
        gaps.append((value - lower.value) / value)
    assert lower is not None
    slow = lower.order == 2 or "acceleration" in name
    assert gaps[1] < (0.03 if slow else 2e-3)
    assert gaps[1] < (0.15 if slow else 0.04) * gaps[0] + 1e-8


@pytest.mark.parametrize("name", ["size, every motion limit", "peak jerk", "rms jerk, capped"])
@pytest.mark.parametrize("smoothness", [3, 4])
def test_smoother_laws_have_the_same_bound(name: str, smoothness: int) -> None:
    """The bound covers all laws, so it may not depend on which splines it came from."""
    spec = CASES[name]
    body = spec.model_dump()
    for segment in body["program"]:
        if segment["kind"] != "dwell":
            segment["law"]["smoothness"] = smoothness
    plain, smooth = problem(spec), problem(DesignSpec.model_validate(body))
    value, lower = found(smooth, 64)
    cubic, reference = found(plain, 160)
    assert lower.value <= cubic * (1.0 + 1e-9)
    assert lower.value == pytest.approx(reference.value, rel=6e-2)
    assert value >= reference.value


# -- any multipliers give a bound --------------------------------------------------------------


@settings(max_examples=7)
@given(
    st.sampled_from([name for name in CASES if name not in FAMILY]),
    st.integers(0, 2**32 - 1),
    st.floats(-9.0, 1.0),
)
def test_garbage_gives_a_bound_too(name: str, seed: int, magnitude: float) -> None:
    """Weak duality: perturbed multipliers may be useless, but their bound is never wrong."""
    question = problem(CASES[name])
    fine, _ = found(question, 64)
    answer = direct(question, [uniform_grid(segment, 10) for segment in question.free])
    rng = np.random.default_rng(seed)
    z = answer.solution.multipliers
    noise = rng.standard_normal(len(z)) * 10.0**magnitude
    for wrong in (z * np.exp(noise), z + noise, rng.permutation(z), z * 10.0 ** abs(magnitude)):
        lower = dual_bound(answer.model, replace(answer.solution, multipliers=wrong))
        assert not lower.value > fine * (1.0 + 1e-9)


def test_a_held_objective_counts_as_a_limit() -> None:
    limits = (angles(29.3, 41.7), jerk(61.0, 71.7))
    question = problem(scene(SYMMETRIC, *limits, objective="peak_acceleration"))
    best, _ = found(question, 64)
    then = scene(SYMMETRIC, *limits)
    held = problem(then, (ObjectiveCap(question.objective, best * 1.05),))
    _, lower = found(held, 32)
    fine, _ = found(held, 160)
    free, _ = found(problem(then), 160)
    assert free * 1.01 < lower.value <= fine


def test_a_trial_level_is_proven_too_low_or_not_at_all() -> None:
    """Pressure angle: a positive bound of the excess says that the trial slope cannot be had."""
    spec = scene(SYMMETRIC, jerk(47.0, 71.7), base=31.0, offset=6.0,
                 objective="peak_pressure_angle")  # fmt: skip
    question = problem(spec)
    grids = [uniform_grid(segment, 64) for segment in question.free]
    values = []
    for slope in np.linspace(0.4, 0.8, 9):
        answer = direct(question, grids, float(slope))
        lower = dual_bound(answer.model, answer.solution).value
        assert lower <= answer.value + 1e-9
        values.append((answer.value, lower))
    assert values[0][1] > 0.0 > values[-1][0]
    assert all(low > 0.0 for value, low in values if value > 2e-3 * values[0][0])


# -- closed forms ------------------------------------------------------------------------------


def test_least_peak_jerk() -> None:
    """32 h/β³, met by 4k intervals of a cubic exactly."""
    value, lower = found(problem(scene(SYMMETRIC, objective="peak_jerk")), 16)
    exact = 32.0 * LIFT / BETA**3
    assert value == pytest.approx(exact, rel=1e-8)
    assert exact * (1.0 - 3e-3) < lower.value <= exact * (1.0 + 1e-12)


def test_least_peak_jerk_of_quintics() -> None:
    """Their jerk has to start and to end at zero: above 32, and slowly coming down to it."""
    free = {"smoothness": 4}
    program = (rise(71.7, **free), dwell(23.9), fall(71.7, **free), dwell(192.7))
    question = problem(scene(program, objective="peak_jerk"))
    unit = LIFT / BETA**3
    peaks = [found(question, n)[0] / unit for n in (16, 32, 64, 128)]
    assert peaks[0] > 48.0 > peaks[1] > peaks[2] > peaks[3] > 32.0
    assert peaks[3] < 33.7
    _, lower = found(question, 128)
    assert 31.0 < lower.value / unit <= 32.0 * (1.0 + 1e-12)


def test_least_peak_acceleration() -> None:
    """4 h/β², which no law with a continuous acceleration meets."""
    value, lower = found(problem(scene(SYMMETRIC, objective="peak_acceleration")), 120)
    unit = LIFT / BETA**2
    assert 4.0 < value / unit < 4.15
    assert lower.value / unit == pytest.approx(4.0, rel=1e-9)
    assert lower.value / unit <= 4.0 * (1.0 + 1e-12)
    assert lower.valid_for == "all motion laws with a bounded acceleration"


@pytest.mark.parametrize("cap", [35.0, 47.0, 80.0])
def test_least_peak_acceleration_under_a_jerk_cap(cap: float) -> None:
    spec = scene(SYMMETRIC, jerk(cap, 71.7), objective="peak_acceleration")
    value, lower = found(problem(spec), 160)
    exact = cap / 4.0 * (1.0 - sqrt(1.0 - 32.0 / cap)) * LIFT / BETA**2
    assert exact * (1.0 - 1e-10) <= value < exact * 1.004
    assert exact * 0.99 < lower.value <= exact * (1.0 + 1e-12)


def turn_share(energies: float) -> float:
    """Rms over the turn [per rad^k] of two segments whose ∫ (g^(k))² dx is given."""
    return sqrt(2.0 * energies * BETA / (2.0 * pi)) * LIFT


def test_least_rms_jerk() -> None:
    """∫ j² = 720: the 3-4-5 law."""
    value, lower = found(problem(scene(SYMMETRIC, objective="rms_jerk")), 96)
    exact = turn_share(720.0) / BETA**3
    assert exact <= value < exact * 1.0005
    assert lower.value == pytest.approx(exact, rel=1e-9)
    assert lower.value <= exact * (1.0 + 1e-12)


def test_least_rms_jerk_of_quintics_is_the_law_itself() -> None:
    program = (rise(71.7, smoothness=4), dwell(23.9), fall(71.7, smoothness=4), dwell(192.7))
    value, lower = found(problem(scene(program, objective="rms_jerk")), 96)
    assert lower.value <= turn_share(720.0) / BETA**3 * (1.0 + 1e-12)
    assert value > lower.value


def test_least_rms_acceleration() -> None:
    """∫ a² = 12, which no law with a continuous acceleration meets."""
    value, lower = found(problem(scene(SYMMETRIC, objective="rms_acceleration")), 96)
    exact = turn_share(12.0) / BETA**2
    assert exact < value < exact * 1.01
    assert lower.value == pytest.approx(exact, rel=1e-9)
    assert lower.value <= exact * (1.0 + 1e-12)


@pytest.mark.parametrize("cap", [35.0, 60.0])
def test_least_rms_acceleration_under_a_jerk_cap(cap: float) -> None:
    """(Jτ)²/3 with τ = (1 − √(1 − 24/J))/2."""
    spec = scene(SYMMETRIC, jerk(cap, 71.7), objective="rms_acceleration")
    value, lower = found(problem(spec), 160)
    tau = (1.0 - sqrt(1.0 - 24.0 / cap)) / 2.0
    exact = turn_share((cap * tau) ** 2 / 3.0) / BETA**2
    assert exact * (1.0 - 1e-9) <= value < exact * 1.002
    assert exact * 0.999 < lower.value <= exact * (1.0 + 1e-12)


def test_dwell_to_turn() -> None:
    """Rise and return mirror each other and turn at the top: 6 (2 + √2) and ∫ j² = 320."""
    value, lower = found(problem(scene(TURN, objective="peak_jerk")), 160)
    exact = 6.0 * (2.0 + sqrt(2.0)) * LIFT / BETA**3
    assert exact * (1.0 - 1e-9) <= value < exact * 1.001
    assert exact * 0.999 < lower.value <= exact * (1.0 + 1e-12)
    value, lower = found(problem(scene(TURN, objective="rms_jerk")), 96)
    exact = turn_share(320.0) / BETA**3
    assert exact <= value < exact * 1.0005
    assert lower.value == pytest.approx(exact, rel=1e-8)
    assert lower.value <= exact * (1.0 + 1e-12)


def velocity_needed(acceleration_cap: float, jerk_cap: float) -> float:
    """Least peak velocity under both caps: V (1 − V/A − A/J) = 1, or V (1 − 2√(V/J)) = 1."""
    a, j = acceleration_cap, jerk_cap
    plain = float(brentq(lambda v: v * (1.0 - 2.0 * sqrt(v / j)) - 1.0, 1.0, j / 9.0))
    if sqrt(plain * j) <= a:
        return plain
    return float(brentq(lambda v: v * (1.0 - v / a - a / j) - 1.0, 1.0, a * (1.0 - a / j) / 2.0))


@pytest.mark.parametrize(
    ("a", "j"), [(1e9, 60.0), (7.0, 90.0), (6.0, 1e9)], ids=["jerk", "both", "acceleration"]
)
def test_the_least_velocity_limit_that_can_be_met(a: float, j: float) -> None:
    """Just above the least peak velocity the program is feasible, just below it is not."""
    least = (a - sqrt(a * a - 4.0 * a)) / 2.0 if j > 1e6 else velocity_needed(a, j)
    for share, feasible in ((1.01, True), (0.998, False)):
        limits: list[Any] = [velocity(least * share, 71.7)]
        limits += [acceleration(a, 71.7)] if a < 1e6 else []
        limits += [jerk(j, 71.7)] if j < 1e6 else []
        question = problem(scene(SYMMETRIC, *limits, objective="peak_jerk"))
        grids = [uniform_grid(segment, 200) for segment in question.free]
        stopped = solve(formulate(question, grids).program).stopped
        assert (stopped is StopReason.SOLVED) == feasible, stopped


def test_initial_values_of_many_points_are_summed_as_one_by_one() -> None:
    rng = np.random.default_rng(4)
    for order in (2, 3):
        x, weights = rng.random(7), rng.standard_normal((7, order))
        each = np.sum(sums_at_start(x[:, None], weights[:, None]), axis=0)
        np.testing.assert_allclose(sums_at_start(x, weights), each, rtol=1e-12)
