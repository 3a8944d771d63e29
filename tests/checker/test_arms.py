"""Arms and tilted faces: limits just beyond the cam's extremes hold, those just within do not."""

import json
import math
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from synthesis.pipeline.proof_file.checker import checker
from tests.checker.run import verdict
from tests.checker.test_holes import ANGLE, FACE, JERK, SINE, SMOOTH, document, dwell, move
from tests.checker.test_limits import is_sharp
from tests.checker.truth import arm_paths, broken, motion

Json = dict[str, Any]
ARM: Json = {"kind": "oscillating_roller", "roller_radius_mm": 10, "arm_mm": 80.0, "sense": "same",
             "centre_distance_mm": 100, "pivot_direction_deg": 0}  # fmt: skip
GROOVE = {"kind": "groove", "clearance_mm": 1, "rim_mm": 5}
PAIR = {"kind": "conjugate", "roller_radius_mm": 20, "arm_mm": 70, "angle_deg": None}
TILTED = {**FACE, "tilt_deg": -12.5, "offset_mm": 7}
LAWS = [SMOOTH, None, SMOOTH, None]
OF_CAM = "no_undercut self_crossing motion size"
START = math.radians(33)


def swing(kind: str, angle: float, lift: float, **law: Any) -> Json:
    found = move(kind, angle, lift)
    found["lift_deg"] = found.pop("lift_mm")
    return {**found, "lift_mm": None, "law": {**found["law"], **law}}


PROGRAM = [swing("rise", 120, 15), dwell(60), swing("return", 120, 15), dwell(60)]
NAMED = [{**PROGRAM[0], "law": SINE}, *PROGRAM[1:]]


def arm(*limits: Json, size: Any = None, named: bool = False, **follower: Any) -> Json:
    """A proof file of an arm that swings from 33 to 48 degrees, by a named law if so asked."""
    size = size or (100 * math.cos(START), 100 * math.sin(START))
    places = " ".join(f"limits/{k}" for k in range(len(limits)))
    program, laws = (NAMED, [None, *LAWS[1:]]) if named else (PROGRAM, LAWS)
    return document(f"{OF_CAM} {places}", program, laws, *limits, size=size,
                    follower={**ARM, **follower}, base_radius_mm=None)  # fmt: skip


def extremes(found: Json, number: int = 0) -> Any:
    """Tangents of pressure angles, convex curvatures, and distances along a path, by sampling."""
    s, sense, _ = motion(found["question"], found["cam"])
    *_, (path, driven, _, _) = list(arm_paths(found["question"], found["cam"], s))[: number + 1]
    share = np.conj(driven) * path[1]
    slope = np.abs(share.real / share.imag) * (sense == 1.0)
    bend = -(np.conj(path[1]) * path[2]).imag / np.abs(path[1]) ** 3
    return math.degrees(math.atan(np.max(slope))), bend, np.abs(path[0])


@pytest.mark.parametrize("sense", ["same", "opposite"])
def test_limits_of_an_arm_are_sharp(sense: str) -> None:
    found = arm(sense=sense, closure={"kind": "force", "contact": "outside", "rim_mm": 0})
    angle, bend, far = extremes(found)
    assert is_sharp(found, "pressure_angle", "rise_deg", angle)
    assert is_sharp(found, "profile_radius", "min_mm", 1 / np.max(bend) - 10, most=False)
    assert is_sharp(found, "outer_radius", "max_mm", np.max(far) - 10)
    if np.min(bend) < 0.0:
        assert is_sharp(found, "cutter_radius", "radius_mm", 10 - 1 / np.min(bend), most=False)


