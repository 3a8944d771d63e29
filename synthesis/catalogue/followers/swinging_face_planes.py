"""Planes below what a swinging face's limits ask, over a range of its angle and its speed.

Symbols as in ``oscillating_flat_face``: ψ angle of the face at its pivot, w = 1 + σφ' > 0. With the
centre distance d given, the profile radius is at least ρ where

    φ'' ≥ Φ(ψ, w) = k w³ / cosψ − w (2w − 1) tanψ,  k = (f + ρ)/d.

A plane as steep as Φ at the middle lies below it once it is lowered by the least of what is left;
that is enclosed on small cells from the middle of each and the range of the slopes on it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from synthesis.numerics.piecewise import Array

CELLS = (16, 6)  # of the enclosure, along ψ and along w; its cost grows with their product
STEEPEST = 1.45  # rad: beyond 83° tanψ grows so fast that no plane bounds anything
ROUNDING = 1e-12  # relative: a plane is lowered by it, far above the rounding of its terms


class Interval(NamedTuple):
    """An interval, elementwise."""

    low: Array
    high: Array

    def times(self, other: Interval) -> Interval:
        """All products."""
        each = np.stack([a * b for a in self for b in other])
        return Interval(np.min(each, axis=0), np.max(each, axis=0))

    def less(self, other: Interval) -> Interval:
        """All differences."""
        return Interval(self.low - other.high, self.high - other.low)

    def reach(self) -> Array:
        """The largest absolute value."""
        return np.maximum(np.abs(self.low), np.abs(self.high))


class MinorantPlane(NamedTuple):
    """by_angle · ψ + by_speed · w + height at n points, (n,) each."""

    by_angle: Array
    by_speed: Array
    height: Array


def minorant_plane(k: float, angle: Interval, speed: Interval) -> MinorantPlane | None:
    """A plane below Φ for angles [rad] and speeds in ranges (n,); None where there is none."""
    if np.max(angle.reach()) > STEEPEST or not np.all(speed.low > 0.0):
        return None
    psi, w = 0.5 * (angle.low + angle.high), 0.5 * (speed.low + speed.high)
    # The slopes of Φ in the middle of the range.
    slopes = _slopes(k, Interval(psi, psi), Interval(w, w))
    by_angle, by_speed = slopes[0].low, slopes[1].low
    # What stands above a plane of these slopes, at the middle of every cell, less the most that it
    # can fall from there: the range of its slopes times half the cell's width (mean value theorem).
    parts, widths = [], []
    for ends, count in zip((angle, speed), CELLS, strict=True):
        shares = np.linspace(0.0, 1.0, count + 1)[:, None]
        edges = ends.low + (ends.high - ends.low) * shares
        parts.append(Interval(edges[:-1], edges[1:]))
        widths.append((ends.high - ends.low) / (2.0 * count))
    cell = Interval(*(np.repeat(edge, CELLS[1], axis=0) for edge in parts[0]))
    pace = Interval(*(np.tile(edge, (CELLS[0], 1)) for edge in parts[1]))
    middle, fast = 0.5 * (cell.low + cell.high), 0.5 * (pace.low + pace.high)
    left = _bend(k, middle, fast) - by_angle * middle - by_speed * fast
    along, across = _slopes(k, cell, pace)
    slack = along.less(Interval(by_angle, by_angle)).reach() * widths[0]
    slack = slack + across.less(Interval(by_speed, by_speed)).reach() * widths[1]
    height = np.min(left - slack, axis=0)
    height -= ROUNDING * (1.0 + np.abs(height) + np.abs(by_angle) + np.abs(by_speed))
    return MinorantPlane(by_angle, by_speed, height)


def _bend(k: float, psi: Array, w: Array) -> Array:
    """Φ."""
    return np.asarray(k * w**3 / np.cos(psi) - w * (2.0 * w - 1.0) * np.tan(psi))


def _slopes(k: float, psi: Interval, w: Interval) -> tuple[Interval, Interval]:
    """The ranges of ∂Φ/∂ψ and ∂Φ/∂w over cells, |ψ| < 90° and w > 0."""
    far = psi.reach()
    near = np.where(psi.low * psi.high < 0.0, 0.0, np.minimum(np.abs(psi.low), np.abs(psi.high)))
    secant = Interval(1.0 / np.cos(near), 1.0 / np.cos(far))
    sine, tangent = (
        Interval(np.sin(psi.low), np.sin(psi.high)),
        Interval(np.tan(psi.low), np.tan(psi.high)),
    )
    factor = Interval(np.full_like(w.low, k), np.full_like(w.low, k))
    cube, square = Interval(w.low**3, w.high**3), Interval(3.0 * w.low**2, 3.0 * w.high**2)
    other = w.times(Interval(2.0 * w.low - 1.0, 2.0 * w.high - 1.0))
    along = factor.times(cube).times(sine).less(other).times(secant.times(secant))
    across = factor.times(square).times(secant)
    return along, across.less(Interval(4.0 * w.low - 1.0, 4.0 * w.high - 1.0).times(tangent))
