"""Multipliers that are densities: against their definition, and against masses by the thousand."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis.formulations.bounds.bound import concluded
from synthesis.formulations.bounds.densities import Hats, shared
from synthesis.formulations.bounds.ledger import Ledger, at_start
from synthesis.formulations.bounds.multiplied import further, said
from synthesis.formulations.bounds.multipliers import ends_priced, heard
from synthesis.formulations.bounds.prices import end_prices
from synthesis.formulations.bounds.switching import Switching, switching
from synthesis.formulations.bounds.tangents import tangents
from synthesis.formulations.cone.control import controls
from synthesis.formulations.question.grid import uniform
from synthesis.numerics.piecewise import Array
from tests.formulations.bounds.test_bound import CASES, FAMILY
from tests.formulations.bounds.test_bound import found as solved_on
from tests.formulations.scenes import direct, problem

PARTS = 4000  # masses that stand for a density


def hat(left: float, right: float, rising: bool, alpha: Array) -> Hats:
    return Hats(np.array([left]), np.array([right]), np.array([rising]), alpha[None])


def seen(hats: Hats) -> Switching:
    """ψ of hats of mass 1 each."""
    plain = switching(hats.left, hats.weights, hats.alpha.shape[1])
    return plain.raised(np.stack([hats.left, hats.right], axis=1), hats.poly)


def by_masses(left: float, right: float, rising: bool, alpha: Array) -> tuple[Array, Array]:
    """The same as many point masses: points, and weights on g, g', …"""
    share = (np.arange(PARTS) + 0.5) / PARTS
    mass = 2.0 * (share if rising else 1.0 - share) / PARTS
    return left + (right - left) * share, mass[:, None] * alpha


@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]), st.booleans())
def test_a_density_is_many_small_masses(seed: int, order: int, rising: bool) -> None:
    rng = np.random.default_rng(seed)
    left, right = np.sort(rng.uniform(size=2))
    alpha = rng.standard_normal(order)
    points, weights = by_masses(left, right, rising, alpha)
    tau = np.concatenate([rng.uniform(size=99), np.linspace(left, right, 101)])
    ours = seen(hat(left, right, rising, alpha))(tau)
    theirs = switching(points, weights, order)(tau)
    np.testing.assert_allclose(ours, theirs, atol=2.0 / PARTS * np.abs(alpha).sum())
    starts = at_start(points, weights).sum(axis=0)
    weights = hat(left, right, rising, alpha).weights
    np.testing.assert_allclose(at_start(np.array([left]), weights)[0], starts, atol=1e-6)


def test_shared_masses_are_the_same_in_sum_and_in_the_mean() -> None:
    x, mass = np.array([0.1, 0.25, 0.7, 0.73]), np.array([1.0, 0.3, 2.0, 0.01])
    falling, rising = shared(x, mass)
    assert np.sum(falling) + np.sum(rising) == pytest.approx(np.sum(mass), rel=1e-15)
    # of equal densities at the points: one flat density
    gaps = np.diff(x)
    reach = np.concatenate([gaps, [0.0]]) + np.concatenate([[0.0], gaps])
    falling, rising = shared(x, 0.5 * reach)
    np.testing.assert_allclose(falling / gaps, 0.5, rtol=1e-15)
    np.testing.assert_allclose(rising / gaps, 0.5, rtol=1e-15)


