"""The finished motion as pieces of cam angle, and its continuity at the junctions between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.numerics.box_search import Boxes
from synthesis.numerics.piecewise import Array, Indices
from synthesis.numerics.taylor import Jets
from synthesis.units import FULL_TURN

HIGHEST_ORDER: Final = 4  # derivative of s up to which continuity is checked

# Two one-sided values of s^(k) count as equal if they differ by less than the sum of two shares and
# their rounding errors. The first is a share of the natural scale lift/β^k. The second is a share
# of lift/ℓ^k, ℓ the length of the shorter adjacent piece: rounding of a spline's control points,
# about a trillionth of a millimetre in s, is magnified by that factor in the k-th derivative.
JUNCTION_TOLERANCE: Final = 1e-9
CONTROL_POINT_ROUNDING: Final = 1e-13

ANGLE_ROUNDING: Final = 4.0 * 2.0**-53 * FULL_TURN  # rounding of a junction's cam angle [rad]

# The first boxes of an enclosure. More of them cost time in the first iteration; with fewer, too
# few are excluded by it. They change the speed only, never what is proven.
BOXES_PER_SEGMENT: Final = 12.0
WIDEST_BOX: Final = 0.06  # [rad]
LARGEST_WAVE_ANGLE: Final = 0.4  # phase over which a law's sinusoid runs in one box [rad]
MOST_BOXES_PER_PIECE: Final = 1000.0


@dataclass(frozen=True)
class Jump:
    """A discontinuity of a derivative, of the given order, at a junction at a cam angle [rad].

    ``size``: right value less left value [mm per rad^order]; ``allowed``: largest difference that
    counts as continuous.
    """

    order: int
    angle: float
    size: float
    allowed: float


class PiecewiseMotion:
    """A finished motion over one turn, piece by piece.

    Junction i lies between piece i and the next piece; the last junction closes the turn.

    Attributes:
        curve: s(θ) on the pieces. segment_of_piece: (n,) index of the segment of each piece.
        stroke: highest less lowest displacement at the ends of the segments [mm].
    """

    def __init__(self, motion: Motion, cuts: Sequence[float] = ()) -> None:
        """``cuts``: cam angles that become ends of pieces as well [rad]."""
        self.original = motion
        self.segments: Sequence[PlacedSegment] = motion.segments
        self.curve, owner = motion.curve.split_at(cuts)
        placed = [s for s in motion.segments if s.angle > 0.0]
        pieces = [s.law.count if s.law is not None else 0 for s in placed]
        each = np.array([(s.index, abs(s.scale), s.angle) for s in placed]).T
        segment, self._lift, self._beta = np.repeat(each, pieces, axis=1).take(owner, axis=1)
        self.segment_of_piece: Indices = segment.astype(np.intp)
        levels = [s.s_end for s in placed]
        self.stroke = max(max(levels) - min(levels), *(abs(s.scale) for s in placed))

    @cached_property
    def jets(self) -> Jets:
        """Taylor models of s to s'''."""
        return Jets(self.curve)

    @cached_property
    def is_finite(self) -> bool:
        """Whether all breaks and coefficients are finite numbers."""
        tables = (self.curve.breaks, self.curve.origins, self.curve.poly, self.curve.waves)
        return bool(np.isfinite(np.concatenate([table.ravel() for table in tables])).all())

    def pieces_of(self, segments: Sequence[int]) -> Indices:
        """Indices of the pieces of these segments."""
        chosen = np.zeros(len(self.segments), dtype=bool)
        chosen[list(segments)] = True
        return chosen[self.segment_of_piece].nonzero()[0]

    def spans_of(
        self, segments: Sequence[int], part: tuple[float, float] | None
    ) -> tuple[Indices, Array]:
        """Pieces (k,) that overlap a part of these segments, and (k, 2) the overlaps [rad].

        ``part``: first and last x in [0, 1] along each segment; None for all of it. If it is a
        point, both pieces that meet there are returned; otherwise pieces that overlap by no more
        than rounding are left out.
        """
        pieces = self.pieces_of(segments)
        if part is None:
            return pieces, sliding_window_view(self.curve.breaks, 2)[pieces]
        start = np.array([s.start for s in self.segments])
        angle = np.array([s.angle for s in self.segments])
        first, last = (  # of the part, on the segment of each piece
            (start + angle * x)[self.segment_of_piece[pieces]] for x in part
        )
        low = np.maximum(first, self.curve.breaks[pieces])
        high = np.minimum(last, self.curve.breaks[pieces + 1])
        kept = high - low >= (0.0 if part[0] == part[1] else ANGLE_ROUNDING)
        return pieces[kept], np.stack([low, high], axis=1)[kept]

    def intervals(self, widest: float) -> Boxes:
        """The whole turn in equal intervals of each piece, none wider than ``widest`` [rad]."""
        breaks, pieces = self.curve.breaks, np.arange(self.curve.count)
        parts = np.maximum(np.ceil(self._lengths / widest - 1e-9), 1.0).astype(np.intp)
        return Boxes.from_spans(pieces, breaks[:-1], breaks[1:], parts)

    @cached_property
    def _lengths(self) -> Array:
        """Lengths of the pieces (n,) [rad]."""
        return np.diff(self.curve.breaks)

    @cached_property
    def initial_boxes(self) -> Indices:
        """Number of boxes into which an enclosure first divides each piece (n,)."""
        length, still = self._lengths, ~self.curve.poly[:, 1:].any(axis=1)
        fewest = 1.0 + BOXES_PER_SEGMENT * length / self._beta
        if self.curve.waves.shape[1]:
            real = self.curve.waves[..., 0] != 0.0
            phase = np.max(np.abs(self.curve.waves[..., 1]) * real, axis=1) * length
            fewest = np.maximum(fewest, phase / LARGEST_WAVE_ANGLE)
            still = still & ~real.any(axis=1)
        wanted = np.where(still, 1.0, np.maximum(fewest, length / WIDEST_BOX))
        return np.ceil(np.minimum(wanted, MOST_BOXES_PER_PIECE)).astype(np.intp)

    @cached_property
    def next_piece(self) -> Indices:
        """The piece that follows each piece round the turn (n,)."""
        return np.roll(np.arange(self.curve.count), -1)

    @cached_property
    def _one_sided(self) -> tuple[Array, Array, Array]:
        """s to its fourth derivative left and right of every junction, and rounding bounds (5, n).

        Each piece is evaluated by its own formula at its own end, so that both values exist.
        """
        n = self.curve.count
        x = np.concatenate([self.curve.breaks[1:], self.curve.breaks[self.next_piece]])
        values, errors = self.jets.derivatives(np.concatenate([np.arange(n), self.next_piece]), x)
        count = HIGHEST_ORDER + 1
        # the junction's angle is rounded itself, which moves s^(k) by s^(k+1) times its rounding
        rounding = errors[:count] + np.abs(values[1 : count + 1]) * ANGLE_ROUNDING
        value = values[:count]
        return value[:, :n], value[:, n:], rounding[:, :n] + rounding[:, n:]

    @cached_property
    def _jumps(self) -> tuple[Array, Array, Array]:
        """Right less left value, what of it is allowed, and its size relative to that: (5, n)."""
        left, right, rounding = self._one_sided
        natural, shape = self._scales(np.array([self._beta, self._lengths]))
        allowed = JUNCTION_TOLERANCE * natural + CONTROL_POINT_ROUNDING * shape + rounding
        sizes = right - left
        return sizes, allowed, np.abs(sizes) / allowed

    def _scales(self, lengths: Array) -> Array:
        """lift / length^k (j, 5, n) for lengths (j, n), the larger of both sides of each junction.

        Between two dwells the stroke takes the place of the lift.
        """
        factors = [np.ones_like(lengths), *[lengths] * HIGHEST_ORDER]
        powers = np.cumprod(factors, axis=0).swapaxes(0, 1)
        sides = self._lift / powers
        scale = np.maximum(sides, sides.take(self.next_piece, axis=-1))
        dwell = self.stroke / np.minimum(powers, powers.take(self.next_piece, axis=-1))
        # a motion that stands still has no scale: any positive number keeps the quotient defined
        return np.maximum(np.where(scale > 0.0, scale, dwell), np.finfo(float).tiny)

    @cached_property
    def _continuous_orders(self) -> int:
        """How many of s, s', s'', … are continuous everywhere, counted from s itself."""
        continuous = np.all(self._jumps[2] <= 1.0, axis=1).tolist()
        return [*continuous, False].index(False)

    def is_continuous_below(self, order: int) -> bool:
        """Whether all derivatives of s below this order are continuous everywhere."""
        return order <= self._continuous_orders

    def discontinuities(self, order: int, junctions: Indices) -> Indices:
        """Those of the junctions at which s^(order) jumps by more than is allowed."""
        apart: Indices = junctions[~(self._jumps[2][order][junctions] <= 1.0)]
        return apart

    def jump_sizes(self, order: int, junctions: Indices) -> Array:
        """s^(order) just after junctions less that just before them (n,) [mm per rad^order]."""
        return np.asarray(self._jumps[0][order][junctions])

    def largest_jump(self, order: int, junctions: Indices) -> Jump:
        """The jump of s^(order) that is largest in relation to what is allowed."""
        sizes, allowed, shares = self._jumps
        i = int(junctions[np.argmax(shares[order][junctions])])
        angle = float(self.curve.breaks[i + 1])
        return Jump(order, angle, float(sizes[order, i]), float(allowed[order, i]))

    def one_sided_values(self, junction: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """s to s''' on the left and on the right of a junction."""
        left, right, _ = self._one_sided
        return tuple(left[:4, junction].tolist()), tuple(right[:4, junction].tolist())

    def junctions_of(
        self, segments: Sequence[int], part: tuple[float, float] | None = None
    ) -> Indices:
        """Junctions at an end of a piece of these segments, or inside a part x of them."""
        before, after = np.zeros((2, self.curve.count), dtype=bool)
        pieces, spans = self.spans_of(segments, part)
        before[pieces] = spans[:, 1] >= self.curve.breaks[pieces + 1] - ANGLE_ROUNDING
        after[pieces] = spans[:, 0] <= self.curve.breaks[pieces] + ANGLE_ROUNDING
        return np.flatnonzero(before | after[self.next_piece])
