"""The third rung: limits that are not convex join the cone program's rows, and IPOPT solves it.

The unknowns are the model's own, and its linear rows and balls stay what they are; where a norm of
the size is the objective, it is minimised itself. Smooth limits are written at points spread over
the turn. The answer is measured densely, the peaks that break a limit are written too, and the
program is solved again from where it stood, until no peak is left: an exchange method.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from synthesis.catalogue.constraints import enlarged
from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.ipopt import StartingPoint, solve
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.heuristics.nonlinear_program import NonlinearModel, whole
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.constraint_samples import (
    ConstraintSamples,
    add_violated,
    initial_samples,
)
from synthesis.optimise.recovery.smooth_limits import peaks, sample, violation

ROUNDS = 6


@dataclass(frozen=True, eq=False)
class NonlinearSolution:
    """A point in the model's unknowns, and why the solver stopped there; its worth is not known.

    Attributes:
        x: the last point that IPOPT called a solution; the start where it called none so.
        rows: of the last program. seconds: all rounds together.
        spots: where smooth limits were written. guess: the point with its multipliers, for IPOPT.
    """

    x: Array
    stopped: StopReason
    word: str
    iterations: int
    seconds: float
    rows: int
    spots: tuple[ConstraintSamples, ...]
    guess: StartingPoint


def solver_tolerances(tolerance: float) -> tuple[float, float]:
    """What a relative gap asks of rows at points, and of the optimum: see ``solve_ipopt``.

    Rows drawn in by a little of what the caller allows save rounds: peaks may lie between them.
    """
    spare = float(np.clip(0.04 * tolerance, 1e-7, 1e-3))
    return spare, float(np.clip(1e-5 * tolerance, 1e-9, 1e-7))


def solve_ipopt(
    model: ConicModel,
    start: Array,
    deadline: float | None = None,
    tighten: float = 1e-6,
    accuracy: float = 1e-9,
    *,
    eased: int = 0,
    growth: float = 0.0,
) -> NonlinearSolution:
    """A local optimum under all limits, those that are not convex included.

    Args:
        model: the relaxation.
        start: a point of its unknowns, best one at which the smooth limits hold.
        deadline: ``time.monotonic()`` at which to stop.
        tighten: relative amount by which smooth limits are drawn in at the points where they are
            written; peaks between these may rise by as much, so a larger one saves rounds.
        accuracy: of the optimum, relative.
        eased: how many of the last limits give way by the level that is made small.
        growth: relative increase of the value for which limits may hold at last: where a cam that
            much larger keeps those that are exceeded between points, they get no rows there.
    """
    spots = initial_samples(*recover_problem(model, start))
    return solve_with_exchange(
        model, spots, StartingPoint(start), deadline, tighten, accuracy, eased, growth=growth
    )


def solve_with_exchange(
    model: ConicModel,
    spots: Sequence[ConstraintSamples],
    guess: StartingPoint,
    deadline: float | None,
    tighten: float,
    accuracy: float,
    eased: int = 0,
    *,
    growth: float = 0.0,
) -> NonlinearSolution:
    """The same from given spots, and multipliers where they are known."""
    began, iterations, rows = time.perf_counter(), 0, 0
    guess = StartingPoint(whole(model, guess.x), guess.rows, guess.bounds)
    stopped, word = StopReason.OUT_OF_TIME, "deadline"
    for _ in range(ROUNDS):
        left = inf if deadline is None else deadline - clock.now()
        if left <= 0.0:
            stopped, word = StopReason.OUT_OF_TIME, "deadline"
            break
        program = NonlinearModel(model, guess.x, eased).stated(spots, tighten)
        found = solve(program, guess, left, accuracy)
        stopped, word, rows = found.stopped, found.word, len(program.lower)
        iterations += found.iterations
        if stopped not in USABLE:
            break
        given = float(found.x[model.epigraph]) if eased else 0.0
        here = recover_problem(model, found.x)
        more = add_violated(*here, eased, given)
        spots, guess = [*spots, *more], StartingPoint(found.x, found.rows, found.bounds)
        if not more or (growth > 0.0 and _mends(*here, growth)):
            break
    seconds = time.perf_counter() - began
    return NonlinearSolution(
        with_norm(model, guess.x), stopped, word, iterations, seconds, rows, tuple(spots), guess
    )


def _mends(problem: Problem, size: tuple[float, ...], growth: float) -> bool:
    """Whether limits that are broken a little hold on a cam that is larger by no more than that."""
    if problem.objective.norm(problem.machine) is None:
        return False  # what growing costs is not known
    follower = problem.machine.follower
    step = growth * follower.radius_norm().value(size)
    larger = enlarged(size, min(step, problem.room(size)))
    samples = sample(problem)
    samples += peaks(problem, samples, larger)
    return violation(problem, samples, larger) < 0.0


def recover_problem(model: ConicModel, x: Array) -> tuple[Problem, tuple[float, ...]]:
    """The problem with the laws of this point, and its size."""
    laws, size = model.recover(x)
    free = model.problem.free
    placed = [s.with_law(law.curve()) for s, law in zip(free, laws, strict=True)]
    return model.problem.with_laws(placed), size


def with_norm(model: ConicModel, x: Array) -> Array:
    """The point with the objective's norm, which IPOPT does not know as an unknown."""
    x = x[: model.program.matrix.shape[1]].copy()
    for ball in model.cone_blocks:
        if ball.bound_column is not None:
            x[ball.bound_column] = float(np.linalg.norm(ball.matrix @ x + ball.shift)) - ball.radius
    return x
