"""The switching function against its definition, and its integrals against dense quadrature."""

from __future__ import annotations

import itertools
from math import factorial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from synthesis.numerics.piecewise import Array
from synthesis.optimise.dual_bound.switching import Switching, switching_pieces


def switching(points: Array, weights: Array) -> Switching:
    """ψ from point rows: x_i (r,) and weights (r, m)."""
    breaks, poly = switching_pieces(points, weights[None])
    return Switching(breaks, poly[0])


DENSE = 200_001


def middles(count: int = DENSE) -> Array:
    return (np.arange(count) + 0.5) / count


def plainly(points: Array, weights: Array, tau: Array) -> Array:
    """Σ w[i, k] (x_i − τ)₊^(m−1−k) / (m−1−k)!, row by row."""
    order = weights.shape[1]
    total = np.zeros_like(tau)
    for x, row in zip(points, weights, strict=True):
        for k, w in enumerate(row):
            n = order - 1 - k
            total += np.where(tau < x, w * (x - tau) ** n / factorial(n), 0.0)
    return total


@st.composite
def functions(draw: st.DrawFn) -> tuple[Array, Array]:
    order = draw(st.sampled_from([2, 3]))
    count = draw(st.integers(1, 9))
    place = st.floats(0.0, 1.0).map(lambda x: round(x, 9))  # no grid has points 1e-300 apart
    inner = draw(st.lists(place, min_size=count, max_size=count))
    ends = draw(st.sampled_from([[], [0.0], [1.0], [0.0, 1.0], [0.37, 0.37]]))
    points = np.array([*inner, *ends])
    seed = draw(st.integers(0, 2**32 - 1))
    return points, np.random.default_rng(seed).standard_normal((len(points), order))


@given(functions())
def test_it_is_what_the_rows_add_up_to(drawn: tuple[Array, Array]) -> None:
    points, weights = drawn
    tau = middles(997)
    tau = tau[np.min(np.abs(tau[:, None] - points), axis=1) > 1e-9]
    found = switching(points, weights)
    np.testing.assert_allclose(found(tau), plainly(points, weights, tau), rtol=0, atol=1e-12)


@given(functions())
def test_a_law_pays_what_psi_says(drawn: tuple[Array, Array]) -> None:
    """Σ w g^(k)(x) = ∫ ψ g^(m) for a law that starts from nothing: here g^(m) = cos 3τ."""
    points, weights = drawn
    order = weights.shape[1]
    anti = [
        [lambda x: np.sin(3 * x) / 3],
        [lambda x: (1 - np.cos(3 * x)) / 9],
        [lambda x: x / 9 - np.sin(3 * x) / 27],
    ]  # first to third integral from zero
    paid = sum(
        float(w @ [anti[order - 1 - k][0](x) for k in range(order)])
        for x, w in zip(points, weights, strict=True)
    )
    found = switching(points, weights)
    nodes, shares = np.polynomial.legendre.leggauss(12)
    width = np.diff(found.breaks)[:, None]
    tau = found.breaks[:-1, None] + width * (nodes + 1.0) / 2.0
    integral = float(np.sum(found(tau) * np.cos(3 * tau) * width * shares / 2.0))
    assert integral == pytest.approx(paid, abs=1e-12)


def less(psi: Switching, value: float) -> Switching:
    return Switching(psi.breaks, psi.poly - value * np.eye(psi.poly.shape[1])[0])


def quadrature(psi: Switching, cap: float, weight: float) -> float:
    """∫ min over |w| ≤ cap of (weight w² + ψ w), by the middle rule."""
    value = psi(middles())
    w = -cap * np.sign(value) if weight == 0.0 else np.clip(-value / (2.0 * weight), -cap, cap)
    return float(np.mean(weight * w**2 + value * w))


