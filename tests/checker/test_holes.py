"""Small files that say something false, or what their witness does not show: all are refused.

Each was accepted by an earlier checker. They are made here, so that what is wrong can be read.
"""

from typing import Any
from unittest.mock import ANY

import pytest

from synthesis.pipeline.proof_file.checker import checker
from tests.checker.run import verdict

Json = dict[str, Any]
ROLLER = {"kind": "translating_roller", "roller_radius_mm": 10, "offset_mm": 0,
          "closure": {"kind": "force", "contact": "outside", "rim_mm": 0}}  # fmt: skip
FACE = {"kind": "translating_flat_face", "tilt_deg": 0, "offset_mm": 0}
ANGLE = {"kind": "pressure_angle", "rise_deg": 60, "return_deg": 60, "dwell_deg": None}
VELOCITY, JERK = {"kind": "velocity", "max_mm_per_s": 1e6}, {"kind": "jerk", "max_mm_per_s3": 1e12}
RADIUS, CUTTER = {"kind": "profile_radius", "min_mm": 1}, {"kind": "cutter_radius", "radius_mm": 11}
NOWHERE = {"kind": "face_width", "width_mm": None, "left_mm": None, "right_mm": None,
           "near_mm": None, "far_mm": None}  # fmt: skip
SMOOTH = {"degree": 3, "knots": [0, 0.25, 0.75, 1], "coefficients": [0, 0, 0, 1, 1, 1]}
QUADRATIC = {"degree": 2, "knots": [0, 0.1, 0.5, 0.9, 1], "coefficients": [0, 0, 0, 1, 1, 1]}
POLYGON = {"degree": 1, "knots": [0, 0.1, 0.9, 1], "coefficients": [0, 0, 1, 1]}
BENT = {**SMOOTH, "coefficients": [0, 1e-4, 0.1, 1, 1, 1]}
NARROW = {"degree": 3, "knots": [0, 1e-14, 0.99999999999999, 1],  # nearly a line
          "coefficients": [0, 1e-14 / 3, 1 / 3, 2 / 3, 1 - 1e-14 / 3, 1]}  # fmt: skip
SINE = {"kind": "cycloidal", "inflection": 0.5}
LINE = {"degree": 3, "knots": [0, 1], "coefficients": [0, 1 / 3, 2 / 3, 1]}


def still(at: float) -> Json:
    """A law that stays where it is."""
    return {"degree": 3, "knots": [0, 1], "coefficients": [at] * 4}


def move(kind: str, angle: float, lift: float, **law: Any) -> Json:
    law = {"kind": "spline", "smoothness": 2, "overshoot": False, **law}
    return {"kind": kind, "angle_deg": angle, "lift_mm": lift, "law": law}


def dwell(angle: float, **more: Any) -> Json:
    return {"kind": "dwell", "angle_deg": angle, **more}


def straight(angle: float, lift: float, **more: Any) -> Json:
    return {"kind": "constant_velocity", "angle_deg": angle, "lift_mm": lift, **more}


def moves(lift: float = 10, **law: Any) -> list[Json]:
    return [move("rise", 180, lift, **law), move("return", 180, lift, **law)]


def document(
    proven: str, program: list[Json], laws: list[Any] | None, *limits: Json,
    size: tuple[float, ...] = (0, 100), witness: Json | None = None, **question: Any,
) -> Json:  # fmt: skip
    """A proof file whose claims at some places (words) are called proven."""
    asked = {
        "speed_rpm": 10, "program": program, "follower": ROLLER, "limits": list(limits),
        "base_radius_mm": {"min": 20, "max": 220}, "continuity": None,
        "objective": {"kind": "base_radius"}, **question,
    }  # fmt: skip
    named = ["objective/0", *(f"limits/{k}" for k in range(len(limits)))]
    named += ["no_undercut", "self_crossing", "motion", "size"]
    claims = [
        {"place": place, "proven": True, **(witness or {})}
        if place in proven.split()
        else {"place": place, "proven": False, "reason": "-"}
        for place in (named if laws else ["infeasible"])
    ]
    cam = {"size": list(size), "laws": laws} if laws else None
    return {"format": "camwright-proof", "version": 1, "question": asked, "cam": cam,
            "claims": claims}  # fmt: skip


def bound(value: float, *rows: Json, segment: int = 0, ends: Any = (-0.1, 0, 0)) -> Json:
    part = {"segment": segment, "rows": list(rows), "ends": list(ends)}
    return {"at_least": value, "multipliers": {"order": 3, "segments": [part]}}


