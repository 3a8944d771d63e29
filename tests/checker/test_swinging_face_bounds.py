"""The least base radius of a swinging face under given laws, against sizes that a test tries."""

import json
import math
from copy import deepcopy
from functools import cache
from typing import Any
from unittest import mock

import numpy as np
import pytest

from synthesis import DesignSpec, proof, synthesise
from synthesis.pipeline.proof_file import swinging_faces
from synthesis.pipeline.proof_file.checker import checker
from tests.checker.run import verdict
from tests.checker.test_any_law import claim_of
from tests.checker.test_holes import NOWHERE
from tests.checker.truth import face_contact, motion

Json = dict[str, Any]
PROGRAM: list[Json] = [
    {"kind": "rise", "angle_deg": 90.0, "lift_deg": 12.0, "law": {"kind": "cycloidal"}},
    {"kind": "dwell", "angle_deg": 40.0},
    {"kind": "return", "angle_deg": 110.0, "lift_deg": 12.0, "law": {"kind": "polynomial_3_4_5"}},
    {"kind": "dwell", "angle_deg": 120.0},
]
RADIUS: Json = {"kind": "profile_radius", "min_mm": 5.0}
WIDTH: Json = {**NOWHERE, "near_mm": 48.0}
ANGLE: Json = {"kind": "pressure_angle", "rise_deg": 5.0, "return_deg": 20.0, "dwell_deg": None}
FAR: Json = {**NOWHERE, "far_mm": 95.0}


@cache
def found(sense: str, distance: float | None, away: float, *kinds: str) -> Json:
    """The file of the best cam of a question."""
    limits = [{"RADIUS": RADIUS, "WIDTH": WIDTH, "ANGLE": ANGLE, "FAR": FAR}[k] for k in kinds]
    follower = {
        "kind": "oscillating_flat_face", "face_offset_mm": away, "sense": sense,
        "centre_distance_mm": distance or {"min": 80.0, "max": 100.0},
    }  # fmt: skip
    body = {"speed_rpm": 100, "program": PROGRAM, "follower": follower, "limits": limits,
            "objective": {"kind": "base_radius"}}  # fmt: skip
    design = synthesise(DesignSpec.model_validate(body))
    with mock.patch.object(swinging_faces, "LEAVES", 100):  # closer than the tests ask for
        file: Json = json.loads(json.dumps(proof(design)))
    return file


def keeps(file: Json, moved: tuple[Any, Any], distance: float, start: float) -> bool:
    """Whether a face that starts at an angle [rad] keeps all limits; ``moved``: s and its sense."""
    question = file["question"]
    away = question["follower"]["face_offset_mm"]
    cam = {**file["cam"], "size": [distance * math.cos(start), distance * math.sin(start)]}
    s, turns = moved
    along, _, radius, _ = face_contact(question, cam, s)
    if np.min(along) <= 0.0 or np.min(radius) < 0.0:
        return False
    for limit in question["limits"]:
        if limit["kind"] == "profile_radius" and np.min(radius) < limit["min_mm"]:
            return False
        if limit["kind"] == "face_width" and (
            np.min(along) < (limit["near_mm"] or 0.0)
            or np.max(along) > (limit["far_mm"] or math.inf)
        ):
            return False
        if limit["kind"] == "pressure_angle":
            for way, name in ((1.0, "rise_deg"), (-1.0, "return_deg")):
                most = math.tan(math.radians(limit[name]))
                if np.any(abs(away) > most * along[turns == way]):
                    return False
    return True


CASES = [
    ("opposite", 95.0, 1.5, "RADIUS"),
    ("same", 85.0, -3.0, "RADIUS"),
    ("same", 90.0, 7.0, "RADIUS", "WIDTH"),
    ("opposite", None, 6.0, "RADIUS", "ANGLE"),
    ("opposite", 90.0, 2.0, "RADIUS", "FAR"),
]