@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]))
def test_the_least_integral_of_high_degrees(seed: int, order: int) -> None:
    """Never above the true one, and near it: quartics that cross zero anywhere."""
    rng = np.random.default_rng(seed)
    x = np.unique(np.concatenate([[0.0, 1.0], rng.uniform(size=5)]))
    psi = switching(rng.uniform(size=4), rng.standard_normal((4, order)), order)
    for left, right in pairwise(x):
        own = hat(left, right, bool(rng.integers(2)), 30.0 * rng.standard_normal(order))
        spans = np.stack([own.left, own.right], axis=1)
        psi = psi.raised(spans, own.poly * rng.standard_normal())
    share, total = (np.arange(PARTS) + 0.5) / PARTS, 0.0
    for left, right in pairwise(psi.breaks):  # ψ jumps from one piece to the next
        total += (right - left) * float(np.mean(np.abs(psi(left + (right - left) * share))))
    assert psi.least(1.0, 0.0) == pytest.approx(-total, rel=1e-5)
    cuts = np.concatenate([[0.0], psi.crossings(), [1.0]])
    for a, b in pairwise(cuts):
        inside = psi(a + (b - a) * np.linspace(1e-6, 1.0 - 1e-6, 301))
        assert np.min(inside) >= -1e-9 or np.max(inside) <= 1e-9


@settings(max_examples=12)
@given(
    st.sampled_from([name for name in CASES if name not in FAMILY]),
    st.integers(0, 2**32 - 1),
    st.floats(-6.0, 0.5),
)
def test_any_density_gives_a_bound(name: str, seed: int, magnitude: float) -> None:
    """Weak duality of densities: any masses, on any rows; the bound is never wrong."""
    asked = problem(CASES[name])
    fine, _ = solved_on(asked, 64)
    answer = direct(asked, [uniform(stretch, 9) for stretch in asked.free])
    plan, solution = answer.plan, answer.solution
    steering = controls(plan)
    assert steering
    order, rng = steering[0].order, np.random.default_rng(seed)
    ledger = Ledger(plan, order)
    for rows, mass in (
        *tangents(plan, solution, order), *further(plan, order, solution.multipliers)
    ):  # fmt: skip
        ledger.book(rows, mass)
    for one in said(plan, order):
        own = np.maximum(solution.multipliers[one.rows : one.rows + one.count], 0.0)
        ledger.book(one.points(), own * rng.uniform(0.0, 2.0, one.count))
        if one.alike:
            noise = 10.0**magnitude * np.max(own) * rng.exponential(size=2 * (one.count - 1))
            ledger.book(one.hats(np.full(len(noise), True)), noise)
    near = ends_priced(plan, solution, heard(plan, solution), order)
    psi = ledger.psi() if all(control.weight for control in steering) else ()
    ledger.book_ends(end_prices(plan, steering, psi, ledger.state, near))
    assert not concluded(plan, solution, ledger, steering).value > fine * (1.0 + 1e-9)


def test_a_tangent_is_below_the_square_wherever_it_is_taken() -> None:
    """The bound of a mean square under a jerk cap, its tangent taken at another law."""
    asked = problem(CASES["rms acceleration"])
    fine, best = solved_on(asked, 64)
    answer = direct(asked, [uniform(stretch, 24) for stretch in asked.free])
    steering = controls(answer.plan)
    assert steering
    values = []
    for shift in (0.0, 1e-3, 0.1):
        x = answer.solution.x * (1.0 + shift)
        moved = replace(answer.solution, x=x)
        ledger = Ledger(answer.plan, 3)
        for rows, mass in tangents(answer.plan, moved, 3):
            ledger.book(rows, mass)
        near = ends_priced(answer.plan, moved, heard(answer.plan, moved), 3)
        ledger.book_ends(end_prices(answer.plan, steering, (), ledger.state, near))
        values.append(concluded(answer.plan, moved, ledger, steering).value)
    assert 0.9 * best.value < values[0] <= fine * (1.0 + 1e-9)
    assert values[2] < values[0]


def test_a_missed_root_makes_the_bound_lower_not_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    psi = seen(hat(0.2, 0.9, True, np.array([40.0, -19.0, 1.7])))
    exact = psi.least(1.0, 0.0)
    monkeypatch.setattr("synthesis.formulations.bounds.switching._roots", lambda poly: [])
    assert -1.3 * abs(exact) < psi.least(1.0, 0.0) < exact * (1.0 + 1e-3)
