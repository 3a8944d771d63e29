"""Proven extremes by branch and bound over boxes, for many questions at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.taylor import Array, Taylor

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]
Models = Callable[[Indices, Array, Array, Sequence[int]], Sequence[Taylor]]

SPLIT: Final = 16
MOST_PARTS: Final = 64
ROUND: Final = 256  # boxes that cost little more than one
MOST_ROUNDS: Final = 12
MOST_BOXES: Final = 100_000  # of each function
VAGUE: Final = 1e-14  # of a value: more than that is not left open of it
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
    """On these pieces, how far does a function exceed ``upper``, or fall below ``lower``?

    Attributes:
        pieces: indices of pieces.
        lower, upper: bounds, −inf and inf where there is none. With both at 0 the question is
            for the largest |f|.
        spans: (k, 2) the part of each piece that counts, None where all of them count whole.
        function: which of the functions.
        relative, absolute: width at which the enclosure is good enough.
    """

    pieces: Indices
    lower: float
    upper: float
    spans: Array | None = None
    function: int = 0
    relative: float = 1e-10
    absolute: float = 0.0


@dataclass(frozen=True)
class Answer:
    """The extreme of a function that is nearest to its bound, or farthest beyond it.

    Attributes:
        extreme: its enclosure. Of a maximum, ``upper`` bounds f everywhere and ``lower`` is
            reached; of a minimum, the other way round. Infinite where nothing could be proven.
        side: +1 if it is a maximum, −1 if a minimum.
        boxes: on how many boxes the question was looked at.
    """

    extreme: Enclosed
    side: int
    boxes: int


@dataclass(frozen=True, eq=False)
class _Boxes:
    """Boxes (n,) of one piece each, and which questions they are for: (questions, n)."""

    piece: Indices
    lo: Array
    hi: Array
    asked: Mask

    def left(self, asked: Mask) -> _Boxes:
        """Those that are still asked for."""
        return replace(self, asked=asked).at(np.flatnonzero(asked.any(axis=0)))

    def at(self, which: Indices) -> _Boxes:
        """Some of them, in this order."""
        return _Boxes(self.piece[which], self.lo[which], self.hi[which], self.asked[:, which])

    def split(self) -> _Boxes:
        """Each cut into equal parts: into many where there are few, for a round costs much."""
        count = max(SPLIT, min(MOST_PARTS, ROUND // len(self.lo)))
        parts = np.arange(count + 1) / count
        edges = self.lo[:, None] + (self.hi - self.lo)[:, None] * parts
        edges[:, -1] = self.hi
        piece, asked = np.repeat(self.piece, count), np.repeat(self.asked, count, axis=1)
        return _Boxes(piece, edges[:, :-1].ravel(), edges[:, 1:].ravel(), asked)

    def joined(self, other: _Boxes) -> _Boxes:
        """These and the others."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return _Boxes(*(np.concatenate(pair, axis=-1) for pair in pairs))


@dataclass(frozen=True, eq=False)
class _Reached:
    """What one box each has for several questions (q,): so much is reached inside of it.

    Attributes:
        sure: excess over a bound, less ``blur``. above: it is over the upper one.
        blur: what the model leaves open of the value.
        value: the function's value at ``angle``. piece: of the box.
    """

    sure: Array
    blur: Array
    above: Mask
    value: Array
    angle: Array
    piece: Indices


