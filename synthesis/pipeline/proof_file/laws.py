"""Laws as columns of a linear program, and its rows."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import factorial
from typing import Any

import numpy as np

from synthesis.numerics.piecewise import Array

Json = dict[str, Any]
ORDER = 3  # of the derivative that is limited


@dataclass
class Law:
    """A free law as columns of the program: g''' over its cap on intervals, and what starts it.

    Attributes:
        first: its first column. knots: (n + 1,). cap: of |g'''|. start: of g' and g'' at 0 the
            values, or None where columns of their own follow those of the intervals.
    """

    segment: Any
    first: int
    knots: Array
    cap: float
    start: list[float | None]
    columns: list[int] = field(default_factory=list)

    def rows(self, x: Array, order: int, width: int) -> tuple[Array, Array]:
        """g^(order) at x (q,), affine in all columns: (q, width) and constants (q,)."""
        matrix, constant = np.zeros((len(x), width)), np.zeros(len(x))
        n = ORDER - order
        ahead = np.maximum(x[:, None] - self.knots, 0.0) ** n * (self.cap / factorial(n))
        matrix[:, self.first : self.first + len(self.knots) - 1] = ahead[:, :-1] - ahead[:, 1:]
        for k, (value, column) in enumerate(zip(self.start, self.columns, strict=True), 1):
            if k >= order:
                power = x ** (k - order) / factorial(k - order)
                if value is None:
                    matrix[:, column] += power
                else:
                    constant += value * power
        return matrix, constant


@dataclass
class Row:
    """A row of the program and what its multiplier is in the file.

    Attributes:
        x, y: ends of the span whose mean it is; equal at points.
        values, upper: values · unknowns ≤ upper.
        places, alpha: where on the law it acts, and its factors there.
        touch: of an arm, the swing where its plane touches [deg]. elastic: whether it may be
            broken at a price, where it is said to be minimised "elastically".
    """

    segment: int
    limit: str
    side: int
    x: float
    y: float
    values: Array
    upper: float
    places: Array
    alpha: Array
    touch: float | None = None
    elastic: bool = False