def named(limit: str, side: int, x: float) -> Json:
    """A row of the second segment, under a named law."""
    rows = [{"limit": limit, "side": side, "multipliers": [[x, 1]]}]
    return {"multipliers": {"order": 3, "segments": [{"segment": 1, "rows": rows, "ends": []}]}}


def chosen(found: Json, *numbers: Json) -> Json:
    """The same with numbers of the cam, segment by segment."""
    found["cam"]["program"] = [*numbers]
    return found


def with_claim(found: Json, index: int, **fields: Any) -> Json:
    found["claims"][index].update(fields)
    return found


ROUND = [move("rise", 120, 30), dwell(60), move("return", 120, 30), dwell(60)]
HALF = [straight(120, 30), dwell(60), straight(120, -30), dwell(60)]
STEEP = [move("rise", 1e-6, 1e6), move("return", 1e-6, 1e6), move("rise", 120, 0.05),
         dwell(59.999998), move("return", 120, 0.05), dwell(60)]  # fmt: skip
ALL = "limits/0 limits/1 no_undercut self_crossing motion size"
# a rise of 18 mm in 180 degrees takes 0.1 mm per degree in the mean: multiplied and summed, the
# rows of this limit on velocity say that there is no such cam
SLOW, MEAN = {"kind": "velocity", "max_mm_per_s": 5}, {"limit": "limits/0", "side": 1,
                                                       "multipliers": [[0, 1, 1, 1]]}  # fmt: skip
TIGHT = {"kind": "velocity", "max_mm_per_s": 1e-3}, {"kind": "jerk", "max_mm_per_s3": 1e-3}

