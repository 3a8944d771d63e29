"""Tables smoothed: against the exact answer, other solvers, other bases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Chebyshev
from scipy.optimize import linprog

from synthesis.catalogue.laws import LAWS
from synthesis.numerics.bspline import SplineSpace
from synthesis.optimise.parameters.table_smoothing import Rows, smooth_table, sparse_basis

RNG = np.random.default_rng(20240817)
BREAKS = np.array([0.0, 0.0731, 0.1812, 0.294, 0.433, 0.6178, 0.7719, 0.8803, 1.0])
REST0, REST1 = np.zeros(3), np.array([1.0, 0.0, 0.0])


def uneven(count: int) -> np.ndarray:
    """Abscissae that are spaced unevenly."""
    return np.sort(np.concatenate([[0.0, 1.0], RNG.uniform(0.0, 1.0, count - 2)]))


def sampled(kind: str, count: int, noise: float) -> tuple[np.ndarray, np.ndarray]:
    x = uneven(count)
    return x, LAWS[kind].curve("rise")(x) + RNG.uniform(-noise, noise, count)


@pytest.mark.parametrize("degree", [3, 4, 5])
@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_the_sparse_basis_is_the_basis(degree: int, order: int) -> None:
    space, x = SplineSpace(degree, BREAKS), uneven(57)
    expected = space.basis(x, order)
    found = sparse_basis(space, x, order).toarray()
    assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()


@pytest.mark.parametrize("count", [61, 361, 7201])
def test_a_noisy_table_of_the_smoothest_law_comes_back_as_that_law(count: int) -> None:
    """3-4-5 has the least mean square jerk of all (720), and lies within the tolerance."""
    noise = 1e-4 / 30.0  # 0.1 µm of 30 mm
    x, g = sampled("polynomial_3_4_5", count, noise)
    fit = smooth_table(Rows(x, g, 1.6 * noise, REST0, REST1), 5)
    dense = np.linspace(0.0, 1.0, 2001)
    assert fit.energy == pytest.approx(720.0, rel=1e-9)
    assert fit.deviation <= 1.6 * noise
    curve, law = fit.space.curve(fit.coefficients), LAWS["polynomial_3_4_5"].curve("rise")
    for order, close in enumerate((1e-6, 1e-5, 1e-4, 1e-2)):
        assert np.abs(curve(dense, order) - law(dense, order)).max() <= close


@pytest.mark.parametrize("kind", ["modified_sine", "cycloidal", "simple_harmonic", "parabolic"])
@pytest.mark.parametrize("degree", [3, 4, 5])
def test_other_laws_come_back_within_the_tolerance(kind: str, degree: int) -> None:
    tolerance = 1e-3 / 30.0
    x, g = sampled(kind, 331, 0.4 * tolerance)
    fit = smooth_table(Rows(x, g, tolerance, REST0, REST1), degree)
    curve = fit.space.curve(fit.coefficients)
    miss = np.abs(curve(x) - g).max()
    assert miss == pytest.approx(fit.deviation, abs=1e-12)
    assert miss <= tolerance
    ends = curve.derivatives([0.0, 1.0], 2)
    assert np.abs(ends - np.array([REST0, REST1]).T).max() <= 1e-10
    off = np.abs(curve(x) - LAWS[kind].curve("rise")(x)).max()
    assert off <= 1.4 * tolerance


def test_the_least_jerk_is_that_of_other_unknowns_and_another_solver() -> None:
    """Chebyshev polynomials of degree 27, stated in cvxpy, on a table of few rows."""
    import cvxpy as cp

    x, g = sampled("modified_trapezoid", 19, 2e-3)
    tolerance = 5e-3
    basis = [Chebyshev.basis(k, domain=[0.0, 1.0]) for k in range(28)]

    def table(at: np.ndarray, order: int) -> np.ndarray:
        return np.stack([(p.deriv(order) if order else p)(at) for p in basis], axis=1)

    nodes, weights = np.polynomial.legendre.leggauss(40)
    roots = np.sqrt(weights / 2.0)[:, None] * table((nodes + 1.0) / 2.0, 3)
    c = cp.Variable(28)
    limits = [cp.abs(table(x, 0) @ c - g) <= tolerance]
    for k in range(3):
        limits += [table(np.array([0.0]), k) @ c == REST0[k]]
        limits += [table(np.array([1.0]), k) @ c == REST1[k]]
    best = cp.Problem(cp.Minimize(cp.sum_squares(roots @ c)), limits).solve(solver=cp.CLARABEL)
    fit = smooth_table(Rows(x, g, tolerance, REST0, REST1), 5)
    assert fit.energy == pytest.approx(best, rel=2e-2)
    assert fit.energy <= best * 1.01


def test_a_tolerance_that_cannot_be_met_comes_as_near_as_can_be() -> None:
    """Two rows so close together that no spline on the finest knots jumps between them."""
    x = np.sort(np.append(uneven(40), [0.4321, 0.4321 + 1e-7]))
    g = LAWS["cycloidal"].curve("rise")(x)
    at = int(np.searchsorted(x, 0.4321))
    g[at] += 2e-3
    rows = Rows(x, g, 1e-5, REST0, REST1)
    fit = smooth_table(rows, 5)
    space = fit.space
    p = space.basis(x)
    first = np.linalg.solve(space.end_derivatives(0.0, 3)[:, :3], REST0)
    last = np.linalg.solve(space.end_derivatives(1.0, 3)[:, -3:], REST1)
    known = p[:, :3] @ first + p[:, -3:] @ last
    inner, ones = p[:, 3:-3], -np.ones((len(x), 1))
    best = linprog(
        np.append(np.zeros(inner.shape[1]), 1.0),
        A_ub=np.vstack([np.hstack([inner, ones]), np.hstack([-inner, ones])]),
        b_ub=np.concatenate([g - known, known - g]),
        bounds=[(None, None)] * inner.shape[1] + [(0.0, None)],
    )
    assert fit.deviation > 10.0 * rows.tolerance
    assert best.fun <= fit.deviation * (1.0 + 1e-9)
    assert fit.deviation <= 1.02 * best.fun


@pytest.mark.parametrize("degree", [4, 5])
def test_a_whole_turn_closes_smoothly(degree: int) -> None:
    x = np.linspace(0.0, 1.0, 181)
    g = 0.4 * np.sin(2.0 * np.pi * x + 0.3) + 0.1 * np.cos(6.0 * np.pi * x)
    level = np.array([g[0]])
    rows = Rows(x, g, 1e-5, level, level, closed=degree - 1)
    fit = smooth_table(rows, degree)
    start, end = fit.space.curve(fit.coefficients).derivatives([0.0, 1.0], degree - 1).T
    sizes = 0.5 * (6.0 * np.pi) ** np.arange(degree)
    assert np.abs(start - end) == pytest.approx(np.zeros(degree), abs=1e-8 * sizes[-1])
    assert fit.deviation <= 1e-5
    with_ends_free = smooth_table(replace(rows, closed=0), degree)
    assert with_ends_free.energy <= fit.energy * (1.0 + 1e-6)


def test_a_tighter_tolerance_costs_jerk() -> None:
    x, g = sampled("modified_sine", 121, 3e-5)
    energies = [
        smooth_table(Rows(x, g, tolerance, REST0, REST1), 5).energy
        for tolerance in (1e-3, 1e-4, 4e-5)
    ]
    assert 720.0 * (1.0 - 1e-9) <= energies[0] < energies[1] < energies[2]
