"""The next mesh: knots where the law costs more than the ideal one, points where rows are violated.

Where a tolerance asks for its last digits, or meshes leave more than it, knots are moved onto the
switches of the best law (``polish_knots``). Its highest derivative is often constant but for steps:
±cap, 0, or what a quadratic objective leaves. A spline's is constant between knots; where a step
falls between two of them, that interval has a value in between, and its share of either level says
where the step is.
With knots there the spline is the best law itself, and the bound gets its best multipliers.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import inf, sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.motion import FreeLaw
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.optimise.dual_bound.bound import Bound
from synthesis.optimise.dual_bound.dual_ascent import improve_multipliers
from synthesis.optimise.problem.boundary import BoundaryState, boundary_states
from synthesis.optimise.problem.derivative_caps import control_order
from synthesis.optimise.problem.grid import (
    CLOSEST_KNOTS,
    RAMP_STEP,
    Grid,
    SplineLaw,
    beside_step,
    grid_through,
    merge_knots,
    uniform_grid,
)
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.state import SolveState, Stage

MOST_INTERVALS: Final = 480  # of a law: a cone program of twice as many takes seconds
COSTLY: Final = 0.05  # of the mean loss of all laws: intervals that lose more get knots
COARSEST_POLISH: Final = 1e-4
"""Tolerance: with this one or a finer one knots are moved in any case, with a coarser one where the
mesh leaves most of the gap."""
POLISH_INTERVALS: Final = (48, 432)
"""Equal ones between the switches, at least and at most: along arcs where a limit binds, a law on
48 of them costs some 1e-5 more than the best, which falls with the square of their number."""
POLISH_INTERVALS_AT_UNIT_TOLERANCE: Final = 0.4  # by the same square: over the root of a tolerance
POLISH_ITERATIONS: Final = 8  # of moving knots to switches, and of making ramps shorter
SHORTER: Final = 0.25  # from one length of the ramps to the next
LITTLE: Final = 0.1  # of the tolerance: a cam that gains less is the best as far as is asked
STAYS: Final = 1e-9  # share of a segment: a switch that moves by less has been located
STEP: Final = 0.02  # share of the derivative's range: less is no switch
FEWEST_INTERVALS: Final = 5  # a law of fewer is left alone

SolveOnce = Callable[[SolveState, int], tuple[SolveState, Candidate | None]]


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
    if _nearly_equal(chosen, [grid.space.breaks for grid in grids], CLOSEST_KNOTS):
        return halve_intervals(problem, grids, violated_points)
    return _mesh_through(problem, chosen, violated_points)


def halve_intervals(
    problem: Problem, grids: tuple[Grid, ...], violated_points: Sequence[Array] = ()
) -> tuple[Grid, ...]:
    """Finer knots everywhere: all intervals cut in two, where none loses more than the others.

    The gap is then the bound's: the points at which it has multipliers lie too far apart.
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
    steps = _end_steps(free, state, softer)
    # A law that is less smooth than it has to be switches at once, on knots that cost it nothing.
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


def polish_knots(state: SolveState, solve_once: SolveOnce) -> SolveState:
    """Solve cone programs by ``solve_once``, each with knots on the switches of the law before."""
    cam = state.relaxed
    if cam is None or not state.problem.free:
        return state
    unfit = state.problem.has_curved_limits or state.problem.objective.quasiconvex
    if state.tolerance > COARSEST_POLISH:
        # Only where the mesh leaves more of the gap than limits outside the relaxation do.
        best = state.incumbent
        unfit |= best is None or best.value - cam.value > cam.value - state.lower
        unfit |= state.cam_only
    if unfit or (state.is_close(cam) and state.covers_all_laws):
        return state
    state = _move_knots(state, cam, solve_once)
    enough = state.suffices or state.cam_only
    return state if enough else _improve_multipliers(state, solve_once)


def _improve_multipliers(state: SolveState, solve_once: SolveOnce) -> SolveState:
    """Raise the bound by the best multipliers of the last program's rows.

    The bound needs fewer knots than the law: a program on the fewest comes first.
    """
    if state.relaxation is None or state.time_left <= 0.0 or state.is_close(state.relaxed):
        return state
    cam, (fewest, _), (model, _, _) = state.relaxed, POLISH_INTERVALS, state.relaxation
    grids = () if cam is None else grids_on_switches(state.problem, cam, fewest)
    if not grids or count_intervals(model.grids) <= count_intervals(grids):
        return _with_best_multipliers(state)
    coarse, _ = solve_once(replace(state, grids=grids), len(state.stages) + 1)
    if coarse.relaxation is state.relaxation:  # no law fits on these: too many knots are left
        return state
    return replace(_with_best_multipliers(coarse), grids=state.grids, relaxation=state.relaxation)


def count_intervals(grids: Sequence[Grid]) -> int:
    """Intervals of all laws."""
    return sum(len(grid.space.breaks) - 1 for grid in grids)


def _with_best_multipliers(state: SolveState) -> SolveState:
    if state.relaxation is None:
        return state
    started = time.perf_counter()
    model, solution, lower = state.relaxation
    better = improve_multipliers(
        model, solution, lower, lambda each: state.would_close(each.value), state.time_left
    )
    if better is lower:
        return state
    return state.with_bound(better).with_stage(
        Stage(
            "multipliers", "SOCP, points and densities", "Clarabel", 0, 0, 0,
            time.perf_counter() - started, "solved", "the best for the bound over all motion laws",
        )
    )  # fmt: skip


