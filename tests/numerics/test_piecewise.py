"""Piecewise: values and derivatives against forty digits, and what is done to whole functions."""

from decimal import Decimal
from math import factorial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.numerics.piecewise import Piecewise, concatenate, sorted_unique
from tests.forty_digits import PI, cos, sin

number = st.floats(-3.0, 3.0).map(lambda v: v + 0.0173)
width = st.integers(1, 1000).map(lambda n: n / 617.3)


@st.composite
def functions(draw: st.DrawFn) -> Piecewise:
    """Two to five pieces with up to six coefficients and up to three waves each."""
    widths = draw(st.lists(width, min_size=2, max_size=5))
    breaks = np.cumsum([draw(number), *widths])
    poly = [draw(st.lists(number, min_size=1, max_size=6)) for _ in widths]
    wave = st.tuples(number, st.floats(0.1, 9.0), number)
    waves = [draw(st.lists(wave, max_size=3)) for _ in widths]
    ends = [draw(st.integers(0, 1)) for _ in widths]
    origins = [breaks[i + end] for i, end in enumerate(ends)]
    return Piecewise.of(breaks, poly, waves, origins)


def power(base: Decimal, exponent: int) -> Decimal:
    return base**exponent if exponent else Decimal(1)


def exact(f: Piecewise, piece: int, x: float, order: int) -> float:
    """The piece's derivative in forty digits; a sine's is the sine a quarter turn further."""
    t = Decimal(x) - Decimal(float(f.origins[piece]))
    total = Decimal(0)
    for j, c in enumerate(f.poly[piece]):
        if j >= order:
            total += (
                Decimal(float(c)) * (factorial(j) // factorial(j - order)) * power(t, j - order)
            )
    for A, w, phase in f.waves[piece]:
        A, w, phase = (Decimal(float(v)) for v in (A, w, phase))
        total += A * power(w, order) * sin(w * t + phase + order * PI / 2)
    return float(total)


def middle(f: Piecewise, fraction: float = 0.43) -> np.ndarray:
    return f.breaks[:-1] + fraction * np.diff(f.breaks)


def size_of(f: Piecewise, order: int) -> float:
    """A bound of every term of the derivative: what rounding is compared with."""
    span = max(1.0, float(np.max(np.diff(f.breaks))))
    terms = [abs(c) * factorial(j) * span**j for row in f.poly for j, c in enumerate(row)]
    waves = [abs(A) * max(w, 1.0) ** (order + 1) for row in f.waves for A, w, _ in row]
    return sum(terms) + sum(waves) + 1.0


@given(functions(), st.integers(0, 6))
def test_every_derivative_in_forty_digits(f: Piecewise, order: int):
    x = middle(f)
    want = [exact(f, i, float(x[i]), order) for i in range(f.count)]
    np.testing.assert_allclose(f(x, order), want, rtol=0, atol=3e-14 * size_of(f, order))


def test_sine_and_cosine_of_the_reference():
    assert abs(sin(PI / 6) - Decimal("0.5")) < Decimal("1e-40")
    assert abs(cos(PI / 3) - Decimal("0.5")) < Decimal("1e-40")
    assert str(PI).startswith("3.1415926535897932384626433832795028841971")


@given(functions())
def test_at_a_break_each_side_has_its_own_piece(f: Piecewise):
    for order in range(4):
        for i in range(1, f.count):
            x = float(f.breaks[i])
            tolerance = 3e-14 * size_of(f, order)
            assert f(x, order, "left") == pytest.approx(exact(f, i - 1, x, order), abs=tolerance)
            assert f(x, order, "right") == pytest.approx(exact(f, i, x, order), abs=tolerance)


@given(functions())
def test_at_the_ends_both_sides_are_the_end_piece(f: Piecewise):
    for x in (f.breaks[0], f.breaks[-1]):
        assert f(x, 1, "left") == f(x, 1, "right")
    assert f(f.breaks[-1]) == pytest.approx(
        exact(f, f.count - 1, float(f.breaks[-1]), 0), abs=3e-14 * size_of(f, 0)
    )


@given(functions())
def test_derivatives_are_the_single_ones_and_shape_is_kept(f: Piecewise):
    x = middle(f)
    table = f.derivatives(x, 3)
    assert table.shape == (4, f.count)
    for order in range(4):
        assert np.array_equal(table[order], f(x, order))
    assert f(x[0]).shape == ()
    assert f(x.reshape(-1, 1)).shape == (f.count, 1)


@given(functions(), number, width, number, number)
def test_placed(f: Piecewise, start: float, wide: float, shift: float, scale: float):
    g = f.rescale(start, wide, shift, scale)
    x = middle(f)
    np.testing.assert_allclose(g.breaks, start + wide * f.breaks, rtol=1e-15)
    at = start + wide * x
    for order in range(4):
        want = scale * f(x, order) / wide**order + (shift if order == 0 else 0.0)
        # x comes back from `at` with its rounding, magnified by 1/width and by the next slope
        back = 1e-14 * (1.0 + (abs(start) + abs(wide)) / wide)
        noise = back * size_of(f, order + 1) * (1.0 + abs(scale)) / wide**order
        np.testing.assert_allclose(g(at, order), want, rtol=1e-12, atol=noise + 1e-14 * abs(shift))


@given(functions())
def test_reversed_runs_backwards_over_the_same_interval(f: Piecewise):
    g = f.mirror()
    both = f.breaks[0] + f.breaks[-1]
    x = middle(f)
    assert g.breaks[0] == pytest.approx(f.breaks[0])
    assert np.all(np.diff(g.breaks) > 0.0)
    for order in range(4):
        noise = 1e-13 * size_of(f, order + 1) * (1.0 + abs(both))
        np.testing.assert_allclose(
            g(both - x, order), (-1.0) ** order * f(x, order), rtol=0, atol=noise
        )
    # sides change places
    inner = f.breaks[1:-1]
    np.testing.assert_allclose(
        g(g.breaks[1:-1], 1, "left"), -f(inner, 1, "right")[::-1], rtol=0,
        atol=1e-13 * size_of(f, 2) * (1.0 + abs(both)),
    )  # fmt: skip


@given(functions(), functions())
def test_join_keeps_every_part(f: Piecewise, g: Piecewise):
    g = g.rescale(float(f.breaks[-1] - g.breaks[0]), 1.0, 0.0, 1.0)
    both = concatenate([f, g])
    assert both.count == f.count + g.count
    for order in range(4):
        assert np.array_equal(both(middle(f), order), f(middle(f), order))
        assert np.array_equal(both(middle(g), order), g(middle(g), order))


@given(functions(), st.floats(0.0, 1.0), st.integers(0, 4))
def test_the_crude_bound_is_one(f: Piecewise, fraction: float, order: int):
    piece = np.arange(f.count)
    x = middle(f, fraction)
    bound = f.bound_derivative(piece, np.diff(f.breaks), order)
    assert np.all(abs(f.at(x, piece, order)) <= bound * (1.0 + 1e-12) + 1e-300)


def test_a_piece_of_no_length_is_never_met():
    f = Piecewise.of([0.0, 1.0, 1.0, 2.0], [[1.0], [99.0], [3.0]])
    assert f(1.0, side="left") == 1.0
    assert f(1.0, side="right") == 3.0
    assert list(f([0.5, 1.5])) == [1.0, 3.0]


def test_a_stretch_of_no_angle_adds_no_piece():
    ramp, still = Piecewise.of([0.0, 1.0], [[0.0, 1.0]]), Piecewise.of([0.0, 1.0], [[0.0]])
    half = np.pi
    motion = Motion.of(
        [
            PlacedSegment(0, "rise", 0.0, half, 0.0, 2.0, ramp),
            PlacedSegment(1, "dwell", half, 0.0, 2.0, 2.0, still),
            PlacedSegment(2, "return", half, half, 2.0, 0.0, ramp),
        ]
    )
    assert motion.curve.count == 2
    assert len(motion.segments) == 3
    assert motion.derivatives(half, 1, "left")[1, 0] == 2.0 / np.pi
    assert motion.derivatives(half, 1, "right")[1, 0] == -2.0 / np.pi


def test_zeros_of_the_sine_stay_exact():
    cycloid = Piecewise.of([0.0, 1.0], [[0.0, 1.0]], [[(-0.5 / np.pi, 2.0 * np.pi, 0.0)]])
    assert list(cycloid.derivatives(0.0)[:3, 0]) == [0.0, 0.0, 0.0]


def test_ragged_rows_are_filled_with_zeros():
    f = Piecewise.of([0.0, 1.0, 3.0], [[1.0, 2.0, 3.0], [5.0]], [[], [(2.0, 1.0, 0.0)]])
    assert f.poly.tolist() == [[1.0, 2.0, 3.0], [5.0, 0.0, 0.0]]
    assert f(0.5) == 1.0 + 1.0 + 0.75
    assert f(2.0) == 5.0 + 2.0 * np.sin(1.0)
    assert f(0.5, 3) == 0.0
    assert f(0.5, 9) == 0.0


def test_all_derivatives_at_once_are_those_one_by_one() -> None:
    """By a scheme of their own: the same to rounding, for polynomials, waves and beyond both."""
    rng = np.random.default_rng(7)
    curve = Piecewise.of(
        [0.0, 0.7, 1.9],
        [rng.normal(size=6), [0.3, -1.2]],
        [[(0.4, 5.0, 0.2), (0.1, 17.0, -0.6)], []],
        origins=[0.7, 0.7],
    )
    x = rng.uniform(0.0, 1.9, 40)
    piece = curve.piece_of(x)
    for highest in (0, 1, 3, 7):
        each = np.stack([curve.at(x, piece, order) for order in range(highest + 1)])
        size = np.max(np.abs(each), axis=1)[:, None]
        assert np.all(np.abs(curve.jet(x, piece, highest) - each) <= 4e-15 * size)


@given(st.lists(st.integers(-9, 9), max_size=30))
def test_distinct_values_in_order(values: list[int]) -> None:
    table = np.array(values, dtype=float).reshape(-1, 1) / 7.0
    np.testing.assert_array_equal(sorted_unique(table), np.unique(table))
