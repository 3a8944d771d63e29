"""Multipliers that are densities: against their definition, and against masses by the thousand."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis.catalogue.constraints import PointInequalities
from synthesis.numerics.piecewise import Array, gauss_points
from synthesis.optimise.conic.control import law_controls
from synthesis.optimise.conic.linear_rows import Scales, Tightening
from synthesis.optimise.conic.tangent_cuts import cut_block
from synthesis.optimise.dual_bound.bound import add_costates, bound_from_lagrangian
from synthesis.optimise.dual_bound.costates import boundary_multipliers
from synthesis.optimise.dual_bound.lagrangian import Lagrangian, sums_at_start
from synthesis.optimise.dual_bound.row_functionals import (
    Hats,
    RowFunctional,
    WeightedRows,
    cone_rows,
    distribute_to_intervals,
    energy_tangents,
    fixed_size_rows,
    row_functionals,
)
from synthesis.optimise.dual_bound.switching import Switching, add_densities
from synthesis.optimise.problem.grid import Grid, grid_through, uniform_grid
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.dual_bound.test_bound import CASES, FAMILY
from tests.optimise.dual_bound.test_bound import found as solved_on
from tests.optimise.dual_bound.test_switching import switching
from tests.optimise.scenes import direct, problem

PARTS = 4000  # masses that stand for a density


def hat(left: float, right: float, rising: float, alpha: Array) -> Hats:
    return Hats(np.array([left]), np.array([right]), np.array([rising]), alpha[None])


def seen(hats: Hats) -> Switching:
    """ψ of hats of mass 1 each."""
    plain = switching(hats.left, hats.weights)
    spans = np.stack([hats.left, hats.right], axis=1)
    breaks, poly = add_densities(plain.breaks, plain.poly[None], spans, hats.poly[None])
    return Switching(breaks, poly[0])


def by_masses(left: float, right: float, rising: float, alpha: Array) -> tuple[Array, Array]:
    """The same as many point masses: points, and weights on g, g', …"""
    share = (np.arange(PARTS) + 0.5) / PARTS
    mass = 2.0 * (rising * share + (1.0 - rising) * (1.0 - share)) / PARTS
    return left + (right - left) * share, mass[:, None] * alpha


@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]), st.sampled_from([0.0, 0.5, 1.0]))
def test_a_density_is_many_small_masses(seed: int, order: int, rising: float) -> None:
    rng = np.random.default_rng(seed)
    left, right = np.sort(rng.uniform(size=2))
    alpha = rng.standard_normal(order)
    points, weights = by_masses(left, right, rising, alpha)
    tau = np.concatenate([rng.uniform(size=99), np.linspace(left, right, 101)])
    ours = seen(hat(left, right, rising, alpha))(tau)
    theirs = switching(points, weights)(tau)
    np.testing.assert_allclose(ours, theirs, atol=2.0 / PARTS * np.abs(alpha).sum())
    starts = sums_at_start(points, weights)
    weights = hat(left, right, rising, alpha).weights
    np.testing.assert_allclose(sums_at_start(np.array([left]), weights), starts, atol=1e-6)


@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]))
def test_a_row_s_mean_over_spans_is_that_of_the_law_and_of_the_bound(seed: int, order: int) -> None:
    """Up to the control itself: by quadrature, by the splines' matrix, and by what ψ gets."""
    rng = np.random.default_rng(seed)
    case = problem(CASES["size, fixed offset"])
    segment, n = case.free[0], 4
    grid = grid_through(segment, np.array([0.0, 0.2, 0.3, 0.71, 1.0]))
    spans = np.stack([grid.space.breaks[:-1], grid.space.breaks[1:]], axis=1)
    cut = PointInequalities(
        np.vstack([rng.standard_normal((order + 1, n)), np.zeros((3 - order, n))]),
        rng.standard_normal((2, n)), rng.standard_normal(n),
    )  # fmt: skip
    here = Grid(grid.space, spans.mean(axis=1))
    block = cut_block(cut, "mean", 0, segment, here, Scales(1.0, 1.0), Tightening(), spans)
    coefficients = rng.standard_normal(grid.space.size)
    law = grid.space.curve(coefficients)
    x, weights = gauss_points(grid.space.breaks, 4)
    shares = weights / np.ptp(spans, axis=1)[:, None]
    mean = sum(block.alpha[k] * np.sum(shares * law(x, k), axis=1) for k in range(order + 1))
    assert block.law_matrix is not None
    np.testing.assert_allclose(block.law_matrix @ coefficients, mean, atol=1e-9)
    model = SimpleNamespace(problem=case)
    rows = RowFunctional(model, block, 0, order).point_rows()  # type: ignore[arg-type]
    start = sum(rows.weights[:, k] * law(rows.x, k) for k in range(order))
    assert rows.poly is not None
    along = (x - spans[:, :1]) / np.ptp(spans, axis=1)[:, None]
    psi = sum(rows.poly[:, [j]] * along**j for j in range(rows.poly.shape[1]))
    np.testing.assert_allclose(
        start + np.sum(weights * psi * law(x, order), axis=1), mean, atol=1e-9
    )
    np.testing.assert_array_equal(rows.rhs, block.rhs)


