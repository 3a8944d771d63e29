"""Proven extremes by branch and bound over boxes, for many questions at once.

Where the functions are at hand in plain numbers too, these say first where each extreme seems to
be. The boxes are small there from the start, and as a rule the first round proves it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from synthesis.numerics.boxes import SPLIT, Boxes, Indices, Mask
from synthesis.numerics.looking import Bounds, sighted
from synthesis.numerics.taylor import Array, Taylor

Models = Callable[[Indices, Array, Array, Sequence[int]], Sequence[Taylor]]
Values = Callable[[Indices, Array, Sequence[int]], Sequence[Array]]

MOST_ROUNDS: Final = 12
MOST_BOXES: Final = 100_000  # of each function
UNBOUNDED: Final = 1e300  # stands for "nothing is known on this box"
ULPS: Final = 2.0**-50
CLEAR: Final = 3.0  # roundings of a value: two lie between its ends, of a box there are some more


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
        relative, absolute: width at which the enclosure is good enough. With an infinite one only
            the end that the first boxes prove is wanted, of ``upper`` or ``lower`` alone; where f
            is nearest to it is not looked for.
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
class _Points:
    """One point (k,) each for some of the questions."""

    question: Indices
    piece: Indices
    at: Array

    def boxes(self, questions: int) -> Boxes:
        """The same as boxes of no width."""
        return Boxes(
            self.piece, self.at, self.at, np.arange(questions)[:, None] == self.question
        )  # fmt: skip


NONE: Final = np.zeros(0, dtype=np.intp)
NOWHERE: Final = _Points(NONE, NONE, np.zeros(0))


@dataclass(frozen=True, eq=False)
class _View:
    """What the models say of boxes.

    Attributes:
        boxes: all of them. live: (q,) the questions that are asked there.
        slot: (q,) which of the models answers each. model: (functions, n).
        excess: (q, n) how far each question's function may exceed a bound, up to ± the model's
            remainder; −inf where it is not asked for.
    """

    boxes: Boxes
    live: Indices
    slot: Indices
    model: Taylor
    excess: Array


class _Search:
    """One branch and bound: the best excess found, and the largest one not excluded."""

    def __init__(self, questions: Sequence[Question]) -> None:
        count = len(questions)
        self.lower = np.array([q.lower for q in questions])
        self.upper = np.array([q.upper for q in questions])
        self.relative = np.array([q.relative for q in questions])
        self.absolute = np.array([q.absolute for q in questions])
        self.function = np.array([q.function for q in questions])
        self.closely = np.flatnonzero(self.absolute < np.inf)
        self.best = np.full(count, -np.inf)
        self.proven = np.full(count, -np.inf)
        self.above = np.ones(count, dtype=bool)
        self.value, self.blur = np.zeros(count), np.zeros(count)
        self.angle = np.zeros(count)
        self.boxes = np.zeros(count, dtype=int)

    def _functions(self, live: Indices) -> tuple[list[int], Indices]:
        """The functions that these questions speak of, and which of them each does."""
        wanted = sorted(set(self.function[live].tolist()))
        return wanted, np.searchsorted(wanted, self.function[live])

    def _excess(self, live: Indices, high: Array, low: Array) -> Array:
        """How far values (q, n) of these questions' functions are beyond a bound."""
        return np.asarray(
            np.maximum(high - self.upper[live, None], self.lower[live, None] - low)
        )  # fmt: skip

    def look(self, boxes: Boxes, values: Values) -> tuple[_Points, Array]:
        """Where each extreme seems to be; and where to cut boxes beside those that seem to be."""
        closely = self.closely
        wanted, slot = self._functions(closely)

        def heights(piece: Indices, x: Array) -> Array:
            found = np.stack(values(piece, x, wanted))[slot]
            return self._excess(closely, found, found)

        bounds = Bounds(self.lower[closely], self.upper[closely])
        seen = sighted(replace(boxes, asked=boxes.asked[closely]), heights, bounds)
        return _Points(closely[seen.question], seen.piece, seen.at), seen.cuts

    def weigh(self, boxes: Boxes, points: _Points, models: Models) -> _View:
        """Take in what the models say of points, where they are exact but for rounding.

        Returns:
            what they say of boxes and, behind these, of points.
        """
        both = boxes.joined(points.boxes(len(self.best)))
        live = np.flatnonzero(both.asked.any(axis=1))
        wanted, slot = self._functions(live)
        model = _stacked(models(both.piece, both.lo, both.hi, wanted))
        model = _cleared(model, both.lo == both.hi)
        high, low = (end[slot] for end in model.range())
        excess = np.where(both.asked[live], self._excess(live, high, low), -np.inf)
        self.boxes += np.count_nonzero(both.asked, axis=1)
        row = np.searchsorted(live, points.question)
        column = np.arange(len(boxes), len(both))
        rem = model.rem[slot[row], column]
        sure = np.where(rem < UNBOUNDED, excess[row, column] - rem, -np.inf)
        self._note(points, high[row, column], sure, rem)
        return _View(both, live, slot, model, excess)

    def _note(self, points: _Points, value: Array, sure: Array, blur: Array) -> None:
        """Keep what was reached at points: values, their excess over a bound, their roundings."""
        # by more than roundings, or these would choose among equal extremes
        better = sure - blur > self.best[points.question]
        q, value = points.question[better], value[better]
        self.best[q], self.value[q], self.angle[q] = sure[better], value, points.at[better]
        self.blur[q] = blur[better]
        self.above[q] = value - self.upper[q] >= self.lower[q] - value

    def leaders(self, view: _View) -> _Points:
        """Where the model of the box that looks best has its extreme, question by question."""
        known = view.model.rem[view.slot] < UNBOUNDED
        leader = np.argmax(np.where(known, view.excess, -np.inf), axis=1)
        high, low, t_high, t_low = view.model.take(view.slot, leader).extremes()
        above = high - self.upper[view.live] >= self.lower[view.live] - low
        piece, lo, hi = (part[leader] for part in (view.boxes.piece, view.boxes.lo, view.boxes.hi))
        where = 0.5 * (lo + hi) + np.where(above, t_high, t_low) * 0.5 * (hi - lo)
        return _Points(view.live, piece, np.clip(where, lo, hi))

    def possible(self, view: _View, boxes: int) -> Array:
        """The largest excess that is possible on each box, −inf where not asked: (questions, n)."""
        found = np.full((len(self.best), boxes), -np.inf)
        found[view.live] = (view.excess + view.model.rem[view.slot])[:, :boxes]
        return found

    def survivors(self, possible: Array) -> Mask:
        """Which boxes may still hold more than the target width above the best found."""
        keep: Mask = possible > (self.best + self._enough())[:, None]
        self.exclude(~keep, possible)
        return keep

    def _enough(self) -> Array:
        """The width that is good enough for each question; no box is narrower than roundings."""
        bound = np.where(self.above, self.upper, self.lower)
        size = np.maximum(np.abs(self.value), np.where(np.isfinite(bound), np.abs(bound), 0.0))
        wanted = np.maximum(self.absolute, self.relative * size)
        return np.asarray(np.maximum(wanted, CLEAR * self.blur))

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
        proven = math.inf if proven > 0.1 * UNBOUNDED else proven
        if best < -0.1 * UNBOUNDED:
            low, high = -math.inf, math.inf
            if self.absolute[q] == math.inf:  # what is proven counts by itself
                low, high = float(self.lower[q]) - proven, float(self.upper[q]) + proven
            return Answer(Enclosed(math.nan, low, high, angle), side, boxes)
        if side > 0:
            low, high = best + float(self.upper[q]), proven + float(self.upper[q])
        else:
            low, high = float(self.lower[q]) - proven, float(self.lower[q]) - best
        return Answer(Enclosed(value, min(low, value), max(high, value), angle), side, boxes)


