"""Grooves, rings, conjugate cams, windows and points: only what is true is accepted."""

from typing import Any

import pytest

from tests.checker.run import verdict
from tests.checker.test_holes import ANGLE, ROLLER, ROUND, SMOOTH, document, dwell, move

Json = dict[str, Any]
OF_CAM = "no_undercut self_crossing motion size"
RING = {"kind": "force", "contact": "inside", "rim_mm": 5}
GROOVE = {"kind": "groove", "clearance_mm": 1, "rim_mm": 5}
PAIR = {"kind": "conjugate", "roller_radius_mm": 10, "offset_mm": 2, "distance_mm": {"min": 250,
        "max": 300}}  # fmt: skip
OUTER, NEAR = {"kind": "outer_radius"}, {"kind": "counter_base_radius"}
LAWS = [SMOOTH, None, SMOOTH, None]


def held(
    closure: Json, *limits: Json, size: Any = (0, 100), proven: str = "size", **q: Any
) -> Json:
    named = " ".join(f"limits/{k}" for k in range(len(limits)))
    return document(f"{proven} {named}", ROUND, LAWS, *limits, size=size,
                    follower={**ROLLER, "closure": closure}, **q)  # fmt: skip


def window(name: str, *parts: Json, laws: list[Any] = LAWS, rise: Json = ROUND[0]) -> Json:
    """A rise of 30 mm in 120 degrees, 10 rpm: 2 s, and 15 mm/s in the mean."""
    found = document("motion", [{**rise, name: list(parts)}, *ROUND[1:]], laws)
    found["claims"].append({"place": f"program/0/{name}", "proven": True})
    return found


def part(first: float, last: float, **bounds: Any) -> Json:
    return {"from_deg": first, "to_deg": last, **bounds}


TRUE = {  # the pitch curve reaches from 100 to 130 mm
    "ring": held(RING, ANGLE, {**OUTER, "max_mm": 145}, {"kind": "cutter_radius", "radius_mm": 11},
                 proven=OF_CAM),
    "groove": held(GROOVE, ANGLE, {**OUTER, "max_mm": 145.5}, proven=OF_CAM),
    "pair": held(PAIR, ANGLE, {**OUTER, "max_mm": 150.1}, {**NEAR, "min_mm": 120},
                 size=(0, 100, 260), proven=OF_CAM),
    "window": window("windows", part(0, 120, travel_mm={"min": 0, "max": 30}),
                     part(50, 60, velocity_mm_per_s={"min": 20, "max": 40}),
                     part(0, 20, acceleration_mm_per_s2={"min": 0, "max": None})),
    "point": window("points", {"angle_deg": 60, "travel_mm": 15, "tolerance_mm": 0}),
}  # fmt: skip
FALSE: dict[str, tuple[Json, str]] = {
    "a ring without its rim": (held(RING, {**OUTER, "max_mm": 144.9}), "program/0"),
    "a groove without its slack": (held(GROOVE, {**OUTER, "max_mm": 145.4}), "program/0"),
    "a radius less than its roller": (held(RING, {**OUTER, "max_mm": 1}), "alone"),
    "a ring's base radius is that of its hollow": (held(RING, base_radius_mm=90), "not within"),
    "a groove's base radius is that of its inner flank": (
        held(GROOVE, base_radius_mm=90), "not within"),
    "the outer flank's hollow": (
        held(GROOVE, {"kind": "cutter_radius", "radius_mm": 150}), "program/"),
    "a slack that is negative": (held({**GROOVE, "clearance_mm": -1}), "not covered"),
    "a slack that is no number": (held({**GROOVE, "clearance_mm": True}), "clearance_mm"),
    "a tolerance that is no number": (
        window("points", {"angle_deg": 60, "travel_mm": 15, "tolerance_mm": True}), "tolerance"),
    "a roller that is held otherwise": (held({**RING, "contact": "beside"}), "contact"),
    "a groove that is touched from inside": (held({**GROOVE, "contact": "inside"}), "not covered"),
    "the distance is not as asked": (held(PAIR, size=(0, 100, 301)), "not within"),
    "the distance is left out": (held(PAIR), "as many laws or sizes"),
    "the counter roller beyond the axis": (
        held({**PAIR, "distance_mm": None}, size=(0, 100, 130), proven="no_undercut"), "program/"),
    "the counter cam's angle": (
        held({**PAIR, "distance_mm": None}, {**ANGLE, "rise_deg": 25}, size=(0, 100, 160),
             proven=""), "program/0"),
    "the counter cam's largest radius": (
        held(PAIR, {**OUTER, "max_mm": 140}, size=(0, 100, 260)), "program/"),
    "the counter cam's base radius": (
        held(PAIR, {**NEAR, "min_mm": 120.1}, size=(0, 100, 260)), "program/"),
    "a base radius of no counter cam": (held(GROOVE, {**NEAR, "min_mm": 0}), "not covered"),
    "a window's velocity": (
        window("windows", part(50, 60, velocity_mm_per_s={"min": None, "max": 20})), "program/0"),
    "a window's travel": (
        window("windows", part(50, 60, travel_mm={"min": 14, "max": None})), "program/0"),
    "a window that ends before it begins": (
        window("windows", part(60, 50, velocity_mm_per_s={"min": None, "max": 20})), "beyond"),
    "a window beyond its segment": (
        window("windows", part(130, 140, velocity_mm_per_s={"min": None, "max": 20})), "beyond"),
    "a window that says nothing": (window("windows", part(50, 60)), "nothing"),
    "a window's range has no other names": (
        window("windows", part(50, 60, travel_mm={"min": 10, "most": 11})), "max"),
    "a window with a tolerance": (
        window("windows", part(50, 60, travel_mm=15, tolerance_mm=30)), "not covered"),
    "a window's value": (window("windows", part(50, 60, velocity_mm_per_s=20)), "program/0"),
    "a point beside the path": (
        window("points", {"angle_deg": 60, "travel_mm": 15.001, "tolerance_mm": 0}), "program/0"),
    "a tolerance that is negative": (
        window("points", {"angle_deg": 60, "travel_mm": 15, "tolerance_mm": -1}), "negative"),
    "a point at the end of the segment": (
        window("points", {"angle_deg": 120, "travel_mm": 29, "tolerance_mm": 0.5}), "program/0"),
    "a point by its velocity": (
        window("points", {"angle_deg": 60, "travel_mm": 15, "velocity_mm_per_s": -20}),
        "program/0"),
}  # fmt: skip


