"""Where functions seem to have their extremes, by numbers: a finding, not a proof.

It tells a proof where to look closely. What it misses costs the proof time and nothing else. To be
run under ``np.errstate(all="ignore")``: what has no value is passed over.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.polynomial.legendre import legvander

from synthesis.numerics.boxes import Boxes
from synthesis.numerics.piecewise import Array, Indices, sorted_unique

# (pieces (n,), points (n,)) -> (questions, n), of each question how large its function is there
ExcessFunction = Callable[[Indices, Array], Array]

PEAKS: Final = 3  # of a question, that are nearly as high as its highest
NEARLY: Final = 0.5  # of what lies between the values on its box
SAMPLES: Final = 5  # on a box
FAN: Final = np.linspace(0.0, 1.0, 257)  # places on a box at which the samples' polynomial is taken
STEPS: Final = 2.0 ** -np.arange(1.0, 12.0)  # of a box: how far from a peak it is cut
LADDER: Final = np.concatenate([-STEPS, STEPS])
ALIKE: Final = 2.0**-44  # relative: points of one peak that differ by less are equally high
EQUAL: Final = 2.0**-34  # the same of peaks


# even places on a box, and from values there to those of their polynomial on the fan
PLACES: Final = np.linspace(0.0, 1.0, SAMPLES)
TO_FAN: Final = np.linalg.solve(
    legvander(2.0 * PLACES - 1.0, SAMPLES - 1).T, legvander(2.0 * FAN - 1.0, SAMPLES - 1).T
)


def locate_extrema(
    boxes: Boxes, heights: ExcessFunction, bounds: Array
) -> tuple[Indices, Indices, Array, Array]:
    """The highest point of every question's function on its active boxes.

    Of several that are equally high the first: roundings do not choose.

    Args:
        boxes: where. heights: of the functions, over their bounds.
        bounds: (questions,) sizes of these: heights are no better known than to their roundings.

    Returns:
        question, piece and point (k,) of each; and sorted points (n,) at which to cut boxes, the
        closer to a peak the closer.
    """
    # 1. samples on every box, and the height of the parabola through its ends and centre
    x = boxes.lo[:, None] + (boxes.hi - boxes.lo)[:, None] * PLACES
    x[:, -1] = boxes.hi
    seen = heights(boxes.piece.repeat(SAMPLES), x.ravel())
    seen = seen.reshape(len(seen), -1, SAMPLES)
    left, middle, right = seen[..., 0], seen[..., SAMPLES // 2], seen[..., -1]
    slope, bend = 0.5 * (right - left), middle - 0.5 * (left + right)
    vertex = np.where(np.abs(slope) < 2.0 * bend, 0.25 * slope * slope / bend, 0.0)
    height = np.maximum(np.maximum(left, right), middle + vertex)
    height = np.where(boxes.active & (height > -np.inf), height, -np.inf)
    # 2. the boxes that are no lower than their neighbours, and may be as high as the highest
    top = height.max(axis=1, initial=-np.finfo(float).max)
    size = np.abs(top) + bounds
    rising = height[:, 1:] > height[:, :-1] + (ALIKE * size)[:, None]
    hill = np.ones(height.shape, dtype=bool)
    hill[:, 1:] &= rising
    hill[:, :-1] &= ~rising
    nearly = height + NEARLY * (np.abs(slope) + np.abs(bend)) >= top[:, None]
    question, box = np.nonzero(hill & nearly)
    kept = _highest(question, height[question, box], EQUAL * size, PEAKS)
    question, box = question[kept], box[kept]
    # 3. there the polynomial through all samples, and a parabola about its highest place
    curve = seen[question, box] @ TO_FAN
    top = curve.max(axis=1)
    best = (curve >= (top - ALIKE * (np.abs(top) + bounds[question]))[:, None]).argmax(axis=1)
    middle = np.clip(best, 1, len(FAN) - 2)
    before, there, after = (curve[np.arange(len(box)), middle + k] for k in (-1, 0, 1))
    bend = before + after - 2.0 * there
    inner = (best == middle) & (bend < 0.0)
    place = np.where(inner, best + 0.5 * (before - after) / bend, best) / (len(FAN) - 1.0)
    width = (boxes.hi - boxes.lo)[box]
    at = np.minimum(boxes.lo[box] + width * place, boxes.hi[box])
    # 4. the highest of each question
    first = _highest(question, top, EQUAL * size, 1)
    cuts = sorted_unique(at[:, None] + width[:, None] * LADDER)
    return question[first], boxes.piece[box[first]], at[first], cuts


def _highest(question: Indices, height: Array, grain: Array, count: int) -> Indices:
    """Which (k,) of the sorted questions are the ``count`` highest of each; of equals the first.

    Args:
        grain: (questions,) by how much heights have to differ to count as different.
    """
    top = np.full(len(grain), -np.inf)
    np.maximum.at(top, question, height)
    below = np.floor((top[question] - height) / grain[question])
    order = np.lexsort((np.where(np.isnan(below), 0.0, below), question))
    rank = np.arange(len(order)) - np.searchsorted(question, question)
    return np.sort(order[rank < count])
