"""Planes above d cos(ψ + c) where the pivot lies in a polygon and the swing in a range.

Symbols: d centre distance; ψ = ψ0 + φ angle at the pivot, φ swing; p = d cosψ0, q = d sinψ0. In
these, d cos(ψ + c) = p cos(φ + c) − q sin(φ + c) is linear in the size for every swing, and along
the swing a cosine; so what stands above a plane of any slope is largest over a corner of the
polygon, at a swing that is known in closed form.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, hypot, pi

import numpy as np

from synthesis.numerics.piecewise import Array

ROUNDING = 1e-13  # relative: a plane is raised by it, far above the rounding of its terms
Point = Sequence[float]


@dataclass(frozen=True, eq=False)
class MajorantPlane:
    """along · φ + size · (p, q) + height [mm] at n points: (n,), (2, n) and (n,)."""

    along: Array
    size: Array
    height: Array


def majorant_plane(
    turn: float, corners: Sequence[Point], swing: tuple[Array, Array], at: tuple[Array, Point]
) -> MajorantPlane:
    """The lowest plane above d cos(ψ + turn) that is as steep as this is at a place.

    Args:
        turn: c [rad].
        corners: (p, q) of a polygon in which the pivot lies [mm].
        swing: lower and upper end of φ, (n,) each [rad].
        at: φ (n,) and (p, q) of the place.
    """
    # The tangent plane's slopes at the place.
    phi, (p, q) = at[0] + turn, at[1]
    size = np.stack([np.cos(phi), -np.sin(phi)])
    along = -p * np.sin(phi) - q * np.cos(phi)
    # What stands above a plane of these slopes is linear in (p, q), hence largest at a corner.
    left = [
        max_of_cosine_minus_line(hypot(*corner), atan2(corner[1], corner[0]) + turn, along, *swing)
        - (size[0] * corner[0] + size[1] * corner[1])
        for corner in corners
    ]
    terms = max(hypot(*corner) for corner in corners) + np.abs(along) * np.abs(swing[1])
    return MajorantPlane(along, size, np.max(left, axis=0) + ROUNDING * terms)


def max_of_cosine_minus_line(
    reach: float, start: float, slope: Array, low: Array, high: Array
) -> Array:
    """The largest of reach · cos(φ + start) − slope · φ for φ between low and high."""

    def difference(phi: Array) -> Array:
        return np.asarray(reach * np.cos(phi + start) - slope * phi)

    # A stationary point has −reach · sin(φ + start) = slope; it is a maximum where the cosine is
    # positive. Of its periods the one nearest to the range is clipped to it: the function has one
    # maximum a period, so its largest value over the range is there or at an end.
    top = np.arcsin(np.clip(-slope / max(reach, 1e-300), -1.0, 1.0)) - start
    top = top + 2.0 * pi * np.round((0.5 * (low + high) - top) / (2.0 * pi))
    inner = difference(np.clip(top, low, high))
    return np.asarray(np.maximum(np.maximum(difference(low), difference(high)), inner))
