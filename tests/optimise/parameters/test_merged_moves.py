"""Moves that run into each other are one move that passes a level, and its cam is one of theirs."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from synthesis import synthesise
from synthesis.catalogue.limits.motion import TRAVEL
from synthesis.optimise.driver import optimise
from synthesis.optimise.parameters.merged_moves import MergedMoves
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.spec.design_spec import DesignSpec
from synthesis.spec.program import Rise
from tests.optimise.parameters.test_number_search import angles, dwell, move

LOW, HIGH = 3.1, 9.6  # mm, of a free lift
JERK = {"kind": "jerk", "max_mm_per_s3": 1.6e6}
PRESSURE = {"kind": "pressure_angle", "rise_deg": 21.4, "return_deg": 24.6}
RISES = [move("rise", 47.3, angles(LOW, HIGH)), move("rise", 38.9, angles(LOW, HIGH))]


def spec(rises: list[dict[str, Any]], **more: Any) -> DesignSpec:
    turned = sum(rise["angle_deg"] for rise in rises)
    body = {
        "speed_rpm": 107.0,
        "program": [*rises, dwell(26.5), move("return", 92.6, 12.7),
                    dwell(round(360.0 - turned - 119.1, 6))],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 3.1, "offset_mm": 0.0},
        "limits": [PRESSURE, JERK],
        "tolerance": 0.005, "proof": "quick",
    }  # fmt: skip
    return DesignSpec.model_validate(body | more)


def test_one_move_has_the_cams_of_all_lifts() -> None:
    question = spec(RISES)
    merged = MergedMoves.of(question)
    assert merged is not None
    one = merged.spec.program[0]
    assert isinstance(one, Rise)
    (point,) = one.points
    low, high = point.ends_of(TRAVEL)
    assert low <= LOW
    assert high >= HIGH
    assert high - low == pytest.approx(HIGH - LOW)
    problem = formulate_problem(merged.spec, merged.spec.objectives()[0])
    state = optimise(problem, 5e-3)
    assert state.incumbent is not None
    # the lifts of its cam, with that cam's laws: the same cam
    own = merged.with_lifts(merged.spec, state.incumbent)
    lifts = [segment.signed_lift for segment in own.program[:2]]
    assert sum(lifts) == pytest.approx(12.7)
    assert all(LOW <= lift <= HIGH for lift in lifts)
    parts = formulate_problem(own, own.objectives()[0])
    cam = merged.split(parts, state.incumbent)
    assert cam.value == pytest.approx(state.incumbent.value, rel=1e-6)
    x = np.linspace(0.0, 1.0, 41)
    whole = state.incumbent.laws[0].curve()
    for law, start, lift, (low, high) in zip(
        cam.laws[:2], (0.0, lifts[0]), lifts, zip(merged.joints, merged.joints[1:], strict=False),
        strict=True,
    ):  # fmt: skip
        travel = start + lift * law.curve()(x)
        np.testing.assert_allclose(travel, 12.7 * whole(low + (high - low) * x), atol=1e-8)
    # no lifts have a smaller cam than its bound
    for first in (LOW, 6.3):
        given = spec([move("rise", 47.3, first), move("rise", 38.9, 12.7 - first)])
        found = optimise(formulate_problem(given, given.objectives()[0]), 5e-3)
        assert found.incumbent is not None
        assert found.incumbent.value >= state.lower


def test_the_answer_has_the_bound_of_all_lifts() -> None:
    answer = synthesise(spec(RISES))
    proof = answer.certificate
    assert answer.status in ("optimal", "feasible")
    assert "at all angles and lifts that are free" in proof.bound_valid_for
    assert proof.lower_bound is not None
    assert proof.value is not None
    assert proof.lower_bound <= proof.value
    assert sum(answer.free_parameters.values()) == pytest.approx(12.7)


@pytest.mark.parametrize(
    "rises",
    [
        [RISES[0], dwell(12.0), RISES[1]],
        [RISES[0], {**RISES[1], "law": {"kind": "spline", "smoothness": 3}}],
        [RISES[0], {**RISES[1], "start": {"velocity_mm_per_s": 40.0}}],
        [{**RISES[0], "end": {"acceleration_mm_per_s2": 0.0, "velocity_mm_per_s": 30.0}}, RISES[1]],
        [{**RISES[0], "points": [{"angle_deg": 20.0, "travel_mm": 1.0}]}, RISES[1]],
    ],
)
def test_what_a_joint_asks_for_keeps_moves_apart(rises: list[dict[str, Any]]) -> None:
    assert MergedMoves.of(spec(rises)) is None
    assert MergedMoves.of(spec(RISES)) is not None


def test_lifts_stay_in_their_ranges_where_levels_do_not_say_all() -> None:
    """Of four moves levels in their ranges may come of lifts that are not: 1, 6, 5 and 8 mm."""
    ranges = [(0.5, 2.0), (0.5, 5.0), (0.5, 6.0), (0.5, 8.0)]
    rises = [move("rise", 30.0, angles(*each)) for each in ranges]
    program = [*rises, dwell(30.0), move("return", 120.0, 20.0), dwell(90.0)]
    merged = MergedMoves.of(spec(rises, program=program))
    assert merged is not None
    levels = np.array([0.0, 1.0, 7.0, 12.0, 20.0])
    one = merged.spec.program[0]
    assert isinstance(one, Rise)
    for point, level in zip(one.points, levels[1:4], strict=True):
        low, high = point.ends_of(TRAVEL)
        assert low <= level <= high
    law = SimpleNamespace(curve=lambda: lambda x: np.interp(x, merged.joints, levels / 20.0))
    moving = [SimpleNamespace(index=0, free=True)]
    cam: Any = SimpleNamespace(problem=SimpleNamespace(segments=moving), laws=[law])
    lifts = [each.signed_lift for each in merged.with_lifts(merged.spec, cam).program[:4]]
    assert sum(lifts) == pytest.approx(20.0, abs=1e-12)
    assert all(low <= lift <= high for lift, (low, high) in zip(lifts, ranges, strict=True))