@pytest.mark.parametrize("name", TRUE)
def test_what_is_true_is_accepted(name: str) -> None:
    code, said = verdict(TRUE[name])
    assert code == 0, said


@pytest.mark.parametrize("name", FALSE)
def test_what_is_false_is_refused(name: str) -> None:
    found, words = FALSE[name]
    code, said = verdict(found)
    assert code in (1, 2), said
    assert words in said.splitlines()[-1], said


def test_travel_of_a_return_counts_in_its_own_sense() -> None:
    for travel, code in ((15, 0), (-15, 1)):
        back = {**move("return", 120, 30), "points": [{"angle_deg": 60, "travel_mm": travel}]}
        program = [ROUND[0], dwell(60), back, dwell(60)]
        found = document("motion", program, LAWS)
        found["claims"].append({"place": "program/2/points", "proven": True})
        assert verdict(found)[0] == code


def test_a_jump_at_a_knot_is_seen_from_both_sides() -> None:
    jump = {"degree": 3, "knots": [0, 0.5, 1], "coefficients": [0, 0, 0.1, 0.9, 1]}
    law = move("rise", 120, 30, smoothness=2)
    found = []
    for ends in ((50, 60), (60, 70)):  # up to the knot, and from it on
        bound = part(*ends, jerk_mm_per_s3={"min": 0, "max": None})
        found.append(verdict(window("windows", bound, laws=[jump, None, SMOOTH, None], rise=law)))
    assert [code for code, _ in found] == [1, 1]  # of the two sides one is negative


PARABOLIC = {**ROUND[0], "law": {"kind": "parabolic", "inflection": 0.5}}
KINKED = {"degree": 2, "knots": [0, 0.5, 1], "coefficients": [0, 0, 1, 1]}


def slow(law: Json | None, first: float, last: float) -> tuple[int, str]:
    """What is said of a jerk of 1 mm/s³ at most on a part of a law whose acceleration jumps."""
    bound = part(first, last, jerk_mm_per_s3={"min": -1, "max": 1})
    rise = PARABOLIC if law is None else move("rise", 120, 30, smoothness=1)
    rise = {**rise, "windows": [bound]}
    found = document("", [rise, *ROUND[1:]], [law, None, SMOOTH, None])
    found["claims"].append({"place": "program/0/windows", "proven": True})
    return verdict(found)


@pytest.mark.parametrize(
    ("law", "ends", "place"),
    [
        (None, (30, 90), "derivative 2 jumps inside"),
        (None, (60, 90), "derivative 2 jumps inside"),
        (None, (0, 30), "derivative 2 jumps at the start of program/0"),
        (None, (90, 120), "derivative 2 jumps at the start of program/1"),
        (KINKED, (50, 70), "derivative 2 jumps inside"),
    ],
)
def test_what_jumps_has_no_bounded_derivative(
    law: Json | None, ends: tuple[float, float], place: str
) -> None:
    """The acceleration of a parabolic law jumps at its ends and in the middle; its jerk is 0."""
    code, text = slow(law, *ends)
    assert code == 1
    assert place in text


def test_next_to_a_jump_a_derivative_has_its_bounds() -> None:
    assert slow(None, 30, 59)[0] == 0
    assert slow(KINKED, 61, 90)[0] == 0
