"""Bounds of an arm's size: rows hold all over their box, and changed trees are refused."""

import copy
import json
import math
import random
from fractions import Fraction
from typing import Any

import pytest

from synthesis import DesignSpec, proof, synthesise
from synthesis.pipeline.proof_file.arms import in_boxes
from synthesis.pipeline.proof_file.checker import as_bytes, checker
from tests.checker.run import verdict
from tests.checker.test_arms import arm
from tests.checker.test_holes import ANGLE, SMOOTH, document, dwell, move
from tests.hard.families import random_scene

Json = dict[str, Any]
SLOPE = 35.0  # deg
ANGLES = {"kind": "pressure_angle", "rise_deg": SLOPE, "return_deg": SLOPE, "dwell_deg": None}


def question_of(sense: str, **follower: Any) -> Any:
    judge, found = checker(), arm(ANGLES, sense=sense, **follower)
    judge.spent.clear()
    return judge.Question(judge.read(json.dumps(found["question"]).encode()))


def boxes(chance: random.Random, question: Any) -> list[tuple[float, float]]:
    """Give a question a box of e and s0, and say which."""
    ends = [(e, e + chance.uniform(0.0, 0.2)) for e in (chance.uniform(-0.4, 0.4),
                                                        chance.uniform(0.05, 0.6))]  # fmt: skip
    question.offsets, question.heights = ([Fraction(repr(x)) for x in each] for each in ends)
    question.bent.clear()
    return ends


@pytest.mark.parametrize("sense", ["same", "opposite"])
def test_rows_of_a_box_hold_all_over_it(sense: str) -> None:
    chance, question = random.Random(sense), question_of(sense)
    judge, segment = checker(), question.program[0]
    (limit,) = (each for each in question.limits.values() if each["kind"] == "pressure_angle")
    k, slope, lift = question.sense, math.tan(math.radians(SLOPE)), float(segment.lift)
    for _ in range(12):
        ends = boxes(chance, question)
        for side in (1, -1):
            touch = Fraction(repr(round(chance.uniform(0.0, lift), 3)))
            row = question.bent_row(segment, limit, Fraction(2, 5), side, touch)
            (a, b, *_), size, most = ([float(x) for x in row[0]], row[1], float(row[2]))
            spare = []
            for n in range(300):
                e, s0 = (x + chance.choice((0.0, 1.0, chance.random())) * (y - x) for x, y in ends)
                swing = math.radians(lift * chance.choice((0.0, 1.0, chance.random())))
                if n == 0:
                    (e, _), (s0, _), swing = *ends, math.radians(float(touch))
                p, q = 1.0 + k * e, s0
                across = q * math.cos(swing) + p * math.sin(swing)
                beside = k * (p * math.cos(swing) - q * math.sin(swing) - 1.0)
                speed = side * (slope * across + side * beside)  # the largest that is allowed
                g, dg = math.degrees(swing) / lift, speed * float(segment.degrees) / lift
                spare.append(most - a * g - b * dg - float(size[0]) * e - float(size[1]) * s0)
            assert min(spare) > -1e-12
            assert min(spare) < 0.1  # with swings of 15 degrees
    judge.spent.clear()


def test_the_work_of_a_row_grows_with_its_range_of_swings() -> None:
    judge, question = checker(), question_of("same")
    question.offsets, question.heights = [Fraction(0), Fraction(1)], [Fraction(0), Fraction(1)]
    (limit,) = (each for each in question.limits.values() if each["kind"] == "pressure_angle")
    taken = []
    for x in (Fraction(1, 5), Fraction(1, 5), Fraction(2, 5)):
        judge.spent.clear()
        question.bent_row(question.program[0], limit, x, 1, Fraction(6))
        taken.append(judge.spent["coefficients"])
    assert taken == [40 + 6 * 10 + 6 * 100, 0, 40 + 6 * 10]  # 15 degrees in parts of less than 3


