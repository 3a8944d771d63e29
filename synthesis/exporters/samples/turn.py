"""The follower's motion over a turn as a file sees it, with the places where its parts meet."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.motion import Motion
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN, Travel

Mask = NDArray[np.bool_]

# A step of a derivative smaller than this part of its peak is rounding, not a jump.
ROUNDING = 1e-6
SMOOTH = 4  # order of a joint where no derivative up to the third jumps


@dataclass(frozen=True, eq=False)
class Joints:
    """Where pieces of the motion meet, the first at cam angle 0.

    Attributes:
        theta: (n,) cam angles in [0, 2π) [rad].
        order: (n,) lowest derivative of s that jumps there; SMOOTH if none up to the third does.
        border: (n,) whether two segments meet there.
    """

    theta: Array
    order: NDArray[np.intp]
    border: Mask

    def breaking(self, highest: int) -> Array:
        """Angles where a derivative up to the given one jumps [rad]."""
        return self.theta[self.order <= highest]

    def marked(self, highest: int) -> Array:
        """The same, and every border of a segment [rad]."""
        return self.theta[self.border | (self.order <= highest)]


@dataclass(frozen=True, eq=False)
class Turn:
    """One turn of a shaft.

    Attributes:
        motion: of the follower. travel: unit of its displacement. omega: speed [rad/s].
    """

    motion: Motion
    travel: Travel
    omega: float

    def rate(self, order: int) -> float:
        """Factor from s^(order) per radian to the time derivative in the unit of travel."""
        return self.travel.wire_factor(order, self.omega)

    def derivatives(self, theta: Array, left: Mask) -> Array:
        """s and its derivatives (4, n) at θ [mm, per radian], one-sided likewise."""
        s = self.motion.derivatives(theta, 3, "right")
        s[:, left] = self.motion.derivatives(theta[left], 3, "left")
        return s

    @cached_property
    def joints(self) -> Joints:
        """Where pieces of the motion meet."""
        theta = self.motion.curve.breaks[:-1]
        left = self.motion.derivatives(theta, 3, "left")
        right = self.motion.derivatives(theta, 3, "right")
        turn = np.linspace(0.0, FULL_TURN, 721)
        everywhere = np.abs(np.hstack([left, right, self.motion.derivatives(turn, 3)]))
        peak = np.max(everywhere, axis=1, keepdims=True)
        # Where a derivative vanishes altogether, its rounding is measured by the displacement's.
        jumps = np.abs(right - left) > ROUNDING * np.maximum(peak, 0.1 * peak[0])
        order = np.where(jumps.any(axis=0), np.argmax(jumps, axis=0), SMOOTH)
        starts = [s.start for s in self.motion.segments if s.angle > 0.0]
        return Joints(theta, order, np.isin(theta, starts))

    @cached_property
    def seam(self) -> float:
        """Middle of the longest dwell [rad], where a closed curve is best cut; without one, 0.

        Dwells that touch count as one, also across cam angle 0.
        """
        moving = [s for s in self.motion.segments if s.angle > 0.0 and s.kind != "dwell"]
        ends = [s.end for s in moving]
        starts = [s.start for s in moving[1:]] + [moving[0].start + FULL_TURN]
        still = [(start - end, end) for end, start in zip(ends, starts, strict=True)]
        length, begin = max(still, key=lambda rest: (round(rest[0], 9), -rest[1]))
        return (begin + 0.5 * length) % FULL_TURN if length > 1e-9 else 0.0
