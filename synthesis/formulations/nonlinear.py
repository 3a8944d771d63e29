"""The third rung: limits that are not convex, added to the cone program's rows and solved locally.

The unknowns are the plan's own. Linear rows, bounds and balls stay what they are; the norm that
a size objective minimises is the objective itself. Smooth limits are written at a few points
where they are nearly used up; the answer is then measured densely, the peaks that break a limit
are added, and the program is solved again from where it stood (an exchange method).
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import casadi
import numpy as np

from synthesis.formulations.convex import Plan
from synthesis.limits import Limit
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.solvers.ipopt import Guess, SmoothProgram, SmoothSolution, solve
from synthesis.solvers.statuses import Stopped

ROUNDS = 5
NEAR = 0.95  # rows are written where the start uses up more than this of a limit
COARSE, DENSE = 4, 16  # samples per knot interval: rows at first, measurement


@dataclass(frozen=True)
class NonlinearSolution:
    """A point in the plan's unknowns, and why the solver stopped there; its worth is measured."""

    x: Array
    stopped: Stopped
    word: str
    iterations: int
    seconds: float
    rows: int


@dataclass(frozen=True, eq=False)
class Spots:
    """Where one smooth limit is written on one stretch.

    Attributes:
        position: among the free stretches, None where the law is given.
        x: (k,) points of the stretch, 0 to 1. s: (4, k) s to s''' there at the time of writing
            [mm, per rad], all that is needed where the law is given.
    """

    limit: Limit
    stretch: Stretch
    position: int | None
    x: Array
    s: Array


def improve(
    plan: Plan, start: Array, deadline: float | None = None, tighten: float = 1e-6
) -> NonlinearSolution:
    begun = time.perf_counter()
    spots = _measured(plan, start, COARSE, NEAR)
    x, word, stopped, count, iterations = start, "no round", Stopped.OUT_OF_TIME, 0, 0
    guess = Guess(start)
    for _ in range(ROUNDS):
        left = inf if deadline is None else deadline - time.perf_counter()
        if left <= 0.0:
            stopped, word = Stopped.OUT_OF_TIME, "deadline"
            break
        program = _stated(plan, spots, guess.x, tighten)
        t = time.perf_counter()
        solution = solve(program, guess, left)
        stopped, word = solution.stopped, solution.word
        iterations += solution.iterations
        count = len(program.lower)
        more = _peaks(plan, solution.x, -0.0)
        print(
            "   round",
            word,
            solution.iterations,
            count,
            f"build {(time.perf_counter() - t) * 1e3 - solution.seconds * 1e3:.1f} solve {solution.seconds * 1e3:.1f}",
            "viol",
            max([m[1] for m in more], default=-1),
            sum(len(m[0].x) for m in more),
        )
        x = solution.x
        if not more:
            break
        spots = spots + [m[0] for m in more]
        guess = Guess(
            x, np.append(solution.rows, np.zeros(sum(len(m[0].x) for m in more))), solution.bounds
        )
    return NonlinearSolution(x, stopped, word, iterations, time.perf_counter() - begun, count)


def _curves(plan, x):
    laws, size = plan.recover(x)
    free = iter(enumerate(laws))
    for stretch in plan.problem.stretches:
        if stretch.law is None:
            position, law = next(free)
            yield stretch.with_law(law.curve()), position
        else:
            yield stretch, None


def _sampled(plan, x, each):
    _, size = plan.recover(x)
    for stretch, position in _curves(plan, x):
        curve = stretch.placed()
        step = np.linspace(0.0, 1.0, each + 1)
        left, width = curve.breaks[:-1], np.diff(curve.breaks)
        theta = left[:, None] + width[:, None] * step
        piece = np.repeat(np.arange(curve.count), each + 1)
        s = np.stack([curve.at(theta.ravel(), piece, k) for k in range(4)])
        for limit in plan.problem.limits:
            for value in limit.smooth(stretch, plan.problem.machine, list(s), size):
                yield limit, stretch, position, curve, theta, s, value.reshape(theta.shape)


