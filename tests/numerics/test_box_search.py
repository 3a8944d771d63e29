"""The box search on functions of one and two variables whose maxima are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from synthesis.numerics.box_search import BoxSearch, Budget
from synthesis.numerics.piecewise import Array, Mask

AMPLE = Budget(levels=60, boxes=100_000)


class Lipschitz(BoxSearch[Array]):
    """The largest value of a function of known slope, over intervals (n, 2)."""

    children = 2

    def __init__(self, function, slope: float, width: float) -> None:
        self.function, self.slope, self.width = function, slope, width
        self.best = -math.inf
        self.levels: list[int] = []

    def bound(self, boxes: Array) -> Array:
        self.levels.append(len(boxes))
        middle, half = boxes.mean(axis=1), 0.5 * np.diff(boxes, axis=1)[:, 0]
        value = self.function(middle)
        self.best = max(self.best, float(np.nanmax(value, initial=-math.inf)))
        return value + self.slope * half

    def threshold(self) -> float:
        return self.best + self.width

    def split(self, boxes: Array, keep: Mask) -> Array:
        low, high = boxes[keep].T
        middle = 0.5 * (low + high)
        return np.concatenate([np.stack([low, middle], 1), np.stack([middle, high], 1)])


WHOLE = np.array([[0.0, 3.0]])


def test_encloses_the_maximum() -> None:
    search = Lipschitz(lambda x: np.sin(x), 1.0, 1e-6)
    assert search.run(WHOLE, AMPLE)
    assert search.best <= 1.0 <= search.proven <= search.best + 1e-6


@pytest.mark.parametrize("budget", [Budget(4, 100_000), Budget(60, 20), Budget(60, 6, total=False)])
def test_what_the_budget_leaves_open_is_bounded_still(budget: Budget) -> None:
    search = Lipschitz(lambda x: np.sin(x), 1.0, 1e-9)
    assert not search.run(WHOLE, budget)
    assert search.best <= 1.0 <= search.proven
    assert len(search.levels) <= budget.levels
    assert (sum(search.levels) if budget.total else max(search.levels)) <= budget.boxes


def test_a_box_of_which_nothing_is_known_stays_open() -> None:
    def only_right(x: Array) -> Array:
        return np.where(x > 1.0, -x, np.nan)

    search = Lipschitz(only_right, 1.0, 1e-3)
    assert not search.run(WHOLE, Budget(8, 1000))
    assert search.proven == math.inf


def test_no_boxes_are_no_work() -> None:
    search = Lipschitz(lambda x: x, 1.0, 0.0)
    assert search.run(np.zeros((0, 2)), AMPLE)
    assert search.proven == -math.inf


class Pair(Lipschitz):
    """sin and cos on the same boxes: a box stays as long as either needs it."""

    def __init__(self, width: float) -> None:
        super().__init__(lambda x: np.stack([np.sin(x), np.cos(x)]), 1.0, width)
        self.best = np.full(2, -math.inf)
        self.proven = np.full(2, -math.inf)

    def bound(self, boxes: Array) -> Array:
        middle, half = boxes.mean(axis=1), 0.5 * np.diff(boxes, axis=1)[:, 0]
        value = self.function(middle)
        self.best = np.maximum(self.best, value.max(axis=1))
        return value + half

    def threshold(self) -> Array:
        return (self.best + self.width)[:, None]

    def split(self, boxes: Array, keep: Mask) -> Array:
        return super().split(boxes, keep.any(axis=0))


def test_several_functions_share_their_boxes() -> None:
    search = Pair(1e-5)
    assert search.run(np.array([[0.1, 3.0]]), AMPLE)
    assert np.all(search.best <= [1.0, math.cos(0.1)])
    assert np.all(search.proven >= [1.0, math.cos(0.1)])
    assert np.all(search.proven <= search.best + 1e-5)


class Nearest(BoxSearch[tuple[Array, Array]]):
    """Least distance of two curves: pairs of intervals, the distance negated."""

    children = 4

    def __init__(self, first, second, speed: float, width: float) -> None:
        self.curves, self.speed, self.width = (first, second), speed, width
        self.least = math.inf

    def bound(self, boxes: tuple[Array, Array]) -> Array:
        (one, other), half = boxes, sum(0.5 * np.diff(box, axis=1)[:, 0] for box in boxes)
        gap = np.hypot(*(self.curves[0](one.mean(axis=1)) - self.curves[1](other.mean(axis=1))))
        self.least = min(self.least, float(gap.min()))
        return self.speed * half - gap

    def threshold(self) -> float:
        return self.width - self.least

    def split(self, boxes: tuple[Array, Array], keep: Mask) -> tuple[Array, Array]:
        halves = [
            [np.stack([box[keep][:, 0], box[keep].mean(axis=1)], 1),
             np.stack([box[keep].mean(axis=1), box[keep][:, 1]], 1)] for box in boxes
        ]  # fmt: skip
        pairs = [(a, b) for a in halves[0] for b in halves[1]]
        return np.concatenate([a for a, _ in pairs]), np.concatenate([b for _, b in pairs])


def test_pairs_of_boxes() -> None:
    circle = lambda t: np.stack([np.cos(t), np.sin(t)])  # noqa: E731
    line = lambda t: np.stack([t, np.full_like(t, 1.25)])  # noqa: E731
    search = Nearest(circle, line, 1.0, 1e-3)
    turn, along = np.array([[0.0, 2.0 * math.pi]]), np.array([[-2.0, 2.0]])
    assert search.run((turn, along), Budget(40, 1_000_000))
    assert -search.proven <= 0.25 <= search.least <= -search.proven + 1e-3
