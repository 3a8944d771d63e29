"""Taylor models of the traced curve and of the profile beside it, on the turning cam."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from synthesis.catalogue.followers.kinematics import Vector2
from synthesis.certify.piecewise_motion import PiecewiseMotion
from synthesis.numerics.boxes import Boxes
from synthesis.numerics.piecewise import Array
from synthesis.numerics.taylor import ROUNDING, Taylor

TraceFunction = Callable[[Any], tuple[Vector2, ...]]  # s to s''' -> p and its derivatives

ANGLE_ROUNDING: Final = 2.0**-48  # relative, of an interval's centre and half width: 32 roundings
ARCSINE_ROUNDING: Final = 1e-12  # relative, of its argument, whose rounding the arc sine magnifies


@dataclass(frozen=True, eq=False)
class ThickChords:
    """A plane curve on intervals, each within ``thickness`` of the straight chord middle ± half.

    Attributes:
        middle, half: (2, n) midpoint and half vector [mm]. thickness: (n,) [mm].
        point: (2, n) the curve's point at the interval's centre, to within ``error`` (n,) [mm].
    """

    middle: Array
    half: Array
    thickness: Array
    point: Array
    error: Array

    @classmethod
    def of(cls, x: Taylor, y: Taylor) -> ThickChords:
        """c0 + c1 t + c2 t² ± rem, |t| ≤ 1, lies within |c2|/2 + |rem| of c0 + c2/2 + c1 t."""
        bend, rem = np.stack([x.c2, y.c2]), np.stack([x.rem, y.rem])
        point, error = np.stack([x.c0, y.c0]), np.hypot(*rem)
        thickness = 0.5 * np.hypot(*bend) + error
        return cls(point + 0.5 * bend, np.stack([x.c1, y.c1]), thickness, point, error)


@dataclass(frozen=True, eq=False)
class ProfileModels:
    """Traced curve and profile on intervals: p and T = D p in the machine frame, as models."""

    intervals: Boxes
    p: Vector2
    tangent: Vector2
    distance: float

    @cached_property
    def theta(self) -> Taylor:
        """The cam angle itself."""
        lo, hi = self.intervals.lo, self.intervals.hi
        centre, half = 0.5 * (lo + hi), 0.5 * (hi - lo)
        rounding = ANGLE_ROUNDING * (np.abs(centre) + half)
        return Taylor.of(centre, half, np.zeros_like(half), rounding)

    @cached_property
    def tangent_angle(self) -> tuple[Array, Array]:
        """Lower and upper end of the tangent's angle on the cam, clockwise positive [rad].

        On each interval the angle is within half a turn of its value at the centre; it is not
        continued from interval to interval.
        """
        tx, ty = self.tangent
        return _range(self.theta - np.arctan2(ty, tx))

    def polar_range(self) -> tuple[Array, Array]:
        """Lower and upper end of the polar angle on the cam of every point of the roller [rad].

        The profile point that it touches is one of them. The whole turn where the roller may cover
        the axis: seen from there, a circle of radius R at distance r fills ± arcsin R/r.
        """
        px, py = self.p
        low, high = _range(np.arctan2(py, px) - self.theta)
        square = px * px + py * py
        least = square.mignitude() - ROUNDING * square.mag
        nearest = np.sqrt(np.where(least > 0.0, least, np.nan))
        sine = (1.0 + ARCSINE_ROUNDING) * abs(self.distance) / nearest
        half = np.arcsin(np.where(sine < 1.0, sine, np.nan)) + ANGLE_ROUNDING
        known = np.isfinite(low + high + half)
        return np.where(known, low - half, -math.pi), np.where(known, high + half, math.pi)

    def chords(self) -> tuple[ThickChords, ThickChords]:
        """Enclosures of the profile and of the traced curve, in the frame of the cam."""
        (px, py), (tx, ty) = self.p, self.tangent
        share = self.distance / np.sqrt(tx * tx + ty * ty)
        cos, sin = np.cos(self.theta), np.sin(self.theta)
        profile, traced = (
            ThickChords.of(x * cos + y * sin, y * cos - x * sin)  # turned by −θ
            for x, y in ((px + ty * share, py - tx * share), (px, py))  # n = (−ty, tx)/|T|
        )
        return profile, traced


def _range(angle: Taylor) -> tuple[Array, Array]:
    """Lower and upper end of an angle's model on each interval."""
    reach = np.abs(angle.c1) + np.abs(angle.c2) + angle.rem
    return angle.c0 - reach, angle.c0 + reach


@dataclass(frozen=True, eq=False)
class OffsetProfile:
    """The traced curve P on the cam, and the profile O = P − d n at a signed distance d [mm].

    P runs clockwise; n is its normal to the left, which points outward. |d| is the radius of the
    roller; d is negative where the cam lies outside the traced curve.
    """

    motion: PiecewiseMotion
    trace: TraceFunction
    distance: float

    def models(self, intervals: Boxes) -> ProfileModels:
        """Both curves on intervals."""
        s = self.motion.jets.models(intervals.piece, intervals.lo, intervals.hi, 1)
        (px, py), (dx, dy), *_ = self.trace((*s, 0.0, 0.0))
        return ProfileModels(intervals, (px, py), (dx + py, dy - px), self.distance)
