"""Step 5 of the checker: limits just beyond the cam's extremes hold, limits just within do not."""

import copy
import json
import math
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from synthesis import DesignSpec, synthesise
from synthesis.pipeline.proof_file.checker import checker
from tests.checker.truth import Json, motion

NEAR = 3e-4  # relative: what sampling misses of an extreme where a derivative has a corner
ENDS = ("left", "right", "near", "far")  # of a face
ANGLES = {"rise": "rise_deg", "return": "return_deg"}


def file_of(follower: Json, limits: list[Json]) -> Json:
    """Question and cam of a coarse design."""
    law = {"kind": "spline"}
    program = [
        {"kind": "rise", "angle_deg": 70.0, "lift_mm": 20.0, "law": law},
        {"kind": "dwell", "angle_deg": 20.0},
        {"kind": "return", "angle_deg": 80.0, "lift_mm": 20.0, "law": law},
        {"kind": "dwell", "angle_deg": 190.0},
    ]
    jerk = {"kind": "jerk", "max_mm_per_s3": 1.6e6}
    spec = {"speed_rpm": 90.0, "program": program, "follower": follower, "limits": [jerk, *limits]}
    design = synthesise(DesignSpec.model_validate({**spec, "tolerance": 0.02, "proof": "quick"}))
    laws = [m.spline.model_dump() if m.spline else None for m in design.motion]
    question = json.loads(design.spec.model_dump_json())
    return {"question": question, "cam": {"size": design.size, "laws": laws}}


@pytest.fixture(scope="module")
def roller() -> Json:
    follower = {"kind": "translating_roller", "roller_radius_mm": 6.0, "offset_mm": 4.0}
    return file_of(follower, [{"kind": "pressure_angle", "rise_deg": 35.0, "return_deg": 40.0}])


@pytest.fixture(scope="module")
def face() -> Json:
    return file_of({"kind": "translating_flat_face"}, [{"kind": "profile_radius", "min_mm": 3.0}])


@lru_cache(maxsize=4)
def enclosed(question: str, cam: str) -> Any:
    """The checker's cam: its path takes long to enclose, and depends on no limit and no load."""
    judge = checker()
    return judge.Cam(judge.Question(judge.read(question.encode())), judge.read(cam.encode()))


def accepts(document: Json, place: str, limit: Json | None = None) -> bool:
    """Whether the checker accepts a claim about the cam, of a limit in place of all others."""
    changed = copy.deepcopy(document)
    if limit is not None:
        changed["question"]["limits"] = [limit]
    judge = checker()
    judge.spent.clear()
    body = judge.read(json.dumps(changed).encode())
    try:
        question = judge.Question(body["question"])
        if place.startswith("limits/"):
            bare = {**changed["question"], "limits": [], "load": None}
            cam = copy.copy(enclosed(json.dumps(bare), json.dumps(changed["cam"])))
            cam.question = question
        else:
            cam = judge.Cam(question, body["cam"])
        cam.check(place)
    except judge.Failure:
        return False
    return True


def is_sharp(
    document: Json, kind: str, field: str, extreme: float, *, most: bool = True, size: float = 0.0
) -> bool:
    """Whether a limit holds where it is a little looser than the extreme, and only there.

    ``most``: it is a largest value. ``size``: of what is sampled, if it is not the extreme itself.
    """
    little = NEAR * (size or extreme) * (1.0 if most else -1.0)
    others = {"pressure_angle": dict.fromkeys(("rise_deg", "return_deg", "dwell_deg")),
              "face_width": dict.fromkeys(f"{name}_mm" for name in ("width", *ENDS))}  # fmt: skip
    limits = ({"kind": kind, **others.get(kind, {}), field: extreme + d} for d in (little, -little))
    return [accepts(document, "limits/0", limit) for limit in limits] == [True, False]


@pytest.mark.parametrize(("kind", "order"), [("velocity", 1), ("acceleration", 2), ("jerk", 3)])
def test_of_the_motion(roller: Json, kind: str, order: int) -> None:
    s, _, _ = motion(roller["question"], roller["cam"])
    omega = roller["question"]["speed_rpm"] * math.pi / 30.0
    most = float(np.max(np.abs(s[order]))) * omega**order
    field = "max_mm_per_s" + ("", "2", "3")[order - 1]
    assert is_sharp(roller, kind, field, most, size=4.0 * most)  # accelerations are peaked


