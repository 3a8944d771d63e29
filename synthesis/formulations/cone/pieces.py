"""A part of a plan: some of its free laws, with the rows on them and on the size alone.

Laws speak to each other through the size and through the joints that they share; what is left out
is a matter of fewer rows, so that a bound of a part is a bound of the whole.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.cone.matrix import Writer
from synthesis.formulations.cone.rows import Block
from synthesis.motion import Stretch
from synthesis.solvers.clarabel import ConeProgram


@dataclass(frozen=True, eq=False)
class Whole:
    """A plan, its rows sorted by the laws that they speak of."""

    plan: Plan

    def beside(self, position: int) -> tuple[int, ...]:
        """A law and those with which it shares derivatives at a joint, in order."""
        found = {position}
        for joint in self.plan.joints:
            if joint.highest >= joint.lowest and position in (joint.before, joint.after):
                found |= {joint.before, joint.after}
        return tuple(sorted(found))

    def part(self, positions: Sequence[int]) -> Plan:
        """The laws at these positions alone, numbered anew; without cones and objective."""
        plan, number = self.plan, {position: k for k, position in enumerate(positions)}
        grids = tuple(plan.grids[k] for k in positions)
        settled = tuple(plan.settled[k] for k in positions)
        joints = tuple(
            replace(joint, before=number[joint.before], after=number[joint.after])
            for joint in plan.joints
            if joint.before in number and joint.after in number
        )
        free = tuple(self._free[k] for k in positions)
        problem = replace(plan.problem, stretches=free)
        columns, at = list[slice](), 0
        for k in positions:
            width = plan.columns[k].stop - plan.columns[k].start
            columns.append(slice(at, at + width))
            at += width
        size = slice(at, at + len(plan.problem.sizing.bounds))
        exact, blocks = (
            tuple(each for k in (None, *positions) for each in _numbered(rows.get(k, ()), number))
            for rows in self._rows
        )
        writer = Writer(size.stop, columns, size, None, settled)
        for joint in joints:
            writer.joint(joint, free, grids)
        writer.fixed(plan.problem.sizing.bounds, plan.scales)
        for block in exact:
            writer.block(block)
        equalities = writer.rows
        for block in blocks:
            writer.block(block)
        matrix, rhs = writer.finished()
        program = ConeProgram(
            sparse.csc_matrix((size.stop, size.stop)), np.zeros(size.stop), matrix, rhs,
            equalities, writer.rows - equalities, (),
        )  # fmt: skip
        return replace(
            plan, problem=problem, grids=grids, settled=settled, joints=joints,
            columns=tuple(columns), size=size, extra=None, squares=slice(size.stop, size.stop),
            exact=exact, blocks=blocks, balls=(), energy=None, program=program, silent=(),
        )  # fmt: skip

    @cached_property
    def _free(self) -> tuple[Stretch, ...]:
        return self.plan.problem.free

    @cached_property
    def _rows(self) -> tuple[dict[int | None, list[Block]], dict[int | None, list[Block]]]:
        """Equalities and inequalities of every law, and of none."""
        return _sorted(self.plan.exact), _sorted(self.plan.blocks)


def _sorted(blocks: Iterable[Block]) -> dict[int | None, list[Block]]:
    found: dict[int | None, list[Block]] = {}
    for block in blocks:
        found.setdefault(block.stretch, []).append(block)
    return found


def _numbered(blocks: Iterable[Block], number: dict[int, int]) -> Iterable[Block]:
    return (b if b.stretch is None else replace(b, stretch=number[b.stretch]) for b in blocks)
