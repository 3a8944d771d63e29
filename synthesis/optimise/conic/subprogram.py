"""A part of a cone program: some of its free laws, with their rows and those on the size alone.

Laws are coupled through the size and through the junctions that they share. A part has fewer rows
than the whole: it is a relaxation of it, so that every bound of the part is one of the whole.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.solvers.clarabel import ConeProgram
from synthesis.optimise.conic.assembly import MatrixBuilder
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel


@dataclass(frozen=True, eq=False)
class ModelByLaw:
    """A model with its rows sorted by law."""

    model: ConicModel

    def coupled_laws(self, position: int) -> tuple[int, ...]:
        """A law and those with which it shares derivatives at a junction, in order."""
        result = {position}
        for junction in self.model.junctions:
            if junction.highest >= junction.lowest and position in (
                junction.before,
                junction.after,
            ):
                result |= {junction.before, junction.after}
        return tuple(sorted(result))

    def submodel(self, positions: Sequence[int]) -> ConicModel:
        """The laws at these positions alone, numbered anew; without cones and objective."""
        model, number = self.model, {position: k for k, position in enumerate(positions)}
        grids = tuple(model.grids[k] for k in positions)
        boundaries = tuple(model.boundary_states[k] for k in positions)
        junctions = tuple(
            replace(junction, before=number[junction.before], after=number[junction.after])
            for junction in model.junctions
            if junction.before in number and junction.after in number
        )
        free = tuple(self._free[k] for k in positions)
        problem = replace(model.problem, segments=free)
        columns, at = list[slice](), 0
        for k in positions:
            width = model.columns[k].stop - model.columns[k].start
            columns.append(slice(at, at + width))
            at += width
        size = slice(at, at + len(model.problem.sizing.bounds))
        exact, blocks = (
            tuple(each for k in (None, *positions) for each in _renumber(rows.get(k, ()), number))
            for rows in self._rows
        )
        writer = MatrixBuilder(size.stop, columns, size, None, boundaries)
        for junction in junctions:
            writer.add_junction(junction, free, grids)
        writer.add_fixed_sizes(model.problem.sizing.bounds, model.scales)
        for block in exact:
            writer.add_block(block)
        equalities = writer.rows
        for block in blocks:
            writer.add_block(block)
        matrix, rhs = writer.build()
        program = ConeProgram(
            sparse.csc_matrix((size.stop, size.stop)), np.zeros(size.stop), matrix, rhs,
            equalities, writer.rows - equalities, (),
        )  # fmt: skip
        return replace(
            model, problem=problem, grids=grids, boundary_states=boundaries, junctions=junctions,
            columns=tuple(columns), size=size, epigraph=None,
            energy_columns=slice(size.stop, size.stop), equality_blocks=exact, blocks=blocks,
            cone_blocks=(), energy=None, program=program, vibration_equalities=(),
        )  # fmt: skip

    @cached_property
    def _free(self) -> tuple[PlacedSegment, ...]:
        return self.model.problem.free

    @cached_property
    def _rows(
        self,
    ) -> tuple[dict[int | None, list[LinearBlock]], dict[int | None, list[LinearBlock]]]:
        """Equalities and inequalities of every law, and of none."""
        return _blocks_by_law(self.model.equality_blocks), _blocks_by_law(self.model.blocks)


def _blocks_by_law(blocks: Iterable[LinearBlock]) -> dict[int | None, list[LinearBlock]]:
    result: dict[int | None, list[LinearBlock]] = {}
    for block in blocks:
        result.setdefault(block.segment, []).append(block)
    return result


def _renumber(blocks: Iterable[LinearBlock], number: dict[int, int]) -> Iterable[LinearBlock]:
    return (b if b.segment is None else replace(b, segment=number[b.segment]) for b in blocks)
