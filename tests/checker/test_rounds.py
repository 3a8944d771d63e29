"""Rounds: bounds of size and motion, and the rows of a roller's radius that follow from them."""

import json
import math
import random
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from synthesis import DesignSpec
from synthesis.pipeline.proof_file.checker import checker

C = math.pi / 180.0
ROLLER_MM = 5.0
LIMITS = [
    {"kind": "jerk", "max_mm_per_s3": 2e6},
    {"kind": "profile_radius", "min_mm": 4.0},
    {"kind": "cutter_radius", "radius_mm": 12.0},
]


def question() -> Any:
    """A rise, a return and a dwell under a roller."""
    body = {
        "speed_rpm": 90.0,
        "program": [
            {"kind": "rise", "angle_deg": 70.0, "lift_mm": 20.0},
            {"kind": "return", "angle_deg": 80.0, "lift_mm": 20.0},
            {"kind": "dwell", "angle_deg": 210.0},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": ROLLER_MM},
        "limits": LIMITS,
        "base_radius_mm": {"max": 80.0},
    }
    asked = DesignSpec.model_validate(body).model_dump_json().encode()
    judge = checker()
    judge.spent.clear()
    return judge.Question(judge.read(asked))


def exact(value: float) -> Fraction:
    return Fraction(repr(value))


@pytest.mark.parametrize("kind", ["profile_radius", "cutter_radius"])
def test_a_row_of_a_radius_holds_wherever_the_limit_does(kind: str) -> None:
    chance, found = random.Random(3), question()
    segment = found.program[0]
    name, limit = next(each for each in found.limits.items() if each[1]["kind"] == kind
                       and each[0] != "no_undercut")  # fmt: skip
    side = 1 if kind == "profile_radius" else -1
    radius = 4.0 + ROLLER_MM if side > 0 else 12.0 - ROLLER_MM
    worst = 0.0
    for number in range(40):
        place, wide = Fraction(number, 40), chance.choice((1.0, 0.1))
        low = chance.uniform(10, 60), chance.uniform(-0.8, 0.8), chance.uniform(-0.3, 0.3)
        ends = [(a, a + b * wide) for a, b in zip(low, (6.0, 0.3, 0.2), strict=True)]
        found.offsets = [exact(round(each / C, 9)) for each in ends[2]]
        found.heights, found.bent = [Fraction(0), Fraction(80)], {}
        found.known = {(0, place): [exact(each) for pair in ends[:2] for each in pair]}
        (alpha, size, upper), h, d = found.bent_row(segment, limit, place, 1, None), 20.0, 70.0
        by_s, by_v, by_a = (float(f) / h * d**k for k, f in enumerate(alpha[:3]))
        most = float(upper) + by_s * float(segment.level)
        for corner in range(60):
            at = [low if corner & 1 << k else high for k, (low, high) in enumerate(ends)]
            if corner >= 8:
                at = [chance.uniform(*pair) for pair in ends]
            big, slide, offset = at
            w = math.hypot(C * big, slide)
            v = slide + offset
            # the acceleration at which side N/W³ is just 1/radius
            a = (w * w + v * slide - side * w**3 / (C * radius)) / big
            s0 = 0.3 * big
            value = by_s * (big - s0) + by_v * v + by_a * a
            value += float(size[0]) * offset + float(size[1]) * s0
            assert value <= most + 1e-12, (name, at)
            worst = max(worst, abs(value) + abs(most))
    assert worst > 0.0


def test_what_is_known_at_two_places_holds_between_them() -> None:
    """A cubic with the largest third derivative on one side, in a hull of no width at its ends."""
    found = question()
    segment, d = found.program[0], 70.0
    segment.forward = False
    for sign in (1.0, -1.0):
        jerk = sign * float(found.jerk)
        e, s0, speed, turn = -2.0, 30.0, 0.6, -jerk * 12.0

        def path(t: float, e=e, s0=s0, speed=speed, turn=turn, jerk=jerk) -> Any:  # type: ignore[no-untyped-def]
            v = speed + turn * t + jerk * t * t / 2
            return s0 + 1.0 + speed * t + turn * t * t / 2 + jerk * t**3 / 6, v - C * e

        found.offsets, found.heights = [Fraction(-2)] * 2, [Fraction(0), Fraction(80)]
        places = [Fraction(1, 5), Fraction(1, 2)]
        found.known = {}
        for place in places:
            x, u = path(float(place) * d)
            found.known[0, place] = [exact(x), exact(x), exact(u), exact(u)]
        for k in range(11):
            place = places[0] + (places[1] - places[0]) * Fraction(k, 10)
            x, u = path(float(place) * d)
            low = found.hull(segment, place)
            assert float(low[0]) - 1e-12 <= x <= -float(low[1]) + 1e-12
            assert float(low[2]) - 1e-12 <= u <= -float(low[3]) + 1e-12
            if 0 < k < 10:  # the narrowest that holds for all such paths
                assert min(u - float(low[2]), -float(low[3]) - u) < 1e-9
    with pytest.raises(checker().Failure):
        found.hull(segment, Fraction(3, 5))


def test_no_size_of_a_range_and_a_circle_is_beyond_the_bound(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    judge, found, chance = checker(), question(), random.Random(5)
    for _ in range(60):
        p, q = chance.uniform(-60, 60), chance.uniform(-1, 1)
        ends = sorted(chance.uniform(-70, 70) for _ in range(2))
        bottom = chance.uniform(0, 50)
        found.radii, found.offsets = [None, Fraction(70)], [exact(each) for each in ends]
        found.heights = [exact(bottom), Fraction(70)]
        both = Fraction(0), (exact(p), exact(q))
        monkeypatch.setattr(judge, "half_plane", lambda *_, both=both: both)
        bound = float(judge.least(found, {}))
        inside = [
            p * C * e + q * s0
            for e in [ends[0] + (ends[1] - ends[0]) * k / 60 for k in range(61)]
            for s0 in {bottom, math.sqrt(max(70.0**2 - e * e, 0.0))}
            if s0 >= bottom and e * e + s0 * s0 <= 70.0**2 + 1e-9
        ]
        if inside:
            assert bound <= min(inside) + 1e-9
            assert bound >= min(inside) - 1.0  # and one of them comes near to it


def body() -> Any:
    """Of given laws: a bound that rests on rows of a radius, in rounds."""
    return json.loads((Path(__file__).parent / "rounds.json").read_text("utf-8"))


def verdict(claim: Any, question: Any) -> int:
    """0 accepted, 1 refused, 2 not readable."""
    judge = checker()
    judge.spent.clear()
    asked, stated = (judge.read(json.dumps(each).encode()) for each in (question, claim))
    try:
        judge.excluded(asked, "objective/0", stated, None)
    except judge.Failure as failure:
        return len(failure.args)
    return 0


def test_a_bound_in_rounds() -> None:
    found = body()
    question, claim = found["question"], found["claim"]
    assert verdict(claim, question) == 0
    better = {**claim, "at_least": claim["at_least"] * 1.001, "below": claim["below"] * 1.001}
    assert verdict(better, question) == 1  # more than the multipliers show
    assert verdict({**claim, "below": claim["at_least"] * 0.99}, question) == 1
    assert verdict({**claim, "rounds": []}, question) == 1
    assert verdict({**claim, "rounds": claim["rounds"][:1]}, question) == 1
    for limit in question["limits"]:
        if limit["kind"] == "profile_radius":
            limit["min_mm"] *= 0.5
    assert verdict(claim, question) == 1


def test_two_cases_cover_the_range_of_a_size() -> None:
    found = body()
    question, claim = found["question"], found["claim"]
    rest = {name: each for name, each in claim.items() if name not in ("rounds", "multipliers")}
    last = {"multipliers": claim["multipliers"]}
    first = {**rest, "rounds": claim["rounds"], "of": "offset", "value": -4.31}
    assert verdict({**first, "cases": [last, last]}, question) == 0
    assert verdict({**first, "cases": [last]}, question) == 2
    nothing = {"multipliers": {"order": 2, "segments": []}}
    for cases in ([last, nothing], [nothing, last]):
        assert verdict({**first, "cases": cases}, question) == 1
