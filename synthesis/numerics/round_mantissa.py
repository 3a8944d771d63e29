"""Numbers without their last digits: what differs by rounding alone comes out the same."""

from __future__ import annotations

import numpy as np

from synthesis.numerics.piecewise import Array

BITS = 40  # of 53


def round_mantissa(values: Array | float, bits: int = BITS) -> Array:
    """Values to so many binary digits: 40 are 1e-12 relative.

    A program with one optimum of many answers differently where the last bit of a number differs:
    so a cam a million times as large would be another one. Numbers whose last digits are gone are
    the same for both. Values are finite, and smaller than 1e290.
    """
    # Veltkamp's splitting (Dekker, Numer. Math. 18 (1971) 224): to the nearest, ties either way
    spread = values * (2.0 ** (53 - bits) + 1.0)
    return np.asarray(spread - (spread - values), dtype=float)
