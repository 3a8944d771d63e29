"""Mean squares in proof files: least values in closed form, and changes that have to be refused."""

import copy
import json
import math
import random
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest
from scipy.integrate import quad

from synthesis import DesignSpec, proof, synthesise
from synthesis.pipeline.proof_file.checker import checker
from tests.checker.run import verdict
from tests.checker.schema import conforms
from tests.checker.test_checker import EXAMPLES, checker_path, claims

LIFT, RISE, RETURN = 20.0, 70.0, 100.0
RATE = 6.0 * 90.0
LEAST = {3: 720.0, 2: 12.0}  # ∫ (g^(m))² dx of the best laws from rest to rest
# ψ over −2 weight is the best control: of the derivatives of g at its end
ENDS = {3: (-1440.0, 720.0, -120.0), 2: (-24.0, 12.0)}
NAMES = {3: "rms_jerk", 2: "rms_acceleration"}


def question(order: int, *laws: str) -> Any:
    first, second = ({"kind": law} for law in laws)
    body = {
        "speed_rpm": RATE / 6.0,
        "program": [
            {"kind": "rise", "angle_deg": RISE, "lift_mm": LIFT, "law": first},
            {"kind": "dwell", "angle_deg": 30.0},
            {"kind": "return", "angle_deg": RETURN, "lift_mm": LIFT, "law": second},
            {"kind": "dwell", "angle_deg": 330.0 - RISE - RETURN},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 5.0, "offset_mm": 0.0},
        "objective": {"kind": NAMES[order]},
        "limits": [],
    }
    return DesignSpec.model_validate(body).model_dump(mode="json")


def accepted(asked: Any, claim: Any) -> bool:
    judge = checker()
    judge.spent.clear()
    asked, claim = (judge.read(json.dumps(each).encode()) for each in (asked, claim))
    try:
        judge.excluded(asked, "objective/0", claim, None)
    except judge.Failure:
        return False
    return True


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("given", [False, True])
def test_the_least_mean_square_from_rest_to_rest(order: int, given: bool) -> None:
    # of a cycloid g' = 1 − cos 2πx
    asked = question(order, "spline", "cycloidal" if given else "spline")
    shares = [LIFT**2 / d ** (2 * order - 1) for d in (RISE, RETURN)]
    taken = [LEAST[order], (2.0 * math.pi) ** (2 * order - 2) / 2.0 if given else LEAST[order]]
    least = RATE**order * math.sqrt(sum(a * b for a, b in zip(shares, taken, strict=True)) / 360.0)
    segments = [
        {"segment": 2 * k, "rows": [], "ends": [share * 1e6 * nu for nu in ENDS[order]]}
        for k, share in enumerate(shares[: 2 - given])
    ]
    witness = {"order": order, "segments": segments, "squares": {"objective": 1e6}}
    assert accepted(asked, {"at_least": least * (1.0 - 1e-9), "multipliers": witness})
    assert not accepted(asked, {"at_least": least * (1.0 + 1e-9), "multipliers": witness})


@pytest.mark.parametrize(
    ("cap", "weight"), [(None, 7.0), (4.0, 3.0), (1.0, 20.0), (1e9, 2.0), (5.0, 0.0)]
)
def test_what_the_control_may_take_is_exact_to_a_billionth_and_not_less(
    cap: float | None, weight: float
) -> None:
    judge, chance = checker(), random.Random(3)
    judge.spent.clear()
    kernels = {Fraction(chance.randint(0, 1000), 1000):
               [Fraction(chance.randint(-50, 50)) for _ in range(5)] for _ in range(9)}  # fmt: skip
    own = None if cap is None else Fraction(cap)
    area, _ = judge.remainder(kernels, own, Fraction(weight))
    cuts = sorted({0.0, 1.0, *map(float, kernels)})

    def taken(tau: float) -> float:
        psi = sum(float(c) * (float(x) - tau) ** n / math.factorial(n)
                  for x, row in kernels.items() if x > tau for n, c in enumerate(row))  # fmt: skip
        most = math.inf if cap is None else cap
        w = min(abs(psi) / (2.0 * weight), most) if weight else most
        return float(abs(psi) * w - weight * w * w)

    exact = sum(quad(taken, a, b, limit=500, epsabs=1e-12)[0] for a, b in pairwise(cuts))
    assert exact * (1.0 - 1e-9) <= float(area) <= exact * (1.0 + 1e-8)


def test_where_the_control_reaches_its_cap_the_bound_is_not_below() -> None:
    judge = checker()
    judge.spent.clear()
    line = {Fraction(1): [Fraction(k == 1) for k in range(5)]}  # ψ = 1 − τ, capped from ⅓ on
    area, _ = judge.remainder(line, Fraction(2, 3), Fraction(1, 4))
    assert Fraction(19, 81) <= area <= Fraction(19, 81) * (1 + Fraction(1, 10**7))


def proof_of(name: str, **changes: Any) -> Any:
    body = {**json.loads((EXAMPLES / f"{name}.json").read_text("utf-8"))["value"], **changes}
    return json.loads(json.dumps(proof(synthesise(DesignSpec.model_validate(body)))))


@pytest.fixture(scope="module")
def default() -> Any:
    """That of a question without an objective: the rms jerk, then the base radius."""
    return proof_of("start-everyday")


@pytest.fixture(scope="module")
def capped() -> Any:
    """The least rms acceleration where the jerk is limited: tangents of the square."""
    return proof_of("example-13-6-sized", objective={"kind": "rms_acceleration"})


