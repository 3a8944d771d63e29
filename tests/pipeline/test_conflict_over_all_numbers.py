"""Conflicts of questions that leave lifts free: what is impossible is so with every lift."""

from __future__ import annotations

from typing import Any

import pytest

from synthesis import DesignSpec, synthesise
from synthesis.design.design import Design
from synthesis.numerics import clock
from synthesis.pipeline import conflict
from synthesis.pipeline.relaxable import Relaxable, relaxable_numbers

REQUEST, MOST = 31.8, 13.0
STEPS = {"min": 4.83, "max": 11.3}
REQUESTS = {"limits/0/return_deg": REQUEST, "base_radius_mm/max": MOST}
SECONDS = 9.0  # 300 programs
SPLITS = (4.83, 8.3)


def question(return_deg: float, first: Any = None, most: float = MOST) -> DesignSpec:
    """Two rises that run into each other; with their lifts free, or the first one given [mm]."""
    lifts = (STEPS, STEPS) if first is None else (first, 16.1 - first)
    free = {"law": {"kind": "spline"}}
    body = {
        "speed_rpm": 278.0,
        "program": [
            {"kind": "rise", "angle_deg": 52.0, "lift_mm": lifts[0], **free},
            {"kind": "rise", "angle_deg": 52.0, "lift_mm": lifts[1], **free},
            {"kind": "dwell", "angle_deg": 36.8},
            {"kind": "return", "angle_deg": 60.6, "lift_mm": 16.1, **free},
            {"kind": "dwell", "angle_deg": 158.6},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 6.02, "offset_mm": 0.0},
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 32.8, "return_deg": return_deg},
            {"kind": "jerk", "max_mm_per_s3": 1.67e8},
        ],
        "base_radius_mm": {"max": most},
        "proof": "thorough",
    }
    return DesignSpec.model_validate(body)


@pytest.fixture(scope="module")
def explained() -> Design:
    """Of two of its numbers alone, in so many programs: they are the clock."""

    def two_numbers(spec: DesignSpec) -> list[Relaxable]:
        return [number for number in relaxable_numbers(spec) if number.paths[0] in REQUESTS]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(clock, "now", lambda: 0.03 * clock.programs_solved())
        patched.setattr(conflict, "relaxable_numbers", two_numbers)
        patched.setattr(conflict, "program_numbers", lambda *_: ())
        return synthesise(question(REQUEST).model_copy(update={"time_budget_s": SECONDS}))


def known(design: Design, field: str) -> tuple[float, float]:
    """The value that is impossible and the one that suffices, of a number in the conflict."""
    assert design.conflict is not None
    (found,) = [each for each in design.conflict.relaxations if each.field == field]
    assert found.at_least is not None
    assert found.needed is not None
    return found.at_least, found.needed


def test_both_values_are_named_and_near(explained: Design) -> None:
    assert explained.status == "infeasible"
    for field, request in REQUESTS.items():
        at_least, needed = known(explained, field)
        assert request < at_least < needed
        assert needed - at_least < 0.2 * (needed - request), field


@pytest.mark.usefixtures("unexplained")
def test_what_is_impossible_is_so_with_every_lift(explained: Design) -> None:
    steep, _ = known(explained, "limits/0/return_deg")
    small, _ = known(explained, "base_radius_mm/max")
    for first, spec in zip(
        SPLITS, (question(steep, SPLITS[0]), question(REQUEST, SPLITS[1], small)), strict=True
    ):
        assert not synthesise(spec.model_copy(update={"proof": "quick"})).motion, first


def test_what_is_needed_suffices_with_lifts_free(explained: Design) -> None:
    _, steep = known(explained, "limits/0/return_deg")
    _, size = known(explained, "base_radius_mm/max")
    for spec in (question(steep), question(REQUEST, most=size)):
        assert synthesise(spec.model_copy(update={"proof": "quick"})).motion