@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]))
def test_psi_of_rows_is_what_the_control_counts_for_in_them(seed: int, order: int) -> None:
    """Of a law with g = g' = … = 0 at 0: Σ weights_k g^(k)(x) + ∫ poly w dτ = ∫ ψ w dτ."""
    rng = np.random.default_rng(seed)
    control = np.polynomial.Polynomial(rng.standard_normal(4))
    law = control.integ(order)
    spans = np.sort(rng.uniform(size=(3, 2)), axis=1)
    x, weights = spans[:, 0], rng.standard_normal((3, order))
    poly = rng.standard_normal((3, 5))
    rows = WeightedRows(0, x, weights, np.zeros(3), np.zeros((3, 0)), spans=spans, poly=poly)
    cuts = np.unique(np.concatenate([[0.0, 1.0], spans.ravel()]))
    tau, shares = (each.ravel() for each in gauss_points(cuts, 6))
    alone = sum(weights[:, k] * law.deriv(k)(x) for k in range(order))
    for row, (low, high) in enumerate(spans):
        at, width = (each.ravel() for each in gauss_points(np.array([low, high]), 6))
        density = np.polynomial.Polynomial(poly[row])((at - low) / (high - low))
        alone[row] += np.sum(width * density * control(at))
    np.testing.assert_allclose(shares * control(tau) @ rows.psi(tau), alone, atol=1e-10)


def test_shared_masses_are_the_same_in_sum_and_in_the_mean() -> None:
    x, mass = np.array([0.1, 0.25, 0.7, 0.73]), np.array([1.0, 0.3, 2.0, 0.01])
    falling, rising = distribute_to_intervals(x, mass)
    assert np.sum(falling) + np.sum(rising) == pytest.approx(np.sum(mass), rel=1e-15)
    # of equal densities at the points: one flat density
    gaps = np.diff(x)
    reach = np.concatenate([gaps, [0.0]]) + np.concatenate([[0.0], gaps])
    falling, rising = distribute_to_intervals(x, 0.5 * reach)
    np.testing.assert_allclose(falling / gaps, 0.5, rtol=1e-15)
    np.testing.assert_allclose(rising / gaps, 0.5, rtol=1e-15)


@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]))
def test_the_least_integral_of_high_degrees(seed: int, order: int) -> None:
    """Never above the true one, and near it: quartics that cross zero anywhere."""
    rng = np.random.default_rng(seed)
    x = np.unique(np.concatenate([[0.0, 1.0], rng.uniform(size=5)]))
    psi = switching(rng.uniform(size=4), rng.standard_normal((4, order)))
    for left, right in pairwise(x):
        own = hat(left, right, bool(rng.integers(2)), 30.0 * rng.standard_normal(order))
        spans = np.stack([own.left, own.right], axis=1)
        more = own.poly[None] * rng.standard_normal()
        breaks, poly = add_densities(psi.breaks, psi.poly[None], spans, more)
        psi = Switching(breaks, poly[0])
    share, total = (np.arange(PARTS) + 0.5) / PARTS, 0.0
    for left, right in pairwise(psi.breaks):  # ψ jumps from one piece to the next
        total += (right - left) * float(np.mean(np.abs(psi(left + (right - left) * share))))
    assert psi.least_integral(1.0, 0.0) == pytest.approx(-total, rel=1e-5)
    cuts = np.concatenate([[0.0], psi.sign_changes(), [1.0]])
    for a, b in pairwise(cuts):
        inside = psi(a + (b - a) * np.linspace(1e-6, 1.0 - 1e-6, 301))
        assert np.min(inside) >= -1e-9 or np.max(inside) <= 1e-9


def flat_face(angles: tuple[float, float], lift: float, radius: float, jerk: float) -> DesignSpec:
    """A slide with a flat face: the limit is on s + s'', of which laws keep long arcs."""
    rise, back = angles
    law = {"kind": "spline"}
    return DesignSpec.model_validate(
        {
            "speed_rpm": 149.0,
            "program": [
                {"kind": "rise", "angle_deg": rise, "lift_mm": lift, "law": law},
                {"kind": "dwell", "angle_deg": 46.0},
                {"kind": "return", "angle_deg": back, "lift_mm": lift, "law": law},
                {"kind": "dwell", "angle_deg": 314.0 - rise - back},
            ],
            "follower": {"kind": "translating_flat_face"},
            "limits": [
                {"kind": "profile_radius", "min_mm": radius},
                {"kind": "jerk", "max_mm_per_s3": jerk},
            ],
        }
    )


