"""Warnings of spatial cams: each rule from its threshold on, silent where its limit is set."""

from __future__ import annotations

import math
from typing import Any

import pytest

from service.commands.tables import describe_spatial_cam
from synthesis.machines.spatial.advice import RULES, with_warnings
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.pipeline import synthesise_spatial
from synthesis.machines.spatial.spec import SpatialCamSpec
from tests.machines.spatial.drums import designed

RADIUS, WIDTH, RPM = 60.0, 12.0, 90.0


def barrel(degrees: float, law: str = "cycloidal", **fields: Any) -> SpatialDesign:
    """A slide in a groove whose largest pressure angle is this, at the groove's floor.

    There tan α = s'/ρ, and the cycloidal law's largest s' is 2 h/β.
    """
    floor = RADIUS - WIDTH
    lift = 0.5 * math.tan(math.radians(degrees)) * floor * math.radians(110.0)
    move = {"angle_deg": 110.0, "lift_mm": lift, "law": {"kind": law}}
    rest = {"kind": "dwell", "angle_deg": 70.0}
    program = [{"kind": "rise", **move}, rest, {"kind": "return", **move}, rest]
    body = {
        "speed_rpm": RPM, "program": program,
        "machine": {"kind": "cylindrical_translating", "cylinder_radius_mm": RADIUS,
                    "roller_radius_mm": 9.0, "roller_width_mm": WIDTH},
    }  # fmt: skip
    return synthesise_spatial(SpatialCamSpec.model_validate(body | fields))


def said(design: SpatialDesign) -> dict[str, str]:
    assert design.severity == (design.warnings[0].severity if design.warnings else "none")
    return {one.code: one.severity for one in design.warnings}


@pytest.fixture(scope="module")
def groove() -> SpatialDesign:
    """A cam of which nothing is to be said."""
    found = barrel(29.9)
    assert said(found) == {}
    return found


def with_value(design: SpatialDesign, quantity: str, value: float) -> SpatialDesign:
    """The same with another value of a measured quantity, judged again."""
    extremes = [
        each.model_copy(update={"value": value}) if each.quantity == quantity else each
        for each in design.extremes
    ]
    return with_warnings(design.model_copy(update={"extremes": extremes}))


def test_the_pressure_angle_is_that_of_the_formula() -> None:
    assert said(barrel(30.1)) == {"pressure_angle": "note"}


@pytest.mark.parametrize(
    ("degrees", "severity"),
    [(30.1, "note"), (37.9, "note"), (38.1, "caution"), (69.9, "caution"), (70.1, "stop")],
)
def test_pressure_angle(groove: SpatialDesign, degrees: float, severity: str) -> None:
    found = with_value(groove, "pressure_angle", degrees)
    assert said(found) == {"pressure_angle": severity}
    assert ("jam" in found.warnings[0].sentence) is (severity == "stop")


def test_a_limit_silences_its_rule() -> None:
    limit = {"kind": "pressure_angle", "max_deg": 60.0}
    assert said(barrel(45.0, limits=[limit])) == {}


def test_a_turret_may_have_what_is_most_for_an_arm() -> None:
    design = designed("turret")
    for degrees, severity in ((49.9, None), (50.1, "caution"), (75.0, "caution")):
        found = said(with_value(design, "pressure_angle", degrees))
        assert found.get("pressure_angle") == severity


@pytest.mark.parametrize(("law", "order"), [("constant_velocity", 1), ("parabolic", 2)])
def test_jumps(law: str, order: int) -> None:
    design = barrel(10.0, law=law)
    (found,) = (one for one in design.warnings if one.code == "jumps")
    lift, beta, omega = design.spec.program[0].lift_mm, math.radians(110.0), RPM * math.pi / 30.0
    size = lift / beta * omega if order == 1 else 8.0 * lift / beta**2 * omega**2
    assert f"by {1e-3 * size:.3g} m/s" in found.sentence
    assert "continuity" not in found.remedy  # of which the spec has no field
    assert found.severity == ("caution" if order == 2 or size > 10.0 else "note")


def test_of_an_arm_jumps_are_those_of_the_roller() -> None:
    """Degrees of swing are measured along the path of the roller's middle."""
    design = designed("arm astride a rib")
    body = design.spec.model_dump(exclude_none=True)
    for each in body["program"]:
        if each["kind"] != "dwell":
            each["law"] = {"kind": "parabolic"}
    again = synthesise_spatial(SpatialCamSpec.model_validate(body))
    (found,) = (one for one in again.warnings if one.code == "jumps")
    rise = body["program"][0]
    swing, beta = math.radians(rise["lift_deg"]), math.radians(rise["angle_deg"])
    omega, arm = (
        again.speed_rpm * math.pi / 30.0,
        math.hypot(again.spec.machine.arm_mm, 0.5 * again.spec.machine.roller_distance_mm),
    )
    size = 8.0 * swing / beta**2 * omega**2 * arm * 1e-3
    assert f"by {size:.3g} m/s²" in found.sentence


def test_roller_speed(groove: SpatialDesign) -> None:
    for product, severity in ((0.99e5, None), (1.01e5, "note"), (2.51e5, "caution")):
        found = said(with_value(groove, "roller_speed", product / 18.0))
        assert found.get("roller_speed") == severity


@pytest.mark.parametrize("quantity", ["convex_radius", "rib_thickness"])
def test_walls_and_ribs_that_are_edges(quantity: str) -> None:
    design = designed("turret")
    for part, severity in ((0.0101, None), (0.0099, "stop")):
        found = said(with_value(design, quantity, part * design.dimensions["roller_radius_mm"]))
        assert found.get("sharp_wall") == severity


def test_an_answer_without_a_cam_has_no_warnings() -> None:
    limits = [{"kind": "pressure_angle", "max_deg": 30.0}]
    machine = {"kind": "cylindrical_translating", "cylinder_radius_mm": {"max": 20.0},
               "roller_radius_mm": 4.0, "roller_width_mm": 5.0}  # fmt: skip
    found = barrel(60.0, limits=limits, machine=machine)
    assert (found.status, found.warnings, found.severity) == ("infeasible", [], "none")


def test_the_terminal_says_stop_first() -> None:
    first, second, *_ = describe_spatial_cam(with_value(designed("turret"), "rib_thickness", 1e-3))
    assert str(first).startswith("feasible, but STOP; ")
    assert str(second).strip().startswith("STOP (sharp_wall, limits/rib_thickness/min_mm): The rib")


def test_every_rule_says_where_it_is_from() -> None:
    assert all(rule.source and rule.checked and rule.thresholds for rule in RULES)
