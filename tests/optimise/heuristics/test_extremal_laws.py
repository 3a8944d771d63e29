"""Cams of extremal laws under a face that swings: next to what the closed form says of any law.

Closed form, by the test's own formulas: with h = d sin ψ − f and B the angle by which the face's
normal turns on the cam, h_low − ρ ≥ (h_high − ρ) cos B; the least base radius is where that holds
with equality for the move that asks for more.
"""

from __future__ import annotations

from dataclasses import replace
from math import asin, cos, hypot, radians, sin
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from synthesis import DesignSpec, synthesise
from synthesis.catalogue.followers.oscillating_flat_face import OscillatingFlatFace
from synthesis.optimise.heuristics.extremal_laws import try_extremal_laws
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.optimise.state import DEFAULT_TIGHTENING, SolveState

PIVOT, OFFSET, RADIUS, RISE, RETURN, SWING = 76.6, 4.6, 6.8, 41.8, 54.7, 17.18
SIGMA = {"same": -1.0, "opposite": 1.0}


def swinging_face(
    sense: str, *more: dict[str, Any], distance: Any = PIVOT, law: Any = None, **other: Any
) -> DesignSpec:
    move = {"lift_deg": SWING, "law": law or {"kind": "spline"}}
    return DesignSpec.model_validate({
        "speed_rpm": 83.7, "objective": {"kind": "base_radius"}, "tolerance": 0.005,
        "program": [
            {"kind": "rise", "angle_deg": RISE, **move}, {"kind": "dwell", "angle_deg": 14.5},
            {"kind": "return", "angle_deg": RETURN, **move}, {"kind": "dwell", "angle_deg": 249.0},
        ],
        "follower": {"kind": "oscillating_flat_face", "centre_distance_mm": distance,
                     "face_offset_mm": OFFSET, "sense": sense},
        "limits": [{"kind": "profile_radius", "min_mm": RADIUS}, *more], **other,
    })  # fmt: skip


def infimum(sense: str, distance: float = PIVOT) -> float:
    """Of the base radius."""
    swing, found = radians(SWING), list[float]()
    for angle, sign in ((RISE, 1.0), (RETURN, -1.0)):
        turn = radians(angle) + sign * SIGMA[sense] * swing

        def spare(base: float, turn: float = turn) -> float:
            low = asin((base + OFFSET) / distance)
            high = distance * sin(low + swing) - OFFSET
            return base - RADIUS - (high - RADIUS) * cos(turn)

        found.append(brentq(spare, RADIUS, distance * cos(swing) - OFFSET))
    return max(found)


def state_of(spec: DesignSpec) -> SolveState:
    question: Problem = formulate_problem(spec, spec.objectives()[0])
    return SolveState(question, spec.tolerance, np.inf, DEFAULT_TIGHTENING)


@pytest.mark.parametrize("smoothness", [1, 2, 3, 4])
@pytest.mark.parametrize("sense", ["same", "opposite"])
def test_the_cam_is_next_to_the_infimum(sense: str, smoothness: int) -> None:
    # with the sense "same" the infimum is next to the largest size, where the face's arm ends
    law = {"kind": "spline", "smoothness": smoothness}
    design = synthesise(swinging_face(sense, law=law))
    assert design.status == "optimal"
    assert design.certificate.lower_bound == pytest.approx(infimum(sense), rel=1e-6)
    assert design.certificate.lower_bound < design.certificate.value < 1.005 * infimum(sense)
    assert [stage.model for stage in design.report.stages] == ["extremal laws"]


def test_a_finer_tolerance_has_shorter_ramps() -> None:
    values = [
        synthesise(swinging_face("opposite", tolerance=tolerance)).certificate.value
        for tolerance in (0.02, 0.005, 0.001, 0.0002)
    ]
    assert values == sorted(values, reverse=True)
    assert values[-1] < 1.0004 * infimum("opposite")


@pytest.mark.parametrize("sense", ["same", "opposite"])
def test_a_pivot_in_a_range_is_as_near_as_it_may_be(sense: str) -> None:
    distances = np.linspace(0.8 * PIVOT, PIVOT, 9)
    least = min(infimum(sense, distance) for distance in distances.tolist())
    question = swinging_face(sense, distance={"min": distances[0], "max": distances[-1]})
    design = synthesise(question)
    assert design.status == "optimal"
    assert design.certificate.lower_bound == pytest.approx(least, rel=1e-6)
    assert design.certificate.value < 1.005 * least


def test_a_pivot_that_may_be_anywhere() -> None:
    # a larger base radius alone leaves the face no arm where it has swung up: the pivot moves away
    found = try_extremal_laws(state_of(swinging_face("opposite", distance={"max": PIVOT})))
    assert found.incumbent is not None
    assert found.incumbent.value < 1.02 * found.lower


