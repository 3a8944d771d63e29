"""Branch and bound over boxes: the one loop (bound, prune, split, stop) behind every enclosure.

A subclass of ``BoxSearch`` says what a box is and how a function is bounded on it; ``run`` does the
rest, level by level, with all boxes of a level at once. It maximises: negate what is to be small.
``Boxes`` are intervals of one variable.

* **Bound.** ``bound`` gives a proven upper bound of the function on each box, or not a number where
  nothing is known. It may improve the incumbent, the largest value that is known to be reached.
* **Prune.** A box whose bound does not exceed ``threshold`` (the incumbent plus the width that is
  good enough) cannot change the answer. Its bound stays in ``proven``, which is above the function
  on every box that was left.
* **Split.** ``split`` cuts the other boxes into parts.
* **Stop** when no box is open, or when the budget is used up. Then the open boxes are left too:
  ``proven`` is valid in either case, it is only wider in the second.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from synthesis.numerics.piecewise import Array, Indices, Mask

B = TypeVar("B")


@dataclass(frozen=True)
class Budget:
    """When a search gives up: after so many levels, the first one counted, or boxes.

    A level that would bring the boxes beyond their number is not begun; ``total``: whether the
    boxes of all levels count, or those of one level.
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

    def is_late(self) -> bool:
        """Whether the time for the search is over; asked after each level."""
        return False

    def leave(self, upper: Array, which: Mask) -> None:
        """Take in the bounds of boxes that are not looked at again."""
        most = np.where(which, upper, -np.inf).max(axis=-1, initial=-np.inf)
        self.proven = np.maximum(self.proven, most)

    def run(self, boxes: B, budget: Budget) -> bool:
        """Search until no box is open; False if budget or time ended the search before that."""
        used = 0
        for level in range(1, budget.levels + 1):
            upper = self.bound(boxes)
            keep: Mask = ~(upper <= self.threshold())
            self.leave(upper, ~keep)
            count = int(np.count_nonzero(keep if keep.ndim == 1 else keep.any(axis=0)))
            if count == 0:
                return True
            used += upper.shape[-1] if budget.total else 0
            spent = used + self.children * count > budget.boxes or self.is_late()
            if level == budget.levels or spent:
                self.leave(np.where(np.isnan(upper), np.inf, upper), keep)
                return False
            boxes = self.split(boxes, keep)
        return False


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes (n,) of one piece each, and which questions they are for: (questions, n)."""

    piece: Indices
    lo: Array
    hi: Array
    active: Mask

    def __len__(self) -> int:
        return len(self.lo)

    @classmethod
    def from_spans(
        cls, pieces: Indices, first: Array, last: Array, counts: Indices, active: Mask | None = None
    ) -> Boxes:
        """Spans [first, last] (k,), each on one of ``pieces`` (k,), cut into equal parts.

        ``counts``: of every piece, into how many; ``active``: (questions, k), None for no question.
        """
        active = np.zeros((0, len(pieces)), dtype=bool) if active is None else active
        parts = np.where(last > first, counts[pieces], 1)
        step = (last - first) / parts
        owner, nth, behind = _counted(parts)
        start, width = first[owner], step[owner]
        lo, hi = start + nth * width, start + (nth + 1) * width
        hi[behind - 1] = last
        return cls(pieces[owner], lo, hi, active.take(owner, axis=1))

    def keep(self, active: Mask) -> Boxes:
        """Those with a question that is still active."""
        which = np.flatnonzero(active.any(axis=0))
        return replace(self, active=active).take(which)

    def take(self, which: Indices) -> Boxes:
        """Some of them, in this order."""
        return Boxes(*(part.take(which, axis=-1) for part in vars(self).values()))

    def split(self, count: int) -> Boxes:
        """Each cut into equal parts, which follow one another."""
        parts = np.arange(count + 1) / count
        edges = self.lo[:, None] + (self.hi - self.lo)[:, None] * parts
        edges[:, -1] = self.hi
        piece, active = np.repeat(self.piece, count), np.repeat(self.active, count, axis=1)
        return Boxes(piece, edges[:, :-1].ravel(), edges[:, 1:].ravel(), active)

    def cut_at(self, cuts: Array) -> Boxes:
        """Each cut at those of the sorted points that lie inside of it."""
        before, behind = cuts.searchsorted(self.lo, "right"), cuts.searchsorted(self.hi)
        parts = np.maximum(behind - before, 0) + 1
        owner, nth, _ = _counted(parts)
        lo, hi, cut = self.lo[owner], self.hi[owner], before[owner] + nth
        inner = nth.nonzero()[0]  # of neighbours in one box
        lo[inner] = hi[inner - 1] = cuts[cut[inner] - 1]
        return Boxes(self.piece[owner], lo, hi, self.active.take(owner, axis=1))

    def append(self, other: Boxes) -> Boxes:
        """These and the others."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Boxes(*(np.concatenate(pair, axis=-1) for pair in pairs))


def _counted(parts: Indices) -> tuple[Indices, Indices, Indices]:
    """Of things with so many parts each, (n,): whose each part is, and the how manieth of it.

    The third is how many parts there are up to each thing's last one, (n,).
    """
    owner, behind = np.arange(len(parts)).repeat(parts), parts.cumsum()
    return owner, np.arange(len(owner)) - (behind - parts)[owner], behind
