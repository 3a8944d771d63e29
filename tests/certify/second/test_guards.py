"""Allowances of the second judge: each one is needed, and none is tenfold."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest
from flint import arb

from synthesis import Design, DesignSpec, confirm, synthesise
from synthesis.certify.second.exact_design import compare
from synthesis.certify.second.self_intersection import _far_pairs, _FlankSearch
from tests.certify.second.test_values import body, given


@pytest.mark.parametrize(("roundings", "agrees"), [(6, True), (60, False)])
def test_a_value_of_the_certificate_is_rounded(roundings: int, agrees: bool) -> None:
    value = 1.0 + roundings * 2.0**-53 * 2.0
    extreme = given().extremes[0].model_copy(update={"value": value, "width": 0.0, "holds": True})
    assert compare(extreme, arb(1), arb(1), True, "").agrees == agrees


@pytest.mark.parametrize(("depth", "apart"), [(0.6e-9, True), (4e-9, False)])
def test_a_billionth_of_the_roller_is_no_interference(depth: float, apart: bool) -> None:
    tip = SimpleNamespace(path="")
    design = SimpleNamespace(link=SimpleNamespace(tips=[tip]), motion=None)
    search = _FlankSearch(design, SimpleNamespace(path="", side=1, distance=7.0))
    flank = arb(7.0) * (1 - arb(depth)), arb(0)
    assert search._is_apart(flank, (arb(0), arb(0))) == apart


@pytest.mark.parametrize(("less", "far"), [(1e-6, True), (5e-6, False)])
def test_half_a_turn_is_far(less: float, far: bool) -> None:
    headings = (0.0, math.pi - less, 4.2, 5.3)
    boxes = [SimpleNamespace(heading=(h, h), turning=0.0) for h in headings]
    assert ((0, 1) in set(_far_pairs(boxes))) == far


def harmonic() -> Design:
    """Accelerations that jump, and are largest, at the ends of short segments late in the turn."""
    law = {"kind": "cubic_2_3"}
    program = [
        {"kind": "dwell", "angle_deg": 250.3},
        {"kind": "rise", "angle_deg": 31.1, "lift_mm": 2.3, "law": law},
        {"kind": "dwell", "angle_deg": 50.7},
        {"kind": "return", "angle_deg": 27.9, "lift_mm": 2.3, "law": law},
    ]
    limits = [{"kind": "acceleration", "max_mm_per_s2": 1e7}]
    return synthesise(DesignSpec.model_validate(body(program=program, limits=limits)))


def verdict(design: Design, limit: str, **changes: Any) -> str:
    extremes = [
        extreme.model_copy(update=changes) if extreme.limit == limit else extreme
        for extreme in design.extremes
    ]
    return confirm(design.model_copy(update={"extremes": extremes})).verdict


def test_jumps_are_known_to_a_billionth_and_ends_of_pieces_to_rounding() -> None:
    design = harmonic()
    jump = next(e.value for e in design.extremes if e.limit == "acceleration_jump")
    assert verdict(design, "acceleration_jump", value=jump * (1.0 + 0.6e-9)) == "confirmed"
    assert verdict(design, "acceleration_jump", value=jump * (1.0 + 4e-9)) == "contradicted"
    peak = next(e.value for e in design.extremes if e.limit == "acceleration")
    # the angle of a junction is rounded, and acceleration changes there by 12 lift/β³ a radian
    slope = 12.0 / math.radians(27.9) / 6.0 * abs(peak)
    for roundings, expected in ((20.0, "confirmed"), (300.0, "contradicted")):
        moved = peak + math.copysign(slope * roundings * 2.0**-53, peak)
        assert verdict(design, "acceleration", value=moved, width=0.0) == expected
