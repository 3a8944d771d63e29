"""Where the next round's knots and points go: where the law pays more than the ideal one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.optimise.dual_bound.bound import Bound
from synthesis.optimise.problem.grid import (
    CLOSEST_KNOTS,
    Grid,
    grid_through,
    merge_knots,
    ramp_knots,
)
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate

MOST_INTERVALS = 240


def add_midpoints(grids: tuple[Grid, ...]) -> tuple[Grid, ...]:
    """More points on the same knots: finer knots are another family, with another bound."""
    return tuple(grid.with_points(0.5 * (grid.points[1:] + grid.points[:-1])) for grid in grids)


def refine_mesh(
    problem: Problem,
    grids: tuple[Grid, ...],
    found: Candidate | None,
    lower: Bound | None,
    missed: Sequence[Array],
) -> tuple[Grid, ...]:
    """Finer knots where the law pays more than the ideal one; points where rows were missed."""
    chosen = []
    for position, (segment, grid) in enumerate(zip(problem.free, grids, strict=True)):
        assert segment.free is not None
        breaks = grid.space.breaks
        if found is None or lower is None or not lower.switching:
            breaks = _halved(breaks, np.full(len(breaks) - 1, True))
        else:
            softer = segment.free.smoothness + 1 - lower.order
            curve = found.laws[position].curve()
            needed = segment.free.knots
            breaks = _where_it_pays(breaks, curve, lower, position, softer, needed)
        if len(breaks) > MOST_INTERVALS:
            breaks = grid.space.breaks
        chosen.append(grid_through(segment, breaks).with_points(missed[position]))
    if all(_alike(new, grid) for new, grid in zip(chosen, grids, strict=True)):
        return halve_intervals(problem, grids, missed)
    return tuple(chosen)


def _alike(new: Grid, grid: Grid) -> bool:
    """Whether new knots are no other than the present ones."""
    breaks, present = new.space.breaks, grid.space.breaks
    return len(breaks) == len(present) and bool(np.all(abs(breaks - present) <= CLOSEST_KNOTS))


def halve_intervals(
    problem: Problem, grids: tuple[Grid, ...], missed: Sequence[Array]
) -> tuple[Grid, ...]:
    """No interval stands out, so what is left is the bound's: its multipliers lie too far apart."""
    chosen = []
    for segment, grid, more in zip(problem.free, grids, missed, strict=True):
        breaks = grid.space.breaks
        if len(breaks) <= MOST_INTERVALS:
            breaks = _halved(breaks, np.full(len(breaks) - 1, True))
        chosen.append(grid_through(segment, breaks).with_points(more))
    return tuple(chosen)


def _where_it_pays(
    breaks: Array,
    curve: Piecewise,
    lower: Bound,
    position: int,
    softer: int,
    needed: Sequence[float],
) -> Array:
    """Knots at the ideal law's switches inside the dear intervals; those without one are halved.

    Those that are ``needed`` stay.
    """
    psi, control = lower.switching[position], lower.controls[position]
    losses = psi.losses(breaks, lambda x: curve(x, control.order), control.cap, control.weight)
    dear = losses > 0.05 * np.sum(losses) / len(losses)
    switches = np.zeros(0) if control.weight else psi.sign_changes()
    inside = np.clip(np.searchsorted(breaks, switches, "right") - 1, 0, len(dear) - 1)
    counts = np.bincount(inside, minlength=len(dear))
    single = dear & (counts == 1)
    halved = _halved(breaks, dear & ~single)
    wanted = np.concatenate([_beside(needed), ramp_knots(switches[single[inside]], softer)])
    return merge_knots(halved, wanted, needed)


def _beside(needed: Sequence[float]) -> Array:
    """As close as knots may lie: where a window ends, even an ideal law has much to settle."""
    step = 1.01 * CLOSEST_KNOTS
    return np.concatenate([np.array(needed) - step, np.array(needed) + step])


def _halved(breaks: Array, chosen: NDArray[np.bool_]) -> Array:
    """The breaks with the chosen intervals cut in two."""
    middle = 0.5 * (breaks[:-1] + breaks[1:])
    return np.union1d(breaks, middle[chosen & (np.diff(breaks) > 2.0 * CLOSEST_KNOTS)])
