"""Boxes of one variable, and which questions about functions of it each of them is for."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from synthesis.numerics.piecewise import Array, Indices, Mask


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
        cls,
        pieces: Indices,
        first: Array,
        last: Array,
        counts: Indices,
        active: Mask | None = None,
    ) -> Boxes:
        """Spans [first, last], each on one piece, cut into equal parts.

        Args:
            pieces, first, last: (k,). counts: of every piece, into how many boxes.
            active: (questions, k); None: boxes for no question.
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
