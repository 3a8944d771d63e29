"""Balls of 200 bits and power series of them: what confirmation computes with.

A ball is a number with a proven radius; every operation widens the radius by what it rounds
(Johansson, IEEE Trans. Comput. 66 (2017) 1281). A series holds a function's Taylor coefficients at
a point or, with a wide ball as its first coefficient, their ranges over an interval.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from flint import arb, arb_series, ctx

BITS: Final = 200
TERMS: Final = 6  # of a series: s to its fifth derivative
_LOCK = threading.Lock()  # precision is the library's global state

Pair = tuple[arb_series, arb_series]


@contextmanager
def exactly() -> Iterator[None]:
    """Within it numbers have ``BITS`` bits and series ``TERMS`` terms."""
    with _LOCK:
        before = ctx.prec, ctx.cap
        ctx.prec, ctx.cap = BITS, TERMS
        try:
            yield
        finally:
            ctx.prec, ctx.cap = before


def degree() -> arb:
    """π/180."""
    return arb.pi() / 180


def hull(low: arb, high: arb) -> arb:
    """The ball over an interval between two exact numbers."""
    return arb((low + high) / 2, (high - low) / 2)


def term(series: arb_series, order: int) -> arb:
    """One coefficient of a series."""
    coefficients = series.coeffs()
    return coefficients[order] if order < len(coefficients) else arb(0)
