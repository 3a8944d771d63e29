"""The convex stage, part by part: matrices, solver, bound; and diagnoses where nothing fits."""

from __future__ import annotations

from math import pi
from typing import Any

from benchmarks.effort import FULL, Effort
from benchmarks.main_job import CONVEX
from benchmarks.section import Section, Table
from benchmarks.timing import Call, in_turns, timed
from synthesis import Design, synthesise
from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.dual_bound.bound import dual_bound, in_problem_units
from synthesis.optimise.problem.grid import Grid, uniform_grid
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.spec.design_spec import DesignSpec

OMEGA = 10.0
KINDS = ("base_radius", "peak_acceleration", "peak_jerk", "rms_jerk")
INTERVALS = (20, 40, 80)
TEXT = """The main job's motion with spline laws, limits 30°/45°, jerk ≤ 1.5 × 32h/β³; one round on
equal intervals for each objective. The gap is that of the round's value to the bound over all
motion laws."""


def run(effort: Effort = FULL) -> Section:
    """Time and gap by objective and knots, and of infeasible scenes."""
    return Section("The convex stage", TEXT, [_stages(effort), _diagnoses(effort)])


def spec(objective: str = "base_radius", jerk: float = 1.5, **more: Any) -> DesignSpec:
    """P1's motion: 30 mm up over 60°, 30° dwell, 60° back; jerk cap in units of 32 h/β³."""
    limits: list[dict[str, Any]] = [
        {"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 45.0},
        {"kind": "jerk", "max_mm_per_s3": jerk * 32.0 * 30.0 / (pi / 3.0) ** 3 * OMEGA**3},
    ]
    return DesignSpec.model_validate(
        {
            "speed_rpm": CONVEX["speed_rpm"],
            "program": CONVEX["program"],
            "follower": {"kind": "translating_roller", "roller_radius_mm": 10.0},
            "limits": limits,
            "objective": {"kind": objective},
            **more,
        }
    )


def _posed(question: DesignSpec, intervals: int) -> tuple[Problem, list[Grid]]:
    problem = formulate_problem(question, question.objectives()[0])
    return problem, [uniform_grid(segment, intervals) for segment in problem.free]


def _stages(effort: Effort) -> Table:
    head = (
        "objective", ">intervals", ">unknowns × rows", ">matrices", ">Clarabel", ">bound", ">gap",
    )  # fmt: skip
    question = effort.some([(kind, intervals) for kind in KINDS for intervals in INTERVALS])
    return Table(head, [_stage(kind, intervals, effort) for kind, intervals in question])


def _stage(kind: str, intervals: int, effort: Effort) -> tuple[str, ...]:
    problem, grids = _posed(spec(kind), intervals)
    plan = formulate(problem, grids)
    solution = solve(plan.program)
    lower = dual_bound(plan, solution)
    calls: dict[str, Call] = {
        "matrices": lambda: formulate(problem, grids),
        "Clarabel": lambda: solve(plan.program),
        "bound": lambda: dual_bound(plan, solution),
    }
    times = in_turns(calls, effort.repeats(20), effort.warm_up(2))
    value = in_problem_units(plan, plan.program.value(solution.x))
    rows, unknowns = plan.program.matrix.shape
    gap = f"{(value - lower.value) / value:.2%}"
    return kind, str(intervals), f"{unknowns} × {rows}", *map(str, times.values()), gap


def _diagnoses(effort: Effort) -> Table:
    rows = []
    for name, question in effort.some(list(_infeasible().items())):
        designs: list[Design] = []
        time = timed(lambda a=question, to=designs: to.append(synthesise(a)), effort.repeats(5), 0)
        found = designs[0].conflict
        assert found is not None
        helpful = sum(relaxation.needed is not None for relaxation in found.relaxations)
        rows.append((name, "; ".join(found.limits), str(helpful), str(time)))
    note = (
        "Where nothing fits: the whole design, with the limits in conflict and values that suffice."
    )
    return Table(("scene", "in conflict", ">changes found", ">time"), rows, note)


def _infeasible() -> dict[str, DesignSpec]:
    on_axis = {"kind": "translating_roller", "roller_radius_mm": 10.0, "offset_mm": 0.0}
    return {
        "jerk below what any law needs": spec(jerk=0.9),
        "base radius ≤ 25 mm": spec(base_radius_mm={"max": 25.0}),
        "base radius 25 mm, offset 0": spec(base_radius_mm=25.0, follower=on_axis),
    }
