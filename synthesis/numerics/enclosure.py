"""Proven extremes by branch and bound over boxes, for many questions at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.taylor import Array, Taylor

Indices = NDArray[np.intp]
Model = Callable[[Indices, Array, Array], Taylor]

SPLIT: Final = 16
MOST_PARTS: Final = 64
ROUND: Final = 256  # boxes that cost little more than one
MOST_ROUNDS: Final = 12
MOST_BOXES: Final = 100_000
UNBOUNDED: Final = 1e300  # stands for "nothing is known on this box"
ULPS: Final = 2.0**-50
WIDENED: Final = 16.0 * 2.0**-53  # of |x|: by how much a model's box may be wider than it was asked


@dataclass(frozen=True)
class Enclosed:
    """A quantity that is proven to lie in [lower, upper].

    Attributes:
        value: what was found, the function's value at ``angle`` to within rounding.
        lower, upper: proven ends; the value lies between them.
        angle: cam angle where it was found [rad].
    """

    value: float
    lower: float
    upper: float
    angle: float

    @property
    def width(self) -> float:
        """Upper less lower end."""
        return self.upper - self.lower


@dataclass(frozen=True)
class Question:
    """On these pieces, how far does f exceed ``upper``, or fall below ``lower``?

    Attributes:
        pieces: indices of pieces.
        lower, upper: bounds, −inf and inf where there is none. With both at 0 the question is
            for the largest |f|.
        spans: (k, 2) the part of each piece that counts, None where all of them count whole.
    """

    pieces: Indices
    lower: float
    upper: float
    spans: Array | None = None


@dataclass(frozen=True)
class Answer:
    """The extreme of f that is nearest to its bound, or farthest beyond it.

    Attributes:
        extreme: its enclosure. Of a maximum, ``upper`` bounds f everywhere and ``lower`` is
            reached; of a minimum, the other way round. Infinite where nothing could be proven.
        side: +1 if it is a maximum, −1 if a minimum.
        boxes: how many boxes it took, all questions together.
    """

    extreme: Enclosed
    side: int
    boxes: int


@dataclass(frozen=True, eq=False)
class _Boxes:
    question: Indices
    piece: Indices
    lo: Array
    hi: Array

    def take(self, keep: NDArray[np.bool_]) -> _Boxes:
        return _Boxes(self.question[keep], self.piece[keep], self.lo[keep], self.hi[keep])

    def split(self) -> _Boxes:
        """Each cut into equal parts: into many where there are few, for a round costs much."""
        count = max(SPLIT, min(MOST_PARTS, ROUND // len(self.lo)))
        parts = np.arange(count + 1) / count
        edges = self.lo[:, None] + (self.hi - self.lo)[:, None] * parts
        edges[:, -1] = self.hi
        question, piece = np.repeat(self.question, count), np.repeat(self.piece, count)
        return _Boxes(question, piece, edges[:, :-1].ravel(), edges[:, 1:].ravel())

    def and_points(self, others: _Boxes) -> _Boxes:
        pairs = zip(vars(self).values(), vars(others).values(), strict=True)
        return _Boxes(*(np.concatenate(pair) for pair in pairs))


@dataclass(frozen=True, eq=False)
class _Seen:
    """What the models say of each box.

    Attributes:
        excess: largest excess over a bound, up to ±``rem``. above: it is over the upper one.
        spare: what of it may lie outside of the box, in the margin for roundings of its ends.
        value: the function's value there, as exact. where: the place.
    """

    excess: Array
    rem: Array
    spare: Array
    above: NDArray[np.bool_]
    value: Array
    where: Array


def _look(boxes: _Boxes, model: Taylor, lower: Array, upper: Array) -> _Seen:
    """The nearer of two bounds on each box, and where the function comes nearest to it."""
    high, low, t_high, t_low = model.extremes()
    points = boxes.lo == boxes.hi
    if points.any():
        high, low = np.where(points, model.c0, high), np.where(points, model.c0, low)
    rem = model.rem + ULPS * model.mag
    known = np.isfinite(high + low + rem)
    if not known.all():
        high, low = np.where(known, high, 0.0), np.where(known, low, 0.0)
        rem = np.where(known, rem, UNBOUNDED)
    over, under = high - upper[boxes.question], lower[boxes.question] - low
    above = over >= under
    t = np.where(above, t_high, t_low)
    where = 0.5 * (boxes.lo + boxes.hi) + t * (0.5 * (boxes.hi - boxes.lo))
    where = np.clip(where, boxes.lo, boxes.hi)
    margin = WIDENED * (np.abs(boxes.lo) + np.abs(boxes.hi))
    share = np.where(points, 0.0, margin / (0.5 * (boxes.hi - boxes.lo) + margin))
    spare = np.where(known, share * (np.abs(model.c1) + 2.0 * np.abs(model.c2)), 0.0)
    excess, value = np.where(above, over, under), np.where(above, high, low)
    return _Seen(excess, rem, spare, above, value, where)


class _Search:
    """One branch and bound: the best excess found, and the largest one not excluded."""

    def __init__(self, questions: Sequence[Question], relative: float, absolute: float) -> None:
        count = len(questions)
        self.lower = np.array([q.lower for q in questions])
        self.upper = np.array([q.upper for q in questions])
        self.relative, self.absolute = relative, absolute
        self.best = np.full(count, -np.inf)
        self.proven = np.full(count, -np.inf)
        self.above = np.ones(count, dtype=bool)
        self.value = np.zeros(count)
        self.angle = np.zeros(count)
        self.piece = np.array([q.pieces[0] for q in questions])
        self.boxes = 0

    def weigh(self, boxes: _Boxes, model: Taylor) -> tuple[Array, _Boxes]:
        """Take in what the models say.

        Returns:
            the largest excess possible on each box, and the points that look best so far.
        """
        self.boxes += len(boxes.lo)
        seen = _look(boxes, model, self.lower, self.upper)
        sure = seen.excess - seen.rem - seen.spare
        leaders = []
        for q in range(len(self.best)):
            mine = np.flatnonzero(boxes.question == q)
            if len(mine):
                leaders.append(mine[np.argmax(seen.excess[mine])])
                top = mine[np.argmax(sure[mine])]
                if sure[top] > self.best[q]:
                    self.best[q] = sure[top]
                    self._found(q, boxes, seen, top)
        at = seen.where[leaders]
        points = _Boxes(boxes.question[leaders], boxes.piece[leaders], at, at)
        return seen.excess + seen.rem, points

    def tops(self) -> _Boxes:
        """The points where most was found."""
        return _Boxes(np.arange(len(self.best)), self.piece, self.angle.copy(), self.angle.copy())

    def settle(self, points: _Boxes, model: Taylor) -> None:
        """Take the values from points, where models are exact but for rounding."""
        self.boxes += len(points.lo)
        seen = _look(points, model, self.lower, self.upper)
        for q in range(len(self.best)):
            mine = np.flatnonzero((points.question == q) & (seen.rem < UNBOUNDED))
            if len(mine):
                top = mine[np.argmax(seen.excess[mine])]
                self.best[q] = max(self.best[q], seen.excess[top] - seen.rem[top])
                self._found(q, points, seen, top)

    def _found(self, q: int, boxes: _Boxes, seen: _Seen, top: np.intp) -> None:
        self.above[q], self.value[q] = seen.above[top], seen.value[top]
        self.angle[q], self.piece[q] = seen.where[top], boxes.piece[top]

    def survivors(self, boxes: _Boxes, possible: Array) -> NDArray[np.bool_]:
        """Boxes that may still hold more than the target width above the best found."""
        bound = np.where(self.above, self.upper, self.lower)
        size = np.maximum(np.abs(self.value), np.where(np.isfinite(bound), np.abs(bound), 0.0))
        target = self.best + np.maximum(self.absolute, self.relative * size)
        keep: NDArray[np.bool_] = possible > target[boxes.question]
        self.exclude(boxes.question[~keep], possible[~keep])
        return keep

    def exclude(self, question: Indices, possible: Array) -> None:
        """Leave these boxes: what is possible there stays in the proven bound."""
        np.maximum.at(self.proven, question, possible)

    def answers(self) -> list[Answer]:
        """What is known of each question."""
        return [self._answer(q) for q in range(len(self.best))]

    def _answer(self, q: int) -> Answer:
        best, proven, value = (float(x[q]) for x in (self.best, self.proven, self.value))
        angle, side = float(self.angle[q]), 1 if self.above[q] else -1
        if best < -0.1 * UNBOUNDED:
            return Answer(Enclosed(math.nan, -math.inf, math.inf, angle), side, self.boxes)
        proven = math.inf if proven > 0.1 * UNBOUNDED else proven
        if side > 0:
            low, high = best + float(self.upper[q]), proven + float(self.upper[q])
        else:
            low, high = float(self.lower[q]) - proven, float(self.lower[q]) - best
        return Answer(Enclosed(value, min(low, value), max(high, value), angle), side, self.boxes)


def enclose(
    model: Model,
    breaks: Array,
    counts: Indices,
    questions: Sequence[Question],
    relative: float = 1e-10,
    absolute: float = 0.0,
) -> list[Answer]:
    """Answer all questions about one function, defined piece by piece.

    Args:
        model: Taylor models of the function on boxes (piece, lo, hi).
        breaks: (n+1,) ends of the pieces; every piece is taken with both its ends.
        counts: (n,) how many boxes to begin with on each piece.
        questions: what is asked.
        relative, absolute: width at which an enclosure is good enough.
    """
    search = _Search(questions, relative, absolute)
    boxes = _first_boxes(breaks, counts, questions)
    with np.errstate(all="ignore"):
        for rounds_left in range(MOST_ROUNDS, 0, -1):
            possible, points = search.weigh(boxes, model(boxes.piece, boxes.lo, boxes.hi))
            keep = search.survivors(boxes, possible)
            left = np.count_nonzero(keep)
            if left == 0 or search.boxes + SPLIT * left > MOST_BOXES or rounds_left == 1:
                search.exclude(boxes.question[keep], possible[keep])
                break
            boxes = boxes.take(keep).split().and_points(points)
        points = search.tops().and_points(points)
        search.settle(points, model(points.piece, points.lo, points.hi))
    return search.answers()


def _first_boxes(breaks: Array, counts: Indices, questions: Sequence[Question]) -> _Boxes:
    """Every piece of every question, cut into its number of boxes."""
    pieces = np.concatenate([q.pieces for q in questions])
    question = np.repeat(np.arange(len(questions)), [len(q.pieces) for q in questions])
    whole = np.stack([breaks[:-1], breaks[1:]], axis=1)
    spans = [whole[q.pieces] if q.spans is None else q.spans for q in questions]
    first, last = np.concatenate(spans).T
    parts = np.where(last > first, counts[pieces], 1)
    piece, question = np.repeat(pieces, parts), np.repeat(question, parts)
    nth = np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)
    start, step = np.repeat(first, parts), np.repeat((last - first) / parts, parts)
    lo, hi = start + nth * step, start + (nth + 1) * step
    end = nth + 1 == np.repeat(parts, parts)
    return _Boxes(question, piece, lo, np.where(end, np.repeat(last, parts), hi))
