"""The finished motion as the judge sees it: pieces, and the joints between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from synthesis.motion import Motion
from synthesis.numerics.jets import Jets
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

Indices = NDArray[np.intp]

# Two values of s^(k) are joined if they differ by less than the sum of these two shares, one of the
# natural scale lift/β^k, one of lift/ℓ^k with ℓ the shorter piece: what a spline's control points
# lose by rounding, a trillionth of a millimetre in s, grows so with the order.
JOIN_TOLERANCE: Final = 1e-9
SHAPE_TOLERANCE: Final = 1e-13
HIGHEST_JOIN: Final = 4
ANGLE_ROUNDING: Final = 4.0 * 2.0**-53 * FULL_TURN  # of the angle of a joint [rad]
TINY: Final = 1e-250  # scale of a motion that stands still


@dataclass(frozen=True)
class Jump:
    """A derivative's two values at a joint that do not agree.

    Attributes:
        order: which derivative. joint: index of the joint. angle: cam angle [rad].
        size: value on the right less value on the left [mm per rad^order].
        allowed: what still counts as joined.
    """

    order: int
    joint: int
    angle: float
    size: float
    allowed: float


class Course:
    """A settled motion over one turn.

    Joint i lies between piece i and the next one; the last joint closes the turn.

    Attributes:
        curve: s(θ). stretch: (n,) index of the stretch of each piece.
        stroke: highest less lowest end of the stretches [mm].
    """

    def __init__(self, motion: Motion, cuts: Sequence[float] = ()) -> None:
        """``cuts``: cam angles at which pieces shall end as well [rad]."""
        self.motion = motion
        self.curve, owner = motion.curve.cut(cuts)
        placed = [s for s in motion.stretches if s.angle > 0.0]
        pieces = [s.law.count if s.law is not None else 0 for s in placed]
        each = np.array([(s.index, abs(s.unit), s.angle) for s in placed]).T
        stretch, self._lift, self._beta = np.repeat(each, pieces, axis=1).take(owner, axis=1)
        self.stretch: Indices = stretch.astype(np.intp)
        self._present = {s.index for s, count in zip(placed, pieces, strict=True) if count}
        levels = [level for s in placed for level in (s.s_start, s.s_end)]
        self.stroke = max(max(levels) - min(levels), *(abs(s.unit) for s in placed))

    @cached_property
    def jets(self) -> Jets:
        """Taylor models of s to s'''."""
        return Jets(self.curve)

    @cached_property
    def finite(self) -> bool:
        """Whether the motion is made of numbers."""
        tables = (self.curve.breaks, self.curve.origins, self.curve.poly, self.curve.waves)
        return bool(np.isfinite(np.concatenate([table.ravel() for table in tables])).all())

    def has(self, stretches: Sequence[int]) -> bool:
        """Whether any of these stretches has pieces."""
        return not self._present.isdisjoint(stretches)

    def _touched(self, stretches: Sequence[int]) -> NDArray[np.bool_]:
        """Which pieces belong to these stretches."""
        chosen = np.zeros(len(self.motion.stretches), dtype=bool)
        chosen[list(stretches)] = True
        return chosen[self.stretch]

    def pieces(self, stretches: Sequence[int]) -> Indices:
        """Indices of the pieces of these stretches."""
        return self._touched(stretches).nonzero()[0]

    def spans(
        self, stretches: Sequence[int], part: tuple[float, float] | None
    ) -> tuple[Indices, Array]:
        """Pieces of a part x of these stretches, and what of each belongs to it: (k,), (k, 2).

        At a point both neighbours count; of a part, no piece that it shares rounding only with.
        """
        pieces = self.pieces(stretches)
        if part is None:
            return pieces, np.stack([self.curve.breaks[:-1], self.curve.breaks[1:]], 1)[pieces]
        first, last = self._ends(part)[:, self.stretch[pieces]]
        low = np.maximum(first, self.curve.breaks[pieces])
        high = np.minimum(last, self.curve.breaks[pieces + 1])
        kept = high - low >= (0.0 if part[0] == part[1] else ANGLE_ROUNDING)
        return pieces[kept], np.stack([low, high], axis=1)[kept]

    def _ends(self, part: tuple[float, float]) -> Array:
        """Cam angles where a part x of every stretch begins and ends: (2, n)."""
        start = np.array([s.start for s in self.motion.stretches])
        angle = np.array([s.angle for s in self.motion.stretches])
        return np.stack([start + angle * x for x in part])

    @cached_property
    def _lengths(self) -> Array:
        """Of the pieces: (n,)."""
        return self.curve.breaks[1:] - self.curve.breaks[:-1]

    @cached_property
    def counts(self) -> Indices:
        """With how many boxes to begin on each piece: few, yet most of them soon excluded."""
        length, still = self._lengths, ~self.curve.poly[:, 1:].any(axis=1)
        fewest = 1.0 + 12.0 * length / self._beta
        if self.curve.waves.shape[1]:
            real = self.curve.waves[..., 0] != 0.0
            angle = np.max(np.abs(self.curve.waves[..., 1]) * real, axis=1) * length
            fewest, still = np.maximum(fewest, angle / 0.4), still & ~real.any(axis=1)
        wanted = np.where(still, 1.0, np.maximum(fewest, length / 0.06))
        return np.ceil(np.minimum(wanted, 1000.0)).astype(np.intp)

    # -- joints ------------------------------------------------------------------------------

    @cached_property
    def after(self) -> Indices:
        """The piece that follows each piece, round the turn."""
        following: Indices = np.arange(1, self.curve.count + 1)
        following[-1] = 0
        return following

    @cached_property
    def _sides(self) -> tuple[Array, Array, Array]:
        """s to its fourth derivative left and right of every joint, and their roundings: (5, n)."""
        n = self.curve.count
        x = np.concatenate([self.curve.breaks[1:], self.curve.breaks[self.after]])
        values, errors = self.jets.derivatives(np.concatenate([np.arange(n), self.after]), x)
        count = HIGHEST_JOIN + 1
        # the joint's angle is itself rounded
        rounding = errors[:count] + np.abs(values[1 : count + 1]) * ANGLE_ROUNDING
        value = values[:count]
        return value[:, :n], value[:, n:], rounding[:, :n] + rounding[:, n:]

    @cached_property
    def _jumps(self) -> tuple[Array, Array, Array]:
        """What is between the sides, what of it counts as joined, the share of both: (5, n)."""
        left, right, rounding = self._sides
        natural, shape = self._scales(np.array([self._beta, self._lengths]))
        allowed = JOIN_TOLERANCE * natural + SHAPE_TOLERANCE * shape + rounding
        sizes = right - left
        return sizes, allowed, np.abs(sizes) / allowed

    @cached_property
    def _whole(self) -> int:
        """How many derivatives from s itself on jump nowhere by more than rounding."""
        joined = np.all(self._jumps[2] <= 1.0, axis=1).tolist()
        return [*joined, False].index(False)

    def _scales(self, lengths: Array) -> Array:
        """Lift over powers of lengths (k, n), the larger of both sides of each joint: (k, 5, n).

        Between two dwells the whole stroke stands for the lift.
        """
        powers = np.ones((len(lengths), HIGHEST_JOIN + 1, self.curve.count))
        for order in range(1, HIGHEST_JOIN + 1):
            powers[:, order] = powers[:, order - 1] * lengths
        sides = self._lift / powers
        scale = np.maximum(sides, sides.take(self.after, axis=-1))
        spare = self.stroke / np.minimum(powers, powers.take(self.after, axis=-1))
        return np.maximum(np.where(scale > 0.0, scale, spare), TINY)

    def worst(self, order: int, joints: Indices) -> Jump:
        """What is between the two sides of a derivative where it is most, by what is allowed."""
        sizes, allowed, shares = self._jumps
        i = int(joints[np.argmax(shares[order][joints])])
        angle = float(self.curve.breaks[i + 1])
        return Jump(order, i, angle, float(sizes[order, i]), float(allowed[order, i]))

    def joined(self, order: int) -> bool:
        """Whether derivatives below this one jump nowhere by more than rounding."""
        return order <= self._whole

    def breaches(self, order: int, joints: Indices) -> Indices:
        """Those of the joints at which a derivative jumps by more than rounding."""
        apart: Indices = joints[~(self._jumps[2][order][joints] <= 1.0)]
        return apart

    def sides(self, joint: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """s to its third derivative on the left and on the right of one joint."""
        left, right, _ = self._sides
        return tuple(left[:4, joint].tolist()), tuple(right[:4, joint].tolist())

    def joints(self, stretches: Sequence[int], part: tuple[float, float] | None = None) -> Indices:
        """Joints that touch these stretches, or a part x of them."""
        before, after = np.zeros((2, self.curve.count), dtype=bool)
        pieces, spans = self.spans(stretches, part)
        before[pieces] = spans[:, 1] >= self.curve.breaks[pieces + 1] - ANGLE_ROUNDING
        after[pieces] = spans[:, 0] <= self.curve.breaks[pieces] + ANGLE_ROUNDING
        return np.flatnonzero(before | after[self.after])