def _move_knots(state: SolveState, cam: Candidate, solve_once: SolveOnce) -> SolveState:
    """Move knots onto the switches of the law until these stay where they are.

    Then the ramps of smoother laws are made shorter, as long as the cam gains by it. Knots say
    which splines are tried, and which multipliers come of them; any multipliers bound all laws
    (weak duality), so no mesh makes a bound false.
    """
    order = control_order(state.problem)
    has_ramps = any(law.space.degree > order for law in cam.laws)
    before, ramp_step, shorten = list[Array](), RAMP_STEP, False
    for _ in range(POLISH_ITERATIONS):
        switches = _switches_of_laws(cam, order)
        shorten = shorten or _nearly_equal(switches, before, STAYS)
        if not switches or (shorten and not has_ramps) or state.time_left <= 0.0:
            break
        ramp_step *= SHORTER if shorten else 1.0
        intervals = polish_intervals(state.tolerance)
        grids = _through_switches(state.problem, switches, intervals, order, ramp_step)
        state, before = replace(state, grids=grids), switches
        state, latest = solve_once(state, len(state.stages) + 1)
        if latest is None or (state.is_close(state.relaxed) and state.covers_all_laws):
            break
        gained = cam.value - latest.value > LITTLE * state.tolerance * latest.value
        if state.suffices or not (gained or (has_ramps and not shorten)):
            break  # what is left of the gap is the bound's
        shorten = shorten or not gained
        cam = latest if gained else cam
    return state


def polish_intervals(tolerance: float) -> int:
    """Equal intervals between the switches of a law that is to be the best within a tolerance."""
    least, most = POLISH_INTERVALS
    return int(min(max(POLISH_INTERVALS_AT_UNIT_TOLERANCE / sqrt(tolerance), least), most))


def grids_on_switches(problem: Problem, cam: Candidate, intervals: int) -> tuple[Grid, ...]:
    """Equal intervals, and knots where the highest derivative of a cam's laws steps.

    Nothing where no law has a step.
    """
    order = control_order(problem)
    switches = _switches_of_laws(cam, order)
    return _through_switches(problem, switches, intervals, order) if switches else ()


def _through_switches(
    problem: Problem,
    switches: Sequence[Array],
    intervals: int,
    order: int,
    ramp_step: float = RAMP_STEP,
) -> tuple[Grid, ...]:
    equal = tuple(uniform_grid(segment, intervals) for segment in problem.free)
    states, _ = boundary_states(problem.segments, equal)
    grids = list[Grid]()
    for segment, grid, state, x in zip(problem.free, equal, states, switches, strict=True):
        assert segment.free is not None
        softer = max(segment.free.smoothness + 1 - order, 0)
        steps = _end_steps(segment.free, state, softer, ramp_step)
        breaks = merge_knots(grid.space.breaks, x, segment.free.knots, (), softer, steps, ramp_step)
        grids.append(grid_through(segment, breaks))
    return tuple(grids)


def _end_steps(
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


def _switches_of_laws(cam: Candidate, order: int) -> list[Array]:
    """The switches of every law's control, a derivative; nothing where none has one."""
    switches = [_switches(law.space.breaks, _control_means(law, order)) for law in cam.laws]
    return switches if any(len(each) for each in switches) else []


def _control_means(law: SplineLaw, order: int) -> Array:
    """The mean over every interval of the derivative that switches.

    Of a law that is smoother it does so in ramps.
    """
    curve, breaks = law.curve(), law.space.breaks
    if law.space.degree <= order:
        return np.asarray(curve.poly[:, -1])  # but for a factor
    return np.asarray(np.diff(curve(breaks, order=order - 1)) / np.diff(breaks))


def _nearly_equal(now: Sequence[Array], before: Sequence[Array], distance: float) -> bool:
    """Whether two lists hold the same knots, none moved by more than a distance."""
    return len(now) == len(before) and all(
        len(one) == len(other) and bool(np.all(np.abs(one - other) <= distance))
        for one, other in zip(now, before, strict=True)
    )


def _switches(breaks: Array, level: Array) -> Array:
    """Where a derivative that is constant between breaks steps from one level to another.

    A step that is spread over neighbouring intervals is put where it leaves the derivative's
    integral as it is. The levels before and after are those of the next interval but one.
    """
    spread = float(np.ptp(level))
    large = np.flatnonzero(np.abs(np.diff(level)) > STEP * spread)
    if len(level) < FEWEST_INTERVALS or len(large) == 0 or spread <= 0.0:
        return np.zeros(0)
    places, widths = [], np.diff(breaks)
    for group in np.split(large, np.flatnonzero(np.diff(large) > 1) + 1):
        first, last = int(group[0]), int(group[-1]) + 1  # intervals of the step itself
        before, after = level[max(first - 1, 0)], level[min(last + 1, len(level) - 1)]
        if abs(before - after) <= STEP * spread:
            continue
        touched = slice(first, last + 1)
        share = (level[touched] - after) / (before - after)
        at = breaks[first] + float(share @ widths[touched])
        places.append(min(max(at, float(breaks[first])), float(breaks[last + 1])))
    inner = np.array(places)
    return np.unique(inner[(inner > 0.0) & (inner < 1.0)])


def is_same_mesh(grids: Sequence[Grid], others: Sequence[Grid]) -> bool:
    """Whether knots and points are the same: another solve would find the same."""
    return all(
        np.array_equal(one.space.breaks, other.space.breaks)
        and np.array_equal(one.points, other.points)
        for one, other in zip(grids, others, strict=True)
    )