HOLES: dict[str, tuple[Json, str]] = {
    "a follower that never moves": (
        document(ALL, [*moves()], [still(0), still(1)], ANGLE, TIGHT[1]), "class asked for"),
    "a bound above its own cam": (
        document(f"objective/0 {ALL}", [move("rise", 60, 30), move("return", 60, 30), dwell(240)],
                 [still(0), still(1), None], *TIGHT, size=(0, 40),
                 witness=bound(119, ends=[-1, 0, 0])), "class asked for"),
    "continuity is not kept inside a law": (
        document("motion", [move("rise", 120, 30, smoothness=1), dwell(60),
                            move("return", 120, 30, smoothness=1), dwell(60)],
                 [QUADRATIC, None, QUADRATIC, None], continuity=2), "class asked for"),
    "accelerations jump inside a law": (
        document(ALL, moves(smoothness=1), [QUADRATIC] * 2, {**JERK, "max_mm_per_s3": 1e-9}),
        "derivative 2 jumps inside program/0"),
    "velocities jump under a limit on acceleration": (
        document("limits/0", moves(smoothness=0), [POLYGON] * 2,
                 {"kind": "acceleration", "max_mm_per_s2": 1e-9}), "smoothness"),
    "a corner of a roller's profile": (
        document("no_undercut", ROUND, [LINE, None] * 2, RADIUS), "derivative 1 jumps"),
    "a corner under a limit on radius": (
        document("limits/0", HALF, [None] * 4, RADIUS), "derivative 1 jumps"),
    "a corner under a cutter": (
        document("limits/0", HALF, [None] * 4, CUTTER), "derivative 1 jumps"),
    "a corner under a flat face": (
        document("limits/0 no_undercut", [straight(180, 10), straight(180, -10)], [None] * 2,
                 RADIUS, follower=FACE, size=(60,)), "derivative 1 jumps"),
    "a step that is small next to the steeper neighbour": (
        document("motion", STEEP, [SMOOTH, SMOOTH, BENT, None, SMOOTH, None]),
        "derivative 1 jumps"),
    "a corner of a lift that is smaller than enclosures are wide": (
        document("limits/0", [{**each, **({"lift_mm": 1e-40} if "lift_mm" in each else {})}
                              for each in ROUND], [LINE, None] * 2,
                 {"kind": "acceleration", "max_mm_per_s2": 1e-9}), "derivative 0 jumps"),
    "a corner beside a named law that is known less well than it is high": (
        document("limits/0", [{**move("rise", 1e-25, 10), "law": SINE}, *moves()[1:], dwell(180)],
                 [None, {**LINE, "coefficients": [0, 1 / 3, 1, 1]}, None],
                 {"kind": "acceleration", "max_mm_per_s2": 1e60}), "derivative 1 jumps"),
    "a corner beside a very narrow piece": (
        document("no_undercut", ROUND, [NARROW, None] * 2), "derivative 1 jumps"),
    "a pressure angle of 0": (
        document("limits/0", moves(), [SMOOTH] * 2, {**ANGLE, "rise_deg": 0}), "between 0 and 90"),
    "a pressure angle of 90 where nothing reads it": (
        document("limits/1", moves(), [SMOOTH] * 2, {**ANGLE, "dwell_deg": 90}, VELOCITY),
        "between 0 and 90"),
    "a pressure angle that is no number": (
        document("limits/0", moves(), [SMOOTH] * 2, {**ANGLE, "return_deg": False}), "return_deg"),
    "a limit with the name of another claim": (
        document("limits/0", moves(), [SMOOTH] * 2, {"kind": "size", "max_mm": 1}), "not covered"),
    "a limit with the name of a row": (
        document("limits/0", moves(), [SMOOTH] * 2, {"kind": "forward", "x": 1}), "not covered"),
    "a face's width under a roller": (
        document("limits/0", moves(), [SMOOTH] * 2, {**NOWHERE, "width_mm": 1}), "not covered"),
    "a roller of negative radius": (
        document("no_undercut", moves(), [SMOOTH] * 2,
                 follower={**ROLLER, "roller_radius_mm": -30}), "follower"),
    "a negative radius": (
        document("limits/0", moves(), [SMOOTH] * 2, {**RADIUS, "min_mm": -5}), "negative"),
    "a dwell that moves": (
        document("limits/0", [dwell(180, lift_mm=10), move("return", 180, 10)], [None, SMOOTH],
                 VELOCITY), "lift_mm"),
    "a rise that falls": (
        document("limits/0", moves(-10), [SMOOTH] * 2, VELOCITY), "program/0"),
    "lift and velocity": (
        document("limits/0", [straight(180, 10, velocity_mm_per_s=5), move("return", 180, 25)],
                 [None, SMOOTH], VELOCITY), "cannot be read"),
    "a law with an unknown field": (
        document("limits/0", moves(cubic=1), [SMOOTH] * 2, VELOCITY), "cubic"),
    "a range with a unit": (
        document("size", moves(), [SMOOTH] * 2,
                 base_radius_mm={"min": 0, "max": 110, "unit": "inch"}), "range"),
    "a number of the cam that is not that of the question": (
        chosen(document("limits/0", moves(), [SMOOTH] * 2, VELOCITY), {"angle_deg": 90}, {}),
        "asked for"),
    "a chosen number of another kind": (
        chosen(document("limits/0", moves(), [SMOOTH] * 2, VELOCITY), {"rise_mm": 5}, {}),
        "rise_mm"),
    "an offset that is no number": (
        document("size", moves(), [SMOOTH] * 2, size=(False, 100)), "no number"),
    "lifts that do not close": (
        document("infeasible", [move("rise", 180, 18), move("return", 180, 17)], None, SLOW, JERK,
                 witness=bound(0, MEAN)), "do not sum to 0"),
    "a law on a dwell": (
        document("limits/0", ROUND, [SMOOTH, SMOOTH, SMOOTH, None], VELOCITY), "has a law"),
    "a flat face with a range of offsets": (
        document("limits/0", moves(), [SMOOTH] * 2, {**NOWHERE, "right_mm": 1e4}, size=(60,),
                 follower={**FACE, "offset_mm": {"min": 0, "max": 1e6}}), "offset_mm"),
    "an objective that only ends like one": (
        document("objective/0", moves(18), [SMOOTH] * 2, SLOW, witness=bound(1e-9, MEAN),
                 objective={"kind": "\n:) \njerk"}), "not covered"),
    "the other side of a limit that has one": (
        document("infeasible", moves(18), None, SLOW, JERK, follower=FACE, witness=bound(
            0, MEAN, {"limit": "no_undercut", "side": -1, "multipliers": []})),
        "says nothing of program/0"),
    "a segment counted from the end": (
        document("infeasible", [*reversed(moves(18))], None, SLOW, JERK,
                 witness=bound(0, MEAN, segment=-1)), "segment is none of 0 to 1"),
    "more end conditions than there are": (
        document("infeasible", moves(18), None, SLOW, JERK,
                 witness=bound(0, MEAN, ends=[-0.1, 0, 0, 7])), "end conditions"),
    "a density on a given law": (
        document("infeasible", [move("rise", 180, 18), {**move("return", 180, 18), "law": SINE}],
                 None, SLOW, JERK, witness=bound(
                     0, {"limit": "limits/0", "side": -1, "multipliers": [[0, 1, 1, 1]]},
                     segment=1, ends=[])), "a density on a segment that is not free"),
    "rounds of a flat face, whose offset is not its size": (
        document("infeasible", [move("rise", 180, 10), {**move("return", 180, 10), "law": SINE}],
                 None, {**RADIUS, "min_mm": 150}, {**NOWHERE, "width_mm": 14}, JERK, follower=FACE,
                 witness={"rounds": [[{"bound": 0, **named("limits/0", 1, 1)}]],
                          **named("limits/1", -1, 0.5)}), "rounds of a flat face"),
    "a largest radius where the roller is on the other side of the axis": (
        document("limits/0", moves(), [SMOOTH] * 2, {"kind": "outer_radius", "max_mm": 100},
                 size=(0, -60)), "program/0, 0."),
    "a largest radius where the face is on the other side of the axis": (
        document("limits/0", moves(), [SMOOTH] * 2, {"kind": "outer_radius", "max_mm": 100},
                 size=(-60,), follower=FACE), "program/0, 0."),
    "proven, but not true": (
        with_claim(document("", moves(), [SMOOTH] * 2), 0, proven="yes"), "proven"),
    "an empty reason": (with_claim(document("", moves(), [SMOOTH] * 2), 0, reason=""), "reason"),
}  # fmt: skip


