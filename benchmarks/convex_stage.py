"""The convex stage: matrices, solver and bound, the same models through CVXPY, and diagnoses."""

from __future__ import annotations

from math import pi
from typing import Any

from benchmarks import Timing, timed
from benchmarks.main_job import CONVEX
from synthesis.formulations.bound import bound
from synthesis.formulations.convex import formulate
from synthesis.formulations.elastic import diagnose
from synthesis.formulations.grid import Grid, uniform
from synthesis.formulations.problem import Problem, pose
from synthesis.formulations.reference import optimum
from synthesis.solvers.clarabel import solve
from synthesis.spec import DesignSpec

OMEGA = 10.0
KINDS = ("base_radius", "peak_acceleration", "peak_jerk", "rms_jerk")
INTERVALS = (20, 40, 80)


def run() -> str:
    """Markdown: time and gap by objective and knots, against CVXPY, and of infeasible scenes."""
    return "\n".join([*_stages(), "", *_diagnoses()])


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


def _posed(asked: DesignSpec, intervals: int) -> tuple[Problem, list[Grid]]:
    problem = pose(asked, asked.objectives()[0])
    return problem, [uniform(stretch, intervals) for stretch in problem.free]


def _stages() -> list[str]:
    lines = [
        "### The convex stage",
        "",
        "P1's motion with spline laws, limits 30°/45°, jerk 1.5 × 32h/β³; one round on equal "
        "intervals. The gap is that of the round's value to the bound over all motion laws; "
        "CVXPY states and solves the same model anew.",
        "",
        "| objective | intervals | unknowns × rows | matrices | Clarabel | bound | gap "
        "| CVXPY | ratio |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    return lines + [_stage(kind, intervals) for kind in KINDS for intervals in INTERVALS]


def _stage(kind: str, intervals: int) -> str:
    problem, grids = _posed(spec(kind), intervals)
    plan = formulate(problem, grids)
    solution = solve(plan.program)
    lower = bound(plan, solution)
    times = [
        timed(lambda: formulate(problem, grids), 20, 3),
        timed(lambda: solve(plan.program), 20, 3),
        timed(lambda: bound(plan, solution), 20, 3),
        timed(lambda: optimum(problem, grids), 5, 1),
    ]
    value = optimum(problem, grids).value
    assert value is not None
    rows, unknowns = plan.program.matrix.shape
    direct = sum(time.median for time in times[:2])
    shown = [f"{1e3 * time.median:.1f} ms" for time in times]
    return (
        f"| {kind} | {intervals} | {unknowns} × {rows} | {' | '.join(shown[:3])} "
        f"| {(value - lower.value) / value:.2%} | {shown[3]} | {times[3].median / direct:.0f} |"
    )


def _diagnoses() -> list[str]:
    scenes = {
        "jerk below what any law needs": spec(jerk=0.9),
        "base radius ≤ 25 mm": spec(base_radius_mm={"max": 25.0}),
        "base radius 25 mm, offset 0": spec(
            base_radius_mm=25.0,
            follower={
                "kind": "translating_roller", "roller_radius_mm": 10.0, "offset_mm": 0.0,
            },
        ),
    }  # fmt: skip
    lines = [
        "### Why nothing fits",
        "",
        "Conflicting limits and the least relaxation of each, on 24 intervals a law.",
        "",
        "| scene | in conflict | relaxations found | time |",
        "|---|---|---|---|",
    ]
    for name, asked in scenes.items():
        problem, grids = _posed(asked, 24)
        found = diagnose(asked, problem, grids)
        helpful = sum(relaxation.needed is not None for relaxation in found.relaxations)
        time: Timing = timed(lambda a=asked, p=problem, g=grids: diagnose(a, p, g), 5, 1)
        shown = f"{1e3 * time.median:.0f} ms"
        lines.append(f"| {name} | {'; '.join(found.limits)} | {helpful} | {shown} |")
    return lines
