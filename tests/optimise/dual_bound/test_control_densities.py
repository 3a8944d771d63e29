"""Flat faces where the acceleration alone is limited: the radius is a row on the control.

The reference is a linear program of its own: s'' constant on each of many intervals, limits at
both ends of each.
"""

from __future__ import annotations

from math import radians
from typing import Any

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import linprog

from synthesis import DesignSpec, synthesise
from tests.optimise.scenes import LIFT, RPM, acceleration, dwell, fall, rise

LEAST = 4.3  # mm, of the profile's radius


def smallest(cap: float, angle: float, intervals: int = 300) -> float:
    """The least base radius of one rise between dwells, |s''| ≤ cap [mm/rad²]."""
    h, n = radians(angle) / intervals, intervals
    # unknowns: s'' on every interval, s at every node, Rb; s' is a sum
    speed = h * np.tril(np.ones((n, n)), -1)
    step = np.zeros((n, 2 * n + 2))
    step[:, :n] = h * speed + 0.5 * h * h * np.eye(n)
    step[np.arange(n), n + np.arange(n)] = 1.0
    step[np.arange(n), n + 1 + np.arange(n)] = -1.0
    rest = np.zeros((3, 2 * n + 2))
    rest[0, :n], rest[1, n], rest[2, 2 * n] = h, 1.0, 1.0  # s' is 0 at the end, s known at both
    radius = np.zeros((2 * n, 2 * n + 2))
    for k in (0, 1):
        here = np.arange(k * n, (k + 1) * n)
        radius[here, np.arange(n)] = radius[here, n + k + np.arange(n)] = radius[here, -1] = -1.0
    bounds = [(-cap, cap)] * n + [(0.0, LIFT)] * (n + 1) + [(LEAST, None)]
    found = linprog(
        np.eye(2 * n + 2)[-1], sparse.csr_array(radius), np.full(2 * n, -LEAST),
        sparse.csr_array(np.vstack([step, rest])), np.append(np.zeros(n + 2), LIFT), bounds,
    )  # fmt: skip
    assert found.status == 0
    return float(found.x[-1])


def answer(factor: float, *more: dict[str, Any]) -> Any:
    return synthesise(DesignSpec.model_validate({
        "speed_rpm": RPM, "tolerance": 3e-3,
        "program": [rise(53.7), dwell(23.9), fall(71.3), dwell(211.1)],
        "follower": {"kind": "translating_flat_face"},
        "limits": [
            {"kind": "profile_radius", "min_mm": LEAST}, acceleration(factor, 53.7), *more,
        ],
    }))  # fmt: skip


@pytest.mark.parametrize("factor", [4.9, 7.7, 17.3])
def test_bound_and_cam_are_next_to_the_linear_programs(factor: float) -> None:
    cap = factor * LIFT / radians(53.7) ** 2
    least = max(smallest(cap, 53.7), smallest(cap, 71.3))
    certificate = answer(factor).certificate
    assert certificate.bound_valid_for == "all motion laws with a bounded acceleration"
    assert certificate.lower_bound <= least * (1.0 + 1e-6)
    assert certificate.lower_bound >= least * (1.0 - 5e-3)
    assert least * (1.0 - 2e-3) <= certificate.value <= least * (1.0 + 6e-3)


def test_a_maximum_between_bound_and_the_best_spline_of_few_knots_has_a_cam() -> None:
    cap = 7.7 * LIFT / radians(53.7) ** 2
    least = max(smallest(cap, 53.7), smallest(cap, 71.3))
    body = answer(7.7).spec.model_dump(mode="json", exclude_none=True)
    body["base_radius_mm"] = {"max": 1.01 * least}
    assert synthesise(DesignSpec.model_validate(body)).status in ("feasible", "optimal")
    body |= {"base_radius_mm": {"max": 0.985 * least}, "time_budget_s": 6}
    design = synthesise(DesignSpec.model_validate(body))
    assert design.status == "infeasible"