def test_of_a_roller(roller: Json) -> None:
    s, sense, _ = motion(roller["question"], roller["cam"])
    e, s0 = roller["cam"]["size"]
    x, u = s0 + s[0], s[1] - e
    alpha = np.degrees(np.abs(np.arctan2(u, x)))
    for way, field in ((1.0, "rise_deg"), (-1.0, "return_deg"), (0.0, "dwell_deg")):
        assert is_sharp(roller, "pressure_angle", field, float(np.max(alpha[sense == way])))
    kappa = (x * x + u * (2.0 * s[1] - e) - x * s[2]) / np.hypot(x, u) ** 3
    sharpest = 1.0 / float(np.max(kappa))
    assert is_sharp(roller, "profile_radius", "min_mm", sharpest - 6.0, most=False, size=sharpest)
    assert is_sharp(
        roller, "cutter_radius", "radius_mm", 6.0 - 1.0 / float(np.min(kappa)), most=False
    )
    for place in ("no_undercut", "self_crossing", "motion", "size"):
        assert accepts(roller, place)
    larger = copy.deepcopy(roller)
    larger["question"]["follower"]["roller_radius_mm"] = sharpest * (1.0 + NEAR)
    assert not accepts(larger, "no_undercut")
    assert not accepts(larger, "self_crossing")


def test_of_a_flat_face(face: Json) -> None:
    s, _, _ = motion(face["question"], face["cam"])
    (base,) = face["cam"]["size"]
    assert is_sharp(face, "profile_radius", "min_mm", float(np.min(base + s[0] + s[2])), most=False)
    assert is_sharp(face, "face_width", "right_mm", float(np.max(s[1])))
    assert is_sharp(face, "face_width", "left_mm", -float(np.min(s[1])))
    assert is_sharp(face, "face_width", "width_mm", 2.0 * float(np.max(np.abs(s[1]))))
    smaller = copy.deepcopy(face)
    smaller["cam"]["size"] = [base - float(np.min(base + s[0] + s[2])) * (1.0 + NEAR)]
    assert not accepts(smaller, "no_undercut")


def test_a_profile_that_turns_back_seen_from_the_axis_is_not_called_simple(roller: Json) -> None:
    # a point as roller has no undercut; so near to the axis its normal passes on the other side
    near = copy.deepcopy(roller)
    near["question"]["follower"]["roller_radius_mm"] = 0.0
    assert accepts(near, "self_crossing")
    near["cam"]["size"] = [10.0, 1.0]
    assert accepts(near, "no_undercut")
    assert not accepts(near, "self_crossing")


def test_sizes_joints_and_backward_moves(roller: Json) -> None:
    outside = copy.deepcopy(roller)
    outside["question"]["base_radius_mm"] = {"min": 500.0, "max": None}
    assert not accepts(outside, "size")
    for index, value in ((1, 1e-4), (-2, 1.0001)):
        bent = copy.deepcopy(roller)
        bent["cam"]["laws"][0]["coefficients"][index] = value
        assert not accepts(bent, "motion")
    back = copy.deepcopy(roller)
    middle = back["cam"]["laws"][2]["coefficients"]
    k = len(middle) // 2
    middle[k], middle[k + 1] = middle[k + 1], middle[k] - 0.05
    assert not accepts(back, "motion")


def test_irrational_numbers_lie_between_their_bounds() -> None:
    judge = checker()
    pi = Fraction(31415926535897932384626433832795028841971, 10**40)  # to 40 decimals, cut off
    low, high = judge.C
    assert low < (pi + Fraction(1, 10**40)) / 180
    assert high > pi / 180
    assert high - low < Fraction(1, 10**34)
    low, high = judge.tangent(Fraction(30))
    assert 3 * low**2 < 1 < 3 * high**2
    assert high - low < Fraction(1, 10**33)
    low, high = judge.tangent(Fraction(15))  # 2 - √3
    assert (2 - high) ** 2 < 3 < (2 - low) ** 2
    root = judge.root(Fraction(2))
    assert 2 < root**2 < 2 + Fraction(1, 10**34)


