"""A part of a cone program: some of its free laws, with their rows and those on the size alone.

Laws are coupled through the size and through the junctions that they share. A part has fewer rows
than the whole: it is a relaxation of it, so that every bound of the part is one of the whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy import sparse

from synthesis.numerics.solvers.clarabel import ConeProgram
from synthesis.optimise.conic.assembly import ConeBlock
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.problem.residual_vibration import VibrationTerm


def coupled_laws(model: ConicModel, position: int) -> tuple[int, ...]:
    """A law and those with which it shares derivatives at a junction, in order."""
    result = {position}
    for junction in model.junctions:
        both = {junction.before, junction.after}
        if junction.highest >= junction.lowest and position in both:
            result |= both
    return tuple(sorted(result))


def submodel(model: ConicModel, positions: Sequence[int]) -> ConicModel:
    """The laws at these positions alone, numbered anew; without an objective.

    Of the cones it has those on residual vibration after runs of these laws, and that on a mean
    square, which leaves them what other laws do not need in any case.
    """
    number = {position: k for k, position in enumerate(positions)}
    # 1. Its rows: junctions, fixed sizes, vibrations, equalities, inequalities (of the size, then
    #    law by law), cones.
    rows, junctions, at = list[int](), [], 0
    for junction in model.junctions:
        first, at = at, at + max(junction.highest - junction.lowest + 1, 0)
        if junction.before in number and junction.after in number:
            rows += range(first, at)
            before, after = number[junction.before], number[junction.after]
            junctions.append(replace(junction, before=before, after=after))
    fixed = sum(low == high for low, high in model.problem.sizing.bounds)
    rows += range(at, at + fixed)
    still = list[VibrationTerm]()
    for number_of_run, run in enumerate(model.vibration_equalities):
        first = at + fixed + 2 * number_of_run
        own = run.of_laws(number)
        if own is not None:
            still.append(own)
            rows += range(first, first + 2)
    every = [
        (at, block if k is None else replace(block, segment=number[k]))
        for at, block in model.numbered_blocks
        if (k := block.segment) is None or k in number
    ]
    every.sort(key=lambda each: -1 if each[1].segment is None else each[1].segment)
    exact, others = ([each for each in every if each[1].exact is kind] for kind in (True, False))
    for at, block in (*exact, *others):
        rows += range(at, at + len(block.rhs))
    inequalities = sum(len(block.rhs) for _, block in others)
    equalities, cones = len(rows) - inequalities, list[ConeBlock]()
    drawn = list[tuple[range, float]]()  # rows that are divided by another room, and factors
    at = model.program.equalities + model.program.inequalities
    for cone in model.cone_blocks:
        first, at = at, at + 1 + len(cone.shift)
        own = None if cone.vibration is None else cone.vibration.of_laws(number)
        if own is not None:
            rows += range(first, at)
            cones.append(replace(cone, vibration=own))
        if cone.energy is not None:
            # over the root of the room that is left to them, in place of that of all laws
            energy, of_laws = cone.energy.of_laws(positions)
            room = cone.room - float(np.sum(cone.energy.least) - np.sum(energy.least))
            unit = (cone.room / room) ** 0.5 if room > 0.0 else 1.0
            drawn.append((range(len(rows) + 1, len(rows) + 1 + len(of_laws)), unit))
            rows += [first, *(first + 1 + of_laws)]
            cones.append(replace(
                cone, matrix=unit * cone.matrix[of_laws], shift=unit * cone.shift[of_laws],
                energy=energy, room=cone.room / unit**2,
            ))  # fmt: skip
    # 2. Its columns: the coefficients of the laws, and the size.
    parts = [*(model.columns[k] for k in positions), model.size]
    kept = np.concatenate([np.arange(part.start, part.stop) for part in parts])
    stops = np.cumsum([0, *(part.stop - part.start for part in parts)]).tolist()
    *columns, size = (slice(*ends) for ends in pairwise(stops))
    whole, width = model.program, len(kept)
    matrix = whole.matrix[rows][:, kept]
    matrix.sort_indices()
    scale = np.ones(len(rows))
    for own_rows, unit in drawn:
        scale[own_rows] = unit
    matrix.data *= scale[matrix.indices]
    program = ConeProgram(
        sparse.csc_matrix((width, width)), np.zeros(width), matrix, scale * whole.rhs[rows],
        equalities, inequalities, tuple(len(cone.shift) + 1 for cone in cones),
    )  # fmt: skip
    free = tuple(model.problem.free[k] for k in positions)
    return replace(
        model, problem=replace(model.problem, segments=free),
        grids=tuple(model.grids[k] for k in positions),
        boundary_states=tuple(model.boundary_states[k] for k in positions),
        junctions=tuple(junctions), columns=tuple(columns), size=size, epigraph=None,
        energy_columns=slice(width, width), equality_blocks=tuple(block for _, block in exact),
        blocks=tuple(block for _, block in others),
        cone_blocks=tuple(replace(cone, matrix=cone.matrix[:, kept]) for cone in cones),
        energy=None, program=program, vibration_equalities=tuple(still),
    )  # fmt: skip


def without_size_rows(model: ConicModel) -> ConicModel:
    """The model without its inequalities on the size alone."""
    kept = np.ones(len(model.program.rhs), dtype=bool)
    for at, block in model.numbered_blocks:
        if block.segment is None and not block.exact:
            kept[at : at + len(block.rhs)] = False
    blocks = tuple(block for block in model.blocks if block.segment is not None)
    program = replace(
        model.program, matrix=sparse.csc_matrix(model.program.matrix[kept]),
        rhs=model.program.rhs[kept],
        inequalities=model.program.inequalities - int(np.count_nonzero(~kept)),
    )  # fmt: skip
    return replace(model, blocks=blocks, program=program)