def enclose(
    models: Models,
    breaks: Array,
    counts: Indices,
    questions: Sequence[Question],
    values: Values | None = None,
) -> list[Answer]:
    """Answer all questions about functions of one variable, defined piece by piece.

    All of them share their boxes: a round costs little more for several functions than for one.

    Args:
        models: Taylor models of the functions wanted on boxes (piece, lo, hi).
        breaks: (n+1,) ends of the pieces; every piece is taken with both its ends.
        counts: (n,) how many boxes to begin with on each piece.
        questions: what is asked.
        values: the functions wanted at points (piece, x) in numbers, which are not relied on.
    """
    if not questions:
        return []
    search, points, seen = _Search(questions), NOWHERE, 0
    boxes = _first_boxes(breaks, counts, questions)
    most = MOST_BOXES * len(set(search.function.tolist()))
    with np.errstate(all="ignore"):
        if values is not None and len(search.closely):
            points, cuts = search.look(boxes, values)
            boxes = boxes.cut(cuts)
        for rounds_left in range(MOST_ROUNDS, 0, -1):
            view = search.weigh(boxes, points, models)
            possible = search.possible(view, len(boxes))
            keep = search.survivors(possible)
            seen += len(boxes)
            left = np.count_nonzero(keep.any(axis=0))
            if left == 0:
                break
            points = search.leaders(view)
            if seen + SPLIT * left > most or rounds_left == 1:
                search.exclude(keep, possible)
                search.weigh(boxes.at(NONE), points, models)
                break
            boxes = boxes.left(keep).split()
    return search.answers()


def _stacked(models: Sequence[Taylor]) -> Taylor:
    """Models of several functions on the same boxes as one of (functions, n)."""
    table = np.concatenate([part for model in models for part in model.parts])
    return Taylor(*table.reshape(len(models), 5, -1).swapaxes(0, 1))


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


def _first_boxes(breaks: Array, counts: Indices, questions: Sequence[Question]) -> Boxes:
    """Every piece that is asked for, cut into its number of boxes; parts of pieces by themselves.

    Those of a piece serve all questions that ask for the whole of it.
    """
    whole = np.zeros((len(questions), len(counts)), dtype=bool)
    for q, question in enumerate(questions):
        if question.spans is None:
            whole[q, question.pieces] = True
    pieces = np.flatnonzero(whole.any(axis=0))
    found = Boxes.spans(pieces, breaks[pieces], breaks[pieces + 1], counts, whole[:, pieces])
    for q, question in enumerate(questions):
        if question.spans is not None:
            asked = np.zeros((len(questions), len(question.pieces)), dtype=bool)
            asked[q] = True
            first, last = question.spans.T
            found = found.joined(Boxes.spans(question.pieces, first, last, counts, asked))
    return found
