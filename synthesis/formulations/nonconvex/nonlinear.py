"""The third rung: limits that are not convex join the cone program's rows, and IPOPT solves it.

The unknowns are the plan's own, and its linear rows and balls stay what they are; where a norm of
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

from synthesis import clock
from synthesis.formulations.cams.smooth import peaks, sample, violation
from synthesis.formulations.cams.spots import Spots, broken, spread
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.nonconvex.statement import Statement, whole
from synthesis.formulations.question.problem import Problem
from synthesis.numerics.piecewise import Array
from synthesis.solvers.ipopt import Guess, solve
from synthesis.solvers.statuses import USABLE, Stopped

ROUNDS = 6


@dataclass(frozen=True, eq=False)
class NonlinearSolution:
    """A point in the plan's unknowns, and why the solver stopped there; its worth is not known.

    Attributes:
        x: the last point that IPOPT called a solution; the start where it called none so.
        rows: of the last program. seconds: all rounds together.
        spots: where smooth limits were written. guess: the point with its multipliers, for IPOPT.
    """

    x: Array
    stopped: Stopped
    word: str
    iterations: int
    seconds: float
    rows: int
    spots: tuple[Spots, ...]
    guess: Guess


def accuracies(tolerance: float) -> tuple[float, float]:
    """What a relative gap asks of rows at points, and of the optimum: see ``improve``.

    Rows drawn in by a little of what the caller allows save rounds: peaks may lie between them.
    """
    spare = float(np.clip(0.04 * tolerance, 1e-7, 1e-3))
    return spare, float(np.clip(1e-5 * tolerance, 1e-9, 1e-7))


def improve(
    plan: Plan,
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
        plan: the relaxation.
        start: a point of its unknowns, best one at which the smooth limits hold.
        deadline: ``time.monotonic()`` at which to stop.
        tighten: relative amount by which smooth limits are drawn in at the points where they are
            written; peaks between these may rise by as much, so a larger one saves rounds.
        accuracy: of the optimum, relative.
        eased: how many of the last limits give way by the level that is made small.
        growth: relative increase of the value for which limits may hold at last: where a cam that
            much larger keeps those that are exceeded between points, they get no rows there.
    """
    spots = spread(*settled(plan, start))
    return exchanged(plan, spots, Guess(start), deadline, tighten, accuracy, eased, growth=growth)


def exchanged(
    plan: Plan,
    spots: Sequence[Spots],
    guess: Guess,
    deadline: float | None,
    tighten: float,
    accuracy: float,
    eased: int = 0,
    *,
    growth: float = 0.0,
) -> NonlinearSolution:
    """The same from given spots, and multipliers where they are known."""
    began, iterations, rows = time.perf_counter(), 0, 0
    guess = Guess(whole(plan, guess.x), guess.rows, guess.bounds)
    stopped, word = Stopped.OUT_OF_TIME, "deadline"
    for _ in range(ROUNDS):
        left = inf if deadline is None else deadline - clock.now()
        if left <= 0.0:
            stopped, word = Stopped.OUT_OF_TIME, "deadline"
            break
        program = Statement(plan, guess.x, eased).stated(spots, tighten)
        found = solve(program, guess, left, accuracy)
        stopped, word, rows = found.stopped, found.word, len(program.lower)
        iterations += found.iterations
        if stopped not in USABLE:
            break
        given = float(found.x[plan.extra]) if eased else 0.0
        here = settled(plan, found.x)
        more = broken(*here, eased, given)
        spots, guess = [*spots, *more], Guess(found.x, found.rows, found.bounds)
        if not more or (growth > 0.0 and _mends(*here, growth)):
            break
    seconds = time.perf_counter() - began
    return NonlinearSolution(
        with_norm(plan, guess.x), stopped, word, iterations, seconds, rows, tuple(spots), guess
    )


def _mends(problem: Problem, size: tuple[float, ...], growth: float) -> bool:
    """Whether limits that are broken a little hold on a cam that is larger by no more than that."""
    if problem.objective.norm(problem.machine) is None:
        return False  # what growing costs is not known
    follower = problem.machine.follower
    step = growth * follower.prime_radius().value(size)
    larger = follower.raised(size, min(step, problem.room(size)))
    samples = sample(problem)
    samples += peaks(problem, samples, larger)
    return violation(problem, samples, larger) < 0.0


def settled(plan: Plan, x: Array) -> tuple[Problem, tuple[float, ...]]:
    """The problem with the laws of this point, and its size."""
    laws, size = plan.recover(x)
    free = plan.problem.free
    placed = [s.with_law(law.curve()) for s, law in zip(free, laws, strict=True)]
    return plan.problem.settled(placed), size


def with_norm(plan: Plan, x: Array) -> Array:
    """The point with the objective's norm, which IPOPT does not know as an unknown."""
    x = x[: plan.program.matrix.shape[1]].copy()
    for ball in plan.balls:
        if ball.head is not None:
            x[ball.head] = float(np.linalg.norm(ball.matrix @ x + ball.shift)) - ball.radius
    return x
