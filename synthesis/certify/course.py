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

Indices = NDArray[np.intp]

JOIN_TOLERANCE: Final = 1e-9  # of the natural scale lift/β^k: closer than this is joined
HIGHEST_JOIN: Final = 4


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

    def __init__(self, motion: Motion) -> None:
        self.motion, self.curve = motion, motion.curve
        placed = [s for s in motion.stretches if s.angle > 0.0]
        pieces = [s.law.count if s.law is not None else 0 for s in placed]
        self.stretch: Indices = np.repeat([s.index for s in placed], pieces)
        self._lift = np.repeat([abs(s.lift) for s in placed], pieces)
        self._beta = np.repeat([s.angle for s in placed], pieces)
        levels = [level for s in placed for level in (s.s_start, s.s_end)]
        self.stroke = max(levels) - min(levels)

    @cached_property
    def jets(self) -> Jets:
        """Taylor models of s to s'''."""
        return Jets(self.curve)

    @cached_property
    def finite(self) -> bool:
        """Whether the motion is made of numbers."""
        tables = (self.curve.breaks, self.curve.origins, self.curve.poly, self.curve.waves)
        return all(bool(np.isfinite(table).all()) for table in tables)

    def pieces(self, stretches: Sequence[int]) -> Indices:
        """Indices of the pieces of these stretches."""
        return np.flatnonzero(np.isin(self.stretch, np.asarray(stretches, dtype=int)))

    @cached_property
    def counts(self) -> Indices:
        """With how many boxes to begin on each piece: few, yet most of them soon excluded."""
        length = np.diff(self.curve.breaks)
        bent = np.any(self.curve.poly[:, 4:] != 0.0, axis=1)
        still = np.all(self.curve.poly[:, 1:] == 0.0, axis=1)
        fewest = np.where(bent, 8.0, 2.0)
        if self.curve.waves.shape[1]:
            real = self.curve.waves[..., 0] != 0.0
            angle = np.max(np.abs(self.curve.waves[..., 1]) * real, axis=1) * length
            fewest, still = np.maximum(fewest, angle / 0.4), still & ~real.any(axis=1)
        wanted = np.where(still, 1.0, np.maximum(fewest, length / 0.06))
        return np.ceil(np.minimum(wanted, 1000.0)).astype(np.intp)

    # -- joints ------------------------------------------------------------------------------

    @cached_property
    def _sides(self) -> tuple[Array, Array]:
        """s to its fourth derivative on the left and on the right of every joint: (5, n) each."""
        here = np.arange(self.curve.count)
        after = np.roll(here, -1)
        x = np.concatenate([self.curve.breaks[1:], self.curve.breaks[after]])
        both, _ = self.jets.derivatives(np.concatenate([here, after]), x)
        filled = np.zeros((HIGHEST_JOIN + 1, len(x)))
        rows = min(len(both), HIGHEST_JOIN + 1)
        filled[:rows] = both[:rows]
        left, right = np.split(filled, 2, axis=1)
        return left, right

    @cached_property
    def _allowed(self) -> Array:
        """(5, n) largest difference that counts as joined."""
        orders = np.arange(HIGHEST_JOIN + 1)[:, None]
        scale = self._lift / self._beta**orders
        scale = np.maximum(scale, np.roll(scale, -1, axis=1))
        spare = self.stroke / np.minimum(self._beta, np.roll(self._beta, -1)) ** orders
        return JOIN_TOLERANCE * np.where(scale > 0.0, scale, spare)

    def jumps(self, order: int, joints: Indices) -> list[Jump]:
        """What is between the two sides of these joints, the worst first by what is allowed."""
        left, right = self._sides
        sizes, allowed = right[order] - left[order], self._allowed[order]
        excess = np.where(np.isnan(sizes), np.inf, np.abs(sizes) / allowed)
        angles = self.curve.breaks
        return [
            Jump(order, int(i), float(angles[i + 1]), float(sizes[i]), float(allowed[i]))
            for i in joints[np.argsort(-excess[joints], kind="stable")]
        ]

    def breaches(self, order: int, joints: Indices) -> list[Jump]:
        """The jumps that are more than rounding, the worst first."""
        left, right = self._sides
        apart = ~(np.abs(right[order] - left[order]) <= self._allowed[order])
        return self.jumps(order, joints[apart[joints]])

    def sides(self, joint: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """s to its third derivative on the left and on the right of one joint."""
        left, right = self._sides
        return tuple(left[:4, joint].tolist()), tuple(right[:4, joint].tolist())

    def joints(self, stretches: Sequence[int]) -> Indices:
        """Joints that touch these stretches."""
        touched = np.isin(self.stretch, np.asarray(stretches, dtype=int))
        return np.flatnonzero(touched | np.roll(touched, -1))
