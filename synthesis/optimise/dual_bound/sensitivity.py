"""Sensitivity: one program's multipliers bound problems with other numbers too.

Multipliers of a program are dual feasible, after the usual projections, for every program with rows
of the same kinds: they need not be its own best ones. So one solution gives a valid bound of every
neighbouring problem, at the cost of evaluating the Lagrangian there. By the envelope theorem it is
exact to first order in what the numbers differ by.
"""

from __future__ import annotations

from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.problem.problem import Problem


def neighbour(model: ConicModel, problem: Problem) -> ConicModel | None:
    """Another problem on a model's mesh, with as many rows of the same kinds; None if they differ.

    Its rows of curved limits hold wherever it allows. Those of a fractional objective hold at one
    level alone.
    """
    if problem.objective.quasiconvex or len(problem.free) != len(model.grids):
        return None
    other = formulate(problem, model.grids)
    return other if _shape(other) == _shape(model) else None


def _shape(model: ConicModel) -> tuple[object, ...]:
    """What two models have in common whose multipliers stand for the same rows."""
    program, blocks = model.program, (block for _, block in model.numbered_blocks)
    rows = [(block.kind, block.segment, block.source, len(block.rhs)) for block in blocks]
    return rows, program.equalities, program.inequalities, program.cones, program.matrix.shape
