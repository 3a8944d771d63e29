"""Rows of all kinds written into one sparse matrix."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from synthesis.formulations.cone.rows import Block, Scales
from synthesis.formulations.question.ends import Ends, Joint, joint_rows
from synthesis.formulations.question.energy import Energy
from synthesis.formulations.question.grid import Grid
from synthesis.formulations.question.ringing import Ring
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


@dataclass(frozen=True, eq=False)
class Pattern:
    """Where a dense part of the matrix is not 0: positions in it, rows and columns, (k,) each."""

    flat: NDArray[np.intp]
    row: NDArray[np.intp]
    column: NDArray[np.intp]


Placed = tuple[Pattern, int, int]  # a part of the matrix, its first row and column


@lru_cache(maxsize=256)
def _pattern(mask: bytes, columns: int) -> Pattern:
    """That of a mask; programs on the same grids have the same ones again and again."""
    flat = np.flatnonzero(np.frombuffer(mask, dtype=bool))
    return Pattern(flat, *np.divmod(flat, columns))


@dataclass(eq=False)
class Writer:
    """Collects A and b of A x + slack = b, from the top row down."""

    width: int
    columns: Sequence[slice]
    size: slice
    extra: int | None
    settled: Sequence[Ends]
    rows: int = 0
    _parts: list[Placed] = field(default_factory=list)
    _values: list[Array] = field(default_factory=list)
    _rhs: list[Array] = field(default_factory=list)

    def _put(self, dense: Array, first_column: int) -> None:
        flat = dense.ravel()
        pattern = _pattern((flat != 0.0).tobytes(), dense.shape[1])
        self._parts.append((pattern, self.rows, first_column))
        self._values.append(flat[pattern.flat])

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
            share = np.empty((len(rhs), block.size.shape[-1]))
            share[:] = block.size
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
        order, empty = _packing(tuple(self._parts), self.rows, self.width)
        value, rhs = np.concatenate(self._values), np.concatenate(self._rhs)
        if order is None:  # a law that meets itself: entries add up
            row, column = _places(self._parts)
            return sparse.csc_matrix((value, (row, column)), shape=empty.shape), rhs
        matrix = copy.copy(empty)
        matrix.data = value[order]
        return matrix, rhs


def _places(parts: Sequence[Placed]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of all entries, part by part."""
    return (
        np.concatenate([pattern.row + row for pattern, row, _ in parts]),
        np.concatenate([pattern.column + column for pattern, _, column in parts]),
    )


@lru_cache(maxsize=8)
def _packing(
    parts: tuple[Placed, ...], rows: int, width: int
) -> tuple[NDArray[np.intp] | None, sparse.csc_matrix]:
    """In which order the entries of all parts come in compressed columns, and the matrix without
    its values; no order where two entries share a place.
    """
    row, column = _places(parts)
    place = column * rows + row
    order = np.argsort(place)
    place, empty = place[order], sparse.csc_matrix((rows, width))
    if (place[1:] == place[:-1]).any():
        return None, empty
    first = np.searchsorted(place, rows * np.arange(width + 1))
    packed = np.zeros(len(place)), row[order].astype(np.int32), first.astype(np.int32)
    return order, sparse.csc_matrix(packed, shape=empty.shape)
