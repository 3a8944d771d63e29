"""The main job in the core: example 13-6 sized, with and without a profile radius that bites.

Time to a certified answer beside its proven gap, and the same unknowns given to SciPy's SLSQP:
its answer is finished and certified by the same rules, so that the two objectives compare.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from math import pi
from time import perf_counter
from typing import Any

import numpy as np
from scipy.optimize import minimize

from benchmarks import timed
from synthesis import DesignSpec, synthesise
from synthesis.answer import Cam, judged
from synthesis.formulations.candidate import grow, settle
from synthesis.formulations.convex import Plan, formulate
from synthesis.formulations.grid import uniform
from synthesis.formulations.problem import pose
from synthesis.formulations.rows import Drawn
from synthesis.numerics.bspline import SplineSpace

OMEGA = 10.0
INTERVALS = 42  # of the first grid at the tolerance below
CONVEX: dict[str, Any] = {
    "speed_rpm": OMEGA * 30.0 / pi,
    "program": [
        {"kind": "rise", "angle_deg": 60.0, "lift_mm": 30.0},
        {"kind": "dwell", "angle_deg": 30.0},
        {"kind": "return", "angle_deg": 60.0, "lift_mm": 30.0},
        {"kind": "dwell", "angle_deg": 210.0},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 10.0},
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 45.0},
        {"kind": "jerk", "max_mm_per_s3": 1.5 * 32.0 * 30.0 / (pi / 3.0) ** 3 * OMEGA**3},
    ],
    "tolerance": 5e-3,
}
BITING = CONVEX | {"limits": [*CONVEX["limits"], {"kind": "profile_radius", "min_mm": 12.0}]}
SHARPER = CONVEX | {"tolerance": 1e-3}
SCENES = {
    "pressure angle and jerk": (CONVEX, 25.0),
    "the same, tolerance 1e-3": (SHARPER, None),
    "and profile radius ≥ 12 mm": (BITING, 150.0),
}


@dataclass(frozen=True)
class Rival:
    """What SLSQP came to: base radius after finishing, whether certified, its own word."""

    base_radius: float
    certified: bool
    word: str
    iterations: int
    seconds: float


def run() -> str:
    """Markdown tables of both."""
    lines = [
        "### The main job: certified answers in the core",
        "",
        "| scene | median | quartiles | base radius | proven gap | status | asked |",
        "|---|---|---|---|---|---|---|",
    ]
    medians = {}
    for name, (body, asked) in SCENES.items():
        spec = DesignSpec.model_validate(body)
        design = synthesise(spec)
        time = timed(lambda spec=spec: synthesise(spec), repeats=20, warm_up=3)
        medians[name] = time.median
        gap = design.certificate.gap
        lines.append(
            f"| {name} | {1e3 * time.median:.1f} ms "
            f"| {1e3 * time.low:.1f} to {1e3 * time.high:.1f} "
            f"| {design.dimensions['base_radius_mm']:.4f} mm | {100 * (gap or 0):.3f} % "
            f"| {design.status} | {'–' if asked is None else f'{asked:.0f} ms'} |"
        )
    lines += ["", *_rivalry(medians["pressure angle and jerk"])]
    return "\n".join(lines)


def _rivalry(ours: float) -> list[str]:
    spec = DesignSpec.model_validate(CONVEX)
    design = synthesise(spec)
    rows = [
        "| on the same unknowns | time | ratio | certified base radius | word |",
        "|---|---|---|---|---|",
        f"| Camwright | {1e3 * ours:.1f} ms | 1 | {design.dimensions['base_radius_mm']:.4f} mm "
        f"| {design.status} |",
    ]
    for iterations in (100, 300):
        rival = slsqp(spec, iterations)
        shown = f"{rival.base_radius:.4f} mm" if rival.certified else "not certified"
        rows.append(
            f"| SciPy SLSQP, at most {iterations} iterations | {1e3 * rival.seconds:.0f} ms "
            f"| {rival.seconds / ours:.0f} | {shown} | {rival.word} ({rival.iterations}) |"
        )
    return rows


def slsqp(spec: DesignSpec, iterations: int) -> Rival:
    """SLSQP on the unknowns of the first cone program, with exact derivatives and a fair start."""
    problem = pose(spec, spec.objectives()[0])
    grids = [uniform(stretch, INTERVALS) for stretch in problem.free]
    plan = formulate(problem, grids, drawn=Drawn(tighten=1e-7))
    start = _start(plan)
    matrix = plan.program.matrix.toarray()
    first = plan.program.equalities
    last = first + plan.program.inequalities
    size = slice(plan.size.start, plan.size.stop)

    def radius(x: np.ndarray) -> tuple[float, np.ndarray]:
        gradient = np.zeros_like(x)
        value = float(np.linalg.norm(x[size]))
        gradient[size] = x[size] / value
        return value, gradient

    rows, rhs = matrix[first:last], plan.program.rhs[first:last]
    conditions = {"type": "ineq", "fun": lambda x: rhs - rows @ x, "jac": lambda _: -rows}
    began = perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = minimize(
            radius, start, jac=True, method="SLSQP", constraints=[conditions],
            options={"maxiter": iterations, "ftol": 1e-9},
        )  # fmt: skip
    seconds = perf_counter() - began
    laws, z = plan.recover(found.x)
    cam = grow(settle(problem, laws, z))
    if cam is None:
        return Rival(np.nan, False, str(found.message), int(found.nit), seconds)
    splines = {
        stretch.index: (law.space, law.coefficients)
        for stretch, law in zip(problem.free, cam.laws, strict=True)
    }
    extremes = judged(spec, Cam(cam.problem.stretches, splines, cam.size))
    return Rival(
        spec.follower.dimensions(cam.size)["base_radius_mm"],
        all(extreme.holds for extreme in extremes),
        str(found.message),
        int(found.nit),
        seconds,
    )


def _start(plan: Plan) -> np.ndarray:
    """The 3-4-5 law's coefficients and a prime radius that is generous."""
    x = np.zeros(plan.program.matrix.shape[1])
    for grid, known, columns in zip(plan.grids, plan.settled, plan.columns, strict=True):
        space: SplineSpace = grid.space
        at = space.greville
        law = 10.0 * at**3 - 15.0 * at**4 + 6.0 * at**5
        fit = np.linalg.solve(space.basis(at), law)
        x[columns] = fit[len(known.first) : space.size - len(known.last)]
    x[plan.size] = np.array([0.3, 2.5]) * 30.0 / plan.scales.size
    return x
