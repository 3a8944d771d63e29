"""Questions with something left free, at sizes that are none's."""

from __future__ import annotations

from typing import Any

from synthesis.machines.spatial.sizing.sequential_convex import formulate_problem
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.optimise.problem.problem import Problem

SPLINE = {"kind": "spline"}
INNER, WIDTH = 71.3, 29.7
TURN, SPEED = 117.0, 66.0


def pressure_angle(degrees: float) -> dict[str, Any]:
    return {"kind": "pressure_angle", "max_deg": degrees}


def jerk(times: float, lift: float = 60.0) -> dict[str, Any]:
    """So many times what any law needs at least."""
    seconds = TURN / (6.0 * SPEED)
    return {"kind": "jerk", "max_deg_per_s3": times * 32.0 * lift / seconds**3}


def globoidal(
    *limits: dict[str, Any], law: dict[str, Any] = SPLINE, lift: float = 60.0, **machine: Any
) -> dict[str, Any]:
    """Six rollers, an index of one of them in 117°; the centre distance left free."""
    sizes = {"roller_radius_mm": 11.2, "roller_inner_mm": INNER, "roller_width_mm": WIDTH}
    return {
        "speed_rpm": SPEED,
        "program": [
            {"kind": "rise", "angle_deg": TURN, "lift_deg": lift, "law": law},
            {"kind": "dwell", "angle_deg": 360.0 - TURN},
        ],
        "machine": {"kind": "globoidal_indexer", "rollers": 6} | sizes | machine,
        "limits": list(limits),
    }


def problem_of(body: dict[str, Any]) -> Problem:
    """The question that the formulations see, its rollers given."""
    spec = SpatialCamSpec.model_validate(body)
    sizes = {name: low for name, (low, high) in spec.machine.ranges().items() if low == high}
    return formulate_problem(spec, spec.placed_segments(), spec.limits, sizes)