@given(
    functions(),
    st.sampled_from([(1.0, 0.0), (41.7, 0.0), (0.83, 0.31), (np.inf, 0.7), (1e-3, 2.0)]),
)
def test_the_least_integral(drawn: tuple[Array, Array], held: tuple[float, float]) -> None:
    points, weights = drawn
    found = switching(points, weights)
    cap, weight = held
    expected = quadrature(found, cap, weight)
    # ψ may live on a sliver next to an end, which the middle rule meets with one point or none
    looked_at = np.concatenate([middles(999), 0.5 * points, 0.5 * (1.0 + points)])
    largest = float(np.abs(found(looked_at)).max()) * min(cap, 10.0) + 1e-12
    assert found.least_integral(cap, weight) == pytest.approx(expected, abs=1e-4 * largest)
    assert found.least_integral(cap, weight) <= 0.0


@given(functions())
def test_nowhere_is_it_above_its_magnitude(drawn: tuple[Array, Array]) -> None:
    found = switching(*drawn)
    largest = float(np.abs(found(middles())).max())
    assert largest <= found.magnitude_bound * (1.0 + 1e-12)


def test_the_least_integral_of_a_line_that_meets_both_ends_of_the_cap() -> None:
    """ψ = 8τ − 3, weight ½: w = −ψ where |ψ| ≤ 1, else ∓1."""
    line = Switching(np.array([0.0, 1.0]), np.array([[-3.0, 8.0]]))
    # ∫ −ψ²/2 over |ψ| ≤ 1 is −1/24; of |ψ| from 1 to 3 and from 1 to 5 ∫ (½ − |ψ|) = −3/8, −5/4
    assert line.least_integral(1.0, 0.5) == pytest.approx(-1.0 / 24.0 - 3.0 / 8.0 - 5.0 / 4.0)


@given(functions(), st.floats(-1.0, 1.0))
def test_crossings_are_where_the_sign_changes(drawn: tuple[Array, Array], value: float) -> None:
    points, weights = drawn
    found = switching(points, weights)
    cuts = np.concatenate([[0.0], less(found, value).sign_changes(), [1.0]])
    assert np.all(np.diff(cuts) > 0.0)
    signs = []
    for left, right in itertools.pairwise(cuts):
        tau = left + (right - left) * middles(501)
        apart = found(tau) - value
        sign = np.sign(apart[np.argmax(np.abs(apart))])
        assert np.all(apart * sign >= -1e-9 * np.abs(found.poly).max())
        signs.append(sign)
    assert all(a != b or a == 0.0 for a, b in itertools.pairwise(signs))


def test_known_crossings() -> None:
    """Least peak jerk: ψ is a parabola with zeros at 1/4 and 3/4."""
    # (τ − 1/4)(τ − 3/4) = u²/2·2 − u + 3/16 with u = 1 − τ
    found = switching(np.array([1.0]), np.array([[2.0, -1.0, 3.0 / 16.0]]))
    np.testing.assert_allclose(found.sign_changes(), [0.25, 0.75], atol=1e-15)
    assert found.least_integral(32.0, 0.0) == pytest.approx(-32.0 / 16.0, rel=1e-14)


def test_a_touch_is_no_crossing() -> None:
    found = switching(np.array([1.0]), np.array([[2.0, -1.0, 0.25]]))  # (τ − 1/2)²
    assert len(found.sign_changes()) == 0
    assert len(less(found, 0.01).sign_changes()) == 2


def test_a_jump_is_a_crossing() -> None:
    found = switching(np.array([0.4, 1.0]), np.array([[0.0, -3.0], [0.0, 1.0]]))
    np.testing.assert_allclose(found.sign_changes(), [0.4])


def test_losses_add_up_to_what_a_law_pays_too_much() -> None:
    rng = np.random.default_rng(5)
    found = switching(rng.uniform(size=7), rng.standard_normal((7, 3)))
    knots = np.linspace(0.0, 1.0, 14)
    for cap, weight in ((3.1, 0.0), (np.inf, 0.4)):

        def law(x: Array) -> Array:
            return 2.0 * np.cos(7.0 * np.floor(x * 13.0))  # constant between the knots

        losses = found.losses(knots, law, cap, weight)
        tau = middles()
        paid = float(np.mean(weight * law(tau) ** 2 + found(tau) * law(tau)))
        assert np.all(losses >= 0.0)
        assert losses.sum() == pytest.approx(paid - found.least_integral(cap, weight), abs=1e-4)
