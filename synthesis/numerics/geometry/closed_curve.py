"""A closed plane curve as it is met on the way round: span by span, each of them smooth."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class CurvePoints:
    """Where a curve is and how it runs on, at n places.

    Attributes:
        points: (n, 2) [mm]. tangent: (n, 2) unit vectors in the sense of running.
        bend: (n,) signed curvature [1/mm], positive where the curve turns left.
        speed: (n,) arc length per unit of the span's fraction [mm], not negative.
    """

    points: Array
    tangent: Array
    curvature: Array
    speed: Array


class ClosedCurve(ABC):
    """A closed curve out of spans, the first beginning where it is best cut open.

    Where one span ends the next begins, at the same point; tangent and curvature may jump.
    """

    @property
    @abstractmethod
    def span_sizes(self) -> Array:
        """(m,) how large each span is, in any unit: by it a first guess is spread [rad]."""

    @abstractmethod
    def at(self, span: Indices, fraction: Array) -> CurvePoints:
        """The course at fractions (n,) of spans (n,); at 0 and 1 the limits from inside."""
