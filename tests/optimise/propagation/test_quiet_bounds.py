"""Bounds of traced points under limits on residual vibration: they hold, and use these limits."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from synthesis import DesignSpec
from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.control import law_controls
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.optimise.propagation import bound_tightening, quantity_bounds
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


def test_a_bound_that_would_gain_little_is_not_sought_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where a cam is known that comes so near to it. No bound is lost, nor one that would gain."""
    problem, gained, spared = question(31.0, 0.4), list[float](), list[int]()
    model, value, _ = smallest(31.0, 0.4)
    held = with_value_cap(problem, 1.02 * value)
    held_model = formulate(held, [grid.knots_only for grid in model.grids])
    controls = law_controls(held_model)
    first, _ = tighten_bounds(
        held_model, controls,
        initial_region(held, controls, dict.fromkeys(range(2), ((0.0, 1.0),))), range(2),
    )  # fmt: skip
    solve_each = quantity_bounds._solve_each

    def counted(*given: Any) -> Any:
        found = solve_each(*given)
        spared.append(int(np.sum(~found[2])))
        return found

    monkeypatch.setattr(quantity_bounds, "_solve_each", counted)
    again, _ = tighten_bounds(held_model, controls, first, range(2))
    assert sum(spared) > 20
    monkeypatch.setattr(bound_tightening, "SLIGHT", -1.0)
    spared.clear()
    every, _ = tighten_bounds(held_model, controls, first, range(2))
    assert sum(spared) == 0
    for key, known in first.point_bounds.items():
        some, all_ = again.point_bounds[key], every.point_bounds[key]
        assert np.all((some.low >= known.low) & (some.high <= known.high))
        width = known.high - known.low
        gained.append(float(np.max((all_.low - some.low) / width)))
        gained.append(float(np.max((some.high - all_.high) / width)))
    assert max(gained) <= 0.05 + 1e-6
