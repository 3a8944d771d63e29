"""Numbers without their last digits."""

import numpy as np
import pytest

from synthesis.numerics.double_double import BITS, round_mantissa


@pytest.mark.parametrize("bits", [BITS, 16])
def test_so_many_digits_are_left_and_no_more(bits: int) -> None:
    rng = np.random.default_rng(bits)
    x = rng.standard_normal(4000) * 10.0 ** rng.uniform(-200.0, 200.0, 4000)
    found = round_mantissa(x, bits)
    whole = np.ldexp(np.frexp(found)[0], bits)
    np.testing.assert_array_equal(whole, np.round(whole))
    assert np.max(np.abs(found / x - 1.0)) <= 2.0**-bits
    assert np.count_nonzero(found != x) > 3900


def test_what_differs_by_rounding_comes_out_the_same() -> None:
    x = np.array([0.1, 1.0 / 3.0, -7.0, 0.0])
    np.testing.assert_array_equal(round_mantissa(x), round_mantissa(x * (1.0 + 2.0**-50)))
    assert float(round_mantissa(0.3 * 3.0)) == float(round_mantissa(0.9))
