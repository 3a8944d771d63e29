"""The traced curve and the profile beside it, on the cam, as Taylor models."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from synthesis.certify.course import Course, Indices
from synthesis.followers.trace import Vector2
from synthesis.numerics.piecewise import Array
from synthesis.numerics.taylor import ROUNDING, Taylor

Trace = Callable[[Any], tuple[Vector2, ...]]  # s to s''' -> the traced point and its derivatives
ANGLE_ROUNDING: Final = 2.0**-48  # of the angle of a box's centre and of its half width
ARCSINE: Final = 1e-12  # relative: more than the roundings of its argument, which it magnifies


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes of cam angle, each inside its (closed) piece: piece, lo, hi are (n,)."""

    piece: Indices
    lo: Array
    hi: Array

    def __len__(self) -> int:
        return len(self.lo)

    def take(self, which: Any) -> Boxes:
        """Some of them, by mask or index."""
        return Boxes(self.piece[which], self.lo[which], self.hi[which])

    def split(self, parts: int) -> Boxes:
        """Each cut into equal parts, which follow one another."""
        edges = self.lo[:, None] + (self.hi - self.lo)[:, None] * (np.arange(parts + 1) / parts)
        edges[:, -1] = self.hi
        lo, hi = edges[:, :-1].ravel(), edges[:, 1:].ravel()
        return Boxes(np.repeat(self.piece, parts), lo, hi)

    def joined(self, other: Boxes) -> Boxes:
        """These and the others."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Boxes(*(np.concatenate(pair) for pair in pairs))

    @classmethod
    def of(cls, course: Course, widest: float) -> Boxes:
        """All pieces of a course, cut so that no box is wider than ``widest`` [rad]."""
        breaks = course.curve.breaks
        parts = np.maximum(np.ceil(np.diff(breaks) / widest - 1e-9), 1.0).astype(np.intp)
        piece = np.repeat(np.arange(course.curve.count), parts)
        nth = np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)
        step = np.diff(breaks)[piece] / parts[piece]
        lo, hi = breaks[piece] + nth * step, breaks[piece] + (nth + 1) * step
        return cls(piece, lo, np.where(nth + 1 == parts[piece], breaks[piece + 1], hi))


@dataclass(frozen=True, eq=False)
class Strokes:
    """A plane curve on boxes: within ``thick`` of the straight stroke mid ± half.

    Attributes:
        mid, half: (2, n) centre and half vector [mm]. thick: (n,) [mm].
        at: (2, n) the curve's point at the box's centre, to within ``near`` (n,).
    """

    mid: Array
    half: Array
    thick: Array
    at: Array
    near: Array

    @classmethod
    def of(cls, x: Taylor, y: Taylor) -> Strokes:
        """c0 + c1 t + c2 t² ± rem lies within |c2|/2 + |rem| of c0 + c2/2 + c1 t."""
        bend, rem = np.stack([x.c2, y.c2]), np.stack([x.rem, y.rem])
        at, near = np.stack([x.c0, y.c0]), np.hypot(*rem)
        thick = 0.5 * np.hypot(*bend) + near
        return cls(at + 0.5 * bend, np.stack([x.c1, y.c1]), thick, at, near)


@dataclass(frozen=True, eq=False)
class Drawn:
    """What a path draws on boxes, as models: p and T = D p in the machine frame, and θ."""

    boxes: Boxes
    p: Vector2
    tangent: Vector2
    distance: float

    @cached_property
    def theta(self) -> Taylor:
        """The cam angle itself."""
        boxes = self.boxes
        centre, half = 0.5 * (boxes.lo + boxes.hi), 0.5 * (boxes.hi - boxes.lo)
        rounding = ANGLE_ROUNDING * (np.abs(centre) + half)
        return Taylor.of(centre, half, np.zeros_like(half), rounding)

    @cached_property
    def heading(self) -> tuple[Array, Array]:
        """Lower and upper end of the tangent's angle on the cam, clockwise positive [rad].

        Each box by itself, in the half turn to either side of its own centre: not yet continued
        from box to box.
        """
        tx, ty = self.tangent
        return _ends(self.theta - ty.arctan2(tx))

    def shadow(self) -> tuple[Array, Array]:
        """Between which polar angles on the cam the roller lies, seen from the axis [rad].

        Both the roller and the profile point that it touches do, wherever it is in a box. A whole
        turn where the axis may lie in the roller.
        """
        px, py = self.p
        low, high = _ends(py.arctan2(px) - self.theta)
        square = px * px + py * py
        least = square.least() - ROUNDING * square.mag
        nearest = np.sqrt(np.where(least > 0.0, least, np.nan))
        share = (1.0 + ARCSINE) * abs(self.distance) / nearest
        half = np.arcsin(np.where(share < 1.0, share, np.nan)) + ANGLE_ROUNDING
        known = np.isfinite(low + high + half)
        return np.where(known, low - half, -math.pi), np.where(known, high + half, math.pi)

    def strokes(self) -> tuple[Strokes, Strokes]:
        """The profile and the traced curve."""
        (px, py), (tx, ty) = self.p, self.tangent
        share = self.distance / np.sqrt(tx * tx + ty * ty)
        cos, sin = np.cos(self.theta), np.sin(self.theta)
        profile, traced = (
            Strokes.of(x * cos + y * sin, y * cos - x * sin)  # as seen from the cam
            for x, y in ((px + ty * share, py - tx * share), (px, py))  # n = (−ty, tx)/|T|
        )
        return profile, traced


def _ends(angle: Taylor) -> tuple[Array, Array]:
    """Between what an angle lies on each box; its last operation allowed for roundings here too."""
    reach = np.abs(angle.c1) + np.abs(angle.c2) + angle.rem
    return angle.c0 - reach, angle.c0 + reach


@dataclass(frozen=True, eq=False)
class Path:
    """The traced curve P on the cam, and the profile O = P − d n at a signed distance.

    P runs clockwise, n is its normal to the left, outward. d is the roller's radius where the
    profile lies inside the traced curve, its negative where it lies outside.
    """

    course: Course
    trace: Trace
    distance: float

    def on(self, boxes: Boxes) -> Drawn:
        """Both curves on boxes."""
        s = self.course.jets.models(boxes.piece, boxes.lo, boxes.hi, 1)
        (px, py), (dx, dy), *_ = self.trace((*s, 0.0, 0.0))
        return Drawn(boxes, (px, py), (dx + py, dy - px), self.distance)