def test_limits_of_the_counter_arm_are_sharp() -> None:
    size = [100 * math.cos(START), 100 * math.sin(START), 85]
    found = arm(size=size, closure=PAIR)
    (main, convex, wide), (other, bend, far) = extremes(found), extremes(found, 1)
    widest = np.max(wide) - 10
    assert other > main
    assert is_sharp(found, "pressure_angle", "rise_deg", other)
    assert 1 / np.max(bend) - 20 < 1 / np.max(convex) - 10
    assert is_sharp(found, "profile_radius", "min_mm", 1 / np.max(bend) - 20, most=False)
    assert is_sharp(found, "outer_radius", "max_mm", max(np.max(far) - 20, widest))


def test_limits_of_a_groove_on_an_arm_are_sharp() -> None:
    found = arm(closure=GROOVE)
    _, bend, far = extremes(found)
    assert is_sharp(found, "outer_radius", "max_mm", np.max(far) + 10.5 + 5)
    assert is_sharp(found, "cutter_radius", "radius_mm", 1 / np.max(bend) + 10.5, most=False)


def test_limits_on_an_arm_are_in_degrees() -> None:
    found = arm()
    s, *_ = motion(found["question"], found["cam"])
    for k, kind in ((1, "velocity"), (2, "acceleration"), (3, "jerk")):
        field = "max_deg_per_s" + ("", "2", "3")[k - 1]
        most = float(np.max(np.abs(s[k]))) * (10 * math.pi / 30) ** k
        assert k == 3 or is_sharp(found, kind, field, most, size=2 * most)
        assert verdict(arm({"kind": kind, field: 1e12, field.replace("deg", "mm"): None}))[0] == 0
        code, said = verdict(arm({"kind": kind, field.replace("deg", "mm"): 1e12}))
        assert (code, "not covered" in said) == (1, True)


@pytest.mark.parametrize("tilt", [-12.5, 20.0])
def test_limits_of_a_tilted_face_are_sharp(tilt: float) -> None:
    program = [move("rise", 120, 30), dwell(60), move("return", 120, 30), dwell(60)]
    follower = {**TILTED, "tilt_deg": tilt}
    found = document(OF_CAM, program, LAWS, follower=follower, size=(60,))
    assert verdict(found)[0] == 0
    s, *_ = motion(found["question"], found["cam"])
    cos, tan = math.cos(math.radians(tilt)), math.tan(math.radians(tilt))
    radius = float(np.min((s[0] + s[2]) * cos))
    assert is_sharp(found, "profile_radius", "min_mm", 60 + radius, most=False, size=150)
    assert is_sharp(found, "outer_radius", "max_mm", 60 + 30 * cos)
    assert is_sharp(found, "pressure_angle", "rise_deg", abs(tilt))
    at = s[1] * cos - (60 + s[0] * cos) * tan - 7 / cos
    right, left = float(np.max(at)), float(-np.min(at))
    assert is_sharp(found, "face_width", "right_mm", right, size=60) == (right > 0)
    assert is_sharp(found, "face_width", "left_mm", left, size=60) == (left > 0)


@pytest.mark.parametrize("tilt", [0.0, 25.0])
def test_a_row_of_a_tilted_face_holds_wherever_the_limit_does(tilt: float) -> None:
    limit = {"kind": "profile_radius", "min_mm": 4}
    found = document("", [move("rise", 180, 30), move("return", 180, 30)], LAWS[:3:2], limit,
                     follower={**FACE, "tilt_deg": tilt}, size=(60,))  # fmt: skip
    judge = checker()
    question = judge.Question(judge.read(json.dumps(found).encode())["question"])
    alpha, size, upper = question.row(question.program[0], question.limits["limits/0"], 1)
    c, cos = math.pi / 180, math.cos(math.radians(tilt))
    for s, base in ((0.0, 20.0), (30.0, 20.0), (30.0, 60.0)):
        a = ((4 - base) / cos - s) * c * c  # just at the limit, per degree²
        value = alpha[0] * s + alpha[2] * a + size[1] * base / cos
        assert float(value) == pytest.approx(float(upper), rel=1e-12)
    question.radii[1] = judge.Fraction(60)
    assert float(question.highest()) == pytest.approx(60 / cos, rel=1e-12)


