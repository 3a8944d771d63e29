"""Allowances of the second judge: each one is needed, and none is tenfold."""

from __future__ import annotations

import cmath
import math
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest
from flint import arb

from synthesis import Design, DesignSpec, confirm, synthesise
from synthesis.certify.second.claims import _find_infinity, _is_decreasing
from synthesis.certify.second.exact_design import ExactDesign, compare
from synthesis.certify.second.exact_motion import (
    ExactMotion,
    LawPiece,
    MotionPiece,
    ball_precision,
    degree,
)
from synthesis.certify.second.invariants import _backward_travel
from synthesis.certify.second.self_intersection import _far_pairs, _FlankSearch
from tests.certify.second.test_families import designed
from tests.certify.second.test_values import RPM, H, body, given


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


@pytest.mark.parametrize(("less", "far"), [(1.5e-6, True), (5e-6, False)])
def test_half_a_turn_is_far(less: float, far: bool) -> None:
    headings = (0.0, math.pi - less, 4.2, 5.3)
    boxes = [SimpleNamespace(heading=(h, h), turning=0.0) for h in headings]
    assert ((0, 1) in set(_far_pairs(boxes))) == far


@pytest.mark.parametrize("turned", [0.3, 1.7, 3.1, 4.4, 6.0])
def test_far_pairs_do_not_depend_on_where_headings_are_counted_from(turned: float) -> None:
    """Headings of a curve with a hollow, wrapped to half a turn, from another direction."""
    course = [0.0, -0.9, -1.7, -2.6, -3.3, -2.9, -3.4, -4.6, -5.2, -6.0, -2.0 * math.pi]

    def pairs(shift: float) -> set[tuple[int, int]]:
        ends = [math.remainder(heading + shift, 2.0 * math.pi) for heading in course]
        boxes = [SimpleNamespace(heading=each, turning=0.02) for each in pairwise(ends)]
        return set(_far_pairs(boxes))

    assert pairs(turned) == pairs(0.0)
    assert 0 < len(pairs(0.0)) < 100


# -- pieces made by hand: one of 0.7 rad and 3 mm, the next of 0.4 rad and 5 mm -----------------


def piece(poly: list[float], angle: float, start: float = 0.0, unit: float = 1.0) -> MotionPiece:
    law = LawPiece(arb(0), arb(1), arb(0), tuple(map(arb, poly)))
    return MotionPiece(law, 0, arb(start), arb(angle), arb(0), arb(unit))


@pytest.mark.parametrize(("share", "found"), [(0.6e-9, None), (4e-9, False)])
@pytest.mark.parametrize("order", [0, 1])
def test_a_jump_of_a_billionth_makes_nothing_infinite(
    share: float, found: bool | None, order: int
) -> None:
    first, second, scale = 0.7, 0.4, 8.0 / 0.4**order
    slope = 1.0 / first
    # s = 3 x up to 3 mm, at the velocity 3/0.7; then on from there, but for the jump
    after = [3.0, slope * 3.0 * second]
    after[order] += share * scale * second**order
    pieces = piece([0.0, 1.0], first, unit=3.0), piece([c / 5.0 for c in after], second, 0.7, 5.0)
    design = SimpleNamespace(
        motion=SimpleNamespace(junctions=lambda: [pieces]), rate=lambda order: arb(1)
    )
    claim = SimpleNamespace(quantity="acceleration")
    line = given().extremes[0].model_copy(update={"value": None, "holds": False})
    there = line.model_copy(update={"angle_deg": math.degrees(0.7)})
    assert _find_infinity(design, claim, there).holds == found
    elsewhere = line.model_copy(update={"angle_deg": math.degrees(0.7 + 1e-8)})
    assert _find_infinity(design, claim, elsewhere).holds is None


def search() -> tuple[_FlankSearch, Design]:
    design = given()
    link = design.completed_spec.follower.link(tuple(arb(z) for z in design.size), degree())
    exact = ExactDesign(design, link, ExactMotion(design))
    return _FlankSearch(exact, exact.machine.follower.flanks[0]), design


