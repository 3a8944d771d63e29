"""Knots moved onto the switches of the best law, where a tolerance asks for its last digits.

The highest derivative of the best law is often constant but for steps: ±cap, 0, or what a quadratic
objective leaves. A spline's is constant between knots; where a step falls between two of them,
that interval has a value in between, and its share of either level says where the step is. With
knots there the spline is the best law itself, and the bound gets its best multipliers.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array
from synthesis.optimise.dual_bound.dual_ascent import improve_multipliers
from synthesis.optimise.problem.grid import Grid, grid_through, merge_knots, uniform_grid
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.state.solve_state import SolveState, Stage

FINEST: Final = 1e-4
"""Tolerance from which on moving the knots is worth its time."""
BESIDE: Final = 48
"""Equal intervals between the switches."""
ROUNDS: Final = 6
STAYS: Final = 1e-9
"""Share of a segment: a switch that moves by less has been found."""
STEP: Final = 0.02
"""Share of the derivative's range: less is no switch."""
FEWEST_INTERVALS: Final = 5
"""A law of fewer is left alone."""

SolveOnce = Callable[[SolveState, int], tuple[SolveState, Candidate | None]]


def polish_knots(state: SolveState, solve_once: SolveOnce) -> SolveState:
    """Solve cone programs, each with its knots on the switches of the law before.

    Args:
        state: after mesh refinement, not yet within its tolerance.
        solve_once: solves one cone program on ``state.grids``; the number is for the report.
    """
    cam = state.relaxed
    if state.tolerance > FINEST or cam is None or not state.problem.free:
        return state
    if state.is_close(cam) and state.covers_all_laws:
        return state
    if state.problem.has_curved_limits or state.problem.objective.quasiconvex:
        return state
    return _improve_multipliers(_move_knots(state, cam, solve_once))


def _improve_multipliers(state: SolveState) -> SolveState:
    """Raise the bound of the last program by the best multipliers of its rows."""
    if state.relaxation is None or state.time_left <= 0.0 or state.is_close(state.relaxed):
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
    """Move knots onto the switches of the law until these stay where they are."""
    before: list[Array] = []
    for number in range(len(state.stages) + 1, len(state.stages) + 1 + ROUNDS):
        switches = [_switches(law.space.breaks, law.curve().poly[:, -1]) for law in cam.laws]
        none_or_same = not any(len(each) for each in switches) or _alike(switches, before)
        if none_or_same or state.time_left <= 0.0:
            break
        both = zip(state.problem.free, switches, strict=True)
        state = replace(state, grids=tuple(_mesh_through(segment, x) for segment, x in both))
        before = switches
        state, latest = solve_once(state, number)
        if latest is None or (state.is_close(state.relaxed) and state.covers_all_laws):
            break
        cam = latest
    return state


def _mesh_through(segment: PlacedSegment, switches: Array) -> Grid:
    """Equal intervals, and knots at the switches."""
    assert segment.free is not None
    equal = uniform_grid(segment, BESIDE).space.breaks
    return grid_through(segment, merge_knots(equal, switches, segment.free.knots))


def _alike(now: list[Array], before: list[Array]) -> bool:
    """Whether no switch has moved."""
    return len(now) == len(before) and all(
        len(one) == len(other) and bool(np.all(np.abs(one - other) <= STAYS))
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
