"""Proven extremes by branch and bound over boxes, for many questions at once.

Where the functions are at hand in plain numbers too, these say first where each extreme seems to
be. The boxes are small there from the start, and as a rule the first iteration proves it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from synthesis.numerics.box_search import Boxes, BoxSearch, Budget
from synthesis.numerics.maxima import locate_extrema
from synthesis.numerics.piecewise import Array, Indices, Mask
from synthesis.numerics.taylor import Taylor

Models = Callable[[Indices, Array, Array, Sequence[int]], Sequence[Taylor]]
Values = Callable[[Indices, Array, Sequence[int]], Sequence[Array]]

MOST_LEVELS: Final = 12  # of dividing; after that open boxes keep their bounds
MOST_BOXES: Final = 100_000  # of each function
FEWEST_PARTS: Final = 16  # of a box that is divided
MOST_PARTS: Final = 64  # of a box that is divided
CHEAP_BATCH: Final = 256  # boxes that cost little more than one
UNBOUNDED: Final = 1e300  # stands for "nothing is known on this box"
ULPS: Final = 2.0**-50  # relative: eight unit roundoffs
CLEAR: Final = 3.0  # roundings of a value: two lie between its ends, of a box there are some more


@dataclass(frozen=True)
class Enclosure:
    """A quantity that is proven to lie in [lower, upper].

    ``value``: what was found, in between: the function's, to rounding, at a cam angle [rad].
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
class ExtremumQuery:
    """On these pieces, how far does a function exceed ``upper``, or fall below ``lower``?

    Attributes:
        lower, upper: bounds, −inf and inf where there is none. With both at 0 the question is
            for the largest |f|.
        spans: (k, 2) the part of each piece that counts, None where all of them count whole.
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
class Extremum:
    """The extreme of a function that is nearest to its bound, or farthest beyond it.

    Attributes:
        enclosure: of the extreme. Of a maximum, ``upper`` bounds f everywhere and ``lower`` is
            reached; of a minimum, the other way round. Infinite where nothing could be proven.
        side: +1 if it is a maximum, −1 if a minimum.
        boxes: on how many boxes the question was looked at.
    """

    enclosure: Enclosure
    side: int
    boxes: int


class _ExtremumSearch(BoxSearch[Boxes]):
    """Box search for the excess of every question's function over its bound.

    The incumbents are values at single points, where the models are exact but for rounding.
    """

    children = FEWEST_PARTS

    def __init__(
        self, models: Models, questions: Sequence[ExtremumQuery], enough: Sequence[float] | None
    ) -> None:
        count = len(questions)
        nowhere, empty = np.zeros(0, dtype=np.intp), np.zeros(0)
        self.models = models
        self.points = Boxes(nowhere, empty, empty, np.zeros((count, 0), dtype=bool))
        spare = [0.0 if enough is None else enough[q.function] for q in questions]
        self.relative = np.array([q.relative for q in questions])
        self.absolute = np.array([q.absolute for q in questions]) + spare
        bounds = np.array([(q.lower, q.upper) for q in questions]).T
        # Of a single bound the extreme is the same wherever it is measured from: from 0 no digit is
        # lost. Of two bounds the excess is rounded as they are.
        finite = np.isfinite(bounds)
        both = finite.all(axis=0)
        self.lower, self.upper = np.where(finite & ~both, 0.0, bounds)
        self.sizes = np.where(finite, np.abs(bounds), 0.0)
        self.rounding = np.where(both, ULPS * self.sizes.max(axis=0), 0.0)
        self.function = [q.function for q in questions]
        self.closely = (self.absolute < np.inf).nonzero()[0]
        self.best = np.full(count, -np.inf)
        self.proven: Array = np.full(count, -np.inf)
        self.above = np.ones(count, dtype=bool)
        self.value, self.blur = np.zeros(count), np.zeros(count)
        self.angle = np.zeros(count)
        self.boxes = np.zeros(count, dtype=int)

    def _functions(self, live: Indices) -> tuple[list[int], list[int]]:
        """The functions that these questions speak of, and which of them each does."""
        functions = [self.function[q] for q in live.tolist()]
        wanted = sorted(set(functions))
        return wanted, [wanted.index(function) for function in functions]

    def _excess(self, live: Indices, high: Array, low: Array) -> Array:
        """How far values (q, n) of these questions' functions are beyond a bound."""
        upper, lower = self.upper[live][:, None], self.lower[live][:, None]
        return np.asarray(np.maximum(high - upper, lower - low))

    def look(self, boxes: Boxes, values: Values) -> tuple[Boxes, Array]:
        """Points where extremes seem to be, and where to cut the boxes beside them."""
        closely = self.closely
        wanted, slot = self._functions(closely)

        def heights(piece: Indices, x: Array) -> Array:
            each = values(piece, x, wanted)
            found = np.concatenate([each[k] for k in slot]).reshape(len(slot), -1)
            return self._excess(closely, found, found)

        searched = Boxes(boxes.piece, boxes.lo, boxes.hi, boxes.active[closely])
        question, piece, at, cuts = locate_extrema(searched, heights, self.rounding[closely] / ULPS)
        return self._points_of(closely[question], piece, at), cuts

    def _points_of(self, question: Indices, piece: Indices, at: Array) -> Boxes:
        """Points (k,), one for each of some questions, as boxes of no width."""
        return Boxes(piece, at, at, np.arange(len(self.best))[:, None] == question)

    def bound(self, boxes: Boxes) -> Array:
        """The largest excess that is possible on each box, −inf where inactive: (questions, n).

        First the points that looked best on the level before are evaluated, together with the
        boxes: what their functions reach there are the incumbents.
        """
        both, question = boxes.append(self.points), self.points.active.argmax(axis=0)
        live = np.flatnonzero(both.active.any(axis=1))
        wanted, slot = self._functions(live)
        each = self.models(both.piece, both.lo, both.hi, wanted)
        model = _stacked([each[k] for k in slot], both.lo == both.hi)
        high, low = model.range()
        excess = np.where(both.active[live], self._excess(live, high, low), -np.inf)
        self.boxes += both.active.sum(axis=1)
        row, column = np.searchsorted(live, question), np.arange(len(boxes), len(both))
        rem = model.rem + self.rounding[live][:, None]
        blur = rem[row, column]
        sure = np.where(blur < UNBOUNDED, excess[row, column] - blur, -np.inf)
        self._note(question, self.points.lo, high[row, column], sure, blur)
        self.view = both, live, model, excess
        possible = np.full((len(self.best), len(boxes)), -np.inf)
        possible[live] = (excess + rem)[:, : len(boxes)]
        return possible

    def threshold(self) -> Array:
        """The incumbents and the width that is good enough; a box is no narrower than roundings."""
        size = np.maximum(np.abs(self.value), np.where(self.above, *self.sizes[::-1]))
        wanted = np.maximum(self.absolute, self.relative * size)
        enough = np.maximum(wanted, CLEAR * self.blur)
        # of a question for an upper bound alone the first boxes are enough
        return np.where(enough < np.inf, self.best + enough, np.inf)[:, None]

    def split(self, boxes: Boxes, keep: Mask) -> Boxes:
        self.points = self.leaders()
        # into many where there are few: an iteration costs much, whatever its boxes
        still = boxes.keep(keep)
        return still.split(max(FEWEST_PARTS, min(MOST_PARTS, CHEAP_BATCH // len(still))))

    def _note(self, question: Indices, at: Array, value: Array, sure: Array, blur: Array) -> None:
        """Keep what was reached at points: values, their excess over a bound, their roundings."""
        # by more than roundings, or these would choose among equal extremes
        better = sure - blur > self.best[question]
        q, value = question[better], value[better]
        self.best[q], self.value[q], self.angle[q] = sure[better], value, at[better]
        self.blur[q] = blur[better]
        self.above[q] = value - self.upper[q] >= self.lower[q] - value

    def leaders(self) -> Boxes:
        """Where the model of the box that looks best has its extreme, question by question."""
        boxes, live, model, excess = self.view
        leader = np.argmax(np.where(model.rem < UNBOUNDED, excess, -np.inf), axis=1)
        model, box = model.take(np.arange(len(leader)), leader), boxes.take(leader)
        (high, low), (t_high, t_low) = model.range(), model.extreme_places()
        above = high - self.upper[live] >= self.lower[live] - low
        where = 0.5 * (box.lo + box.hi) + np.where(above, t_high, t_low) * 0.5 * (box.hi - box.lo)
        return self._points_of(live, box.piece, np.clip(where, box.lo, box.hi))

    def answers(self) -> list[Extremum]:
        """What is known of each question."""
        known = (self.best, self.proven, self.value, self.angle, self.boxes, self.lower, self.upper)
        each = enumerate(zip(*(x.tolist() for x in known), strict=True))
        return [self._answer(q, *values) for q, values in each]

    def _answer(
        self, q: int, best: float, proven: float, value: float, angle: float, boxes: int,
        lower: float, upper: float,
    ) -> Extremum:  # fmt: skip
        side, proven = 1 if self.above[q] else -1, math.inf if proven > 0.1 * UNBOUNDED else proven
        if best < -0.1 * UNBOUNDED:
            low, high = -math.inf, math.inf
            if self.absolute[q] == math.inf:  # what is proven counts by itself
                low, high = lower - proven, upper + proven
            return Extremum(Enclosure(math.nan, low, high, angle), side, boxes)
        low, high = (best + upper, proven + upper) if side > 0 else (lower - proven, lower - best)
        return Extremum(Enclosure(value, min(low, value), max(high, value), angle), side, boxes)


def enclose(
    models: Models,
    breaks: Array,
    counts: Indices,
    questions: Sequence[ExtremumQuery],
    values: Values | None = None,
    enough: Sequence[float] | None = None,
) -> list[Extremum]:
    """Answer all questions about functions of one variable, defined piece by piece.

    All of them share their boxes: an iteration costs little more for several functions.

    Args:
        models: Taylor models of the functions wanted on boxes (piece, lo, hi).
        breaks: (n+1,) ends of the pieces; every piece is taken with both its ends.
        counts: (n,) how many boxes to begin with on each piece.
        values: the functions wanted at points (piece, x) in numbers, which are not relied on.
        enough: of each function, by how much wider than its question says an enclosure may be.
    """
    if not questions:
        return []
    search = _ExtremumSearch(models, questions, enough)
    boxes = _first_boxes(breaks, counts, questions)
    budget = Budget(MOST_LEVELS, MOST_BOXES * len(set(search.function)))
    with np.errstate(all="ignore"):
        if values is not None and len(search.closely):
            search.points, cuts = search.look(boxes, values)
            boxes = boxes.cut_at(cuts)
        if not search.run(boxes, budget):
            # the points that look best on the boxes left open are incumbents too
            search.points = search.leaders()
            search.bound(boxes.take(np.zeros(0, dtype=np.intp)))
    return search.answers()


def _stacked(models: Sequence[Taylor], points: Mask) -> Taylor:
    """Models of several functions on the same boxes as one of (functions, n).

    Of points without what they say beyond them. Roundings of the range are in the remainder. Where
    nothing is known it is 0 to within ``UNBOUNDED``.
    """
    table = np.concatenate(
        [part for parts in zip(*(model.parts for model in models), strict=True) for part in parts]
    )
    table = table.reshape(5, len(models), -1)
    np.copyto(table[1:3], 0.0, where=points)
    c0, c1, c2, rem, mag = table
    rem += ULPS * mag
    known = np.isfinite(c0 + c1 + c2 + rem)
    if not known.all():
        np.copyto(table[:3], 0.0, where=~known)
        np.copyto(rem, UNBOUNDED, where=~known)
    return Taylor(c0, c1, c2, rem, mag)


def _first_boxes(breaks: Array, counts: Indices, questions: Sequence[ExtremumQuery]) -> Boxes:
    """Every piece that a question covers, cut into its number of boxes; parts of pieces apart.

    Those of a piece serve all questions that ask for the whole of it.
    """
    whole = np.zeros((len(questions), len(counts)), dtype=bool)
    for q, question in enumerate(questions):
        if question.spans is None:
            whole[q, question.pieces] = True
    pieces = np.flatnonzero(whole.any(axis=0))
    active = whole.take(pieces, axis=1)
    found = Boxes.from_spans(pieces, breaks[pieces], breaks[pieces + 1], counts, active)
    for q, question in enumerate(questions):
        if question.spans is not None:
            active = np.zeros((len(questions), len(question.pieces)), dtype=bool)
            active[q] = True
            first, last = question.spans.T
            found = found.append(Boxes.from_spans(question.pieces, first, last, counts, active))
    return found
