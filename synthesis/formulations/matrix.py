"""Rows of all kinds written into one sparse matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from synthesis.formulations.ends import Ends, Joint, joint_rows
from synthesis.formulations.energy import Energy
from synthesis.formulations.grid import Grid
from synthesis.formulations.ringing import Ring
from synthesis.formulations.rows import Block, Scales
from synthesis.motion import Stretch
from synthesis.numerics.digits import rounded
from synthesis.numerics.piecewise import Array
from synthesis.terms import Norm


@dataclass(frozen=True, eq=False)
class Ball:
    """‖matrix x + shift‖ ≤ x[head] + radius; without head ≤ radius alone.

    ``norm`` is set where the cone speaks of the size variables alone, ``source`` is its cone's;
    ``ring`` where it is about what the motion leaves an oscillator ringing with.
    """

    matrix: Array
    shift: Array
    head: int | None
    radius: float
    norm: Norm | None
    tighten: float = 0.0
    source: str = ""
    ring: Ring | None = None

    @property
    def give(self) -> float:
        """What it gives for one unit of a part that gives way: its radius, or a natural size."""
        return self.radius if self.ring is None else max(self.radius, 1.0)


@dataclass(eq=False)
class Writer:
    """Collects A and b of A x + slack = b, from the top row down."""

    width: int
    columns: Sequence[slice]
    size: slice
    extra: int | None
    settled: Sequence[Ends]
    rows: int = 0
    _entries: list[tuple[NDArray[np.intp], NDArray[np.intp], Array]] = field(default_factory=list)
    _rhs: list[Array] = field(default_factory=list)

    def _put(self, dense: Array, first_column: int) -> None:
        flat = dense.ravel()
        found = np.flatnonzero(flat != 0.0)  # three times as fast as by rows and columns
        row, column = np.divmod(found, dense.shape[1])
        self._entries.append((row + self.rows, column + first_column, flat[found]))

    def _close(self, rhs: Array) -> None:
        self._rhs.append(rhs)
        self.rows += len(rhs)

    def joint(self, joint: Joint, free: Sequence[Stretch], grids: Sequence[Grid]) -> None:
        """Equal derivatives on both sides of a joint of free laws, each row scaled to one."""
        sides = joint_rows(joint, free, grids)
        known = np.zeros(len(sides[0].dense))
        for side in sides:
            inner, fixed = self.settled[side.position].split(side.dense)
            self._put(inner, self.columns[side.position].start)
            known += fixed
        self._close(-known)

    def fixed(self, bounds: Sequence[tuple[float, float]], scales: Scales) -> None:
        """Size variables that leave no choice."""
        for j, (low, high) in enumerate(bounds):
            if low == high:
                self._put(np.ones((1, 1)), self.size.start + j)
                self._close(rounded(np.array([low / scales.size])))

    def roots(self, squares: Energy, first_column: int) -> None:
        """y = factor · c over the root of the unit: what the mean square sums the squares of."""
        for columns, factor, known in zip(self.columns, squares.factors, self.settled, strict=True):
            inner, fixed = known.split(factor / squares.unit**0.5)
            self._put(inner, columns.start)
            self._put(-np.eye(len(inner)), first_column)
            self._close(-fixed)
            first_column += len(inner)

    def block(self, block: Block) -> None:
        """Inequality rows."""
        rhs = block.rhs - block.tighten
        if block.laws is not None and block.stretch is not None:
            inner, fixed = self.settled[block.stretch].split(block.laws)
            self._put(inner, self.columns[block.stretch].start)
            rhs = rhs - fixed
        if len(block.size):
            share = np.broadcast_to(block.size, (len(rhs), block.size.shape[-1]))
            self._put(share, self.size.start)
        if block.level and self.extra is not None:
            self._put(np.full((len(rhs), 1), block.level), self.extra)
        self._close(rhs)

    def ball(self, ball: Ball) -> None:
        """(x[head] + radius, matrix x + shift) in the second-order cone."""
        if ball.head is not None:
            self._put(np.full((1, 1), -1.0), ball.head)
        self._close(np.array([ball.radius * (1.0 - ball.tighten)]))
        self._put(rounded(-ball.matrix), 0)
        self._close(rounded(ball.shift))

    def norm_ball(
        self,
        norm: Norm,
        unit: float,
        radius: float | None,
        tighten: float = 0.0,
        source: str = "",
    ) -> Ball:
        """‖norm‖ ≤ radius [mm], or ≤ the extra unknown where no radius is given."""
        matrix = np.zeros((len(norm.shift), self.width))
        matrix[:, self.size] = norm.matrix
        shift = np.array(norm.shift) / unit
        if radius is None:
            return Ball(matrix, shift, self.extra, 0.0, norm)
        # divided by the radius: the cone keeps its shape however large the cam is
        scale = radius / unit if radius > 0.0 else 1.0
        centred = radius / unit / scale
        return Ball(matrix / scale, shift / scale, None, centred, norm, tighten, source)

    def energy_ball(self, squares: Energy, value: float) -> Ball:
        """Mean square ≤ value²."""
        rest = max(value**2 - squares.constant, 0.0) ** 0.5 or 1.0
        matrix = np.zeros((sum(len(f) for f in squares.factors), self.width))
        shift = np.zeros(len(matrix))
        at = 0
        for columns, factor, known in zip(self.columns, squares.factors, self.settled, strict=True):
            inner, fixed = known.split(factor)
            matrix[at : at + len(factor), columns] = inner / rest
            shift[at : at + len(factor)] = fixed / rest
            at += len(factor)
        return Ball(matrix, shift, None, 1.0, None)

    def silent(self, ring: Ring) -> None:
        """Nothing may be left ringing."""
        matrix, shift = self._ringing(ring)
        self._put(matrix, 0)
        self._close(-shift)

    def ring_ball(self, ring: Ring, tighten: float) -> Ball:
        """What is left ringing ≤ its radius."""
        return Ball(*self._ringing(ring), None, ring.radius, None, tighten, ring.source, ring)

    def _ringing(self, ring: Ring) -> tuple[Array, Array]:
        """A ring's two rows in the unknowns, and what is settled of them."""
        matrix, shift = np.zeros((2, self.width)), ring.shift.copy()
        for share, rows in zip(ring.shares, ring.rows, strict=True):
            inner, fixed = self.settled[share.position].split(rows)
            matrix[:, self.columns[share.position]] = inner
            shift += fixed
        return matrix, shift

    def finished(self) -> tuple[sparse.csc_matrix, Array]:
        """A in compressed columns, and b."""
        row, column, value = (np.concatenate(part) for part in zip(*self._entries, strict=True))
        place = column * self.rows + row
        order = np.argsort(place)
        place, shape = place[order], (self.rows, self.width)
        rhs = np.concatenate(self._rhs)
        if (place[1:] == place[:-1]).any():  # a law that meets itself: entries add up
            return sparse.csc_matrix((value, (row, column)), shape=shape), rhs
        first = np.searchsorted(place, self.rows * np.arange(self.width + 1))
        packed = value[order], row[order].astype(np.int32), first.astype(np.int32)
        return sparse.csc_matrix(packed, shape=shape), rhs
