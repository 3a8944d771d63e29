"""Branch and bound over boxes: the one loop (bound, prune, split, stop) behind every enclosure.

A subclass of ``BoxSearch`` says what a box is and how a function is bounded on it; ``run`` does the
rest, level by level, with all boxes of a level at once. It maximises: negate what is to be small.

* **Bound.** ``bound`` gives a proven upper bound of the function on each box. On the way it may
  improve the incumbent, the largest value that is known to be reached.
* **Prune.** A box whose bound does not exceed ``threshold`` (the incumbent plus the width that is
  good enough) cannot change the answer. Its bound stays in ``proven``, so that ``proven`` is above
  the function on every box that was left, now or earlier.
* **Split.** ``split`` cuts the other boxes into parts.
* **Stop** when no box is open, or when the budget is used up. Then the open boxes are left too:
  ``proven`` is valid in either case, it is only wider in the second.

Not a number as a bound means that nothing is known: such a box stays open.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from synthesis.numerics.piecewise import Array, Mask

B = TypeVar("B")


@dataclass(frozen=True)
class Budget:
    """When a search gives up.

    Attributes:
        levels: most levels, the first one counted.
        boxes: a level that would bring the boxes beyond this number is not begun.
        total: whether the boxes of all levels count, or those of one level.
    """

    levels: int
    boxes: int
    total: bool = True


class BoxSearch(ABC, Generic[B]):
    """One search; B holds the boxes of a level.

    Several functions may share their boxes: then bounds are (functions, n), thresholds
    (functions, 1), and a box stays open as long as one function needs it.

    Attributes:
        proven: upper bound of the function over all boxes that were left: a number or (functions,).
        children: fewest parts that ``split`` makes of a box; by it the next level is estimated.
    """

    proven: Any = -np.inf
    children: int

    @abstractmethod
    def bound(self, boxes: B) -> Array:
        """Upper bounds on a level's boxes, (n,) or (functions, n); −inf: of no interest."""

    @abstractmethod
    def threshold(self) -> Array | float:
        """What a bound must exceed for its box to stay open; read after every ``bound``."""

    @abstractmethod
    def split(self, boxes: B, keep: Mask) -> B:
        """The next level: the boxes to ``keep``, (n,) or (functions, n), cut into parts."""

    def leave(self, upper: Array, which: Mask) -> None:
        """Take in the bounds of boxes that are not looked at again."""
        most = np.where(which, upper, -np.inf).max(axis=-1, initial=-np.inf)
        self.proven = np.maximum(self.proven, most)

    def run(self, boxes: B, budget: Budget) -> bool:
        """Search until no box is open; False if the budget ended the search before that."""
        used = 0
        for level in range(1, budget.levels + 1):
            upper = self.bound(boxes)
            keep: Mask = ~(upper <= self.threshold())
            self.leave(upper, ~keep)
            count = int(np.count_nonzero(keep if keep.ndim == 1 else keep.any(axis=0)))
            if count == 0:
                return True
            used += upper.shape[-1] if budget.total else 0
            if level == budget.levels or used + self.children * count > budget.boxes:
                self.leave(np.where(np.isnan(upper), np.inf, upper), keep)
                return False
            boxes = self.split(boxes, keep)
        return False
