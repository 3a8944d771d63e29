"""Linear relaxation of a bound on the pitch curve's curvature, for a roller on an arm.

Symbols as in ``oscillating_roller``, lengths over the arm l: v = φ' = s'/l, P = d cosψ, Q = d sinψ,
L = 1 + σ v, A = L − P, W² = A² + Q². Where Q > 0 the bound side · κ ≤ k reads

    side φ'' ≥ Φ = [side (W² + σ v A L) − k W³] / Q.

With d given Φ is a function of ψ and v. With the pivot free P = p cosφ − q sinφ and Q = p sinφ +
q cosφ, and Φ is one of φ, v, p and q. A second arm at the angle γ to the first, beyond the axis,
has ψ2 = γ − ψ, v2 = −v and σ2 = −σ: the same with P and Q turned. Over a box Φ lies above a plane
that is as steep as Φ at a place of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import Any

import numpy as np

from synthesis.catalogue.box_bounds import BoxBound
from synthesis.catalogue.constraints import MotionBox, PointInequalities
from synthesis.numerics.affine import minorant_plane, positive
from synthesis.numerics.piecewise import Array

WIDE = 20.0  # rad per rad: over a wider range of v no plane bounds anything
CELLS = {2: (4, 4), 4: (2, 2, 1, 1)}
"""Of the enclosure along each variable; its cost grows with their product."""


@dataclass(frozen=True)
class ArmCurvatureBound(BoxBound):
    """side · κ ≤ most, most > 0, on the pitch curve of a roller on an arm.

    X = lψ where d is given, else X = s; u = X'.

    Attributes:
        reference, sense: l [mm] and σ of the follower, whose motion and size it speaks of.
        distance: d [mm]; None where the pivot is free.
        side: +1 or −1. most: [1/length].
        arm: l of the arm that carries the roller [mm].
        angle: γ, of a second arm [rad]; None: the arm is the follower's own.
    """

    reference: float
    sense: float
    distance: float | None
    side: int
    most: float
    arm: float
    angle: float | None = None

    @property
    def needs_motion_bounds(self) -> bool:
        return self.distance is None

    def _bend(self, along: Any, speed: Any, *pivot: Any) -> Any:
        """Φ at ψ and v, or at φ, v, p/l and q/l, l that of the follower."""
        scale, c, s = self.reference / self.arm, np.cos(along), np.sin(along)
        if self.distance is None:
            p, q = pivot
            ahead, beside = (p * c - q * s) * scale, (p * s + q * c) * scale
        else:
            ahead, beside = c * (self.distance / self.arm), s * (self.distance / self.arm)
        if self.angle is not None:
            by, to = cos(self.angle), sin(self.angle)
            ahead, beside = ahead * by + beside * to, ahead * to - beside * by
        turn = speed * self.sense
        lever = turn + 1.0
        back = lever - ahead
        square = back * back + beside * beside
        bend = (square + turn * back * lever) * float(self.side)
        return (bend - square * np.sqrt(square) * (self.most * self.arm)) / positive(beside)

    def linear_relaxation(
        self, low: Array, high: Array, about: Array | None, moving: MotionBox | None = None
    ) -> tuple[PointInequalities, ...]:
        least, most = low[:2], high[:2]
        place = 0.5 * (least + most) if about is None else about[:2]
        if self.distance is None:
            if moving is None:
                return ()
            one = np.ones(low.shape[1])
            ends = np.array([[a * one, b * one] for a, b in moving.sizes])
            least, most = np.concatenate([least, ends[:, 0]]), np.concatenate([most, ends[:, 1]])
            middle = 0.5 * (ends[:, 0] + ends[:, 1])
            size = middle if moving.about is None else np.outer(moving.about[1], one)
            place = np.concatenate([place, size])
        least, most, place = least / self.reference, most / self.reference, place / self.reference
        if not np.all(most - least <= WIDE):
            return ()
        cells = CELLS[len(least)]
        below = minorant_plane(self._bend, least, most, np.clip(place, least, most), cells)
        if below is None:
            return ()
        slopes, height = below
        # side φ'' (of a second arm −φ'') ≥ slopes · (X/l, u/l, z/l) + height
        bend = np.full_like(height, -self.side if self.angle is None else self.side)
        rows = np.stack([slopes[0], slopes[1], bend, np.zeros_like(height)])
        by = np.array(self.coordinates.size_factors[0])[:, None] * slopes[0]
        size = by if self.distance is not None else slopes[2:]
        unit = self.reference
        return (PointInequalities(rows / unit, size / unit, -height),)
