"""SplineSpace against scipy's design matrix, and the properties that formulations rely on."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from synthesis.numerics.bspline import SplineSpace

DEGREES = st.integers(3, 5)


@st.composite
def spaces(draw: st.DrawFn) -> SplineSpace:
    """Degree 3 to 5, one to twelve intervals, of which the widest is twenty times the narrowest."""
    gaps = np.array(draw(st.lists(st.integers(5, 100), min_size=1, max_size=12))) + 0.37
    breaks = np.concatenate([[0.0], np.cumsum(gaps) / gaps.sum()])
    breaks[-1] = 1.0
    return SplineSpace(draw(DEGREES), breaks)


@st.composite
def splines(draw: st.DrawFn) -> tuple[SplineSpace, np.ndarray]:
    space = draw(spaces())
    values = st.integers(-1000, 1000).map(lambda n: (n + 0.31) / 700.0)
    size = space.size
    return space, np.array(draw(st.lists(values, min_size=size, max_size=size)))


def grid(space: SplineSpace) -> np.ndarray:
    """Both ends, every knot, and angles between."""
    return np.unique(np.concatenate([space.breaks, np.linspace(0.0, 1.0, 83)]))


def steepness(space: SplineSpace, order: int) -> float:
    """The size that derivatives of this order reach: degree over the narrowest gap, each time."""
    return (space.degree / float(np.min(np.diff(space.breaks)))) ** order


@given(spaces())
def test_the_basis_is_scipy_s_design_matrix(space: SplineSpace):
    x = grid(space)
    design = BSpline.design_matrix(x, space.knots, space.degree).toarray()
    np.testing.assert_allclose(space.basis(x), design, rtol=0, atol=1e-14)


@given(spaces())
def test_the_basis_is_a_partition_of_unity(space: SplineSpace):
    x = grid(space)
    B = space.basis(x)
    assert B.shape == (len(x), space.size)
    assert np.all(B >= -1e-15)
    np.testing.assert_allclose(B.sum(axis=1), 1.0, rtol=1e-14)
    for order in range(1, space.degree + 1):
        rounding = 1e-14 * steepness(space, order)
        np.testing.assert_allclose(space.basis(x, order).sum(axis=1), 0.0, atol=rounding)


@given(spaces())
def test_it_is_clamped(space: SplineSpace):
    ends = space.basis(np.array([0.0, 1.0]))
    corners = np.zeros_like(ends)
    corners[0, 0] = corners[1, -1] = 1.0
    np.testing.assert_allclose(ends, corners, rtol=0, atol=1e-15)
    # the k-th derivative at an end knows only the k + 1 outermost coefficients
    for order in range(1, space.degree):
        rows = space.basis(np.array([0.0, 1.0]), order)
        assert np.all(rows[0, order + 1 :] == 0.0)
        assert np.all(rows[1, : -order - 1] == 0.0)


@given(splines())
def test_it_reproduces_polynomials_of_its_degree(case):
    # Greville: the coefficients of x are the averages of the inner knots (Marsden's identity)
    space, _ = case
    p, knots = space.degree, space.knots
    greville = np.array([knots[i + 1 : i + p + 1].mean() for i in range(space.size)])
    x = grid(space)
    np.testing.assert_allclose(space.basis(x) @ greville, x, rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        space.basis(x, 1) @ greville, 1.0, rtol=0, atol=1e-13 * steepness(space, 1)
    )


@given(splines(), st.integers(0, 3))
def test_derivative_rows_are_those_of_the_derivative_spline(case, order: int):
    space, c = case
    order = min(order, space.degree)
    x = grid(space)[:-1] + 1e-9  # just right of each knot: the top derivative jumps there
    x = x[x < 1.0]
    spline = BSpline(space.knots, c, space.degree)
    want = spline.derivative(order)(x) if order else spline(x)
    tolerance = 1e-13 * steepness(space, order)
    np.testing.assert_allclose(space.basis(x, order) @ c, want, rtol=1e-10, atol=tolerance)


@given(splines(), st.integers(0, 5))
def test_control_gives_the_coefficients_of_the_derivative(case, order: int):
    space, c = case
    order = min(order, space.degree)
    d = space.control_matrices[order] @ c
    assert d.shape == (space.size - order,)
    x = grid(space)
    inner = space.knots[order : len(space.knots) - order]
    want = BSpline(inner, d, space.degree - order)(x)
    tolerance = 1e-13 * steepness(space, order) * 4.0
    np.testing.assert_allclose(space.basis(x, order) @ c, want, rtol=1e-11, atol=tolerance)


@given(splines(), st.integers(0, 5))
def test_a_spline_lies_in_the_hull_of_its_coefficients(case, order: int):
    space, c = case
    order = min(order, space.degree)
    d = space.control_matrices[order] @ c
    values = space.basis(grid(space), order) @ c
    tolerance = 1e-13 * steepness(space, order) * 4.0
    assert np.all(values <= d.max() + tolerance)
    assert np.all(values >= d.min() - tolerance)


@given(splines())
def test_the_pieces_are_the_spline(case):
    space, c = case
    curve = space.curve(c)
    assert np.array_equal(curve.breaks, space.breaks)
    spline = BSpline(space.knots, c, space.degree)
    x = np.concatenate([[0.0, 1.0], *(space.breaks[:-1] + f * np.diff(space.breaks)
                                      for f in (0.0, 0.1234, 0.5678, 0.99))])  # fmt: skip
    for order in range(space.degree + 1):
        want = spline(x, nu=order)
        tolerance = 1e-13 * max(1.0, steepness(space, order))
        np.testing.assert_allclose(curve(x, order), want, rtol=0, atol=tolerance)


@given(splines())
def test_the_spline_is_as_smooth_as_its_degree_says(case):
    space, c = case
    curve = space.curve(c)
    inner = space.breaks[1:-1]
    for order in range(space.degree):
        left, right = curve(inner, order, "left"), curve(inner, order, "right")
        tolerance = 1e-13 * max(1.0, steepness(space, order))
        np.testing.assert_allclose(left, right, rtol=0, atol=tolerance)


@given(splines())
def test_rising_coefficients_make_a_rising_spline(case):
    space, c = case
    curve = space.curve(np.sort(c))
    assert np.min(curve(np.linspace(0.0, 1.0, 301), 1)) >= -1e-13 * steepness(space, 1)


@pytest.mark.parametrize("degree", [3, 4, 5])
def test_at_an_inner_knot_the_right_piece_counts_and_at_one_the_last(degree: int):
    space = SplineSpace(degree, np.array([0.0, 0.23, 0.61, 1.0]))
    c = np.cos(np.arange(space.size) * 1.7)
    top = space.basis(np.array([0.23, 0.23 + 1e-6, 0.61, 0.7, 1.0, 0.9]), degree) @ c
    assert top[0] == pytest.approx(top[1], rel=1e-12)
    assert top[2] == pytest.approx(top[3], rel=1e-12)
    assert top[4] == pytest.approx(top[5], rel=1e-12)
    assert top[0] != pytest.approx(top[2], rel=1e-3)


def test_sizes():
    space = SplineSpace(4, np.linspace(0.0, 1.0, 8))
    assert space.size == 7 + 4
    assert len(space.knots) == space.size + 4 + 1


@given(splines())
def test_steps_of_coefficients_stand_for_the_slope(case):
    space, c = case
    x, factors = space.step_slopes
    slope = SplineSpace(space.degree - 1, space.breaks)
    np.testing.assert_allclose(x, slope.greville, rtol=0, atol=1e-15)
    np.testing.assert_allclose(space.step_matrix @ c, c[:-1] - c[1:], rtol=0, atol=0)
    scale = 1e-14 * steepness(space, 1) * np.abs(c).max()
    np.testing.assert_allclose(
        factors * (space.control_matrices[1] @ c), space.step_matrix @ c, atol=scale
    )


@given(splines(), st.integers(1, 3))
def test_prices_of_an_end_pay_for_its_coefficients(case, count: int):
    space, c = case
    gradient = c[:count]
    prices = space.end_multipliers(gradient)
    paid = prices @ space.end_derivatives(1.0, count)[:, space.size - count :]
    np.testing.assert_allclose(paid, -gradient, atol=1e-9 * np.abs(gradient).max())
