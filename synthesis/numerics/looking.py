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

from synthesis.numerics.boxes import Boxes, Indices
from synthesis.numerics.piecewise import distinct
from synthesis.numerics.taylor import Array

# (pieces (n,), points (n,)) -> (questions, n), of each question how large its function is there
Heights = Callable[[Indices, Array], Array]

PEAKS: Final = 3  # of a question, that are nearly as high as its highest
NEARLY: Final = 0.5  # of what lies between the values on its box
FAN: Final = np.linspace(0.0, 1.0, 33)
REACH: Final = 0.25  # of a box, to either side of its parabola's peak: there it is looked for
STEPS: Final = 2.0 ** -np.arange(1.0, 12.0)  # of a box: how far from a peak it is cut
LADDER: Final = np.concatenate([-STEPS, STEPS])
HUGE: Final = 1e290  # what is larger is none of a function's values
EQUAL: Final = 2.0**-34  # relative: peaks whose heights differ by less are one as high as the other
ALIKE: Final = 2.0**-44  # the same of points beside each other
BLUR: Final = 2.0**-48  # of a bound: what is left of a height over it is no better known
BESIDE: Final = np.arange(-1, 2)[:, None]


@dataclass(frozen=True, eq=False)
class Sighted:
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
class Bounds:
    """What heights are measured from, (questions,) each: value − upper, or lower − value."""

    lower: Array
    upper: Array

    def grain(self, question: Indices, height: Array, share: float) -> Array:
        """By how much heights have to differ from these to count as others: (n,)."""
        lower, upper = self.lower[question], self.upper[question]
        size = np.minimum(np.abs(lower - height), np.abs(upper + height))
        return np.asarray(share * _finite(size) + self._blur[question])

    @cached_property
    def _blur(self) -> Array:
        """What is not known of a height because it is one over a bound: (questions,)."""
        return BLUR * np.maximum(_finite(np.abs(self.lower)), _finite(np.abs(self.upper)))


def _finite(values: Array) -> Array:
    return np.where(values < HUGE, values, 0.0)


def sighted(boxes: Boxes, heights: Heights, bounds: Bounds) -> Sighted:
    """The highest point of every question's function on the boxes that it is asked for.

    Of several that are equally high the first: roundings do not choose.

    Args:
        boxes: where. heights: of the functions, over their bounds.
    """
    question, box, place = _peaks(boxes, heights, bounds)
    piece, left, right = boxes.piece[box], boxes.lo[box], boxes.hi[box]
    width = right - left
    first, last = np.maximum(place - REACH, 0.0), np.minimum(place + REACH, 1.0)
    low, high = left + width * first, np.minimum(left + width * last, right)
    peak, on = np.arange(len(box)), np.repeat(piece, len(FAN))
    x = np.minimum(low[:, None] + (high - low)[:, None] * FAN, high[:, None])
    height = heights(on, x.ravel()).reshape(len(boxes.asked), *x.shape)[question, peak]
    top = np.max(height, axis=1)
    grain = bounds.grain(question, top, ALIKE)
    best = np.argmax(height >= (top - grain)[:, None], axis=1)
    middle = np.minimum(np.maximum(best, 1), len(FAN) - 2)
    three = peak, middle + BESIDE
    low, here, high = x[three]
    before, there, behind = height[three]
    bend = before + behind - 2.0 * there
    vertex = here + 0.5 * (before - behind) / bend * (here - low)  # of a parabola through them
    inner = (best == middle) & (bend < 0.0)
    at = np.where(inner, np.minimum(np.maximum(vertex, low), high), x[peak, best])
    first = _leading(question, top, bounds, 1)
    cuts = distinct(at[:, None] + width[:, None] * LADDER)
    return Sighted(question[first], piece[first], at[first], cuts)


def _peaks(boxes: Boxes, heights: Heights, bounds: Bounds) -> tuple[Indices, Indices, Array]:
    """Questions and boxes: of every question that of the highest peak and others nearly as high.

    The height on a box is that of a parabola through its ends and centre; where on the box that
    has its peak, from 0 to 1, is the third.
    """
    piece, x = boxes.piece, np.concatenate([boxes.lo, 0.5 * (boxes.lo + boxes.hi), boxes.hi])
    found = heights(np.concatenate([piece, piece, piece]), x)
    left, middle, right = found.reshape(len(found), 3, -1).swapaxes(0, 1)
    slope, bend = 0.5 * (right - left), middle - 0.5 * (left + right)
    inner = np.abs(slope) < 2.0 * bend
    vertex = np.where(inner, 0.25 * slope * slope / bend, 0.0)
    height = np.maximum(np.maximum(left, right), middle + vertex)
    height = np.where(boxes.asked & (height > -np.inf), height, -np.inf)
    top = np.max(height, axis=1)
    grain = bounds.grain(np.arange(len(top)), top, ALIKE)
    rising = height[:, 1:] > height[:, :-1] + grain[:, None]
    hill = np.ones(height.shape, dtype=bool)
    hill[:, 1:] &= rising
    hill[:, :-1] &= ~rising
    nearly = height + NEARLY * (np.abs(slope) + np.abs(bend)) >= top[:, None]
    question, box = np.nonzero(hill & nearly & (height > -np.inf))
    kept = _leading(question, height[question, box], bounds, PEAKS)
    question, box = question[kept], box[kept]
    slope, bend, inner = slope[question, box], bend[question, box], inner[question, box]
    place = np.where(inner, 0.5 + 0.25 * slope / bend, np.where(slope > 0.0, 1.0, 0.0))
    return question, box, place


def _leading(question: Indices, height: Array, bounds: Bounds, count: int) -> Indices:
    """Which (k,) are among the so many highest of their question; of equal ones the first."""
    top = np.full(len(bounds.lower), -np.inf)
    np.maximum.at(top, question, height)
    top = top[question]
    below = np.floor((top - height) / bounds.grain(question, top, EQUAL))
    order = np.lexsort((np.where(np.isnan(below), 0.0, below), question))
    ranked = question[order]
    return order[np.arange(len(order)) - np.searchsorted(ranked, ranked) < count]