def test_headings_are_those_of_the_curve_on_the_cam() -> None:
    with ball_precision():
        found, design = search()
        e, s0 = design.size
        for piece in found.motion.pieces:
            for box in found._boxes_of(piece):
                for x, heading in zip((box.low, box.high), box.heading, strict=True):
                    theta = float(piece.angle_at(x))
                    side = "left" if x == piece.law.high else "right"
                    s, v = design.curve.derivatives([theta], 1, side)[:, 0]
                    # the point e + i (s0 + s) turns on the cam by −θ
                    tangent = (1j * v - 1j * (e + 1j * (s0 + s))) * cmath.exp(-1j * theta)
                    assert math.cos(cmath.phase(tangent) - heading) > 1.0 - 1e-12


def test_boxes_hold_the_roller_s_centre_and_the_flank() -> None:
    with ball_precision():
        found, design = search()
        e, s0 = design.size
        for piece in found.motion.pieces:
            for box in found._boxes_of(piece):
                middle = found._middle(box)
                theta = float(piece.angle_at(middle.low))
                s, v = design.curve.derivatives([theta], 1)[:, 0]
                centre = e + 1j * (s0 + s)
                inward = (v - centre) / abs(v - centre)  # the tangent, turned by a quarter
                for wide, narrow, exact in (
                    (box.centre, middle.centre, centre),
                    (box.flank, middle.flank, centre + 6.5 * inward),
                ):
                    place = exact * cmath.exp(-1j * theta)
                    for ball, point, x in zip(wide, narrow, (place.real, place.imag), strict=True):
                        assert abs(float(ball.mid()) - x) <= float(ball.rad()) + 1e-9
                        assert float(point) == pytest.approx(x, abs=1e-9)


def test_halves_make_up_their_box() -> None:
    with ball_precision():
        found, _ = search()
        for box in found._boxes_of(found.motion.pieces[0]):
            first, second = found._halves(box)
            assert (first.low, first.high, second.high) == (box.low, second.low, box.high)
            assert box.low < first.high < box.high


def test_backward_travel_is_enclosed() -> None:
    """s = x² − x/2 mm falls by 1/16 mm up to x = 1/4; turned round, it falls by 9/16 beyond."""
    with ball_precision():
        for forward, exact in ((1, 1.0 / 16.0), (-1, 9.0 / 16.0)):
            least, most = _backward_travel(piece([0.0, -0.5, 1.0], 0.7), forward)
            assert float(least) <= exact <= float(most)
            assert float(most - least) < 1e-6
        assert _backward_travel(piece([0.0, 1.0, 1.0], 0.7), 1) == (arb(0), arb(0))


def test_a_radius_falls_as_curvature_grows_and_a_hollow_one_grows() -> None:
    assert _is_decreasing(lambda k: 1 / k if k > 0 else None)
    assert not _is_decreasing(lambda k: -1 / k if k < 0 else None)
    assert not _is_decreasing(lambda v: v * 3)
    assert _is_decreasing(lambda v: -v)


def test_a_dimension_is_known_to_a_trillionth() -> None:
    base = next(e.value for e in given().extremes if e.limit == "base_radius")
    assert base is not None
    assert verdict(given(), "base_radius", value=base * (1.0 + 0.3e-12)) == "confirmed"
    assert verdict(given(), "base_radius", value=base * (1.0 + 1e-11)) == "contradicted"


def follower(**offset: float) -> dict[str, Any]:
    return body()["follower"] | {"offset_mm": offset}


