"""The ladder: closed form, cone program on finer and finer knots, IPOPT; no rung without need."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf, isfinite, sqrt

import numpy as np

from synthesis.errors import SolverFailed
from synthesis.formulations.bound import Bound, bound
from synthesis.formulations.candidate import (
    Candidate, exceeded, grow, needs_size, settle, smallest, at_size,
)  # fmt: skip
from synthesis.formulations.convex import Plan, formulate
from synthesis.formulations.grid import Grid, SettledLaw, merged, over, uniform
from synthesis.formulations.problem import Problem
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution, solve
from synthesis.solvers.statuses import Stopped

ROUNDS = 6
COARSE, FINE = 12, 96  # intervals of the first grid, by tolerance
ALLOWED = 1e-9  # relative excess of a row that is solver noise: the certificate decides
USABLE = (Stopped.SOLVED, Stopped.INACCURATE)


@dataclass(frozen=True)
class Stage:
    """What one stage modelled and what it cost."""

    stage: str
    model: str
    solver: str
    unknowns: int
    rows: int
    iterations: int
    seconds: float
    status: str
    note: str = ""


@dataclass(eq=False)
class Search:
    """How far one problem has come.

    Attributes:
        best: best cam so far. relaxed: best cam of the convex relaxation.
        lower, over: best lower bound and the family that it covers.
        infeasible: proven for the relaxation on the present knots.
        last: the last cone program with its solution.
    """

    problem: Problem
    tolerance: float
    deadline: float
    tighten: float
    best: Candidate | None = None
    relaxed: Candidate | None = None
    lower: float = -inf
    over: str = ""
    infeasible: bool = False
    stages: list[Stage] = field(default_factory=list)
    grids: tuple[Grid, ...] = ()
    last: tuple[Plan, ConeSolution] | None = None

    def left(self) -> float:
        """Seconds left."""
        return self.deadline - time.monotonic()

    def offer(self, found: Candidate) -> None:
        """Look at a cam of the relaxation, and at what it becomes under the other limits."""
        if self.relaxed is None or found.value < self.relaxed.value:
            self.relaxed = found
        finished = grow(found)
        if finished is not None and (self.best is None or finished.value < self.best.value):
            self.best = finished

    def learn(self, lower: Bound) -> None:
        """Keep a bound if it is the best so far; the least prime radius bounds a norm too."""
        value = lower.value
        if self.problem.objective.norm(self.problem.machine) is not None:
            value = max(value, self.problem.sizing.least)
        if value > self.lower:
            self.lower, self.over = value, lower.over

    def close(self, found: Candidate | None) -> bool:
        """Whether a cam is within the tolerance of the bound."""
        if found is None or not isfinite(self.lower):
            return False
        to_wire, machine = self.problem.objective.to_wire, self.problem.machine
        value, lower = to_wire(found.value, machine), to_wire(self.lower, machine)
        return value - lower <= 0.99 * self.tolerance * abs(value)


def search(
    problem: Problem, tolerance: float, deadline: float = inf, tighten: float = 1e-7
) -> Search:
    """Solve one problem to a relative gap, or as near as the ladder comes.

    Args:
        problem: the question.
        tolerance: relative gap asked for.
        deadline: ``time.monotonic()`` at which to stop with the best so far.
        tighten: relative amount by which limits are drawn in for the solver's sake.

    Raises:
        SolverFailed: no rung gave a usable point.
    """
    state = Search(problem, tolerance, deadline, tighten)
    if not _closed_form(state):
        first = int(np.clip(3.0 / sqrt(tolerance), COARSE, FINE))
        state.grids = tuple(uniform(stretch, first) for stretch in problem.free)
        _climb(state)
    if state.relaxed is not None and not state.close(state.best) and state.left() > 0.0:
        _nonlinear(state)
    return state


def _closed_form(state: Search) -> bool:
    """First rung: given laws and rows only; True where it spoke."""
    started = time.perf_counter()
    problem = state.problem
    if problem.free or needs_size(problem):
        return False
    size = smallest(problem)
    if size is None:
        return False
    found = at_size(problem, (), size)
    state.learn(Bound(_unmoved(problem, size), "every size of the given laws", ()))
    state.offer(found)
    sizes = len(problem.sizing.bounds)
    seconds = time.perf_counter() - started
    state.stages.append(Stage("closed form", "half-planes", "none", sizes, 0, 0, seconds, "solved"))
    return True


def _unmoved(problem: Problem, size: tuple[float, ...]) -> float:
    """The objective before the size is moved off what binds it, less rounding."""
    norm = problem.objective.norm(problem.machine)
    if norm is None:
        return at_size(problem, (), size).value * (1.0 - 1e-12)
    return norm.value(size) * (1.0 - 1e-12)


def _climb(state: Search) -> None:
    """Second rung: cone programs on finer and finer knots until the bound is near."""
    solve_once = _fraction if state.problem.objective.fractional else _round
    for number in range(1, ROUNDS + 1):
        started = time.perf_counter()
        plan, solution, lower = solve_once(state)
        state.last = (plan, solution)
        if lower is not None:
            state.learn(lower)
        found = _read(plan, solution) if solution.stopped in USABLE else None
        missed = _missed(found) if found is not None else []
        if found is not None and not any(excess > ALLOWED for _, _, excess in missed):
            state.offer(found)
        _report(state, number, plan, solution, time.perf_counter() - started)
        if solution.stopped is Stopped.INFEASIBLE and (number > 1 or not state.grids):
            state.infeasible = state.relaxed is None
            return
        if state.close(state.relaxed) or state.left() <= 0.0 or not state.grids:
            break
        state.grids = _finer(state, lower, missed)
    if state.relaxed is None and state.left() > 0.0:
        raise SolverFailed(
            "Clarabel", solution.word, "Ask for a larger tolerance or looser limits."
        )


def _round(state: Search, trial: float = 0.0) -> tuple[Plan, ConeSolution, Bound | None]:
    """One cone program on the present grids, with its bound."""
    plan = formulate(state.problem, state.grids, trial, state.tighten)
    solution = solve(plan.program, state.left())
    return plan, solution, bound(plan, solution) if solution.stopped in USABLE else None


def _fraction(state: Search) -> tuple[Plan, ConeSolution, Bound | None]:
    """A fractional objective on the present grids: lower the trial level until it stays."""
    trial = 1.0 if state.relaxed is None else state.relaxed.value
    for _ in range(12):
        plan, solution, lower = _round(state, trial)
        if solution.stopped not in USABLE:
            return plan, solution, None
        reached = _read(plan, solution).value
        settled = abs(reached - trial) <= 1e-3 * state.tolerance * trial
        trial = reached
        if settled:
            break
    below = trial * (1.0 - 0.5 * state.tolerance)
    _, proof, excess = _round(state, below)
    proven = excess is not None and excess.value > 0.0
    over = excess.over if excess is not None else ""
    psi = excess.switching if excess is not None else ()
    return plan, solution, Bound(below if proven else 0.0, over, psi)


def _read(plan: Plan, solution: ConeSolution) -> Candidate:
    laws, size = plan.recover(solution.x)
    return settle(plan.problem, laws, size)


def _missed(found: Candidate) -> list[tuple[int, float, float]]:
    """Where rows of limits are worst on free laws: stretch, angle [rad], relative excess."""
    worst = []
    for index, stretch in enumerate(found.problem.stretches):
        if stretch.free is None:
            continue
        for row in found.problem.limit_rows(stretch):
            excess, theta = exceeded(row, found.problem, index, found.size)
            scale = max(abs(row.upper), abs(stretch.lift), 1e-300)
            worst.append((stretch.index, theta, excess / scale))
    return worst


def _finer(
    state: Search, lower: Bound | None, missed: list[tuple[int, float, float]]
) -> tuple[Grid, ...]:
    """Knots where the bound says that the ideal law switches, points where rows were worst."""
    finer = []
    for position, (stretch, grid) in enumerate(zip(state.problem.free, state.grids, strict=True)):
        breaks = grid.space.breaks
        switches = lower.switching[position].crossings() if lower and lower.switching else None
        if switches is None or stretch.free is None or stretch.free.smoothness > 2:
            breaks = _halved(breaks)
        else:
            breaks = merged(breaks, switches)
        points = [
            (theta - stretch.start) / stretch.angle
            for index, theta, excess in missed
            if index == stretch.index and excess > -1e-3
        ]
        kept = np.clip(np.array(points), 0.0, 1.0)
        finer.append(over(stretch, breaks).with_points(kept))
    return tuple(finer)


def _halved(breaks: Array) -> Array:
    return np.union1d(breaks, 0.5 * (breaks[:-1] + breaks[1:]))


def _report(state: Search, number: int, plan: Plan, solution: ConeSolution, seconds: float) -> None:
    rows, unknowns = plan.program.matrix.shape
    knots = sum(len(grid.space.breaks) - 1 for grid in plan.grids)
    model = "QP" if plan.energy is not None else "SOCP" if plan.balls else "LP"
    state.stages.append(
        Stage(
            f"convex {number}", f"{model}, {knots} spline intervals", "Clarabel", unknowns, rows,
            solution.iterations, seconds, solution.stopped.value,
        )
    )  # fmt: skip


def _nonlinear(state: Search) -> None:
    """Third rung: limits that are not convex, from the relaxation's cam grown out of them."""
    from synthesis.formulations.nonlinear import improve  # CasADi only where it is needed

    started = time.perf_counter()
    plan = formulate(state.problem, state.grids, 0.0, state.tighten)
    start = state.best or state.relaxed
    assert start is not None
    solution = improve(plan, plan.point(start.laws, start.size), state.deadline)
    laws, size = plan.recover(solution.x)
    found = settle(state.problem, laws, size, keep_hint=True)
    if not any(excess > ALLOWED for _, _, excess in _missed(found)):
        finished = grow(found)
        if finished is not None and (state.best is None or finished.value < state.best.value):
            state.best = finished
    state.stages.append(
        Stage(
            "nonlinear", "NLP", "IPOPT", len(solution.x), solution.rows, solution.iterations,
            time.perf_counter() - started, solution.stopped.value,
        )
    )  # fmt: skip