def test_a_row_of_a_face_holds_where_its_law_goes_below_the_lowest_position() -> None:
    law = {"overshoot": True}
    program = [move("rise", 120, 30, **law), dwell(60), move("return", 120, 30, **law), dwell(60)]
    limit = {"kind": "profile_radius", "min_mm": 0}
    found = document("", program, LAWS, limit, JERK, follower=FACE, size=(60,))
    judge = checker()
    question = judge.Question(judge.read(json.dumps(found).encode())["question"])
    segment, pi = question.program[0], Fraction(31415926535897932384626433832795028841971693993751)
    alpha, _, upper = question.row(segment, question.limits["limits/0"], 1)
    c, deep = pi / 10**49 / 180, segment.depth(question.jerk)
    assert deep > 0
    for s in (-deep, Fraction(0), Fraction(30)):
        a = -s * c * c  # just at the limit, with a base radius of 0
        assert alpha[0] * s + alpha[2] * a <= upper
    question.jerk = None  # nothing is known of how far it goes
    assert question.row(segment, question.limits["limits/0"], 1) is None


WRONG: dict[str, tuple[Json, str]] = {
    "the pivot's distance is not as asked": (arm(centre_distance_mm=100.001), "not within"),
    "the pivot's distance is beyond its range": (
        arm(centre_distance_mm={"min": 101, "max": None}), "not within"),
    "the pivot's distance is less than nothing": (
        arm(centre_distance_mm={"min": None, "max": -100}), "not within"),
    "the base radius is not as asked": (
        {**arm(), "question": {**arm()["question"], "base_radius_mm": 60}}, "not within"),
    "the arm is not chosen": (arm(arm_mm={"min": 70, "max": 90}), "as many laws or sizes"),
    "the arm is beyond its range": (
        arm(arm_mm={"min": 81, "max": 90}, size=(100 * math.cos(START), 100 * math.sin(START), 80)),
        "not within"),
    "the angle between the arms is beyond its range": (
        arm(closure={**PAIR, "angle_deg": {"min": 96, "max": 97}},
            size=(100 * math.cos(START), 100 * math.sin(START), 95)), "not within"),
    "an angle at the start": (arm(initial_angle_deg=33), "initial_angle_deg"),
    "no sense": (arm(sense="left"), "no sense"),
    "a counter roller of a slide": (arm(closure={**PAIR, "distance_mm": 100}), "not covered"),
    "an arm that drives inwards": (
        arm(size=(100 * math.cos(START), -100 * math.sin(START))), "program/0"),
    "an arm that passes the line to the axis": (
        arm(size=(100 * math.cos(math.radians(170)), 100 * math.sin(math.radians(170)))),
        "program/0"),
    "a lift in mm": (document("motion", [move("rise", 180, 15), move("return", 180, 15)],
                              [SMOOTH] * 2, follower=ARM, size=(80, 60)), "not covered"),
    "a size in rounds": (
        document("infeasible", PROGRAM, None, {"kind": "jerk", "max_deg_per_s3": 1e9}, ANGLE,
                 follower=ARM, witness={"rounds": [[{"bound": 2, "multipliers": {
                     "order": 3, "segments": []}}]], "multipliers": {"order": 3, "segments": []}}),
        "do not exclude every size"),
    "a row of an arm's pressure angle": (
        document("infeasible", PROGRAM, None, {"kind": "jerk", "max_deg_per_s3": 1e9}, ANGLE,
                 follower=ARM, witness={"multipliers": {"order": 3, "segments": [
                     {"segment": 2, "rows": [{"limit": "limits/1", "side": 1, "multipliers":
                                              [[0.5, 1]]}], "ends": [0, 0, 0]}]}}),
        "is not [x, factor, swing]"),
    "a row of an arm without a box": (
        document("infeasible", PROGRAM, None, {"kind": "jerk", "max_deg_per_s3": 1e9}, ANGLE,
                 follower=ARM, base_radius_mm=None,
                 witness={"multipliers": {"order": 3, "segments": [
                     {"segment": 2, "rows": [{"limit": "limits/1", "side": 1, "multipliers":
                                              [[0.5, 1, 7]]}], "ends": [0, 0, 0]}]}}),
        "has no range"),
    "a face that stands along its slide": (
        document("motion", PROGRAM[1:2], [None], follower={**FACE, "tilt_deg": 90}, size=(60,)),
        ""),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_false_of_an_arm_is_refused(name: str) -> None:
    found, words = WRONG[name]
    code, said = verdict(found)
    assert code in (1, 2), said
    assert words in said.splitlines()[-1], said


def test_what_is_true_of_an_arm_is_accepted() -> None:
    for found in (
        arm(ANGLE, named=True),
        arm(ANGLE, closure=GROOVE),
        arm({**JERK, "max_mm_per_s3": None, "max_deg_per_s3": 1e12}),
    ):
        code, said = verdict(found)
        assert code == 0, said
        assert not any(
            broken(found, c["place"])
            for c in found["claims"]
            if c["proven"] and c["place"] != "limits/0"
        )


@pytest.mark.parametrize("terms", [3, 4, 10])
def test_a_series_of_an_angle_lies_around_its_sine(
    terms: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    judge = checker()
    monkeypatch.setattr(judge, "TERMS", terms)
    for degrees in ([0, 0.3, 0.1], [44.4, 45.2, 45.9, 45.7], [-1.5, 1.5], [179.9, 180.2]):
        exact = [judge.Fraction(repr(float(x))) for x in degrees]
        for found, wave in zip(judge.waves(judge.enclose(exact)), (np.sin, np.cos), strict=True):
            for t in np.linspace(0.0, 1.0, 9):
                angle = bernstein_value(degrees, t)
                low, high = (
                    bernstein_value([pair[k] / judge.UNIT for pair in found], t) for k in (0, 1)
                )
                assert low - 1e-15 <= wave(math.radians(angle)) <= high + 1e-15
            assert degrees[0] or terms < 10 or all(y - x <= judge.SHARP for x, y in found)


def test_powers_that_are_cut_off_are_added_as_what_they_come_to() -> None:
    judge, high = checker(), 14
    b = [((k % 3 - 1) * judge.UNIT, (k % 3 - 1) * judge.UNIT + judge.UNIT * k) for k in range(15)]
    found = judge.cut(b)
    assert high + 1 == len(b) > len(found) == judge.TERMS + 1
    for t in np.linspace(0.0, 1.0, 9):
        low, most = (bernstein_value([pair[k] / judge.UNIT for pair in found], t) for k in (0, 1))
        for k in (0, 1):
            assert low <= bernstein_value([pair[k] / judge.UNIT for pair in b], t) <= most
    narrow = [(x, x + 1000) for x, _ in b[:5]]  # nothing is cut off
    found = judge.cut(narrow)
    assert all(y - x < 1100 for x, y in found)
    assert all(x <= z <= w <= y for (x, y), (z, w) in zip(found[::4], narrow[::4], strict=True))


def test_sines_of_known_angles_lie_between_both_numbers() -> None:
    judge, half = checker(), Fraction(1, 2)
    for degrees, wave, value in ((30, 0, half), (150, 0, half), (60, 1, half), (300, 1, half),
                                 (-30, 0, -half), (180, 1, -1), (360, 0, 0)):  # fmt: skip
        low, high = judge.circle(Fraction(degrees))[wave]
        assert low < value < high or (low <= value <= high and abs(value) != half)
        assert high - low < Fraction(1, 10**32)


def bernstein_value(coefficients: Any, t: float) -> float:
    b = [float(x) for x in coefficients]
    while len(b) > 1:
        b = [(1 - t) * x + t * y for x, y in pairwise(b)]
    return b[0]