@pytest.mark.parametrize(
    ("limit", "asked", "narrower"),
    [
        ("base_radius", {"base_radius_mm": {"max": 37.0}}, {"base_radius_mm": {"min": 38.0}}),
        ("base_radius", {"base_radius_mm": {"min": 21.0}}, {"base_radius_mm": {"max": 20.0}}),
        ("room_for_shaft", {"shaft_diameter_mm": 9.0}, {"shaft_diameter_mm": 80.0}),
        ("room_for_hub", {"hub_diameter_mm": 31.0}, {"hub_diameter_mm": 80.0}),
        ("offset", {"follower": follower(max=0.5)}, {"follower": follower(min=7.5)}),
    ],
)
def test_a_dimension_out_of_its_range_is_not_said_to_hold(
    limit: str, asked: dict[str, Any], narrower: dict[str, Any]
) -> None:
    """The verdict of a dimension is found from the question, not taken from the certificate."""
    spec, other = (
        DesignSpec.model_validate(body(base_radius_mm=None, follower=follower()) | changes)
        for changes in (asked, narrower)
    )
    design = synthesise(spec)
    assert confirm(design).verdict == "confirmed"
    assert verdict(design, limit, holds=False) == "contradicted"
    changed = Design.model_validate(design.model_dump() | {"spec": other.model_dump()})
    assert not next(line for line in confirm(changed).lines if line.limit == limit).agrees


@pytest.mark.parametrize(("share", "agrees"), [(1e-12, True), (1e-10, False)])
def test_a_range_is_missed_by_no_more_than_rounding(share: float, agrees: bool) -> None:
    question = body(base_radius_mm={"max": 37.0})
    design = synthesise(DesignSpec.model_validate(question))
    least = design.dimensions["base_radius_mm"] * (1.0 + share)
    other = DesignSpec.model_validate(question | {"base_radius_mm": {"min": least}})
    changed = Design.model_validate(design.model_dump() | {"spec": other.model_dump()})
    (line,) = (line for line in confirm(changed).lines if line.limit == "base_radius")
    assert line.agrees == agrees


def test_an_end_state_that_nobody_asked_for_is_not_confirmed() -> None:
    line = (
        given()
        .extremes[-1]
        .model_copy(
            update={"limit": "acceleration_required", "field": "program/0/start", "value": 0.0}
        )
    )
    design = given().model_copy(update={"extremes": [*given().extremes, line]})
    assert confirm(design).verdict == "incomplete"


def test_a_state_is_measured_at_the_end_that_it_was_asked_of() -> None:
    """Of a rise that picks up a constant velocity and comes to rest."""
    velocity, law = 41.3, {"kind": "polynomial_5"}
    between = velocity * 23.1 / (6.0 * RPM)  # in 23.1° [mm]
    program = [
        {"kind": "rise", "angle_deg": 71.25, "lift_mm": H, "law": law},
        {"kind": "constant_velocity", "angle_deg": 23.1, "lift_mm": between},
        {"kind": "rise", "angle_deg": 53.5, "lift_mm": 9.7, "law": law,
         "start": {"velocity_mm_per_s": velocity}},
        {"kind": "return", "angle_deg": 121.9, "lift_mm": H + between + 9.7,
         "law": {"kind": "polynomial_3_4_5"}},
        {"kind": "dwell", "angle_deg": 90.25},
    ]  # fmt: skip
    design = synthesise(DesignSpec.model_validate(body(program=program)))
    (line,) = (line for line in confirm(design).lines if line.limit == "velocity_required")
    assert (line.field, line.agrees) == ("program/2/start", True)
    assert float(line.value or 1.0) < 1e-12 * velocity


def test_rows_of_a_table_are_known_to_a_billionth_of_its_tolerance() -> None:
    design = designed("table")
    (line,) = (e for e in design.extremes if e.limit == "table_deviation")
    assert line.value is not None
    assert line.bound is not None
    for share, expected in ((0.6e-9, "confirmed"), (4e-9, "contradicted")):
        value = line.value + share * line.bound
        assert verdict(design, "table_deviation", value=value) == expected
    # a line that names no table, or no bound, is not confirmed
    assert verdict(design, "table_deviation", bound=None) == "incomplete"
    assert verdict(design, "table_deviation", field="program/2/tolerance_mm") == "incomplete"


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
