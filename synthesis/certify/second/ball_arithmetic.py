"""Ball arithmetic of 200 bits, and power series of balls: what the second judge computes with.

A ball is a number with a proven radius; every operation enlarges the radius by its rounding error
(Johansson, IEEE Trans. Comput. 66 (2017) 1281). A series holds the Taylor coefficients of a
function at a point or, if its first coefficient is a wide ball, their ranges over an interval.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from flint import arb, arb_series, ctx

BITS: Final = 200  # 60 digits: 25 are left after cancellation in every quantity
TERMS: Final = 6  # of a series: s to its fifth derivative, for the jerk to its second
_LOCK = threading.Lock()  # precision is global state of the library

SeriesVector = tuple[arb_series, arb_series]


@contextmanager
def ball_precision() -> Iterator[None]:
    """Inside the context balls have ``BITS`` bits and series ``TERMS`` terms."""
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
    """The ball over the interval between two exact numbers."""
    return arb((low + high) / 2, (high - low) / 2)


def coefficient(series: arb_series, order: int) -> arb:
    """One Taylor coefficient of a series; 0 beyond its last."""
    coefficients = series.coeffs()
    return coefficients[order] if order < len(coefficients) else arb(0)
