"""What programs draw through points: straight lines, or cubic splines over the chords' lengths.

CAD systems pass a cubic spline of two continuous derivatives through the points of a file, with the
length of the chords as its parameter (Creo names it in its file, ``arclength``; de Boor; Piegl and
Tiller, The NURBS Book, 9.2.1). They differ in what they do at the ends:

    periodic     a closed curve has none
    not-a-knot   the third derivative is continuous across the second and the last but one point
    natural      the curve is straight at its ends: wrong, unless the cam is
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline

from synthesis.numerics.piecewise import Array

ReaderName = Literal["polyline", "periodic", "not-a-knot", "natural"]
CUBIC: tuple[ReaderName, ...] = ("periodic", "not-a-knot", "natural")


@dataclass(frozen=True, eq=False)
class Reading:
    """One turn of the curve that a reader draws.

    Attributes:
        reader: how it is drawn. spline: its parameter to points and their derivatives.
        knots: (n + 1,) the parameter at the points, the first one's again at the end.
        first: which of the points it begins with: others than the first where some are repeated.
    """

    reader: ReaderName
    spline: CubicSpline | BSpline
    knots: Array
    first: int

    def __call__(self, parameter: Array, order: int = 0) -> Array:
        """The points (2, k), or a derivative of them, at parameters (k,)."""
        return np.asarray(self.spline(parameter, order), dtype=float).T


def reading(points: Array, repeated: int, reader: ReaderName) -> Reading:
    """The curve through points.

    Args:
        points: (n, 2) of a ring, no two neighbours the same [mm].
        repeated: how many more there are past the first point's repetition. A curve that is not
            closed is used from the middle of these on, so that its ends are away from both sides.
    """
    if reader == "periodic":
        repeated = 0
    all_points = np.vstack([points, points[: repeated + 1]])
    steps = np.hypot(*np.diff(all_points, axis=0).T)
    knots = np.concatenate([[0.0], np.cumsum(steps)])
    first = repeated // 2
    used = knots[first : first + len(points) + 1]
    return Reading(reader, spline_through(knots, all_points, reader), used, first)


def spline_through(knots: Array, values: Array, reader: ReaderName) -> CubicSpline | BSpline:
    """What a reader draws through values (n,) or (n, d) at given parameters (n,)."""
    if reader == "polyline":
        return make_interp_spline(knots, values, k=1)
    return CubicSpline(knots, values, bc_type=reader)
