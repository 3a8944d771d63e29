"""Laws solved on rounded numbers, made continuous to the last digits on the exact numbers.

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

from synthesis.catalogue.motion import ANY_STATE, PlacedSegment
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeProgram, project_on_equalities
from synthesis.optimise.conic.assembly import MatrixBuilder
from synthesis.optimise.problem.boundary import boundary_states
from synthesis.optimise.problem.grid import Grid

Splines = Mapping[int, tuple[SplineSpace, Array]]
NOWHERE: Array = np.zeros(0)


def repair_junctions(segments: Sequence[PlacedSegment], splines: Splines) -> Splines:
    """The splines of free laws with coefficients that meet their neighbours to rounding.

    None where all of them lie between dwells: those meet as they are. ``splines``: of free laws and
    of tables, by index of their segment.
    """
    segments_on_cam = [segment for segment in segments if segment.angle > 0.0]
    is_spline = [s.index in splines and s.table is None for s in segments_on_cam]
    if all(_lies_between_dwells(segments_on_cam, k) for k, free in enumerate(is_spline) if free):
        return {}
    segments_on_cam = [
        replace(s, law=None) if free else s
        for s, free in zip(segments_on_cam, is_spline, strict=True)
    ]
    free = [segment for segment in segments_on_cam if segment.law is None]
    grids = [Grid(splines[segment.index][0], NOWHERE) for segment in free]
    boundaries, junctions = boundary_states(segments_on_cam, grids)
    inner = [
        splines[segment.index][1][len(boundary.first) : grid.space.size - len(boundary.last)]
        for segment, grid, boundary in zip(free, grids, boundaries, strict=True)
    ]
    stops = np.cumsum([0, *map(len, inner)]).tolist()
    columns = [slice(a, b) for a, b in pairwise(stops)]
    x = np.concatenate(inner)
    writer = MatrixBuilder(len(x), columns, slice(len(x), len(x)), None, boundaries)
    for junction in junctions:
        writer.add_junction(junction, free, grids)
    if writer.rows:
        matrix, rhs = writer.build()
        nothing = sparse.csc_matrix((len(x), len(x)))
        x = project_on_equalities(
            ConeProgram(nothing, np.zeros(len(x)), matrix, rhs, writer.rows, 0, ()), x
        )
    return {
        segment.index: (grid.space, boundary.expand(x[own]))
        for segment, grid, boundary, own in zip(free, grids, boundaries, columns, strict=True)
    }


def _lies_between_dwells(segments_on_cam: Sequence[PlacedSegment], k: int) -> bool:
    """Whether a free law lies between dwells and nothing else is asked of its ends."""
    own = segments_on_cam[k]
    beside = segments_on_cam[k - 1], segments_on_cam[(k + 1) % len(segments_on_cam)]
    constrained = own.start_state != ANY_STATE or own.end_state != ANY_STATE
    return not constrained and all(each.law is not None and each.law.is_constant for each in beside)