def test_the_row_of_one_size_and_swing_is_the_limit_itself() -> None:
    question = question_of("same")
    question.offsets, question.heights = [Fraction(1, 10)] * 2, [Fraction(3, 10)] * 2
    question.known[0, Fraction(2, 5)] = [Fraction(6), Fraction(6), None, None]
    limit = next(x for x in question.limits.values() if x["kind"] == "pressure_angle")
    row = question.bent_row(question.program[0], limit, Fraction(2, 5), 1, Fraction(6))
    swing, slope = math.radians(6.0), math.tan(math.radians(SLOPE))
    across = 0.3 * math.cos(swing) + 0.9 * math.sin(swing)
    beside = -(0.9 * math.cos(swing) - 0.3 * math.sin(swing) - 1.0)
    dg = (slope * across + beside) * 120.0 / 15.0
    spare = row[2] - row[0][0] * Fraction(6, 15) - row[0][1] * Fraction(dg)
    assert abs(spare - row[1][0] / 10 - row[1][1] * Fraction(3, 10)) < 1e-12


@pytest.mark.parametrize("sense", ["same", "opposite"])
def test_rows_of_the_distance_hold_all_over_their_box(sense: str) -> None:
    distance = {"min": 90.0, "max": 110.0}  # of an arm of 80 mm
    chance, question = random.Random(sense), question_of(sense, centre_distance_mm=distance)
    inside = 0
    for _ in range(60):
        ends = boxes(chance, question)
        rows = [question.distance_row(side) for side in (1, -1)]
        for _ in range(60):
            e, s0 = (chance.uniform(*each) for each in ends)
            if 90.0 <= 80.0 * math.hypot(1.0 + question.sense * e, s0) <= 110.0:
                inside += 1
                assert not question.empty(Fraction(math.hypot(e, s0) + 1e-12))
                for _, size, most in rows:
                    assert float(size[0]) * e + float(size[1]) * s0 <= float(most) + 1e-12
    assert inside > 200


@pytest.fixture(scope="module")
def tree() -> Json:
    spec = {**random_scene("arm, laws given", 0), "tolerance": 1e-3}
    return json.loads(json.dumps(proof(synthesise(DesignSpec.model_validate(spec)))))


def test_an_arm_whose_laws_meet_in_overshoot_has_its_file() -> None:
    """Some multipliers say nothing, as where they start is not bounded; that is no error."""
    program = [{**move(kind, 90, 0, overshoot=True), "lift_deg": 20} for kind in ("rise", "return")]
    for each in program:
        del each["lift_mm"]
    follower = {"kind": "oscillating_roller", "roller_radius_mm": 1, "arm_mm": 22,
                "centre_distance_mm": {"min": 20, "max": 30}, "sense": "same",
                "pivot_direction_deg": 0}  # fmt: skip
    limits = [{"kind": "jerk", "max_deg_per_s3": 1e5}, ANGLE]
    question = document("", [*program, dwell(180)], None, *limits, follower=follower)["question"]
    assert in_boxes(as_bytes(question), [SMOOTH, SMOOTH, None], 15.0) is not None


def leaves(part: Json) -> list[Json]:
    return [leaf for each in part["cases"] for leaf in leaves(each)] if "cases" in part else [part]


def test_an_arm_has_a_bound(tree: Json) -> None:
    assert verdict(tree)[0] == 0
    claim = tree["claims"][0]
    assert claim["proven"]
    assert "note" not in claim


@pytest.mark.parametrize("change", ["value", "swapped", "case", "lengths", "radius", "distance"])
def test_a_changed_tree_is_refused(tree: Json, change: str) -> None:
    document = copy.deepcopy(tree)
    claim, follower = document["claims"][0], document["question"]["follower"]
    if change == "value":
        claim["at_least"] = claim["below"] = 1.01 * claim["at_least"]
    elif change == "swapped":
        claim["cases"].reverse()
    elif change == "case":
        filled = [leaf for leaf in leaves(claim) if leaf["multipliers"]["segments"]]
        filled[0]["multipliers"] = {"order": 3, "segments": []}
    elif change == "lengths":  # of an arm that is no length
        claim.update({"of": "arm", "value": -1.0, "cases": [claim.copy(), claim.copy()]})
    elif change == "radius":
        follower["roller_radius_mm"] *= 1.5
    else:
        follower["centre_distance_mm"] *= 1.2
    code, said = verdict(document)
    assert code == 1, said
    assert said.startswith("objective/0: "), said
