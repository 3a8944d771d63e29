"""What confirmation finds, against closed forms to 25 digits, and against wrong certificates."""

from __future__ import annotations

import sys
from decimal import Decimal
from functools import lru_cache
from typing import Any

import pytest

from synthesis import Design, DesignSpec, confirm, synthesise
from synthesis.errors import ExtraMissing, InputError
from tests.forty_digits import PI
from tests.hard import cases
from tests.hard.random_specs import random_spec

H, RISE, RPM = 17.3, 71.25, 83.5
LIMITS = [
    {"kind": "velocity", "max_mm_per_s": 1e4}, {"kind": "acceleration", "max_mm_per_s2": 1e6},
    {"kind": "jerk", "max_mm_per_s3": 1e8}, {"kind": "pressure_angle", "rise_deg": 80.0},
]  # fmt: skip


def body(**changes: Any) -> dict[str, Any]:
    law = {"kind": "polynomial_3_4_5"}
    return {
        "speed_rpm": RPM,
        "program": [
            {"kind": "rise", "angle_deg": RISE, "lift_mm": H, "law": law},
            {"kind": "dwell", "angle_deg": 41.0},
            {"kind": "return", "angle_deg": 113.5, "lift_mm": H, "law": law},
            {"kind": "dwell", "angle_deg": 134.25},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 6.5, "offset_mm": 3.25},
        "base_radius_mm": 33.5,
        "limits": LIMITS,
    } | changes


@lru_cache(maxsize=4)
def given() -> Design:
    return synthesise(DesignSpec.model_validate(body()))


def test_peaks_of_the_3_4_5_law_to_25_digits() -> None:
    # in (h/β)(6n): ω = 6n degrees per second, so that no π remains; Cv 15/8, Ca 10/√3, Cj 60
    lines = {line.limit: line for line in confirm(given()).lines}
    rate = 6 * Decimal(RPM) / Decimal(RISE)
    for name, order, peak in (
        ("velocity", 1, Decimal(15) / 8),
        ("acceleration", 2, 10 / Decimal(3).sqrt()),
        ("jerk", 3, Decimal(60)),
    ):
        found, exact = Decimal(lines[name].value or 0), Decimal(H) * rate**order * peak
        assert abs(abs(found) - exact) < Decimal("3e-24") * exact


def test_a_search_that_ends_early_still_encloses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("synthesis.certify.second.exact_motion.MAX_INTERVALS", 3)
    lines = {line.limit: line for line in confirm(given()).lines}
    rate, wide = 6 * Decimal(RPM) / Decimal(RISE), 0
    for name, order, peak in (
        ("velocity", 1, Decimal(15) / 8),
        ("acceleration", 2, 10 / Decimal(3).sqrt()),
    ):
        middle, half = Decimal(lines[name].value or 0), Decimal(lines[name].width or 0) / 2
        exact = Decimal(H) * rate**order * peak
        assert abs(abs(middle) - exact) <= half * (1 + Decimal("1e-12")) + Decimal("1e-20") * exact
        wide += half > exact / 1000
    assert wide


def test_the_pressure_angle_at_rest_to_25_digits() -> None:
    """tan α = e/s0, checked by a series of the arc tangent of its own."""
    found = next(x for x in confirm(given()).lines if x.limit == "prime_circle_angle")
    e, s0 = (Decimal(z) for z in given().size)
    q = e / s0
    angle = sum((-1) ** k * q ** (2 * k + 1) / (2 * k + 1) for k in range(30))
    assert abs(Decimal(found.value or 0) - angle * 180 / PI) < Decimal("1e-23")


def tampered(limit: str, **changes: Any) -> Design:
    extremes = [
        extreme.model_copy(update=changes) if extreme.limit == limit else extreme
        for extreme in given().extremes
    ]
    return given().model_copy(update={"extremes": extremes})


@pytest.mark.parametrize(
    ("limit", "changes"),
    [
        ("pressure_angle_rise", {"value": 15.0}),
        ("velocity", {"value": 1.0 + 1e-9, "width": 1e-10}),
        ("jerk", {"holds": False}),
        ("self_crossing", {"holds": False}),
        ("base_radius_positive", {"value": 33.5 + 2e-10}),
        ("displacement_join", {"bound": -1.0}),
    ],
)
def test_a_wrong_line_is_contradicted(limit: str, changes: dict[str, Any]) -> None:
    if limit == "velocity":  # by a billionth of itself
        right = next(e.value for e in given().extremes if e.limit == limit)
        changes = changes | {"value": right * changes["value"]}
    found = confirm(tampered(limit, **changes))
    assert found.verdict == "contradicted"
    assert [line.limit for line in found.lines if line.agrees is False] == [limit]


def test_a_wrong_cam_is_contradicted() -> None:
    design = given().model_copy(update={"size": [given().size[0], given().size[1] * (1 - 1e-9)]})
    found = confirm(design)
    assert {x.limit for x in found.lines if x.agrees is False} >= {"pressure_angle_rise"}


def test_a_profile_that_crosses_itself_is_seen() -> None:
    """A certificate that calls it simple is contradicted; one that says so agrees."""
    sharp = cases.CASES["jerk cap on a parabolic law"].spec
    design = synthesise(DesignSpec.model_validate(sharp))
    line = next(x for x in confirm(design).lines if x.limit == "self_crossing")
    reported = next(x for x in design.extremes if x.limit == "self_crossing")
    assert not reported.holds
    assert (line.holds, line.agrees) == (False, True)
    lie = [x.model_copy(update={"holds": True}) if x is reported else x for x in design.extremes]
    lines = confirm(design.model_copy(update={"extremes": lie})).lines
    assert next(x for x in lines if x.limit == "self_crossing").agrees is False


def test_the_same_design_the_same_bytes() -> None:
    assert confirm(given()).model_dump_json() == confirm(given()).model_dump_json()


def test_precision_is_given_back() -> None:
    from flint import ctx

    before = ctx.prec, ctx.cap
    confirm(given())
    assert (ctx.prec, ctx.cap) == before


def test_without_a_cam_there_is_nothing_to_confirm() -> None:
    with pytest.raises(InputError, match="no cam"):
        confirm(given().model_copy(update={"motion": []}))


def test_without_the_extra_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "flint", None)
    with pytest.raises(ExtraMissing, match=r"camwright\[exact\]"):
        confirm(given())


def test_a_cam_so_sharp_that_its_tangent_seems_to_vanish_on_wide_boxes() -> None:
    """A random spec whose design could not be confirmed: the square of a tangent held 0."""
    design = synthesise(DesignSpec.model_validate(random_spec(122)))
    assert design.motion
    assert confirm(design).verdict == "confirmed"
