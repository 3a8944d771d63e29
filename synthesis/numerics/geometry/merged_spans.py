"""Neighbouring spans of a curve taken as one, where what happens between them is small.

A motion law of many knots makes a curve of many spans, and a spline with the curve's own curvature
at each of their ends needs three control points there. Where curvature is continuous and its first
and second derivative by the arc length jump by J and K, a spline of degree 5 that knows nothing of
it, with nodes every h, departs by some J h³/300 + K h⁴/1200, a part of the cubic and the quartic
that it cannot follow: where that is far below the tolerance the spans may as well be one. This is a
guess at what pays; how far the spline departs is measured afterwards.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.geometry.closed_curve import ClosedCurve, CurvePoints, Indices
from synthesis.numerics.piecewise import Array

SHARES = 1.0 / 300.0, 1.0 / 1200.0
STEP = 1e-3  # of a span, over which the curvature's derivative is taken
ROUNDING = 1e-9  # of the curvature: a step of it that is none


class MergedSpans(ClosedCurve):
    """A curve with some of its spans made one.

    Args:
        curve: whose spans run on in proportion to their sizes where they are joined.
        starts: (m,) numbers of the spans that begin one of the new ones, the first among them.
    """

    def __init__(self, curve: ClosedCurve, starts: Indices) -> None:
        self.curve, self.starts = curve, starts
        self.ends = np.concatenate([[0.0], np.cumsum(curve.span_sizes)])
        self.last = np.append(starts[1:], len(curve.span_sizes)) - 1

    @property
    def span_sizes(self) -> Array:
        return np.asarray(self.ends[self.last + 1] - self.ends[self.starts])

    def at(self, span: Indices, fraction: Array) -> CurvePoints:
        first, last, size = self.starts[span], self.last[span], self.span_sizes[span]
        place = self.ends[first] + size * fraction
        own = np.clip(np.searchsorted(self.ends, place, side="right") - 1, first, last)
        own = np.where(fraction == 1.0, last, own)
        part = self.ends[own + 1] - self.ends[own]
        inside = np.where(fraction == 1.0, 1.0, np.clip((place - self.ends[own]) / part, 0.0, 1.0))
        found = self.curve.at(own, inside)
        return CurvePoints(
            found.points, found.tangent, found.curvature, found.speed * (size / part)
        )


def merge_smooth_spans(curve: ClosedCurve, spacing: Array, tolerance: float) -> ClosedCurve:
    """The curve with the spans joined between which nothing happens that a spline would see.

    Args:
        curve: the curve. spacing: (m,) of nodes along each span that its smoothness asks for [mm].
        tolerance: largest departure [mm].
    """
    count = len(curve.span_sizes)
    near = np.minimum(spacing, np.roll(spacing, 1))
    jumps = _jumps(curve)
    seen = SHARES[0] * jumps[0] * near**3 + SHARES[1] * jumps[1] * near**4
    gentle = seen < 0.1 * tolerance
    gentle[0] = False
    if not gentle.any():
        return curve
    return MergedSpans(curve, np.arange(count)[~gentle])


def _jumps(curve: ClosedCurve) -> Array:
    """(2, m) jumps of the curvature's derivatives where each span begins; ∞ where more jumps."""
    span = np.arange(len(curve.span_sizes))
    begins = [curve.at(span, np.full(len(span), STEP * k)) for k in range(4)]
    ends = [curve.at(span, np.full(len(span), 1.0 - STEP * k)) for k in range(4)]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        (first, second), (first_before, second_before) = _slopes(begins), _slopes(ends)
        # the derivatives before a joint are taken backwards: the first has the other sign
        jumps = np.stack([first + np.roll(first_before, 1), second - np.roll(second_before, 1)])
    told = _smooth(begins[0], ends[0]) & np.all(np.isfinite(jumps), axis=0)
    return np.where(told, np.abs(jumps), np.inf)


def _slopes(courses: list[CurvePoints]) -> tuple[Array, Array]:
    """dκ/dσ and d²κ/dσ² at the first of four places that follow one another from a span's end."""
    a, b, c, d = (course.curvature for course in courses)
    step = STEP * courses[0].speed
    first = (18.0 * b - 11.0 * a - 9.0 * c + 2.0 * d) / (6.0 * step)
    return first, (2.0 * a - 5.0 * b + 4.0 * c - d) / step**2


def _smooth(begins: CurvePoints, ends: CurvePoints) -> NDArray[np.bool_]:
    """(m,) whether point, tangent and curvature go on where each span begins."""
    bend, before = begins.curvature, np.roll(ends.curvature, 1)
    size = np.maximum(np.abs(bend), np.abs(before))
    turned = np.hypot(*(begins.tangent - np.roll(ends.tangent, 1, axis=0)).T)
    moved = np.hypot(*(begins.points - np.roll(ends.points, 1, axis=0)).T)
    extent = np.max(np.abs(begins.points))
    same = np.abs(bend - before) <= ROUNDING * size
    return np.asarray(same & (turned <= ROUNDING) & (moved <= ROUNDING * extent))
