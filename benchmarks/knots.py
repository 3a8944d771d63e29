"""Number of knots and degree of the laws: error of one round on equal intervals against time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.axis import Axis, relative, seconds
from benchmarks.diagram import Diagram, Point, Series
from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import Call, Timing, in_turns
from benchmarks.truth import BASE_RADIUS, PEAK_ACCELERATION, PRIME, Scene
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.problem.grid import RAMP_STEP, Grid, grid_through, merge_knots
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.optimise.recovery.candidate import recover_cam

KINDS = {  # smoothness, and whether there are ramps at the ends
    "C2, cubic": (2, False),
    "C3, quartic": (3, False),
    "C4, quintic": (4, False),
    "C3, ramps at both ends": (3, True),
    "C4, ramps at both ends": (4, True),
}
INTERVALS = (7, 13, 23, 43, 83, 163)  # none of them falls on a switch of the best law
LEAST = 1e-7
TEXT = """One cone program on equal intervals, with its bound: what do more knots gain, and what do
they cost? *Error* is that of the cam that comes out, limits held at every angle, against the closed
form or the reference (see Tolerance); *gap* is to the bound over all motion laws. The best law's
jerk jumps at the ends. A C2 law can do so, and its error falls with the square of the interval;
laws of higher smoothness start from jerk 0 and lose part of an interval at each end, unless they
get short ramps there: one or two more knots {ramp} of the segment apart. Equal intervals are where
a search begins; then knots are put where they pay. What no spline on these knots can do is left
out."""


@dataclass(frozen=True)
class Outcome:
    """One round."""

    kind: str
    intervals: int
    unknowns: int
    time: Timing
    error: float
    gap: float


@dataclass(frozen=True)
class _Round:
    """What is timed: matrices, solver, bound."""

    problem: Problem
    grids: tuple[Grid, ...]

    def __call__(self) -> tuple[float, float, int] | None:
        """Value and bound [problem units], number of unknowns; None where nothing fits."""
        plan = formulate(self.problem, self.grids)
        solution = solve(plan.program)
        if solution.stopped is StopReason.INFEASIBLE:
            return None
        found = recover_cam(self.problem, *plan.recover(solution.x))
        lower = dual_bound(plan, solution).value
        return found.value, lower, plan.program.matrix.shape[1]


def run(effort: Effort = FULL) -> Section:
    """Two scenes, three degrees."""
    parts = []
    for name, scene in effort.some([("radius", BASE_RADIUS), ("acceleration", PEAK_ACCELERATION)]):
        found = _outcomes(scene, effort)
        parts += [_diagram(name, scene, found), _table(found)]
    return Section("Knots and degree", TEXT.format(ramp=RAMP_STEP), parts)


def _outcomes(scene: Scene, effort: Effort) -> list[Outcome]:
    cases = [(kind, n) for kind in effort.some(list(KINDS)) for n in effort.some(INTERVALS)]
    rounds = {case: _posed(scene, *KINDS[case[0]], case[1]) for case in cases}
    found = {case: once() for case, once in rounds.items()}
    solved = {case: once for case, once in found.items() if once is not None}
    calls: dict[str, Call] = {f"{kind} {n}": rounds[kind, n] for kind, n in solved}
    times = in_turns(calls, effort.repeats(7), 0)
    outcomes = []
    for (kind, intervals), (value, lower, unknowns) in solved.items():
        exact = _in_problem_units(scene, rounds[kind, intervals].problem)
        error, gap = max(1.0 - exact / value, scene.known_to), 1.0 - lower / value
        time = times[f"{kind} {intervals}"]
        outcomes.append(Outcome(kind, intervals, unknowns, time, error, gap))
    return outcomes


def _posed(scene: Scene, smoothness: int, ramped: bool, intervals: int) -> _Round:
    spec = scene.spec(smoothness)
    problem = formulate_problem(spec, spec.objectives()[0])
    return _Round(
        problem, tuple(_grid(s, intervals, smoothness - 2 if ramped else 0) for s in problem.free)
    )


def _grid(segment: PlacedSegment, intervals: int, softer: int) -> Grid:
    """Equal intervals, with knots for ramps of so many derivatives at both ends."""
    equal = np.linspace(0.0, 1.0, intervals + 1)
    return grid_through(segment, merge_knots(equal, np.zeros(0), softer=softer))


def _in_problem_units(scene: Scene, problem: Problem) -> float:
    """The optimum: of the base radius the prime radius."""
    if scene is BASE_RADIUS:
        return PRIME
    return problem.objective.from_wire(scene.exact, problem.machine)


def _table(found: list[Outcome]) -> Table:
    rows = [
        (
            one.kind, str(one.intervals), str(one.unknowns), str(one.time),
            f"{one.error:.1e}", f"{one.gap:.1e}",
        )
        for one in found
    ]  # fmt: skip
    head = ("law", ">intervals", ">unknowns", ">time", ">true error", ">proven gap")
    return Table(head, rows)


def _diagram(name: str, scene: Scene, found: list[Outcome]) -> Diagram:
    series = []
    for kind in dict.fromkeys(one.kind for one in found):
        rounds = [one for one in found if one.kind == kind]
        points = [
            Point(
                one.time.median, one.error, one.time.low, one.time.high,
                str(one.intervals) if one in (rounds[0], rounds[-1]) else "",
            )
            for one in rounds
        ]  # fmt: skip
        series.append(Series(kind, points))
    return Diagram(
        f"knots-{name}",
        f"Knots and degree: {scene.name}",
        "True error against time; the numbers beside the marks are the intervals of a law.",
        Axis("time of one round", seconds),
        Axis("true error", relative, least=LEAST),
        series,
    )
