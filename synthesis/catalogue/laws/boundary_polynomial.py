"""The polynomial that meets any velocity and acceleration at its two ends (VDI 2143)."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from math import comb, factorial
from typing import ClassVar, Literal

from pydantic import Field

from synthesis.catalogue.laws.base import (
    ANY,
    REST,
    TASKS,
    EndDerivatives,
    EndKinds,
    LawEntry,
    MotionLaw,
)
from synthesis.catalogue.laws.rest_to_rest import about_both_ends
from synthesis.catalogue.motion import SegmentKind
from synthesis.numerics.piecewise import Piecewise

Derivatives = tuple[float, ...]


@lru_cache(maxsize=1024)
def hermite(start: Derivatives, end: Derivatives) -> Piecewise:
    """The polynomial of degree 2m − 1 with g, g', …, g^(m−1) as given at 0 and at 1.

    Two-point Taylor formula: with y = 1 − x,
    g = y^m Σ_k x^k Σ_j g^(j)(0)/j! C(m−1+k−j, k−j) + x^m Σ_k y^k Σ_j (−1)^j g^(j)(1)/j! C(…),
    k < m, j ≤ k; expanded in fractions, so that both ends are met to the last bit.
    """
    from_start, from_end = _weights(start, 1), _weights(end, -1)
    m = len(start)
    total = [Fraction(0)] * (2 * m)
    for k in range(m):
        for i in range(m + 1):  # (1 − x)^m x^k
            total[k + i] += from_start[k] * comb(m, i) * (-1) ** i
        for i in range(k + 1):  # x^m (1 − x)^k
            total[m + i] += from_end[k] * comb(k, i) * (-1) ** i
    return about_both_ends(total, Fraction(1))


def _weights(values: Derivatives, sign: int) -> list[Fraction]:
    m = len(values)
    taylor = [Fraction(value) * sign**j / factorial(j) for j, value in enumerate(values)]
    return [
        sum((taylor[j] * comb(m - 1 + k - j, k - j) for j in range(k + 1)), Fraction(0))
        for k in range(m)
    ]


class BoundaryPolynomial(MotionLaw):
    """The polynomial that meets any boundary values: every task of VDI 2143.

    Its velocity and acceleration at either end are the ones required in `start` and `end`; what
    is not required is the neighbour's where that has a law of its own, and rest otherwise.

    | kind | what it meets at both ends |
    |---|---|
    | `polynomial_5` | s, v, a: of all motions with these the least mean square jerk |
    | `polynomial_7` | s, v, a, and no jerk there: the least mean square of the jerk's slope |
    """

    kind: Literal["polynomial_5", "polynomial_7"]
    overshoot: bool = Field(
        False, description="Allow the follower to move backwards within the segment."
    )
    inherited_derivatives: ClassVar[int] = 2
    ends: ClassVar[EndKinds] = "R-R"
    tasks: ClassVar[tuple[str, ...]] = TASKS
    entries: ClassVar = {
        "polynomial_5": LawEntry(
            "Polynomial of degree 5, any boundary values",
            "VDI 2143-1 (general polynomial of degree 5)",
            hermite((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ),
        "polynomial_7": LawEntry(
            "Polynomial of degree 7, any boundary values",
            "VDI 2143-1 (general polynomial of degree 7)",
            hermite((0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),
        ),
    }

    @property
    def may_reverse(self) -> bool:
        return self.overshoot

    def curve(self, segment: SegmentKind) -> Piecewise:
        return self.with_end_derivatives(segment, REST, REST)

    def with_end_derivatives(
        self, segment: SegmentKind, start: EndDerivatives = ANY, end: EndDerivatives = ANY
    ) -> Piecewise:
        """End derivatives that are not required are zero."""
        jerk = (0.0,) if self.kind == "polynomial_7" else ()
        first, last = (tuple(value or 0.0 for value in known) for known in (start, end))
        return hermite((0.0, *first, *jerk), (1.0, *last, *jerk))