class _Search:
    """One branch and bound: the best excess found, and the largest one not excluded."""

    def __init__(self, questions: Sequence[Question]) -> None:
        count = len(questions)
        self.lower = np.array([q.lower for q in questions])
        self.upper = np.array([q.upper for q in questions])
        self.relative = np.array([q.relative for q in questions])
        self.absolute = np.array([q.absolute for q in questions])
        self.function = np.array([q.function for q in questions])
        self.best = np.full(count, -np.inf)
        self.proven = np.full(count, -np.inf)
        self.above = np.ones(count, dtype=bool)
        self.value = np.zeros(count)
        self.angle = np.zeros(count)
        self.piece = np.array([q.pieces[0] for q in questions])
        self.blur = np.full(count, np.inf)
        self.boxes = np.zeros(count, dtype=int)

    def weigh(self, boxes: _Boxes, models: Models) -> tuple[Array, _Boxes]:
        """Take in what the models say.

        Returns:
            (questions, n) the largest excess possible on each box, −inf where it is not asked
            for, and the points that look best so far.
        """
        live, function, model, excess = self._look(boxes, models)
        rem = model.rem[function]
        leader, top = np.argmax(excess, axis=1), np.argmax(excess - rem, axis=1)
        found = self._reached(live, boxes.at(top), model.take(function, top))
        self._note(live, found, found.sure > self.best[live])
        leading = self._reached(live, boxes.at(leader), model.take(function, leader))
        possible = np.full(boxes.asked.shape, -np.inf)
        possible[live] = excess + rem
        return possible, self._points(live, leading.piece, leading.angle)

    def settle(self, points: _Boxes, models: Models) -> None:
        """Take values from points, where models are exact but for rounding, if they are vague."""
        vague = self.blur > VAGUE * np.abs(self.value)
        if not vague.any():
            return
        tops = self._points(np.arange(len(self.best)), self.piece, self.angle)
        points = tops.joined(points)
        points = points.left(points.asked & vague[:, None])
        live, function, model, excess = self._look(points, models)
        top = np.argmax(np.where(model.rem[function] < UNBOUNDED, excess, -np.inf), axis=1)
        found = self._reached(live, points.at(top), model.take(function, top))
        self._note(live, found, found.sure > -0.1 * UNBOUNDED)

    def _look(self, boxes: _Boxes, models: Models) -> tuple[Indices, Indices, Taylor, Array]:
        """What the models say of these boxes.

        Returns:
            the questions (q,) that are asked there, which model answers each (q,), the models of
            (functions, n), and how far each question's function may exceed a bound, up to ±rem:
            (q, n), −inf where it is not asked for.
        """
        live = np.flatnonzero(boxes.asked.any(axis=1))
        wanted = sorted(set(self.function[live].tolist()))
        function = np.searchsorted(wanted, self.function[live])
        model = _stacked(models(boxes.piece, boxes.lo, boxes.hi, wanted))
        model = _cleared(model, boxes.lo == boxes.hi)
        high, low = (end[function] for end in model.range())
        asked = boxes.asked[live]
        self.boxes[live] += np.count_nonzero(asked, axis=1)
        excess = np.maximum(high - self.upper[live, None], self.lower[live, None] - low)
        return live, function, model, np.where(asked, excess, -np.inf)

    def _reached(self, questions: Indices, box: _Boxes, model: Taylor) -> _Reached:
        """Where a function comes nearest to one of its bounds on one box for each question."""
        high, low, t_high, t_low = model.extremes()
        over, under = high - self.upper[questions], self.lower[questions] - low
        above = over >= under
        value, t = np.where(above, high, low), np.where(above, t_high, t_low)
        half = 0.5 * (box.hi - box.lo)
        where = np.clip(0.5 * (box.lo + box.hi) + t * half, box.lo, box.hi)
        # the extreme may lie in the margin for roundings of the box's ends, outside of it
        margin = WIDENED * (np.abs(box.lo) + np.abs(box.hi))
        share = np.where(half == 0.0, 0.0, margin / (half + margin))
        spare = share * (np.abs(model.c1) + 2.0 * np.abs(model.c2))
        blur = model.rem + spare
        return _Reached(np.where(above, over, under) - blur, blur, above, value, where, box.piece)

    def _note(self, questions: Indices, found: _Reached, which: Mask) -> None:
        """Keep what was reached, for some of these questions."""
        q = questions[which]
        self.best[q] = np.maximum(self.best[q], found.sure[which])
        self.above[q], self.value[q] = found.above[which], found.value[which]
        self.angle[q], self.piece[q] = found.angle[which], found.piece[which]
        self.blur[q] = found.blur[which]

    def _points(self, questions: Indices, piece: Indices, at: Array) -> _Boxes:
        """Points, one for each of these questions."""
        asked = np.arange(len(self.best))[:, None] == questions
        return _Boxes(piece, at, at, asked)

    def survivors(self, possible: Array) -> Mask:
        """Which boxes may still hold more than the target width above the best found."""
        keep: Mask = possible > (self.best + self._enough())[:, None]
        self.exclude(~keep, possible)
        return keep

    def _enough(self) -> Array:
        """The width that is good enough for each question."""
        bound = np.where(self.above, self.upper, self.lower)
        size = np.maximum(np.abs(self.value), np.where(np.isfinite(bound), np.abs(bound), 0.0))
        return np.asarray(np.maximum(self.absolute, self.relative * size))

    def exclude(self, which: Mask, possible: Array) -> None:
        """Leave these boxes: what is possible there stays in the proven bound."""
        most = np.max(possible, axis=1, where=which, initial=-np.inf)
        self.proven = np.maximum(self.proven, most)

    def answers(self) -> list[Answer]:
        """What is known of each question."""
        return [self._answer(q) for q in range(len(self.best))]

    def _answer(self, q: int) -> Answer:
        best, proven, value = (float(x[q]) for x in (self.best, self.proven, self.value))
        angle, side, boxes = float(self.angle[q]), 1 if self.above[q] else -1, int(self.boxes[q])
        if best < -0.1 * UNBOUNDED:
            return Answer(Enclosed(math.nan, -math.inf, math.inf, angle), side, boxes)
        proven = math.inf if proven > 0.1 * UNBOUNDED else proven
        if side > 0:
            low, high = best + float(self.upper[q]), proven + float(self.upper[q])
        else:
            low, high = float(self.lower[q]) - proven, float(self.lower[q]) - best
        return Answer(Enclosed(value, min(low, value), max(high, value), angle), side, boxes)


