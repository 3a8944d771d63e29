"""Sums of two floats that stand for one number of about 32 digits (Dekker, Numer. Math. 18 (1971)).

Only what divided differences need. Arrays of any shape; no overflow within what cams are made of.
"""

from __future__ import annotations

from synthesis.numerics.piecewise import Array

DoubleDouble = tuple[Array, Array]
SPLIT = 2.0**27 + 1.0  # Veltkamp: halves a float's digits


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