def test_rows_that_every_cam_keeps_are_weaker_than_the_limit(roller: Json) -> None:
    judge = checker()
    judge.spent.clear()
    question = judge.Question(judge.read(json.dumps(roller["question"]).encode()))
    for side in (1, -1):
        alpha, size, upper = question.row(question.program[0], question.limits["limits/1"], side)
        assert alpha[:2] == [size[1], side]
        assert size[0] == -side
        assert upper == 0
        # of s and of s0: c tan 35 degrees rounded up, and by very little
        low = judge.tangent(Fraction(35))[0] * judge.C[0]
        assert low < -alpha[0] < low * (1 + Fraction(1, 10**30))


def test_the_largest_radius(roller: Json, face: Json) -> None:
    s, _, _ = motion(face["question"], face["cam"])
    assert is_sharp(face, "outer_radius", "max_mm", face["cam"]["size"][0] + float(s[0].max()))
    s, _, _ = motion(roller["question"], roller["cam"])
    e, s0 = roller["cam"]["size"]
    farthest = math.hypot(e, s0 + float(s[0].max())) - 6.0
    assert is_sharp(roller, "outer_radius", "max_mm", farthest)


def test_numbers_that_the_question_leaves_free_lie_in_their_ranges(roller: Json) -> None:
    document = copy.deepcopy(roller)
    rise, dwell = document["question"]["program"][:2]
    rise["angle_deg"], dwell["angle_deg"] = {"min": 60.0, "max": 75.0}, {"min": 5.0, "max": 30.0}
    judge = checker()

    def holds(*chosen: Json) -> bool:
        document["cam"]["program"] = [*chosen, {}, {}]
        judge.spent.clear()
        body = judge.read(json.dumps(document).encode())
        try:
            question = judge.Question(body["question"], body["cam"]["program"])
            judge.Cam(question, body["cam"]).check("limits/0")
        except judge.Failure:
            return False
        return True

    assert holds({"angle_deg": 70.0}, {"angle_deg": 20.0})
    assert not holds({"angle_deg": 76.0}, {"angle_deg": 14.0})  # beyond the range
    assert not holds({"angle_deg": 70.0}, {})  # not chosen
    assert not holds({"angle_deg": 60.0}, {"angle_deg": 30.0})  # too steep for the jerk limit
    rise["angle_deg"] = 70.0
    assert holds({}, {"angle_deg": 20.0})  # given: nothing is to be chosen
    assert holds({"angle_deg": 70.0}, {"angle_deg": 20.0})
    assert not holds({"angle_deg": 60.0}, {"angle_deg": 20.0})  # not that of the question


def test_no_field_of_a_question_may_be_missing(roller: Json, face: Json) -> None:
    """A default that nobody sees would be part of what is proven: a groove's width, say."""
    judge = checker()
    closures: list[Json] = [
        {"kind": "groove", "clearance_mm": 0.1, "rim_mm": 2.0},
        {"kind": "force", "contact": "inside", "rim_mm": 2.0},
    ]
    window = {"from_deg": 10.0, "to_deg": 30.0, "travel_mm": {"min": 0.0, "max": 19.0}}

    def read(question: Json) -> None:
        judge.spent.clear()
        judge.Question(judge.read(json.dumps(question).encode()))

    for closure in closures:
        question = copy.deepcopy(roller["question"])
        question["follower"]["closure"] = closure
        question["program"][0]["windows"] = [window]
        read(question)
        optional = {"contact": "outside"} if closure["kind"] == "force" else {}
        places = [question["follower"]["closure"], question["follower"],
                  question["program"][0]["windows"][0], question["program"][0],
                  question["program"][0]["law"], *question["limits"]]  # fmt: skip
        names = ("clearance_mm", "rim_mm", "offset_mm", "roller_radius_mm", "from_deg", "to_deg",
                 "law", "lift_mm", "smoothness", "overshoot", "dwell_deg",
                 "max_mm_per_s3")  # fmt: skip
        for place in places:
            for name in set(place) & set(names) - set(optional):
                value = place.pop(name)
                with pytest.raises(judge.Failure) as failed:
                    read(question)
                assert failed.value.args[1:] == (2,), name
                place[name] = value
    # widths of the other kind of face need not stand there
    question = copy.deepcopy(face["question"])
    question["limits"] = [{"kind": "face_width", "width_mm": None, "left_mm": 60.0,
                           "right_mm": 60.0}]  # fmt: skip
    read(question)
