"""Laws that were found on rounded numbers, joined to the last digits on the numbers as asked.

A question is solved in units of its own, without its last digits. What two neighbours share is then
equal in those units: a lift or an angle that differs by 1e-11 leaves as much of a high derivative,
thousands of times larger than lift/β^k, between them. The coefficients nearest to those found that
keep every joint are as good, and differ from them by no more than that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy import sparse

from synthesis.formulations.cone.matrix import Writer
from synthesis.formulations.question.ends import meet
from synthesis.formulations.question.grid import Grid
from synthesis.motion import ANY_STATE, Stretch
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeProgram, closed

Splines = Mapping[int, tuple[SplineSpace, Array]]
NOWHERE: Array = np.zeros(0)


def rejoined(stretches: Sequence[Stretch], splines: Splines) -> Splines:
    """The splines of free laws with coefficients that meet their neighbours to rounding.

    None where all of them lie between dwells: those meet as they are.

    Args:
        stretches: the turn in order, laws settled: free are those that are splines of no table.
        splines: of free laws and of tables, by index of their stretch: space and coefficients.
    """
    turning = [stretch for stretch in stretches if stretch.angle > 0.0]
    sought = [s.index in splines and s.readings is None for s in turning]
    if all(_rests(turning, k) for k, free in enumerate(sought) if free):
        return {}
    turning = [replace(s, law=None) if free else s for s, free in zip(turning, sought, strict=True)]
    free = [stretch for stretch in turning if stretch.law is None]
    grids = [Grid(splines[stretch.index][0], NOWHERE) for stretch in free]
    settled, joints = meet(turning, grids)
    inner = [
        splines[stretch.index][1][len(known.first) : grid.space.size - len(known.last)]
        for stretch, grid, known in zip(free, grids, settled, strict=True)
    ]
    stops = np.cumsum([0, *map(len, inner)]).tolist()
    columns = [slice(a, b) for a, b in pairwise(stops)]
    x = np.concatenate(inner)
    writer = Writer(len(x), columns, slice(len(x), len(x)), None, settled)
    for joint in joints:
        writer.joint(joint, free, grids)
    if writer.rows:
        matrix, rhs = writer.finished()
        nothing = sparse.csc_matrix((len(x), len(x)))
        x = closed(ConeProgram(nothing, np.zeros(len(x)), matrix, rhs, writer.rows, 0, ()), x)
    return {
        stretch.index: (grid.space, known.expand(x[own]))
        for stretch, grid, known, own in zip(free, grids, settled, columns, strict=True)
    }


def _rests(turning: Sequence[Stretch], k: int) -> bool:
    """Whether a free law lies between dwells and nothing else is asked of its ends."""
    own, beside = turning[k], (turning[k - 1], turning[(k + 1) % len(turning)])
    asked = own.at_start != ANY_STATE or own.at_end != ANY_STATE
    return not asked and all(each.law is not None and each.law.still for each in beside)
