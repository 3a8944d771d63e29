"""An answer comes when the time budget ends, whatever is being done then."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from synthesis import DesignSpec, synthesise
from synthesis.errors import TimeBudgetExceeded
from tests.hard.mixed_specs import mixed_spec
from tests.hard.random_specs import random_spec
from tests.pipeline.scenes import PRESSURE, jerk, spec
from tests.pipeline.ticking import ticking

EXAMPLES = Path(__file__).parents[2] / "openapi" / "examples"
BUDGET = 0.35
UNSEEN = 0.4  # the longest without a look at the clock
LATE = 1.1 * BUDGET + UNSEEN  # such a stretch, or what is measured of the last cam, begins in time


def example(name: str) -> dict[str, Any]:
    body = json.loads((EXAMPLES / f"{name}.json").read_text(encoding="utf-8"))
    found: dict[str, Any] = body["value"]
    return found


def swinging(distance: Any) -> dict[str, Any]:
    """An arm with five free laws, a window of radii and no cam that is easily found."""
    moves = [("rise", 61.3), ("return", 37.7), ("rise", 11.9), ("return", 25.1), ("rise", 22.9)]
    lifts = [10.3, 13.3, 12.9, 13.2, 3.3]
    program = [
        {"kind": kind, "angle_deg": angle, "lift_deg": lift}
        for (kind, angle), lift in zip(moves, lifts, strict=True)
    ]
    return {
        "speed_rpm": 194.8,
        "program": [*program, {"kind": "dwell", "angle_deg": 201.1}],
        "follower": {
            "kind": "oscillating_roller", "arm_mm": 48.5, "roller_radius_mm": 12.1,
            "sense": "same", "centre_distance_mm": distance,
        },
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 48.4, "return_deg": 15.8},
            {"kind": "acceleration", "max_deg_per_s2": 6.3e7},
        ],
        "objective": {"kind": "peak_jerk"},
        "base_radius_mm": {"max": 35.9},
        "tolerance": 0.08,
    }  # fmt: skip


THOROUGH = spec(
    limits=[PRESSURE, jerk(48.0), {"kind": "profile_radius", "min_mm": 12.0}],
    tolerance=1e-5, proof="thorough",
).model_dump(mode="json", exclude_unset=True)  # fmt: skip
ASKED: dict[str, dict[str, Any]] = {
    "cone programs and their bound": example("example-13-6-sized") | {"tolerance": 1e-6},
    "curvature, thorough": THOROUGH,
    "a counter arm's place": example("conjugate-arms"),
    "a pivot given": example("oscillating-roller"),
    "a pivot left free": example("pivot-free"),
    "a pivot for five laws": swinging({"min": 49.3, "max": 71.2}),
    "a pivot given, no cam": swinging(61.3),
    "a swinging face, laws free": random_spec(52),
    "steepness on an arm": example("least-pressure-angle"),
    "free angles": example("spot-weld"),
    "an arm's length": example("free-arm"),
    "why nothing fits": example("infeasible-on-purpose"),
    "the gentlest law": mixed_spec(2691) | {"proof": "quick"},
    "the least excess of all limits": mixed_spec(1774) | {"proof": "quick"},
    "a price on smoothness": example("smoothness-price") | {"tolerance": 1e-6},
}


@pytest.mark.parametrize("name", ASKED)
def test_no_answer_is_late(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    question = DesignSpec.model_validate({**ASKED[name], "time_budget_s": BUDGET})
    with ticking(monkeypatch) as machine:
        try:
            answered = synthesise(question) is not None
        except TimeBudgetExceeded as ended:
            answered = ended.budget_s == pytest.approx(BUDGET)
    assert answered
    assert machine.time <= LATE
    assert machine.longest <= UNSEEN
