"""The digits of floats: numbers of twice as many, and of fewer (Dekker, Numer. Math. 18 (1971)).

Two floats stand for one number of about 32 digits, their sum; only what divided differences need.
Arrays of any shape; no overflow within what cams are made of.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from synthesis.numerics.piecewise import Array

DoubleDouble = tuple[Array, Array]
SPLIT: Final = 2.0**27 + 1.0  # Veltkamp: halves a float's digits
BITS: Final = 40  # of 53, that ``round_mantissa`` leaves


def difference(a: Array, b: Array) -> DoubleDouble:
    """a − b exactly (Knuth)."""
    high = a - b
    seen = high - a
    return high, (a - (high - seen)) - (b + seen)


def product(a: Array, b: Array) -> DoubleDouble:
    """a b exactly (Dekker)."""
    high = a * b
    a1, b1 = SPLIT * a, SPLIT * b
    a1, b1 = a1 - (a1 - a), b1 - (b1 - b)
    a2, b2 = a - a1, b - b1
    return high, ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2


def neighbour_differences(a: DoubleDouble) -> DoubleDouble:
    """a[i + 1] − a[i] of numbers along the last axis."""
    high, low = difference(a[0][..., 1:], a[0][..., :-1])
    return normalise(high, low + (a[1][..., 1:] - a[1][..., :-1]))


def normalise(high: Array, low: Array) -> DoubleDouble:
    """The same number with the larger part rounded to nearest."""
    total = high + low
    return total, low - (total - high)


def quotient(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    """a / b."""
    first = a[0] / b[0]
    back = product(first, b[0])
    rest, error = difference(a[0], back[0])
    missing = rest + (error + a[1] - back[1] - first * b[1])
    return normalise(first, missing / b[0])


def round_mantissa(values: Array | float, bits: int = BITS) -> Array:
    """Values to so many binary digits: 40 are 1e-12 relative.

    A program with one optimum of many answers differently where the last bit of a number differs:
    so a cam a million times as large would be another one. Numbers whose last digits are gone are
    the same for both. Values are finite, and smaller than 1e290.
    """
    # Veltkamp's splitting (Dekker, Numer. Math. 18 (1971) 224): to the nearest, ties either way
    spread = values * (2.0 ** (53 - bits) + 1.0)
    return np.asarray(spread - (spread - values), dtype=float)
