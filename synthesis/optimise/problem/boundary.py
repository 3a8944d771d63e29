"""How a free law meets its neighbours: what they settle of it, and what both share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synthesis.catalogue.motion import EndState, PlacedSegment
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array
from synthesis.optimise.problem.grid import Grid

TYPICAL_END = 1e3  # derivatives of end splines in g: keeps the rows of joints near one


@dataclass(frozen=True, eq=False)
class BoundaryState:
    """Known derivatives of g at x = 0 and x = 1, from order 0 up, and the coefficients they fix.

    Attributes:
        start, end: (p,) and (q,) known values of g, g', … at the two ends.
        first, last: the p first and q last spline coefficients, which follow from them.
    """

    start: Array
    end: Array
    first: Array
    last: Array

    def expand(self, inner: Array) -> Array:
        """All coefficients from the unknown ones."""
        return np.concatenate([self.first, inner, self.last])

    def split(self, dense: Array) -> tuple[Array, Array]:
        """Rows over all coefficients as rows over the unknown ones, and the known part: (r,)."""
        p, q = len(self.first), len(self.last)
        stop = dense.shape[1] - q
        fixed = dense[:, stop:] @ self.last
        if np.count_nonzero(self.first):  # none where it starts at rest
            fixed += dense[:, :p] @ self.first
        return dense[:, p:stop], fixed


@dataclass(frozen=True)
class Junction:
    """A joint of two free laws where derivatives from ``lowest`` to ``highest`` are shared.

    Attributes:
        before, after: positions among the free segments.
    """

    before: int
    after: int
    lowest: int
    highest: int


@dataclass(frozen=True, eq=False)
class JunctionSide:
    """One side of a joint: rows dense · c of the law at ``position``, orders lowest to highest.

    ``units`` is the factor with which g^(k) enters each row.
    """

    position: int
    dense: Array
    units: Array


def junction_rows(
    junction: Junction, free: Sequence[PlacedSegment], grids: Sequence[Grid]
) -> tuple[JunctionSide, JunctionSide]:
    """Rows of equal derivatives, before minus after, in units of the larger side."""
    orders = np.arange(junction.lowest, junction.highest + 1)
    sizes = [free[k].lift / free[k].angle ** orders for k in (junction.before, junction.after)]
    scale = np.maximum(np.abs(sizes[0]), np.abs(sizes[1])) * TYPICAL_END
    units = (sizes[0] / scale, -sizes[1] / scale)
    rows = [
        grids[k].space.end_derivatives(x, junction.highest + 1)[junction.lowest :]
        for k, x in ((junction.before, 1.0), (junction.after, 0.0))
    ]
    return (
        JunctionSide(junction.before, units[0][:, None] * rows[0], units[0]),
        JunctionSide(junction.after, units[1][:, None] * rows[1], units[1]),
    )


def boundary_states(
    segments: Sequence[PlacedSegment], grids: Sequence[Grid]
) -> tuple[list[BoundaryState], list[Junction]]:
    """What the neighbours on a whole turn settle of every free law, and what free laws share."""
    position = {s.index: k for k, s in enumerate(s for s in segments if s.law is None)}
    starts: list[Array] = [np.zeros(1)] * len(position)
    finishes: list[Array] = [np.ones(1)] * len(position)
    junctions: list[Junction] = []
    for before, after in zip(segments, (*segments[1:], segments[0]), strict=True):
        if before.law is None and after.law is None:
            junction, known = _free_joint(before, after, position)
            junctions.append(junction)
            finishes[junction.before] = required_end(before, known[0], at_start=False)
            starts[junction.after] = required_end(after, known[1], at_start=True)
        elif before.law is None:
            finishes[position[before.index]] = given_end(before, after, at_start=False)
        elif after.law is None:
            starts[position[after.index]] = given_end(after, before, at_start=True)
    result = []
    for grid, start, end in zip(grids, starts, finishes, strict=True):
        first, last = slice(0, len(start)), slice(grid.space.size - len(end), grid.space.size)
        ends = (grid.space, 0.0, start, first), (grid.space, 1.0, end, last)
        result.append(BoundaryState(start, end, *(_end_coefficients(*each) for each in ends)))
    return result, junctions


def _free_joint(
    before: PlacedSegment, after: PlacedSegment, position: dict[int, int]
) -> tuple[Junction, tuple[EndState, EndState]]:
    """The joint of two free laws, and what is known of it on both sides.

    Where the follower turns back and neither law may overshoot, its velocity is known to be 0: it
    is not negative on one side and not positive on the other.
    """
    assert before.free is not None
    assert after.free is not None
    monotone = not (before.free.overshoot or after.free.overshoot)
    turn = EndState(0.0 if monotone and before.lift * after.lift < 0.0 else None)
    sides = before.end_state.filled_from(turn), after.start_state.filled_from(turn)
    highest = min(
        before.free.continuity_at(at_start=False), after.free.continuity_at(at_start=True)
    )
    lowest = 1 + sum(value is not None for value in sides[0].known)
    highest = max(highest, lowest - 1)
    return Junction(position[before.index], position[after.index], lowest, highest), sides


def required_end(free: PlacedSegment, known: EndState, *, at_start: bool) -> Array:
    """g and as many of its derivatives as are known at an end."""
    derivatives = known.normalised(free.angle, free.scale)
    value = 0.0 if at_start else free.lift / free.scale
    return np.array([value, *(v for v in derivatives if v is not None)])


def given_end(free: PlacedSegment, given: PlacedSegment, *, at_start: bool) -> Array:
    """Derivatives of g where a free law meets a given one: those asked for, else the given's."""
    assert free.free is not None
    highest = free.free.continuity_at(at_start=at_start)
    values = given.end_derivatives(max(highest, 2), at_start=not at_start)
    known = values * free.angle ** np.arange(len(values)) / free.scale
    known[0] = 0.0 if at_start else free.lift / free.scale
    required = (free.start_state if at_start else free.end_state).normalised(free.angle, free.scale)
    count = highest + 1
    for order, value in enumerate(required, start=1):
        if value is not None:
            known[order], count = value, max(count, order + 1)
    return np.asarray(known[:count])


def _end_coefficients(space: SplineSpace, x: float, values: Array, where: slice) -> Array:
    """The coefficients at an end that its known derivatives settle; all equal at rest."""
    if not values[1:].any():
        return np.full(len(values), values[0])
    rows = space.end_derivatives(x, len(values))[:, where]
    return np.asarray(np.linalg.solve(rows, values), dtype=float)
