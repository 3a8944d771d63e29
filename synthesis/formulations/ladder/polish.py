"""Knots moved onto the steps of the best law, where a tolerance asks for its last digits.

The highest derivative of the best law is often constant but for steps: ±cap, 0, or what a quadratic
objective leaves. Of a spline it is constant between knots; where a step falls between two of them
that interval has a value in between, and the share of either level says where the step is. With
knots there the spline is the best law itself, and the bound gets its best multipliers.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

import numpy as np

from synthesis.formulations.bounds.sharper import sharper
from synthesis.formulations.cams.candidate import Candidate
from synthesis.formulations.question.grid import Grid, merged, over, uniform
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array

FINEST: Final = 1e-4  # tolerance from which on this is worth its time
BESIDE: Final = 48  # equal intervals between the steps
ROUNDS: Final = 6
STAYS: Final = 1e-9  # of the segment: a step that moves less has been found
STEP: Final = 0.02  # of the derivative's range: less is no step
LEAST: Final = 5  # intervals

Solve = Callable[[Search, int], Candidate | None]


def polish(state: Search, solve: Solve) -> None:
    """More cone programs, each with its knots on the steps of the law before.

    Args:
        state: a search that has climbed and is not yet within its tolerance.
        solve: one cone program on ``state.grids``, offered to the state; the number is for the
            report.
    """
    found, free = state.relaxed, state.problem.free
    if state.tolerance > FINEST or found is None or not free:
        return
    if state.close(found) and state.wide:
        return
    if state.problem.curved or state.problem.objective.fractional:
        return
    _move(state, found, solve)
    _sharpen(state)


def _sharpen(state: Search) -> None:
    """The best multipliers for the rows of the last program."""
    if state.program is None or state.left() <= 0.0 or state.close(state.relaxed):
        return
    started = time.perf_counter()
    plan, solution, lower = state.program
    found = sharper(plan, solution, lower, lambda each: state.enough(each.value), state.left())
    if found is lower:
        return
    state.learn(found)
    state.stages.append(
        Stage(
            "multipliers", "SOCP, points and densities", "Clarabel", 0, 0, 0,
            time.perf_counter() - started, "solved", "the best for the bound over all motion laws",
        )
    )  # fmt: skip


def _move(state: Search, first: Candidate, solve: Solve) -> None:
    """Knots on the steps of the law, until these stay where they are."""
    free, found = state.problem.free, first
    before: list[Array] = []
    for number in range(len(state.stages) + 1, len(state.stages) + 1 + ROUNDS):
        steps = [_steps(law.space.breaks, law.curve().poly[:, -1]) for law in found.laws]
        if not any(len(each) for each in steps) or _alike(steps, before) or state.left() <= 0.0:
            return
        state.grids = tuple(_through(s, x) for s, x in zip(free, steps, strict=True))
        before = steps
        latest = solve(state, number)
        if latest is None or (state.close(state.relaxed) and state.wide):
            return
        found = latest


def _through(stretch: Stretch, steps: Array) -> Grid:
    """Equal intervals, and knots at the steps."""
    assert stretch.free is not None
    needed = stretch.free.knots
    plain = uniform(stretch, BESIDE).space.breaks
    return over(stretch, merged(plain, steps, needed))


def _alike(steps: list[Array], before: list[Array]) -> bool:
    """Whether no step has moved."""
    return len(steps) == len(before) and all(
        len(now) == len(then) and bool(np.all(np.abs(now - then) <= STAYS))
        for now, then in zip(steps, before, strict=True)
    )


def _steps(breaks: Array, level: Array) -> Array:
    """Where a derivative that is constant between breaks steps from one level to another.

    A step spread over neighbouring intervals is put where it leaves the derivative's integral as it
    is; an interval to either side counts as touched, the level beyond is that of the side.
    """
    spread = float(np.ptp(level))
    large = np.flatnonzero(np.abs(np.diff(level)) > STEP * spread)
    if len(level) < LEAST or len(large) == 0 or spread <= 0.0:
        return np.zeros(0)
    found, widths = [], np.diff(breaks)
    for group in np.split(large, np.flatnonzero(np.diff(large) > 1) + 1):
        first, last = int(group[0]), int(group[-1]) + 1  # intervals of the step itself
        before, after = level[max(first - 1, 0)], level[min(last + 1, len(level) - 1)]
        if abs(before - after) <= STEP * spread:
            continue
        touched = slice(first, last + 1)
        share = (level[touched] - after) / (before - after)
        at = breaks[first] + float(share @ widths[touched])
        found.append(min(max(at, float(breaks[first])), float(breaks[last + 1])))
    inner = np.array(found)
    return np.unique(inner[(inner > 0.0) & (inner < 1.0)])
