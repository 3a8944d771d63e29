"""Where functions seem to have their extremes, by numbers: a finding, not a proof.

It tells a proof where to look closely. What it misses costs the proof time and nothing else.
To be run under ``np.errstate(all="ignore")``: what has no value is passed over.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.polynomial.legendre import legvander

from synthesis.numerics.boxes import Boxes
from synthesis.numerics.piecewise import Array, Indices, sorted_unique

# (pieces (n,), points (n,)) -> (questions, n), of each question how large its function is there
ExcessFunction = Callable[[Indices, Array], Array]

PEAKS: Final = 3  # of a question, that are nearly as high as its highest
NEARLY: Final = 0.5  # of what lies between the values on its box
FEW: Final = 160  # boxes: of so many each is looked at more closely, for it is larger as a rule
PLACES: Final = (5, 9)  # on a box, where functions are evaluated: of many boxes, and of few
FAN: Final = np.linspace(0.0, 1.0, 257)  # on a box: there they are looked at
STEPS: Final = 2.0 ** -np.arange(1.0, 12.0)  # of a box: how far from a peak it is cut
LADDER: Final = np.concatenate([-STEPS, STEPS])
HUGE: Final = 1e290  # what is larger is none of a function's values
ALIKE: Final = 2.0**-44  # relative: points of a peak whose heights differ by less are as high
EQUAL: Final = 2.0**-34  # the same of peaks
EACH: Final = np.array([[ALIKE], [EQUAL]])
BLUR: Final = 2.0**-48  # of a bound: what is left of a height over it is no better known
BESIDE: Final = np.arange(-1, 2)[:, None]


def _between(places: int) -> tuple[Array, Array]:
    """Even places on a box, and from values there to those of their polynomial on the fan."""
    at = np.linspace(0.0, 1.0, places)
    fan, known = (legvander(2.0 * x - 1.0, places - 1) for x in (FAN, at))
    return at, np.asarray((fan @ np.linalg.inv(known)).T)


MANY_BOXES, FEW_BOXES = (_between(places) for places in PLACES)


@dataclass(frozen=True, eq=False)
class ExtremumCandidates:
    """What was seen.

    Attributes:
        question, piece, at: (k,) where the functions of these questions seem to be highest.
        cuts: sorted, where to cut boxes: the closer to a peak the closer.
    """

    question: Indices
    piece: Indices
    at: Array
    cuts: Array


@dataclass(frozen=True, eq=False)
class ExcessBounds:
    """What heights are measured from, (questions,) each: value − upper, or lower − value."""

    lower: Array
    upper: Array

    def grains(self, question: Indices, height: Array) -> tuple[Array, Array]:
        """By how much heights (n,) have to differ from these to count as others, and of peaks."""
        lower, upper = self.lower[question], self.upper[question]
        size = np.minimum(np.abs(lower - height), np.abs(upper + height))
        alike, equal = EACH * _finite(size) + self._blur[question]
        return alike, equal

    @cached_property
    def _blur(self) -> Array:
        """What is not known of a height because it is one over a bound: (questions,)."""
        return BLUR * np.maximum(_finite(np.abs(self.lower)), _finite(np.abs(self.upper)))


def _finite(values: Array) -> Array:
    return np.where(values < HUGE, values, 0.0)


def locate_extrema(
    boxes: Boxes, heights: ExcessFunction, bounds: ExcessBounds
) -> ExtremumCandidates:
    """The highest point of every question's function on the boxes that it is asked for.

    Of several that are equally high the first: roundings do not choose.

    Args:
        boxes: where. heights: of the functions, over their bounds.
    """
    places, between = FEW_BOXES if len(boxes) <= FEW else MANY_BOXES
    question, box, seen = _peaks(boxes, heights, bounds, places)
    piece, left, width = boxes.piece[box], boxes.lo[box], (boxes.hi - boxes.lo)[box]
    height = seen @ between
    top = height.max(axis=1)
    alike, equal = bounds.grains(question, top)
    best = (height >= (top - alike)[:, None]).argmax(axis=1)
    middle = np.minimum(np.maximum(best, 1), len(FAN) - 2)
    before, there, behind = height[np.arange(len(box)), middle + BESIDE]
    bend = before + behind - 2.0 * there
    inner = (best == middle) & (bend < 0.0)
    place = np.where(inner, best + 0.5 * (before - behind) / bend, best)  # of a parabola's vertex
    at = np.minimum(left + width * (place / (len(FAN) - 1.0)), boxes.hi[box])
    first = _highest(question, top, equal, len(bounds.lower))
    cuts = sorted_unique(at[:, None] + width[:, None] * LADDER)
    return ExtremumCandidates(question[first], piece[first], at[first], cuts)


def _peaks(
    boxes: Boxes, heights: ExcessFunction, bounds: ExcessBounds, places: Array
) -> tuple[Indices, Indices, Array]:
    """Questions and boxes: of every question that of the highest peak and others nearly as high.

    The height on a box is that of a parabola through its ends and centre. The third are the
    heights at the places on these boxes: (k, places).
    """
    x = boxes.lo[:, None] + (boxes.hi - boxes.lo)[:, None] * places
    x[:, -1] = boxes.hi
    seen = heights(boxes.piece.repeat(len(places)), x.ravel())
    seen = seen.reshape(len(seen), -1, len(places))
    left, middle, right = seen[..., 0], seen[..., len(places) // 2], seen[..., -1]
    slope, bend = 0.5 * (right - left), middle - 0.5 * (left + right)
    inner = np.abs(slope) < 2.0 * bend
    vertex = np.where(inner, 0.25 * slope * slope / bend, 0.0)
    height = np.maximum(np.maximum(left, right), middle + vertex)
    height = np.where(boxes.active & (height > -np.inf), height, -np.inf)
    top = height.max(axis=1, initial=-HUGE)
    alike, equal = bounds.grains(np.arange(len(top)), top)
    rising = height[:, 1:] > height[:, :-1] + alike[:, None]
    hill = np.ones(height.shape, dtype=bool)
    hill[:, 1:] &= rising
    hill[:, :-1] &= ~rising
    nearly = height + NEARLY * (np.abs(slope) + np.abs(bend)) >= top[:, None]
    question, box = np.nonzero(hill & nearly)
    if np.bincount(question, minlength=1).max() > PEAKS:
        below = np.floor((top[question] - height[question, box]) / equal[question])
        kept = _first_few(question, below)
        question, box = question[kept], box[kept]
    return question, box, seen[question, box]


def _first_few(question: Indices, below: Array) -> Indices:
    """Which (k,) of the sorted questions are the ``PEAKS`` least below; of equal ones the first."""
    order = np.lexsort((np.where(np.isnan(below), 0.0, below), question))
    rank = np.arange(len(order)) - np.searchsorted(question, question)
    return np.sort(order[rank < PEAKS])


def _highest(question: Indices, height: Array, grain: Array, questions: int) -> Indices:
    """Which (k,) of the sorted questions is the highest of each; of equal ones the first."""
    top = np.full(questions, -np.inf)
    np.maximum.at(top, question, height)
    high = (~(top[question] - height > grain)).nonzero()[0]
    which = question[high]
    new = np.ones(len(high), dtype=bool)
    np.not_equal(which[1:], which[:-1], out=new[1:])
    return high[new]
