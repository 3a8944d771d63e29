"""The last digits: knots on the switches of the best law, and the best multipliers for the bound.

A law's highest derivative is often constant but for steps: ±cap, 0, or what a quadratic objective
leaves. A spline's is constant between knots; where a step falls between two of them, that interval
has a value in between, and its share of either level says where the step is. With knots there the
spline is the best law itself, and the bound gets its best multipliers.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array
from synthesis.optimise.dual_bound.dual_ascent import improve_multipliers
from synthesis.optimise.problem.boundary import boundary_states
from synthesis.optimise.problem.derivative_caps import control_order
from synthesis.optimise.problem.grid import (
    CLOSEST_KNOTS,
    RAMP_STEP,
    Grid,
    SplineLaw,
    count_intervals,
    grid_through,
    merge_knots,
    uniform_grid,
)
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.refinement.mesh import end_steps, nearly_equal
from synthesis.optimise.state import SolveState, Stage

COARSEST_POLISH: Final = 1e-4
"""Tolerance: with this one or a finer one knots are moved in any case, with a coarser one where the
mesh leaves most of the gap."""
POLISH_INTERVALS: Final = (48, 432)
"""Equal ones between the switches, at least and at most: along arcs where a limit binds, a law on
48 of them costs some 1e-5 more than the best, which falls with the square of their number."""
POLISH_INTERVALS_AT_UNIT_TOLERANCE: Final = 0.4  # by the same square: over the root of a tolerance
POLISH_ITERATIONS: Final = 8  # of moving knots to switches, and of making ramps shorter
SHORTER: Final = 0.25  # from one length of the ramps to the next
MOST_IDLE: Final = 1  # of these iterations in turn that give no better cam, before the last
LITTLE: Final = 0.1  # of the tolerance: a cam that gains less is the best as far as is asked
STAYS: Final = 1e-9  # share of a segment: a switch that moves by less has been located
STEP: Final = 0.02  # share of the derivative's range: less is no switch
FEWEST_INTERVALS: Final = 5  # a law of fewer is left alone

Switches = Sequence[Array]  # of every law, shares of its segment
SolveOnce = Callable[[SolveState, int], tuple[SolveState, Candidate | None]]


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
    state, switches = _move_knots(state, cam, solve_once)
    enough = state.suffices or state.cam_only
    return state if enough else _improve_multipliers(state, switches, solve_once)


def _move_knots(
    state: SolveState, cam: Candidate, solve_once: SolveOnce
) -> tuple[SolveState, Switches]:
    """Move knots onto the switches of the law until these stay where they are.

    A step that stays spread over both intervals beside its knot gets two: the ends of a short arc.
    Then the ramps of smoother laws are made shorter, as long as the cam gains by it. Knots say
    which splines are tried, and which multipliers come of them; any multipliers bound all laws
    (weak duality), so no mesh makes a bound false.

    Returns:
        the state, and the switches of the last laws.
    """
    order = control_order(state.problem)
    has_ramps = any(law.space.degree > order for law in cam.laws)
    switches = found = _switches_of_laws(cam, order)
    before: Switches = ()
    ramp_step, shorten, idle = RAMP_STEP, False, 0
    for _ in range(POLISH_ITERATIONS):
        shorten = shorten or nearly_equal(switches, before, STAYS)
        if not switches or (shorten and not has_ramps) or state.time_left <= 0.0:
            break
        # 1. The best law with knots on the switches, and where that law switches itself.
        ramp_step *= SHORTER if shorten else 1.0
        intervals = polish_intervals(state.tolerance)
        grids = _through_switches(state.problem, switches, intervals, order, ramp_step)
        state, latest = solve_once(replace(state, grids=grids), len(state.stages) + 1)
        if latest is None:
            break
        if state.suffices or (state.is_close(state.relaxed) and state.covers_all_laws):
            break
        found_before, found = found, _switches_of_laws(latest, order, switches)
        # 2. Go on while the cam gains. One that does not may have knots beyond its switches, on
        #    the other side than those before: the next ones lie between.
        tolerance = state.problem_tolerance(latest.value)
        gained = cam.value - latest.value > LITTLE * tolerance * latest.value
        idle = 0 if gained else idle + 1
        cam = latest if gained else cam
        if idle > MOST_IDLE:
            if shorten or not has_ramps:
                break  # what is left of the gap is the bound's
            shorten = True
        switches, before = _extrapolate(before, found_before, switches, found), switches
    return state, found


def _extrapolate(
    before: Switches, found_before: Switches, on_knots: Switches, found: Switches
) -> Switches:
    """The next places of knots: fixed points by the secant of two iterations, switch by switch.

    An iteration f takes knots x to the switches f(x) that are found with them. Only where knots lie
    on either side of a switch in turn is its fixed point taken, which lies between; else what is
    found last.
    """
    if not [*map(len, before)] == [*map(len, on_knots)] == [*map(len, found)]:
        return found
    result = list[Array]()
    for x, f_of_x, y, f_of_y in zip(before, found_before, on_knots, found, strict=True):
        moved = np.abs(y - x) > STAYS
        slope = np.divide(f_of_y - f_of_x, y - x, out=np.zeros(len(y)), where=moved)
        slope = np.minimum(slope, 0.0)
        result.append((f_of_y - slope * y) / (1.0 - slope))
    return result


def _improve_multipliers(
    state: SolveState, switches: Switches, solve_once: SolveOnce
) -> SolveState:
    """Raise the bound by the best multipliers of the last program's rows.

    The bound needs fewer knots than the law: a program on the fewest comes first.
    """
    if state.relaxation is None or state.time_left <= 0.0 or state.is_close(state.relaxed):
        return state
    (fewest, _), (model, _, _), problem = POLISH_INTERVALS, state.relaxation, state.problem
    grids = _through_switches(problem, switches, fewest, control_order(problem))
    if not grids or count_intervals(model.grids) <= count_intervals(grids):
        return _with_best_multipliers(state)
    coarse, _ = solve_once(replace(state, grids=grids), len(state.stages) + 1)
    if coarse.relaxation is state.relaxation:  # no law fits on these: too many knots are left
        return state
    return replace(_with_best_multipliers(coarse), grids=state.grids, relaxation=state.relaxation)


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


def polish_intervals(tolerance: float) -> int:
    """Equal intervals between the switches of a law that is to be the best within a tolerance."""
    least, most = POLISH_INTERVALS
    return int(min(max(POLISH_INTERVALS_AT_UNIT_TOLERANCE / sqrt(tolerance), least), most))


def grids_on_switches(problem: Problem, cam: Candidate, intervals: int) -> tuple[Grid, ...]:
    """Equal intervals, and knots where the highest derivative of a cam's laws steps.

    Nothing where no law has a step.
    """
    order = control_order(problem)
    return _through_switches(problem, _switches_of_laws(cam, order), intervals, order)


def _through_switches(
    problem: Problem, switches: Switches, intervals: int, order: int, ramp_step: float = RAMP_STEP
) -> tuple[Grid, ...]:
    """Equal intervals, and knots on the switches; nothing where there are none."""
    if not switches:
        return ()
    equal = tuple(uniform_grid(segment, intervals) for segment in problem.free)
    states, _ = boundary_states(problem.segments, equal)
    grids = list[Grid]()
    for segment, grid, state, x in zip(problem.free, equal, states, switches, strict=True):
        assert segment.free is not None
        softer = max(segment.free.smoothness + 1 - order, 0)
        steps = end_steps(segment.free, state, softer, ramp_step)
        breaks = merge_knots(grid.space.breaks, x, segment.free.knots, (), softer, steps, ramp_step)
        grids.append(grid_through(segment, breaks))
    return tuple(grids)


def _switches_of_laws(cam: Candidate, order: int, before: Switches = ()) -> Switches:
    """The switches of every law's control, a derivative; nothing where none has one.

    ``before``: the switches on which knots of these laws lie, by law.
    """
    known = before or [np.zeros(0)] * len(cam.laws)
    switches = [
        _locate_switches(law.space.breaks, _control_means(law, order), on_knots)
        for law, on_knots in zip(cam.laws, known, strict=True)
    ]
    return switches if any(len(each) for each in switches) else ()


def _control_means(law: SplineLaw, order: int) -> Array:
    """The mean over every interval of the derivative that switches.

    Of a law that is smoother it does so in ramps.
    """
    curve, breaks = law.curve(), law.space.breaks
    if law.space.degree <= order:
        return np.asarray(curve.poly[:, -1])  # but for a factor
    return np.asarray(np.diff(curve(breaks, order=order - 1)) / np.diff(breaks))


def _locate_switches(breaks: Array, level: Array, before: Array) -> Array:
    """Where a derivative that is constant between breaks steps from one level to another.

    A step that is spread over neighbouring intervals is put where it leaves the derivative's
    integral as it is. A short arc may lie within a step, and takes two: ``_ends_of_arc``.

    Args:
        breaks, level: the ends of the intervals, shares of the segment, and the derivative there.
        before: breaks that are known as switches.
    """
    # The ramps at both ends are no switches: the law begins and ends there.
    inside = np.flatnonzero(np.diff(breaks) > CLOSEST_KNOTS)
    one, other = (inside[0], inside[-1] + 1) if len(inside) else (0, 0)
    breaks, level = breaks[one : other + 1], level[one:other]
    if len(level) < FEWEST_INTERVALS:
        return np.zeros(0)
    least, places = STEP * float(np.ptp(level)), list[float]()
    large = np.flatnonzero(np.abs(np.diff(level)) > least)
    for group in np.split(large, np.flatnonzero(np.diff(large) > 1) + 1) if len(large) else ():
        # The intervals that the step is spread over; it leads from the level of the interval
        # before these to that of the one behind them.
        first, last = int(group[0]), int(group[-1]) + 2
        start, end = float(level[max(first - 1, 0)]), float(level[min(last, len(level) - 1)])
        around, levels = breaks[first : last + 1], level[first:last]
        distances = np.abs(before[:, None] - around[1:-1])
        known = 1 + np.flatnonzero(np.any(distances <= STAYS, axis=0))
        found = _ends_of_arc(around, levels, (start, end), known, least)
        if not found and abs(start - end) > least:
            found = [float(around[0] + (levels - end) / (start - end) @ np.diff(around))]
        places += np.clip(found, around[0], around[-1]).tolist()
    inner = np.array(places)
    return np.unique(inner[(inner > 0.0) & (inner < 1.0)])


def _ends_of_arc(
    breaks: Array, levels: Array, outside: tuple[float, float], known: NDArray[np.intp],
    least: float,
) -> list[float]:  # fmt: skip
    """Both ends of a short arc within a step; empty where there is none.

    A step from one cap to the other has one where it stays spread over both intervals beside its
    knot: a lower derivative is at its cap, or a limit on it binds, and the derivative is next to 0.
    So has a derivative that leaves a cap and comes back to it, at a level that is not known.

    Args:
        breaks, levels: of the intervals of the step. outside: the levels before and behind.
        known: breaks that are known as switches. least: a smaller change of the level is none.
    """
    (start, end), widths = outside, np.diff(breaks)
    comes_back, has_ends = abs(start - end) <= least, len(known) > 1
    if min(abs(start), abs(end)) <= least or (start * end > 0.0 and not comes_back):
        return []
    if comes_back and not has_ends:
        # As wide as if it were 0, about the middle by moments of what the integral lacks.
        share = (1.0 - levels / start) * widths
        width = float(np.sum(share))
        middle = float(share @ (0.5 * (breaks[1:] + breaks[:-1]))) / width if width else 0.0
        return [middle - 0.5 * width, middle + 0.5 * width] if width > 0.0 else []
    if not len(known):
        return []
    left, right = int(known[0]), int(known[-1])
    if not has_ends and min(abs(levels[left - 1] - start), abs(levels[right] - end)) <= least:
        return []  # the switch is not where the knot is
    level = float(np.mean(levels[left:right])) if comes_back else 0.0
    if abs(level - start) <= least:
        return []  # between the knots the derivative is at its cap
    # The integral stays as it is on either side: an interval outside both knots, whose level lies
    # between that outside and the arc's, makes the arc wider by that share of its width; what those
    # between the knots differ from the arc's level makes it narrower.
    before = (levels[:left] - start) / (level - start) @ widths[:left]
    behind = (levels[right:] - end) / (level - end) @ widths[right:]
    excess = float((levels[left:right] - level) @ widths[left:right])
    return [
        float(breaks[left] - before + max(excess / (start - level), 0.0)),
        float(breaks[right] + behind - max(excess / (end - level), 0.0)),
    ]
