"""The next mesh: more knots where the law costs more than the ideal one, more points for rows."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from math import inf
from typing import Final

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.motion import FreeLaw
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.optimise.dual_bound.bound import Bound
from synthesis.optimise.problem.boundary import BoundaryState, boundary_states
from synthesis.optimise.problem.grid import (
    CLOSEST_KNOTS,
    RAMP_STEP,
    Grid,
    beside_step,
    grid_through,
    merge_knots,
)
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate

MOST_INTERVALS: Final = 480  # of a law: a cone program of twice as many takes seconds
COSTLY: Final = 0.05  # of the mean loss of all laws: intervals that lose more get knots


def add_midpoints(grids: tuple[Grid, ...]) -> tuple[Grid, ...]:
    """More points on the same knots: finer knots are another family, with another bound."""
    return tuple(grid.with_points(0.5 * (grid.points[1:] + grid.points[:-1])) for grid in grids)


def refine_mesh(
    problem: Problem,
    grids: tuple[Grid, ...],
    cam: Candidate | None,
    lower: Bound | None,
    violated_points: Sequence[Array] = (),
    *,
    very_costly: float = inf,
) -> tuple[Grid, ...]:
    """Finer knots where the law pays more than the ideal one; points where rows are violated.

    ``very_costly``: of the mean loss: intervals that lose more are cut in four.
    """
    if cam is None or lower is None or not lower.switching:
        return halve_intervals(problem, grids, violated_points)
    chosen, (states, _) = [], boundary_states(problem.segments, grids)
    curves = [law.curve() for law in cam.laws]
    losses = _losses(grids, curves, lower)
    mean = np.sum(np.concatenate(losses)) / sum(map(len, losses))
    if mean == 0.0:  # no interval loses anything
        return halve_intervals(problem, grids, violated_points)
    for position, (segment, grid) in enumerate(zip(problem.free, grids, strict=True)):
        assert segment.free is not None
        chosen.append(
            _knots_of_costly_intervals(
                segment.free, states[position], grid.space.breaks, curves[position],
                losses[position] > COSTLY * mean, losses[position] > very_costly * mean, lower,
                position,
            )
        )  # fmt: skip
    if nearly_equal(chosen, [grid.space.breaks for grid in grids], CLOSEST_KNOTS):
        return halve_intervals(problem, grids, violated_points)
    return _mesh_through(problem, chosen, violated_points)


def halve_intervals(
    problem: Problem, grids: tuple[Grid, ...], violated_points: Sequence[Array] = ()
) -> tuple[Grid, ...]:
    """Finer knots everywhere: all intervals cut in two.

    For laws of which no interval loses more than the others. What is left of the gap is the bound's
    then: the points at which it has multipliers lie too far apart.
    """
    before = (grid.space.breaks for grid in grids)
    chosen = [_halved(breaks) if len(breaks) <= MOST_INTERVALS else breaks for breaks in before]
    return _mesh_through(problem, chosen, violated_points)


def _mesh_through(
    problem: Problem, breaks: Sequence[Array], violated_points: Sequence[Array]
) -> tuple[Grid, ...]:
    """Grids over breaks, with the points where rows are violated."""
    grids = tuple(grid_through(*each) for each in zip(problem.free, breaks, strict=True))
    if not violated_points:
        return grids
    return tuple(g.with_points(x) for g, x in zip(grids, violated_points, strict=True))


def _losses(grids: Sequence[Grid], curves: Sequence[Piecewise], lower: Bound) -> list[Array]:
    """What every interval of every law loses against the ideal law [objective's units]."""
    return [
        psi.losses(grid.space.breaks, partial(curve, order=c.order), c.cap, c.weight)
        for grid, curve, psi, c in zip(grids, curves, lower.switching, lower.controls, strict=True)
    ]


def _knots_of_costly_intervals(
    free: FreeLaw,
    state: BoundaryState,
    breaks: Array,
    curve: Piecewise,
    costly: NDArray[np.bool_],
    very: NDArray[np.bool_],
    lower: Bound,
    position: int,
) -> Array:
    """The knots, and more in each interval that loses much against the ideal law.

    One with a single switch of the ideal law gets knots there, others are halved; ends of windows
    get knots beside them.
    """
    psi, control = lower.switching[position], lower.controls[position]
    switches = np.zeros(0) if control.weight else psi.sign_changes()
    inside = np.clip(np.searchsorted(breaks, switches, "right") - 1, 0, len(costly) - 1)
    counts = np.bincount(inside, minlength=len(costly))
    single = costly & (counts == 1)
    halved = _halved(breaks, (costly & ~single) | very)
    if np.any(very):  # and these halves again
        halved = _halved(halved, very[np.searchsorted(breaks, halved[:-1], "right") - 1])
    # Beside the ends of windows knots lie as close as they may: a bound or a value that ends there
    # at once leaves the law little angle to change in.
    softer = free.smoothness + 1 - lower.order
    ends, step = np.array(free.knots), beside_step(softer)
    steps = end_steps(free, state, softer)
    # A law of a lower class than is asked for switches at once, on knots that cost it nothing.
    jumps = curve.poly.shape[1] - 2 < free.smoothness
    wanted = switches[(counts == 1 if jumps else single)[inside]]
    finer, present = (
        merge_knots(each, wanted, free.knots, (*(ends - step), *(ends + step)), softer, steps)
        for each in (halved, breaks)
    )
    if len(finer) <= MOST_INTERVALS:
        return finer
    return present if jumps else breaks


def _halved(breaks: Array, chosen: NDArray[np.bool_] | bool = True) -> Array:
    """The breaks with the chosen intervals, or all, cut in two."""
    middle = 0.5 * (breaks[:-1] + breaks[1:])
    return np.union1d(breaks, middle[chosen & (np.diff(breaks) > 2.0 * CLOSEST_KNOTS)])


def end_steps(
    free: FreeLaw, state: BoundaryState, softer: int, ramp_step: float = RAMP_STEP
) -> tuple[float, float]:
    """The lengths of a ramp's intervals at both ends of a law.

    A ramp from rest has equal coefficients, exactly. Where the law moves they are rounded, and
    that is divided by the third power of the ramp's length.
    """
    start, end = (
        ramp_step if len(end) > free.smoothness and not end[1:].any() else beside_step(softer)
        for end in (state.start, state.end)
    )
    return start, end


def nearly_equal(now: Sequence[Array], before: Sequence[Array], distance: float) -> bool:
    """Whether two lists hold the same knots, none moved by more than a distance."""
    return len(now) == len(before) and all(
        len(one) == len(other) and bool(np.all(np.abs(one - other) <= distance))
        for one, other in zip(now, before, strict=True)
    )


def is_same_mesh(grids: Sequence[Grid], others: Sequence[Grid]) -> bool:
    """Whether knots and points are the same: another solve would find the same."""
    return all(
        np.array_equal(one.space.breaks, other.space.breaks)
        and np.array_equal(one.points, other.points)
        for one, other in zip(grids, others, strict=True)
    )
