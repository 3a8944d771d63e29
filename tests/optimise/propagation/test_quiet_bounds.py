"""Bounds of traced points under limits on residual vibration: they hold, and use these limits."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from synthesis import DesignSpec
from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.control import law_controls
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.optimise.propagation.bound_tightening import tighten_bounds
from synthesis.optimise.propagation.improving_region import ImprovingRegion, initial_region
from synthesis.optimise.propagation.law_tightening import with_value_cap

RPM, LIFT, KNOTS = 143.7, 21.3, 24


def question(dwell: float, largest: float) -> Problem:
    """A rise and a return, one run where no dwell is between; the train swings some four times in
    either.
    """
    moves = {"rise": 93.1, "return": 107.7}
    rise, back = (
        {"kind": kind, "angle_deg": angle, "lift_mm": LIFT, "law": {"kind": "spline"}}
        for kind, angle in moves.items()
    )
    rests = ({"kind": "dwell", "angle_deg": a} for a in (dwell, 360.0 - 200.8 - dwell))
    top, low = rests
    ringing = {
        "kind": "residual_vibration", "natural_frequency_hz": 37.3, "damping_ratio": 0.03,
        "max_mm": largest,
    }  # fmt: skip
    spec = DesignSpec.model_validate({
        "speed_rpm": RPM, "program": [rise, top, back, low],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 7.9},
        "limits": [{"kind": "pressure_angle", "rise_deg": 31.0, "return_deg": 37.0},
                   {"kind": "jerk", "max_mm_per_s3": 8.1e5}, ringing],
    })  # fmt: skip
    return formulate_problem(spec, spec.objectives()[0])


@cache
def smallest(dwell: float, largest: float) -> tuple[ConicModel, float, np.ndarray]:
    """The smallest cam on some knots: its model, value and point."""
    problem = question(dwell, largest)
    model = formulate(problem, [uniform_grid(law, KNOTS) for law in problem.free])
    solution = solve(model.program)
    assert model.epigraph is not None
    return model, float(solution.x[model.epigraph] * model.scales.size), solution.x


@cache
def bounds(dwell: float, largest: float, value: float) -> ImprovingRegion:
    """What is known of cams no larger than a value."""
    problem = question(dwell, largest)
    grids = [uniform_grid(law, KNOTS) for law in problem.free]
    capped = formulate(with_value_cap(problem, value), grids)
    controls = law_controls(capped)
    assert controls is not None
    region = initial_region(problem, controls, {0: ((0.45, 0.55),)})
    region, failed = tighten_bounds(capped, controls, region, [0])
    assert not failed
    return region


@pytest.mark.parametrize(("dwell", "largest"), [(31.3, 0.0), (31.3, 0.02), (0.0, 0.02)])
def test_quiet_cams_keep_to_bounds_that_are_narrow(dwell: float, largest: float) -> None:
    model, value, point = smallest(dwell, largest)
    allowed = 1.002 * value
    region = bounds(dwell, largest, allowed)
    laws, size = model.recover(point)
    for (k, seen), known in region.point_bounds.items():
        segment = model.problem.free[k].with_law(laws[k].curve())
        s = segment.placed().derivatives(segment.start + segment.angle * known.nodes)
        traced = np.stack(seen.evaluate(s[:3], size))[:2]
        assert np.all(traced >= known.low[:2] - 1e-6)
        assert np.all(traced <= known.high[:2] + 1e-6)
    # without the limit cams of this size move in many more ways
    loud = bounds(dwell, 1e3, allowed)
    assert region.mean_width < 0.96 * loud.mean_width
