"""Scenes for the convex stage: specs in few words, and the direct program's optimum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

import numpy as np

from synthesis.catalogue.motion import Motion
from synthesis.numerics.solvers.clarabel import ConeSolution, solve
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.problem.grid import Grid, grid_through, uniform_grid
from synthesis.optimise.problem.mean_square import mean_square
from synthesis.optimise.problem.problem import ObjectiveCap, Problem, formulate_problem
from synthesis.spec.design_spec import DesignSpec

RPM = 83.7
OMEGA = RPM * 2.0 * pi / 60.0
LIFT = 27.3


def rise(angle: float, lift: float = LIFT, law: Any = None, **free: Any) -> dict[str, Any]:
    law = {"kind": "spline", **free} if law is None else {"kind": law}
    return {"kind": "rise", "angle_deg": angle, "lift_mm": lift, "law": law}


def fall(angle: float, lift: float = LIFT, law: Any = None, **free: Any) -> dict[str, Any]:
    return {**rise(angle, lift, law, **free), "kind": "return"}


def dwell(angle: float) -> dict[str, Any]:
    return {"kind": "dwell", "angle_deg": angle}


PLAIN = (rise(71.7), dwell(23.9), fall(83.3), dwell(181.1))
TURNING = (rise(131.7), fall(97.3), dwell(131.0))


def velocity(factor: float, angle: float, lift: float = LIFT) -> dict[str, Any]:
    """``factor`` times the mean velocity over the angle."""
    value = factor * lift / (angle * pi / 180.0) * OMEGA
    return {"kind": "velocity", "max_mm_per_s": value}


def acceleration(factor: float, angle: float, lift: float = LIFT) -> dict[str, Any]:
    """``factor`` times h/β²: at least 4 for a rise between dwells."""
    value = factor * lift / (angle * pi / 180.0) ** 2 * OMEGA**2
    return {"kind": "acceleration", "max_mm_per_s2": value}


def jerk(factor: float, angle: float, lift: float = LIFT) -> dict[str, Any]:
    """``factor`` times h/β³: at least 32 for a rise between dwells."""
    value = factor * lift / (angle * pi / 180.0) ** 3 * OMEGA**3
    return {"kind": "jerk", "max_mm_per_s3": value}


def angles(rise_deg: float | None, return_deg: float | None = None, **more: Any) -> dict[str, Any]:
    return {"kind": "pressure_angle", "rise_deg": rise_deg, "return_deg": return_deg, **more}


def scene(
    program: Sequence[Mapping[str, Any]],
    *limits: Mapping[str, Any],
    objective: str = "base_radius",
    offset: Any = None,
    base: Any = None,
    roller: float = 9.1,
) -> DesignSpec:
    return DesignSpec.model_validate(
        {
            "speed_rpm": RPM,
            "program": list(program),
            "follower": {
                "kind": "translating_roller",
                "roller_radius_mm": roller,
                "offset_mm": offset,
            },
            "base_radius_mm": base,
            "limits": list(limits),
            "objective": {"kind": objective},
            "proof": "quick",
        }
    )


def problem(spec: DesignSpec, held: tuple[ObjectiveCap, ...] = ()) -> Problem:
    return formulate_problem(spec, spec.objectives()[0], held)


def even(question: Problem, intervals: int) -> list[Grid]:
    return [uniform_grid(segment, intervals + 3 * k) for k, segment in enumerate(question.free)]


def uneven(question: Problem, seed: int, intervals: int = 9) -> list[Grid]:
    rng = np.random.default_rng(seed)
    found = []
    for segment in question.free:
        steps = rng.uniform(0.3, 1.7, intervals)
        breaks = np.concatenate([[0.0], np.cumsum(steps) / steps.sum()])
        breaks[-1] = 1.0
        found.append(grid_through(segment, breaks))
    return found


@dataclass(frozen=True, eq=False)
class Direct:
    """The answer of the ready matrices, its value measured on what was recovered."""

    model: ConicModel
    solution: ConeSolution
    value: float


def direct(question: Problem, grids: Sequence[Grid], level: float = 0.0) -> Direct:
    model = formulate(question, grids, level)
    solution = solve(model.program)
    assert solution.stopped in (StopReason.SOLVED, StopReason.INACCURATE), solution.stopped
    return Direct(model, solution, measured(model, solution))


def measured(model: ConicModel, solution: ConeSolution) -> float:
    """The objective in problem units, from the recovered laws and size."""
    question = model.problem
    laws, size = model.recover(solution.x)
    norm, order = question.objective.norm(question.machine), question.objective.energy_order()
    if norm is not None:
        image = np.array(norm.matrix) @ np.array(size) + np.array(norm.shift)
        return float(np.linalg.norm(image))
    if order is not None:
        return sqrt(mean_square(moved(question, laws).curve, order))
    assert model.epigraph is not None
    return float(solution.x[model.epigraph]) * model.scales.level


def moved(question: Problem, laws: Sequence[Any]) -> Motion:
    placed = [s.with_law(law.curve()) for s, law in zip(question.free, laws, strict=True)]
    return Motion.of(question.with_laws(placed).segments)