@pytest.mark.parametrize("case", CASES)
def test_the_bound_is_the_least_base_radius_that_a_search_finds(case: Any) -> None:
    file = found(*case)
    code, said = verdict(file)
    assert code == 0, said
    assert claim_of(file)["proven"] is True
    least, (_, distance, away, *_) = math.inf, case
    moved = motion(file["question"], file["cam"])[:2]
    distances = [distance] if distance else np.linspace(80.0, 100.0, 11).tolist()
    for d in distances:
        angles = np.linspace(0.0, 1.2, 49)
        kept = [a for a in angles.tolist() if d * math.sin(a) > away and keeps(file, moved, d, a)]
        if kept:
            low, high = min(kept) - angles[1], min(kept)
            for _ in range(30):
                middle = 0.5 * (low + high)
                low, high = (low, middle) if keeps(file, moved, d, middle) else (middle, high)
            least = min(least, d * math.sin(high) - away)
    bound = claim_of(file)["at_least"]
    # its rows of a radius are differences along the cam
    assert bound <= least * (1.0 + 1e-4)
    assert bound > least * (1.0 - (2e-4 if distance else 2e-2))


@pytest.mark.parametrize("case", CASES[:4])
def test_no_larger_base_radius_follows(case: Any) -> None:
    file = deepcopy(found(*case))
    claim = claim_of(file)
    for name in ("at_least", "below"):
        claim[name] *= 1.0005
    assert verdict(file)[0] == 1


def leaves(body: Json) -> list[Json]:
    return [x for case in body["cases"] for x in leaves(case)] if "cases" in body else [body]


def test_no_leaf_may_be_missing() -> None:
    """The pivot is at one distance: the sizes lie on an arc, which one box does not know."""
    file = deepcopy(found(*CASES[0]))
    parts = [each for each in leaves(claim_of(file)) if each["multipliers"]["segments"]]
    assert len(parts) > 1
    for each in parts:
        kept = each["multipliers"]
        each["multipliers"] = {"order": 3, "segments": []}
        assert verdict(file)[0] == 1
        each["multipliers"] = kept
    assert verdict(file)[0] == 0


def test_a_row_of_a_free_law_is_none() -> None:
    file = deepcopy(found(*CASES[0]))
    spline = {"kind": "spline", "smoothness": 2, "overshoot": False}
    for each in file["question"]["program"]:
        each.update({"law": spline} if "law" in each else {})
    jerk = {"kind": "jerk", "max_deg_per_s3": 1e9}
    file["question"]["limits"].append(jerk)
    file["claims"].append({"place": "limits/1", "proven": False, "reason": "-"})
    code, said = verdict(file)
    assert (code, "says nothing of program" in said) == (1, True)


@pytest.mark.parametrize("distance", [None, {"min": 80.0, "max": None}, {"min": 80.0, "max": 1e3}])
def test_a_pivot_that_may_be_farther_away_proves_less(distance: Any) -> None:
    file = deepcopy(found(*CASES[0]))
    file["question"]["follower"]["centre_distance_mm"] = distance
    assert verdict(file)[0] == 1


def test_rounds_speak_of_rollers_alone() -> None:
    file = deepcopy(found(*CASES[0]))
    claim_of(file)["rounds"] = []
    code, said = verdict(file)
    assert (code, "rounds of a flat face" in said) == (1, True)


def test_rows_are_what_limits_leave_to_spare() -> None:
    """α · z ≤ ϱ with e and the base radius, at sizes and places at random."""
    file, chance = found(*CASES[3]), np.random.default_rng(4)
    judge = checker()
    judge.spent.clear()
    question = judge.Question(judge.read(json.dumps(file["question"]).encode()))
    limits = [question.limits[f"limits/{k}"] for k in (0, 1)]
    for _ in range(20):
        p, q = chance.uniform(40, 90), chance.uniform(10, 60)
        cam = {**file["cam"], "size": [p, q]}
        s, turns, _ = motion(file["question"], cam)
        along, _, radius, away = face_contact(file["question"], cam, s)
        # a place in the middle of a sample of the return, x of the segment
        index = int(np.flatnonzero(turns == -1.0)[chance.integers(20, 300)])
        first = int(np.flatnonzero(turns == -1.0)[0])
        x = (index - first + 0.5) / int(np.sum(turns == -1.0))
        segment, speed = question.program[2], float(np.radians(s[1][index]))
        w = 1.0 + question.sense * speed
        most = math.tan(math.radians(20.0))
        for limit, spare in (
            (limits[0], (radius[index] - 5.0) * w**3),
            (limits[1], along[index] * w - abs(away) * w / most),
        ):
            _, size, rest = question.face_row(segment, limit, judge.Fraction(x), 1)
            e, s0 = question.sense * (p - 1.0), q - away
            left = float(rest) - float(size[0]) * e - float(size[1]) * s0
            assert left == pytest.approx(spare, rel=2e-3, abs=2e-2)