def test_all_of_a_plain_question_is_proven(default: Any, capped: Any) -> None:
    schema = json.loads(checker_path().with_name("proof.schema.json").read_text("utf-8"))
    for document in (default, capped):
        assert conforms(document, schema, schema)
        assert all(claim["proven"] and "note" not in claim for claim in document["claims"])
        assert verdict(document)[0] == 0
    said = verdict(default)[1]
    assert "with rms_jerk up to 1619460.08" in said
    assert "has an rms_jerk below 1302044.59" in said


def test_the_schema_says_what_held_values_and_squares_are(default: Any) -> None:
    schema = json.loads(checker_path().with_name("proof.schema.json").read_text("utf-8"))
    for name, value in (("held", [-1.0]), ("held", 1.0)):
        changed = copy.deepcopy(default)
        claims(changed)["objective/1"][name] = value
        assert not conforms(changed, schema, schema)


def square(claim: Any, factor: float) -> None:
    squares = claim["multipliers"]["squares"]
    for name in squares:
        squares[name] *= factor


def renamed(claim: Any, name: str) -> None:
    claim["multipliers"]["squares"] = {name: next(iter(claim["multipliers"]["squares"].values()))}


def in_halves(claim: Any) -> None:
    """Each law twice, with half of all: what weighs it must not count for both."""
    witness = claim["multipliers"]
    for part in witness["segments"]:
        part["ends"] = [0.5 * nu for nu in part["ends"]]
        for row in part["rows"]:
            for each in row["multipliers"]:
                each[len(each) // 2 :] = [0.5 * value for value in each[len(each) // 2 :]]
    witness["segments"] += copy.deepcopy(witness["segments"])
    square(claim, 0.5)


def without_a_segment(claim: Any) -> None:
    del claim["multipliers"]["segments"][0]


def exchanged(claim: Any) -> None:
    for part, number in zip(claim["multipliers"]["segments"], (2, 0), strict=True):
        part["segment"] = number


CHANGES: dict[str, tuple[str, Callable[[Any], None]]] = {
    "a higher jerk": ("0", lambda claim: claim.update(at_least=claim["at_least"] * 1.00001)),
    "a larger radius": ("1", lambda claim: claim.update(at_least=claim["at_least"] * 1.0001)),
    "more is held": ("1", lambda claim: claim.update(held=[claim["held"][0] * 1.001])),
    "the cam keeps less": ("1", lambda claim: claim.update(held=[claim["held"][0] * 0.999])),
    "nothing is held": ("1", lambda claim: claim.update(held=[])),
    "too much is held": ("1", lambda claim: claim.update(held=claim["held"] * 2)),
    "held before the first": ("0", lambda claim: claim.update(held=[claim["at_least"]])),
    "a negative square": ("1", lambda claim: square(claim, -1.0)),
    "no square": ("1", lambda claim: square(claim, 0.0)),
    "a small square": ("1", lambda claim: square(claim, 0.99)),
    "a large square": ("0", lambda claim: square(claim, 1.01)),
    "of another name": ("1", lambda claim: renamed(claim, "objective")),
    "of a limit": ("1", lambda claim: renamed(claim, "limits/0")),
    "of a lower order": ("0", lambda claim: claim["multipliers"].update(order=2)),
    "squares left out": ("1", lambda claim: claim["multipliers"].pop("squares")),
    "a square for two halves": ("1", in_halves),
    "the same without rows": ("0", in_halves),
    "a law left out": ("0", without_a_segment),
    "laws exchanged": ("0", exchanged),
}


@pytest.mark.parametrize("name", CHANGES)
def test_changed_witnesses_are_refused(default: Any, name: str) -> None:
    document = copy.deepcopy(default)
    rank, change = CHANGES[name]
    change(claims(document)[f"objective/{rank}"])
    document["claims"] = [
        each if each["place"] == f"objective/{rank}"
        else {"place": each["place"], "proven": False, "reason": "not looked at"}
        for each in document["claims"]
    ]  # fmt: skip
    assert verdict(document)[0] != 0


def test_a_claim_is_of_the_objective_at_its_place(default: Any) -> None:
    document = copy.deepcopy(default)
    first, second = (claims(document)[f"objective/{k}"] for k in (0, 1))
    first["place"], second["place"] = second["place"], first["place"]
    assert verdict(document)[0] == 2


def tangents(document: Any) -> list[Any]:
    witness = claims(document)["objective/0"]["multipliers"]
    return [row for part in witness["segments"] for row in part["rows"]
            if row["limit"] == "objective"]  # fmt: skip


def test_tangents_of_a_square_count_once(capped: Any) -> None:
    document = copy.deepcopy(capped)
    in_halves(claims(document)["objective/0"])
    assert verdict(document)[0] == 1
    document = copy.deepcopy(capped)
    for row in tangents(document):  # a gap: what is left out counts for nothing
        del row["multipliers"][len(row["multipliers"]) // 2]
    assert verdict(document)[0] == 1
    document = copy.deepcopy(capped)
    (first, *_), *_ = (row["multipliers"] for row in tangents(document))
    first[1] += 1e-6  # into the next one
    assert "overlap" in verdict(document)[1]
    document = copy.deepcopy(capped)
    (first, *_), *_ = (row["multipliers"] for row in tangents(document))
    first[1:] = [first[2]]  # at a point
    assert "no width" in verdict(document)[1]


def test_of_given_laws_the_one_value_is_the_least() -> None:
    document = proof_of("fixed-laws", objective={"kind": "rms_acceleration"})
    claim = claims(document)["objective/0"]
    assert claim["proven"]
    assert "note" not in claim
    assert verdict(document)[0] == 0
    claim["at_least"] *= 1.0001
    assert verdict(document)[0] == 1
