"""Models of piecewise functions: against the function itself, exactly evaluated."""

from decimal import Decimal
from math import factorial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from synthesis.numerics.piecewise import Piecewise
from synthesis.numerics.taylor import Jets
from tests.certify.cams import laws
from tests.forty_digits import cos, sin

FRACTION = st.just(0.0) | st.floats(1e-20, 1.0)  # not so near to 0 that powers underflow


def exact(curve: Piecewise, piece: int, x: float, order: int) -> Decimal:
    """f^(order)(x) of the floating-point coefficients, without rounding."""
    t = Decimal(x) - Decimal(float(curve.origins[piece]))
    total = Decimal(0)
    for j in range(order, curve.poly.shape[1]):
        ratio = factorial(j) // factorial(j - order)
        power = t ** (j - order) if j > order else 1  # Decimal refuses 0 ** 0
        total += ratio * Decimal(float(curve.poly[piece, j])) * power
    for amplitude, frequency, phase in curve.waves[piece].tolist():
        w = Decimal(frequency)
        angle = w * t + Decimal(phase)
        if amplitude == 0.0:
            continue
        wave = (sin(angle), cos(angle), -sin(angle), -cos(angle))[order % 4]
        total += Decimal(amplitude) * w**order * wave
    return total


@given(laws(), FRACTION, st.sampled_from([1.0, 0.3, 1e-2, 1e-6, 0.0]), st.data())
def test_a_box_holds_every_value(law, start, width, data):
    piece = data.draw(st.integers(0, law.count - 1))
    left, right = law.breaks[piece], law.breaks[piece + 1]
    lo = left + start * (1.0 - width) * (right - left)
    hi = min(lo + width * (right - left), right)
    jets = Jets(law)
    where = np.array([piece])
    found = jets.models(where, np.array([lo]), np.array([hi]), 3)
    for order, model in enumerate(found):
        with np.errstate(all="ignore"):
            high, low = model.range()
        rem = float(model.rem[0])
        for x in np.linspace(lo, hi, 5):
            truth = exact(law, piece, float(x), order)
            assert Decimal(float(low[0])) - Decimal(rem) <= truth
            assert truth <= Decimal(float(high[0])) + Decimal(rem)


@given(laws(), FRACTION, st.data())
def test_roundings_are_bounded(law, part, data):
    piece = data.draw(st.integers(0, law.count - 1))
    x = law.breaks[piece] + part * (law.breaks[piece + 1] - law.breaks[piece])
    values, errors = Jets(law).derivatives(np.array([piece]), np.array([x]))
    for order in range(len(values)):
        truth = exact(law, piece, float(x), order)
        assert abs(Decimal(float(values[order, 0])) - truth) <= Decimal(float(errors[order, 0]))


@given(laws())
def test_it_is_the_same_function(law):
    jets = Jets(law)
    x = 0.5 * (law.breaks[1:] + law.breaks[:-1])
    piece = np.arange(law.count)
    for order in range(5):
        value, error = (row[order] for row in jets.derivatives(piece, x))
        scale = 1e-12 * (1.0 + np.abs(value))
        np.testing.assert_array_less(np.abs(value - law.at(x, piece, order)), error + scale)


@pytest.mark.parametrize("order", range(4))
def test_a_cubic_is_exact_on_any_box(order):
    law = Piecewise.of([0.0, 2.0], [[0.3, -1.0, 2.0, 5.0]])
    model = Jets(law).models(np.array([0]), np.array([0.0]), np.array([2.0]), 3)[order]
    dropped = 5.0 if order == 0 else 0.0  # (x − 1)³ has no place in a quadratic
    assert model.rem[0] == pytest.approx(dropped, abs=1e-12)


def test_a_standing_piece_is_exact():
    law = Piecewise.of([0.0, 6.0], [[12.7, 0.0, 0.0]])
    s, v, a, j = Jets(law).models(np.array([0]), np.array([0.0]), np.array([6.0]), 3)
    assert s.c0[0] == 12.7
    assert s.rem[0] < 1e-13
    for model in (v, a, j):
        assert model.mag[0] == 0.0
