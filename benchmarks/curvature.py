"""Limits on curvature: the nonlinear rung alone, warm-started from the cone program's cam."""

import time
from collections.abc import Callable
from math import pi
from statistics import median
from typing import Any

import numpy as np

from benchmarks import timed
from benchmarks.main_job import CONVEX
from synthesis.formulations.candidate import grow, settle
from synthesis.formulations.convex import Plan, formulate
from synthesis.formulations.grid import uniform
from synthesis.formulations.nonlinear import improve
from synthesis.formulations.problem import pose
from synthesis.solvers.clarabel import solve
from synthesis.spec import DesignSpec

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
GRIDS = (20, 42)  # intervals of both laws; 42 is the ladder's first grid at a tolerance of 5e-3
ALLOWANCES = (5e-5, 1e-6)
REPEATS = 15


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


def posed(asked: DesignSpec, intervals: int) -> tuple[Plan, np.ndarray, float]:
    """The plan, the start, and the prime radius that the relaxation allows."""
    problem = pose(asked, asked.objectives()[0])
    plan = formulate(problem, [uniform(stretch, intervals) for stretch in problem.free])
    laws, size = plan.recover(solve(plan.program).x)
    raised = grow(settle(problem, laws, size))
    assert raised is not None
    return plan, plan.point(raised.laws, raised.size), float(np.hypot(*size))


def processor(call: Callable[[], object]) -> float:
    """Median processor time of a call [s]: what a busy machine does not disturb."""
    seconds = []
    for _ in range(REPEATS):
        began = time.process_time()
        call()
        seconds.append(time.process_time() - began)
    return median(seconds)


def run() -> str:
    """A Markdown table."""
    lines = [
        "### Curvature: IPOPT on the cone program's unknowns",
        "",
        "| scene | intervals | drawn in by | wall, median (quartiles) | processor | iterations "
        "| rows | prime radius: relaxation, raised, answer |",
        "|---|--:|--:|---|--:|--:|--:|---|",
    ]
    for name, scene in SCENES.items():
        for intervals in GRIDS:
            plan, start, relaxed = posed(spec(scene), intervals)
            raised = float(np.hypot(*plan.recover(start)[1]))
            for allowed in ALLOWANCES:

                def call(plan: Plan = plan, x: np.ndarray = start, t: float = allowed) -> object:
                    return improve(plan, x, tighten=t)

                found = improve(plan, start, tighten=allowed)
                prime = float(np.hypot(*plan.recover(found.x)[1]))
                lines.append(
                    f"| {name} | {intervals} | {allowed:.0e} "
                    f"| {timed(call, repeats=REPEATS, warm_up=2)} | {1e3 * processor(call):.0f} ms "
                    f"| {found.iterations} | {found.rows} "
                    f"| {relaxed:.3f}, {raised:.3f}, {prime:.4f} mm |"
                )
    return "\n".join(lines)