def enclose(
    models: Models, breaks: Array, counts: Indices, questions: Sequence[Question]
) -> list[Answer]:
    """Answer all questions about functions of one variable, defined piece by piece.

    All of them share their boxes: a round costs little more for several functions than for one.

    Args:
        models: Taylor models of the functions wanted on boxes (piece, lo, hi).
        breaks: (n+1,) ends of the pieces; every piece is taken with both its ends.
        counts: (n,) how many boxes to begin with on each piece.
        questions: what is asked.
    """
    if not questions:
        return []
    search = _Search(questions)
    boxes = _first_boxes(breaks, counts, questions)
    most = MOST_BOXES * len(set(search.function.tolist()))
    seen = 0
    with np.errstate(all="ignore"):
        for rounds_left in range(MOST_ROUNDS, 0, -1):
            possible, points = search.weigh(boxes, models)
            keep = search.survivors(possible)
            seen += len(boxes.lo)
            left = np.count_nonzero(keep.any(axis=0))
            if left == 0 or seen + SPLIT * left > most or rounds_left == 1:
                search.exclude(keep, possible)
                break
            boxes = boxes.left(keep).split().joined(points)
        search.settle(points, models)
    return search.answers()


def _stacked(models: Sequence[Taylor]) -> Taylor:
    """Models of several functions on the same boxes as one of (functions, n)."""
    table = np.stack([part for model in models for part in model.parts])
    return Taylor(*np.moveaxis(table.reshape(len(models), 5, -1), 1, 0))


def _cleared(model: Taylor, points: Mask) -> Taylor:
    """The model without what it says beyond points, roundings of its range in the remainder.

    Where nothing is known it is 0 to within ``UNBOUNDED``.
    """
    rem = model.rem + ULPS * model.mag
    c0, c1, c2 = (model.c0, *(np.where(points, 0.0, part) for part in (model.c1, model.c2)))
    known = np.isfinite(c0 + c1 + c2 + rem)
    if not known.all():
        c0, c1, c2 = (np.where(known, part, 0.0) for part in (c0, c1, c2))
        rem = np.where(known, rem, UNBOUNDED)
    return Taylor(c0, c1, c2, rem, model.mag)


def _first_boxes(breaks: Array, counts: Indices, questions: Sequence[Question]) -> _Boxes:
    """Every piece that is asked for, cut into its number of boxes; parts of pieces by themselves.

    Those of a piece serve all questions that ask for the whole of it.
    """
    whole = np.zeros((len(questions), len(counts)), dtype=bool)
    for q, question in enumerate(questions):
        if question.spans is None:
            whole[q, question.pieces] = True
    pieces = np.flatnonzero(whole.any(axis=0))
    found = _cut(pieces, breaks[pieces], breaks[pieces + 1], counts, whole[:, pieces])
    for q, question in enumerate(questions):
        if question.spans is not None:
            asked = np.zeros((len(questions), len(question.pieces)), dtype=bool)
            asked[q] = True
            first, last = question.spans.T
            found = found.joined(_cut(question.pieces, first, last, counts, asked))
    return found


def _cut(pieces: Indices, first: Array, last: Array, counts: Indices, asked: Mask) -> _Boxes:
    """Spans [first, last], each on one piece, cut into the number of boxes of that piece."""
    parts = np.where(last > first, counts[pieces], 1)
    step = (last - first) / parts
    owner = np.repeat(np.arange(len(pieces)), parts)
    nth = np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)
    lo = first[owner] + nth * step[owner]
    hi = np.where(nth + 1 == parts[owner], last[owner], first[owner] + (nth + 1) * step[owner])
    return _Boxes(pieces[owner], lo, hi, asked[:, owner])