def test_limits_that_are_tightened_make_the_cam_larger() -> None:
    # where the certificate has refused a cam, its enclosures being wider than the cam's slack
    state = state_of(swinging_face("opposite"))
    found, larger = (
        try_extremal_laws(replace(state, tighten=tighten)).incumbent for tighten in (1e-7, 1e-3)
    )
    assert found is not None
    assert larger is not None
    assert larger.value == pytest.approx(1.001 * found.value, rel=1e-5)


def test_what_limits_the_motion_is_kept() -> None:
    # the extremal laws reach this speed: no cam of theirs is offered
    free = try_extremal_laws(state_of(swinging_face("same")))
    assert free.incumbent is not None
    rates = [
        np.max(np.abs(s.placed().derivatives(np.linspace(s.start, s.start + s.angle, 500))[1]))
        for s in free.incumbent.problem.segments
    ]
    most = max(rates) / PIVOT * 83.7 * 6.0  # of the cam's turn per second
    limit = {"kind": "velocity", "max_deg_per_s": 0.97 * most}
    held = try_extremal_laws(state_of(swinging_face("same", limit)))
    assert held.incumbent is None


@pytest.mark.parametrize(
    "more",
    [{"kind": "acceleration", "max_deg_per_s2": 1e9}, {"kind": "jerk", "max_deg_per_s3": 1e13}],
)
def test_capped_derivatives_have_other_best_laws(more: dict[str, Any]) -> None:
    state = state_of(swinging_face("same", more))
    assert try_extremal_laws(state) is state


@pytest.mark.parametrize("sense", ["same", "opposite"])
@pytest.mark.parametrize(("start", "end"), [(0.0, SWING), (SWING, 0.0)])
def test_a_move_runs_along_one_radius(sense: str, start: float, end: float) -> None:
    follower = swinging_face(sense).follower
    assert isinstance(follower, OscillatingFlatFace)
    (curve, *_) = follower.profile_radius_constraints(0.1)
    base, angle, ramp, turned = 63.0, radians(71.3), 1e-3, [radians(each) for each in (start, end)]
    move = curve.extremal_move(angle, *(PIVOT * each for each in turned), (base,), ramp)
    assert move is not None
    # the motion, by integration, and the radius under it by the follower's own formula
    bend = np.interp(np.linspace(0.0, 1.0, 400_001), move.x, move.acceleration)
    step = angle / 400_000
    rate = np.append(0.0, np.cumsum(0.5 * step * (bend[1:] + bend[:-1])))
    s = PIVOT * turned[0] + np.append(0.0, np.cumsum(0.5 * step * (rate[1:] + rate[:-1])))
    assert s[-1] == pytest.approx(PIVOT * turned[1], abs=2e-3 * PIVOT * radians(SWING))
    radius = follower.face_radius(np.stack([s, rate, bend, 0.0 * s]), (base,))
    inside = slice(int(0.01 * len(s)), int(0.99 * len(s)))
    assert np.ptp(radius[inside]) < 5e-3 * np.mean(radius[inside])
    assert np.min(radius) > 0.99 * np.mean(radius[inside])
    assert np.all(np.diff(move.breaks) > 0.0)
    assert hypot(move.breaks[0], move.breaks[-1] - 1.0) == 0.0


def test_no_move_where_the_limit_leaves_no_room() -> None:
    least = infimum("same")
    follower = swinging_face("same").follower
    assert isinstance(follower, OscillatingFlatFace)
    (curve, *_) = follower.profile_radius_constraints(RADIUS)
    args = radians(RISE), 0.0, PIVOT * radians(SWING)
    assert curve.extremal_move(*args, (0.999 * least,), 1e-4) is None
    assert curve.extremal_move(*args, (1.001 * least,), 1e-4) is not None
    assert curve.extremal_move(*args, (PIVOT * cos(radians(SWING)),), 1e-4) is None


@pytest.mark.parametrize(
    ("offset", "swing", "angle", "base_angle"),
    [(4.6, SWING, 5.0, 75.0), (-30.0, 30.0, 10.0, 40.0)],  # beyond the right angle; faster than it
)
def test_no_move_of_a_face_that_touches_nowhere(
    offset: float, swing: float, angle: float, base_angle: float
) -> None:
    follower = swinging_face("opposite").follower.model_copy(update={"face_offset_mm": offset})
    (curve, *_) = follower.profile_radius_constraints(0.1)
    size = (PIVOT * sin(radians(base_angle)) - offset,)
    assert curve.extremal_move(radians(angle), 0.0, PIVOT * radians(swing), size, 1e-3) is None
