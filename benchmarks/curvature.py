"""Limits on curvature: the nonlinear rung alone, warm-started from the cone program's cam."""

from math import pi
from typing import Any

import numpy as np

from benchmarks.effort import FULL, Effort
from benchmarks.main_job import CONVEX
from benchmarks.section import Section, Table
from benchmarks.timing import timed
from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.heuristics.ipopt_search import solve_ipopt
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.recovery.candidate import enlarge_until_feasible, recover_cam
from synthesis.spec.design_spec import DesignSpec

OMEGA = 10.0
MAIN = "main job, radius ≥ 12 mm"
SCENES: dict[str, dict[str, Any]] = {
    MAIN: {"angles": (30.0, 45.0), "jerk": 1.5, "roller": 10.0, "profile_radius": 12.0},
    "symmetric, radius ≥ 5 mm": {
        "angles": (45.0, 45.0), "jerk": 2.0, "roller": 20.0, "profile_radius": 5.0, "offset": 0.0,
    },
    "unequal angles, radius ≥ 5 mm": {
        "angles": (30.0, 45.0), "jerk": 2.0, "roller": 20.0, "profile_radius": 5.0,
    },
    "knife edge, radius ≥ 20 mm": {
        "angles": (45.0, 45.0), "jerk": 2.0, "roller": 0.0, "profile_radius": 20.0,
    },
    "cutter of 60 mm": {
        "angles": (45.0, 45.0), "jerk": 4.0, "roller": 5.0, "cutter_radius": 60.0,
    },
}  # fmt: skip
INTERVALS = 42  # of both laws: the ladder's first grid at a tolerance of 5e-3
ALLOWANCES = (5e-5, 1e-6)
TEXT = """Limits that are not convex: IPOPT on the cone program's unknowns, started from the cam of
the relaxation, raised until every limit holds. Smooth limits are written at points and drawn in
there by a part of their size, which saves rounds. Lengths are prime radii."""


def spec(scene: dict[str, Any]) -> DesignSpec:
    """30 mm up over 60°, 30° dwell, 60° back: the jerk cap in units of 32 h/β³."""
    jerk = scene["jerk"] * 32.0 * 30.0 / (pi / 3.0) ** 3 * OMEGA**3
    rise, back = scene["angles"]
    limits: list[dict[str, Any]] = [
        {"kind": "pressure_angle", "rise_deg": rise, "return_deg": back},
        {"kind": "jerk", "max_mm_per_s3": jerk},
    ]
    if "profile_radius" in scene:
        limits.append({"kind": "profile_radius", "min_mm": scene["profile_radius"]})
    if "cutter_radius" in scene:
        limits.append({"kind": "cutter_radius", "radius_mm": scene["cutter_radius"]})
    return DesignSpec.model_validate(
        {
            "speed_rpm": CONVEX["speed_rpm"],
            "program": CONVEX["program"],
            "follower": {
                "kind": "translating_roller",
                "roller_radius_mm": scene["roller"],
                "offset_mm": scene.get("offset"),
            },
            "limits": limits,
        }
    )


def posed(question: DesignSpec, intervals: int) -> tuple[ConicModel, np.ndarray, float]:
    """The plan, the start, and the prime radius that the relaxation allows."""
    problem = formulate_problem(question, question.objectives()[0])
    plan = formulate(problem, [uniform_grid(segment, intervals) for segment in problem.free])
    laws, size = plan.recover(solve(plan.program).x)
    raised = enlarge_until_feasible(recover_cam(problem, laws, size))
    assert raised is not None
    return plan, plan.point(raised.laws, raised.size), float(np.hypot(*size))


def run(effort: Effort = FULL) -> Section:
    """Each scene with both allowances."""
    cases = [(name, allowed) for name in SCENES for allowed in ALLOWANCES]
    rows = [_row(name, allowed, effort) for name, allowed in effort.some(cases)]
    head = (
        "scene", ">drawn in by", ">time", ">iterations", ">rows",
        ">relaxation", ">raised", ">answer",
    )  # fmt: skip
    return Section("Curvature: the nonlinear stage alone", TEXT, [Table(head, rows)])


def _row(name: str, allowed: float, effort: Effort) -> tuple[str, ...]:
    plan, start, relaxed = posed(spec(SCENES[name]), INTERVALS)
    found = solve_ipopt(plan, start, tighten=allowed)
    time = timed(
        lambda: solve_ipopt(plan, start, tighten=allowed), effort.repeats(7), effort.warm_up(1)
    )
    primes = (relaxed, *(float(np.hypot(*plan.recover(x)[1])) for x in (start, found.x)))
    radii = [f"{prime:.3f} mm" for prime in primes]
    counts = (str(found.iterations), str(found.rows))
    return name, f"{allowed:.0e}", str(time), *counts, *radii