@pytest.mark.parametrize("name", HOLES)
def test_what_is_false_or_not_shown_is_refused(name: str) -> None:
    found, words = HOLES[name]
    code, said = verdict(found)
    assert code in (1, 2), said
    assert words in said.splitlines()[-1]


def test_a_file_of_the_same_making_that_is_true_is_accepted() -> None:
    found = document(ALL, ROUND, [SMOOTH, None] * 2, ANGLE, VELOCITY)
    code, said = verdict(found)
    assert (code, said.splitlines()[-1]) == (0, "6 of 7 claims proven"), said


def test_a_radius_that_is_a_root_may_miss_what_is_asked_for_by_its_rounding() -> None:
    for radius, words in ((90.0449898, "but for 1/"), (90.04498, "not within"), (90, "not within")):
        found = document("size", moves(), [SMOOTH] * 2, size=(3, 100), base_radius_mm=radius,
                         follower={**ROLLER, "offset_mm": 3})  # fmt: skip
        assert words in verdict(found)[1]  # the root of 10009 less 10: 90.04498987...


def test_a_question_of_the_same_making_without_a_cam_is_accepted() -> None:
    found = document("infeasible", moves(18), None, SLOW, JERK, witness=bound(0, MEAN))
    assert verdict(found)[0] == 0
    found = document("infeasible", moves(18), None, {**SLOW, "max_mm_per_s": 6}, JERK,
                     witness=bound(0, MEAN))  # fmt: skip
    assert verdict(found)[0] == 1  # just possible


def many(count: int) -> Json:
    """A law of many pieces that is nearly a straight line."""
    middle = [k / count for k in range(1, count)]
    return {"degree": 3, "knots": [0, *middle, 1],
            "coefficients": [0, *(k / (count + 2) for k in range(1, count + 2)), 1]}  # fmt: skip


LONG: dict[str, tuple[Json, str]] = {
    "segments": (document("size", [dwell(3.6)] * 101, [None] * 101), "segments"),
    "limits": (document("size", moves(), [SMOOTH] * 2, *[VELOCITY] * 51), "limits"),
    "pieces": (document("size", moves(), [many(11000), SMOOTH]), "coefficients"),
    "digits": (document("size", moves(), [SMOOTH] * 2, size=(0, 10**26)), "digits"),
}  # fmt: skip


@pytest.mark.parametrize("name", LONG)
def test_what_takes_too_long_cannot_be_read(name: str) -> None:
    found, words = LONG[name]
    code, said = verdict(found)
    assert code == 2, said
    assert words in said.splitlines()[-1]


@pytest.mark.parametrize("what", ["numbers", "coefficients", "halvings of intervals"])
def test_work_is_bounded(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    tight = {**ANGLE, "rise_deg": 10, "return_deg": 10}
    found = document("limits/0 limits/1 motion", moves(30), [SMOOTH] * 2, tight, VELOCITY)
    assert verdict(found)[0] == 0
    monkeypatch.setitem(checker().MOST, what, 1)
    assert verdict(found) == (2, ANY)


def test_steps_of_rounds_that_say_nothing_are_counted() -> None:
    nothing = {"multipliers": {"order": 3, "segments": []}}
    found = document("infeasible", moves(18), None, SLOW, JERK,
                     witness={"rounds": [[{"bound": 0, **nothing}] * 10], **nothing})  # fmt: skip
    assert verdict(found)[0] == 1
    assert checker().spent["coefficients"] == 11 * 2 * len(moves())