@pytest.mark.parametrize("spec", [
    flat_face((93.0, 71.0), 14.7, 6.1, 3.1e6), flat_face((64.0, 117.0), 21.3, 2.9, 5.7e6),
])  # fmt: skip
def test_along_an_arc_the_gap_closes_as_the_square_of_the_knots_distance(spec: DesignSpec) -> None:
    """Although no more than one point of each knot interval has a multiplier."""
    gaps = []
    for intervals in (26, 104):
        value, lower = solved_on(problem(spec), intervals)
        gaps.append((value - lower.value) / value)
    assert 1e-4 < gaps[0] < 0.1
    assert gaps[1] < gaps[0] / 12.0


def test_a_limit_met_at_one_point_has_its_multiplier_there() -> None:
    """The base circle of the dwell is the least radius: only the law's end is at its limit."""
    value, lower = solved_on(problem(flat_face((123.0, 113.0), 9.41, 3.02, 510000.0)), 17)
    assert value == pytest.approx(3.02, rel=1e-6)
    assert value * (1.0 - 1e-5) < lower.value <= value * (1.0 + 1e-9)


@settings(max_examples=7)
@given(
    st.sampled_from([name for name in CASES if name not in FAMILY]),
    st.integers(0, 2**32 - 1),
    st.floats(-6.0, 0.5),
)
def test_any_density_gives_a_bound(name: str, seed: int, magnitude: float) -> None:
    """Weak duality of densities: any masses, on any rows; the bound is never wrong."""
    question = problem(CASES[name])
    fine, _ = solved_on(question, 64)
    answer = direct(question, [uniform_grid(segment, 9) for segment in question.free])
    model, solution = answer.model, answer.solution
    steering = law_controls(model)
    assert steering
    order, rng = steering[0].order, np.random.default_rng(seed)
    lagrangian = Lagrangian(model, order)
    for rows, mass in (
        *energy_tangents(model, solution, order),
        *fixed_size_rows(model, solution.multipliers),
        *cone_rows(model, solution.multipliers),
    ):  # fmt: skip
        lagrangian.add_rows(rows, mass)
    for one in row_functionals(model, order):
        own = np.maximum(solution.multipliers[one.first_row : one.first_row + one.count], 0.0)
        lagrangian.add_rows(one.point_rows(), own * rng.uniform(0.0, 2.0, one.count))
        if one.uniform:
            noise = 10.0**magnitude * np.max(own) * rng.exponential(size=2 * (one.count - 1))
            lagrangian.add_rows(one.hat_rows(np.sort(rng.uniform(0.0, 1.0, one.count))), noise)
    near = boundary_multipliers(model, solution, order)
    add_costates(lagrangian, steering, near)
    assert not bound_from_lagrangian(solution, lagrangian, steering).value > fine * (1.0 + 1e-9)


def test_a_tangent_is_below_the_square_wherever_it_is_taken() -> None:
    """The bound of a mean square under a jerk cap, its tangent taken at another law."""
    question = problem(CASES["rms acceleration"])
    fine, best = solved_on(question, 64)
    answer = direct(question, [uniform_grid(segment, 24) for segment in question.free])
    steering = law_controls(answer.model)
    assert steering
    values = []
    for shift in (0.0, 1e-3, 0.1):
        x = answer.solution.x * (1.0 + shift)
        moved = replace(answer.solution, x=x)
        lagrangian = Lagrangian(answer.model, 3)
        for rows, mass in energy_tangents(answer.model, moved, 3):
            lagrangian.add_rows(rows, mass)
        near = boundary_multipliers(answer.model, moved, 3)
        add_costates(lagrangian, steering, near)
        values.append(bound_from_lagrangian(moved, lagrangian, steering).value)
    assert 0.9 * best.value < values[0] <= fine * (1.0 + 1e-9)
    assert values[2] < values[0]


def test_a_missed_root_makes_the_bound_lower_not_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    psi = seen(hat(0.2, 0.9, True, np.array([40.0, -19.0, 1.7])))
    exact = psi.least_integral(1.0, 0.0)
    monkeypatch.setattr("synthesis.optimise.dual_bound.switching._roots", lambda poly: [])
    assert -1.3 * abs(exact) < psi.least_integral(1.0, 0.0) < exact * (1.0 + 1e-3)