def _measured(plan, x, each, near):
    found = []
    for limit, stretch, position, curve, theta, s, value in _sampled(plan, x, each):
        keep = value > -near
        if position is not None:
            keep[:-1, -1] = False
        elif curve.count == 1 and np.ptp(value) < 1e-12:
            keep[:, 1:] = False
        if keep.any():
            xs = (theta[keep] - stretch.start) / stretch.angle
            found.append(Spots(limit, stretch, position, np.clip(xs, 0, 1), s[:, keep.ravel()]))
    return found


def _peaks(plan, x, above):
    _, size = plan.recover(x)
    found = []
    for limit, stretch, position, curve, theta, s, value in _sampled(plan, x, DENSE):
        pad = np.pad(value, ((0, 0), (1, 1)), constant_values=-np.inf)
        top = (value > pad[:, :-2]) & (value >= pad[:, 2:])
        a, b, c = pad[:, :-2], value, pad[:, 2:]
        with np.errstate(all="ignore"):
            move = 0.5 * (a - c) / (a - 2 * b + c)
        move = np.where(
            np.isfinite(a) & np.isfinite(c) & np.isfinite(move), np.clip(move, -1, 1), 0
        )
        h = theta[:, 1:2] - theta[:, :1]
        at = (theta + move * h)[top]
        piece = np.nonzero(top)[0]
        ss = np.stack([curve.at(at, piece, k) for k in range(4)])
        vs = np.max(
            [v for v in limit.smooth(stretch, plan.problem.machine, list(ss), size)], axis=0
        )
        vs = np.maximum(vs, -np.inf)
        keep = vs > above
        if keep.any():
            xs = (at[keep] - stretch.start) / stretch.angle
            found.append(
                (Spots(limit, stretch, position, np.clip(xs, 0, 1), ss[:, keep]), vs.max())
            )
    return found


def _stated(plan, spots, x0, tighten):
    program = plan.program
    x = casadi.MX.sym("x", program.linear.size)
    first = program.equalities + program.inequalities
    matrix = program.matrix[:first]
    rows = [casadi.mtimes(_dm(matrix), x)]
    lower = [program.rhs[: program.equalities], np.full(program.inequalities, -inf)]
    upper = [program.rhs[:first]]
    objective = None
    low, high = np.full(program.linear.size, -inf), np.full(program.linear.size, inf)
    for ball in plan.balls:
        image = casadi.mtimes(_dm(ball.matrix), x) + ball.shift
        if ball.head is not None:
            objective = casadi.norm_2(image)
            low[ball.head] = high[ball.head] = x0[ball.head]
        else:
            v0 = float(np.sum((ball.matrix @ x0 + ball.shift) ** 2)) or 1.0
            rows.append(casadi.sumsqr(image) / v0)
            lower.append([-inf])
            upper.append([(ball.radius * (1 - ball.tighten)) ** 2 / v0])
    if objective is None:
        objective = casadi.dot(casadi.DM(program.linear), x)
        if program.quadratic.nnz:
            full = program.quadratic + program.quadratic.T
            full.setdiag(program.quadratic.diagonal())
            objective += 0.5 * casadi.bilin(_dm(full), x, x)
    z = casadi.vertsplit(x[plan.size] * plan.scales.size)
    for spot in spots:
        s = _moved(plan, spot, x)
        for value in spot.limit.smooth(spot.stretch, plan.problem.machine, s, z):
            rows.append(value)
            lower.append(np.full(len(spot.x), -inf))
            upper.append(np.full(len(spot.x), -tighten))
    return SmoothProgram(
        x, objective, casadi.vertcat(*rows), np.concatenate(lower), np.concatenate(upper), low, high
    )


def _moved(plan, spot, x):
    if spot.position is None:
        return [casadi.DM(row) for row in spot.s]
    grid, known, columns = (
        plan.grids[spot.position],
        plan.settled[spot.position],
        plan.columns[spot.position],
    )
    out = []
    for k in range(4):
        unit = spot.stretch.lift / spot.stretch.angle**k
        inner, fixed = known.split(unit * grid.space.basis(spot.x, k))
        fixed = fixed + (spot.stretch.s_start if k == 0 else 0.0)
        out.append(casadi.mtimes(_dm(inner), x[columns]) + fixed)
    return out


def _dm(m):
    from scipy import sparse

    return casadi.DM(sparse.csc_matrix(m))
