"""Rows of all kinds written into one sparse matrix."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from synthesis.catalogue.constraints import AffineNorm
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.double_double import round_mantissa
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.linear_rows import LinearBlock, Scales
from synthesis.optimise.problem.boundary import BoundaryState, Junction, junction_rows
from synthesis.optimise.problem.grid import Grid
from synthesis.optimise.problem.mean_square import Energy
from synthesis.optimise.problem.residual_vibration import VibrationTerm


@dataclass(frozen=True, eq=False)
class ConeBlock:
    """‖matrix x + shift‖ ≤ x[head] + radius; without head ≤ radius alone.

    ``norm`` is set where the cone speaks of the size variables alone, ``source`` is its cone's;
    ``vibration`` where it bounds a residual vibration, ``energy`` where it bounds a mean square,
    less what given laws have of it by ``room``.
    """

    matrix: Array
    shift: Array
    bound_column: int | None
    radius: float
    norm: AffineNorm | None
    tightening: float = 0.0
    source: str = ""
    vibration: VibrationTerm | None = None
    energy: Energy | None = None
    room: float = 0.0


@dataclass(frozen=True, eq=False)
class Pattern:
    """Where a dense part of the matrix is not 0: positions in it, rows and columns, (k,) each."""

    flat: NDArray[np.intp]
    row: NDArray[np.intp]
    column: NDArray[np.intp]


Part = tuple[Pattern, int, int]  # a part of the matrix, its first row and column


@lru_cache(maxsize=256)
def _pattern(mask: bytes, columns: int) -> Pattern:
    """That of a mask; programs on the same grids have the same ones again and again."""
    flat = np.flatnonzero(np.frombuffer(mask, dtype=bool))
    return Pattern(flat, *np.divmod(flat, columns))


@dataclass(eq=False)
class MatrixBuilder:
    """Collects A and b of A x + slack = b, from the top row down."""

    width: int
    columns: Sequence[slice]
    size: slice
    epigraph: int | None
    boundary_states: Sequence[BoundaryState]
    rows: int = 0
    _parts: list[Part] = field(default_factory=list)
    _values: list[Array] = field(default_factory=list)
    _rhs: list[Array] = field(default_factory=list)

    def _add_entries(self, dense: Array, first_column: int) -> None:
        flat = dense.ravel()
        pattern = _pattern((flat != 0.0).tobytes(), dense.shape[1])
        self._parts.append((pattern, self.rows, first_column))
        self._values.append(flat[pattern.flat])

    def _end_rows(self, rhs: Array) -> None:
        self._rhs.append(rhs)
        self.rows += len(rhs)

    def add_junction(
        self, junction: Junction, free: Sequence[PlacedSegment], grids: Sequence[Grid]
    ) -> None:
        """Equal derivatives on both sides of a joint of free laws, each row scaled to one."""
        sides = junction_rows(junction, free, grids)
        known = np.zeros(len(sides[0].dense))
        for side in sides:
            inner, fixed = self.boundary_states[side.position].split(side.dense)
            self._add_entries(inner, self.columns[side.position].start)
            known += fixed
        self._end_rows(-known)

    def add_fixed_sizes(self, bounds: Sequence[tuple[float, float]], scales: Scales) -> None:
        """Size variables that leave no choice."""
        for j, (low, high) in enumerate(bounds):
            if low == high:
                self._add_entries(np.ones((1, 1)), self.size.start + j)
                self._end_rows(round_mantissa(np.array([low / scales.size])))

    def add_energy(self, squares: Energy, first_column: int) -> None:
        """y = factor · c over the root of the unit: what the mean square sums the squares of."""
        for columns, factor, boundary in zip(
            self.columns, squares.factors, self.boundary_states, strict=True
        ):
            inner, fixed = boundary.split(factor / squares.unit**0.5)
            self._add_entries(inner, columns.start)
            self._add_entries(-np.eye(len(inner)), first_column)
            self._end_rows(-fixed)
            first_column += len(inner)

    def add_block(self, block: LinearBlock) -> None:
        """Inequality rows."""
        rhs = block.rhs - block.tightening
        if block.law_matrix is not None and block.segment is not None:
            inner, fixed = self.boundary_states[block.segment].split(block.law_matrix)
            self._add_entries(inner, self.columns[block.segment].start)
            rhs = rhs - fixed
        if len(block.size):
            share = np.empty((len(rhs), block.size.shape[-1]))
            share[:] = block.size
            self._add_entries(share, self.size.start)
        if block.level and self.epigraph is not None:
            self._add_entries(np.full((len(rhs), 1), block.level), self.epigraph)
        self._end_rows(rhs)

    def add_cone(self, cone: ConeBlock) -> None:
        """(x[head] + radius, matrix x + shift) in the second-order cone."""
        if cone.bound_column is not None:
            self._add_entries(np.full((1, 1), -1.0), cone.bound_column)
        self._end_rows(np.array([cone.radius * (1.0 - cone.tightening)]))
        self._add_entries(round_mantissa(-cone.matrix), 0)
        self._end_rows(round_mantissa(cone.shift))

    def norm_cone(
        self,
        norm: AffineNorm,
        unit: float,
        radius: float | None,
        tighten: float = 0.0,
        source: str = "",
    ) -> ConeBlock:
        """‖norm‖ ≤ radius [length], or ≤ the extra unknown where no radius is given."""
        matrix = np.zeros((len(norm.shift), self.width))
        matrix[:, self.size] = norm.matrix
        shift = np.array(norm.shift) / unit
        if radius is None:
            return ConeBlock(matrix, shift, self.epigraph, 0.0, norm)
        # divided by the radius: the cone keeps its shape however large the cam is
        scale = radius / unit if radius > 0.0 else 1.0
        centred = radius / unit / scale
        return ConeBlock(matrix / scale, shift / scale, None, centred, norm, tighten, source)

    def energy_cone(self, squares: Energy, value: float) -> ConeBlock:
        """Mean square ≤ value²."""
        squares = squares.between([(each.start, each.end) for each in self.boundary_states])
        rest = max(value**2 - squares.constant, 0.0) ** 0.5 or 1.0
        matrix = np.zeros((sum(len(f) for f in squares.factors), self.width))
        shift = np.zeros(len(matrix))
        at = 0
        for columns, factor, boundary in zip(
            self.columns, squares.factors, self.boundary_states, strict=True
        ):
            inner, fixed = boundary.split(factor)
            matrix[at : at + len(factor), columns] = inner / rest
            shift[at : at + len(factor)] = fixed / rest
            at += len(factor)
        return ConeBlock(matrix, shift, None, 1.0, None, energy=squares, room=rest**2)

    def add_apex(self, cone: ConeBlock) -> None:
        """Equalities in place of a cone of radius 0: matrix x + shift = 0."""
        self._add_entries(cone.matrix, 0)
        self._end_rows(-cone.shift)

    def vibration_cone(self, vibration: VibrationTerm, tighten: float) -> ConeBlock:
        """Residual vibration ≤ its radius."""
        matrix, shift = np.zeros((2, self.width)), vibration.shift.copy()
        for share, rows in zip(vibration.law_terms, vibration.rows, strict=True):
            inner, fixed = self.boundary_states[share.position].split(rows)
            matrix[:, self.columns[share.position]] = inner
            shift += fixed
        radius, source = vibration.radius, vibration.source
        return ConeBlock(matrix, shift, None, radius, None, tighten, source, vibration)

    def build(self) -> tuple[sparse.csc_matrix, Array]:
        """A in compressed columns, and b."""
        order, empty = _compressed_order(tuple(self._parts), self.rows, self.width)
        value, rhs = np.concatenate(self._values), np.concatenate(self._rhs)
        if order is None:  # a law that meets itself: entries add up
            row, column = _entries(self._parts)
            return sparse.csc_matrix((value, (row, column)), shape=empty.shape), rhs
        matrix = copy.copy(empty)
        matrix.data = value[order]
        return matrix, rhs


def _entries(parts: Sequence[Part]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of all entries, part by part."""
    return (
        np.concatenate([pattern.row + row for pattern, row, _ in parts]),
        np.concatenate([pattern.column + column for pattern, _, column in parts]),
    )


@lru_cache(maxsize=8)
def _compressed_order(
    parts: tuple[Part, ...], rows: int, width: int
) -> tuple[NDArray[np.intp] | None, sparse.csc_matrix]:
    """In which order the entries of all parts come in compressed columns, and the matrix without
    its values; no order where two entries share a place.
    """
    row, column = _entries(parts)
    place = column * rows + row
    order = np.argsort(place)
    place, empty = place[order], sparse.csc_matrix((rows, width))
    if (place[1:] == place[:-1]).any():
        return None, empty
    first = np.searchsorted(place, rows * np.arange(width + 1))
    packed = np.zeros(len(place)), row[order].astype(np.int32), first.astype(np.int32)
    return order, sparse.csc_matrix(packed, shape=empty.shape)
