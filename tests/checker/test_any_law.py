"""What every law keeps of a slide's size, whether its derivatives are limited or not."""

import json
import math
from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest

from synthesis import DesignSpec, proof, synthesise
from synthesis.pipeline.proof_file.checker import as_bytes
from synthesis.pipeline.proof_file.sizes import in_sizes
from tests.checker.run import verdict
from tests.checker.test_holes import document, dwell, move, straight
from tests.hard.families import random_scene

Json = dict[str, Any]
ROLLER = {"kind": "translating_roller", "roller_radius_mm": 8.0}
FACE = {"kind": "translating_flat_face"}
ANGLE = {"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 35.0}
RADIUS = {"kind": "profile_radius", "min_mm": 3.0}
VELOCITY = {"kind": "velocity", "max_mm_per_s": 100.0}
NAMED = {"kind": "cycloidal"}
HUB = {"shaft_diameter_mm", "hub_diameter_mm"}
OF_CAM = ("no_undercut", "self_crossing", "motion", "size")


def rest_of(**changes: Any) -> Json:
    return {"factor": 1, "limit": "limits/0", "end": 1, **changes}


CLOSED: Json = {"kind": "translating_flat_face", "tilt_deg": 0, "offset_mm": 0}


def asked(
    follower: Json, *limits: Json, rise: float = 90.0, lift: float = 20.0, back: Json | None = None,
    **more: Any,
) -> Json:  # fmt: skip
    """A question without limits on acceleration or jerk."""
    spline = {"kind": "spline"}
    program = [
        {"kind": "rise", "angle_deg": rise, "lift_mm": lift, "law": spline},
        {"kind": "dwell", "angle_deg": 40.0},
        {"kind": "return", "angle_deg": 100.0, "lift_mm": lift, "law": back or spline},
        {"kind": "dwell", "angle_deg": 220.0 - rise},
    ]
    return {"speed_rpm": 100.0, "program": program, "follower": follower, "limits": list(limits),
            "objective": {"kind": "base_radius"}, **more}  # fmt: skip


def witnessed(body: Json, at_least: float | None = None, infeasible: bool = False) -> Json:
    """A file that claims the least size of a question, or that it has no cam, and no more."""
    question = DesignSpec.model_validate(body).model_dump(mode="json", exclude=HUB)
    found = in_sizes(as_bytes(question))
    assert found is not None
    value, multipliers = found
    assert math.isfinite(value) or infeasible
    places = ["infeasible"] if infeasible else [
        "objective/0", *(f"limits/{k}" for k in range(len(body["limits"]))), *OF_CAM
    ]  # fmt: skip
    claims = [{"place": place, "proven": False, "reason": "-"} for place in places]
    claims[0] = {"place": places[0], "proven": True, "multipliers": multipliers}
    if not infeasible:
        claims[0]["at_least"] = value * (1.0 - 1e-6) if at_least is None else at_least
    return {"format": "camwright-proof", "version": 1, "question": question,
            "cam": None if infeasible else {}, "claims": claims}  # fmt: skip


def claim_of(file: Json) -> Json:
    """The claim about all cams."""
    found: Json = next(c for c in file["claims"] if c["place"] in ("objective/0", "infeasible"))
    return found


@pytest.fixture(scope="module")
def slide() -> Json:
    return witnessed(asked({**ROLLER, "offset_mm": 0.0}, ANGLE))


@pytest.fixture(scope="module")
def face() -> Json:
    return witnessed(asked(FACE, RADIUS, rise=60.0))


def test_a_centred_slide_is_as_small_as_the_closed_form_says(slide: Json) -> None:
    """ds/dθ ≤ tan α (s0 + s), so that ln((s0 + h)/s0) ≤ β tan α."""
    least = [
        20.0 / math.expm1(math.radians(beta) * math.tan(math.radians(alpha)))
        for beta, alpha in ((90.0, 30.0), (100.0, 35.0))
    ]
    assert verdict(slide)[0] == 0
    assert claim_of(slide)["proven"] is True
    value = claim_of(slide)["at_least"] + 8.0
    assert max(least) * (1.0 - 1e-5) < value <= max(least)


def test_a_flat_face_comes_to_rest(face: Json) -> None:
    """∫ sin θ (Rb + s + s″ − r) dθ ≥ 0 over the rise, from s = 0 to h and at rest."""
    cosine = math.cos(math.radians(60.0))
    least = 3.0 + 20.0 * cosine / (1.0 - cosine)
    assert verdict(face)[0] == 0
    assert least * (1.0 - 1e-5) < claim_of(face)["at_least"] <= least


@pytest.mark.parametrize(
    "body",
    [
        asked(ROLLER, {**ANGLE, "return_deg": 30.0}, rise=20.0, lift=60.0,
              base_radius_mm={"min": 5.0, "max": 30.0}),
        asked(ROLLER, ANGLE, VELOCITY),
        asked(FACE, RADIUS, rise=30.0, base_radius_mm={"min": 5.0, "max": 30.0}),
    ],
    ids=["too small", "too slow", "a face too small"],
)  # fmt: skip
def test_without_a_cam_there_is_a_proof(body: Json) -> None:
    code, said = verdict(witnessed(body, infeasible=True))
    assert code == 0, said
    assert said.splitlines()[0].startswith(
        "infeasible: no law and no size keep these limits together"
    )


@pytest.mark.parametrize("end", [0, 1])
def test_a_move_beside_a_given_one_comes_to_rest(end: int) -> None:
    """Next to a straight line its velocity is that of the line: up before the top, down after."""
    ramp = straight(30, 4 if end else -4)
    program = (
        [move("rise", 60, 20), ramp, dwell(40), move("return", 150, 24), dwell(80)]
        if end
        else [move("rise", 150, 24), dwell(40), ramp, move("return", 60, 20), dwell(80)]
    )
    theta, speed = math.radians(60.0), 4.0 / math.radians(30.0)
    left = math.cos(theta) * 20.0 - math.sin(theta) * speed
    least = 3.0 + left / (1.0 - math.cos(theta))
    part = {"segment": 0 if end else 3, "rows": [], "ends": [], "rest": rest_of(end=end)}
    for factor, code in ((1.0 - 1e-9, 0), (1.0 + 1e-9, 1)):
        multipliers = {"order": 3, "segments": [part]}
        file = document(
            "objective/0", program, [None] * 5, RADIUS, follower=CLOSED,
            base_radius_mm={"min": 0, "max": 220},
            witness={"at_least": least * factor, "multipliers": multipliers},
        )  # fmt: skip
        assert verdict(file)[0] == code


def cells_of(file: Json) -> list[Json]:
    """The parts of its multipliers that speak of durations."""
    parts = claim_of(file)["multipliers"]["segments"]
    return [part for part in parts if "duration" in part]


def twice(part: Json) -> None:
    part["duration"]["rows"] += part["duration"]["rows"]


def beyond(part: Json) -> None:
    *_, last = part["duration"]["rows"][0]["cells"]
    last[1] = 3.0


def below(part: Json) -> None:
    first, *_ = part["duration"]["rows"][0]["cells"]
    first[0] = -3.0


def backwards(part: Json) -> None:
    for cell in part["duration"]["rows"][0]["cells"]:
        cell[:2] = cell[1::-1]


def negative(part: Json) -> None:
    part["duration"]["factor"] *= -1.0


def other_side(part: Json) -> None:
    part["duration"]["rows"][0]["side"] *= -1


def heavier(part: Json) -> None:
    part["duration"]["rows"][0]["side"] *= 2


def other_limit(part: Json) -> None:
    part["duration"]["rows"][0]["limit"] = "no_undercut"


def dwelling(part: Json) -> None:
    part["segment"] = 1


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (twice, "heights overlap"),
        (beyond, "lie beyond"),
        (below, "lie beyond"),
        (backwards, "heights overlap"),
        (negative, "factor is negative"),
        (other_side, "how fast"),
        (heavier, "how fast"),
        (other_limit, "how fast"),
        (dwelling, "how fast"),
    ],
)
def test_what_no_duration_shows_is_refused(
    slide: Json, change: Callable[[Json], None], why: str
) -> None:
    file = deepcopy(slide)
    change(cells_of(file)[0])
    code, said = verdict(file)
    assert code == 1
    assert why in said


def test_a_window_limits_no_whole_move(slide: Json) -> None:
    file = deepcopy(slide)
    rise = file["question"]["program"][0]
    slow = {"min": None, "max": 1.0}
    rise["windows"] = [{"from_deg": 10.0, "to_deg": 20.0, "velocity_mm_per_s": slow}]
    (part,) = cells_of(file)
    group = {"limit": "program/0/windows/0/1", "side": 1, "cells": [[0, 1, 1]]}
    part.update(segment=0, duration={"factor": 1, "rows": [group]})
    file["claims"].append({"place": "program/0/windows", "proven": False, "reason": "-"})
    code, said = verdict(file)
    assert (code, "how fast" in said) == (1, True)


def test_a_given_law_passes_its_heights_too(slide: Json) -> None:
    """The theorem is one on all laws: those of the question among them."""
    file = deepcopy(slide)
    (part,) = cells_of(file)
    file["question"]["program"][part["segment"]]["law"] = {**NAMED, "inflection": 0.5}
    assert verdict(file)[0] == 0


@pytest.mark.parametrize("more", [1e-4, 1.0])
def test_no_more_than_is_true_follows(slide: Json, face: Json, more: float) -> None:
    for file in (deepcopy(slide), deepcopy(face)):
        claim_of(file)["at_least"] *= 1.0 + more
        assert "do not exclude every size" in verdict(file)[1]


MOVES = [move("rise", 60, 20), dwell(40), move("return", 100, 20), dwell(160)]
LONG = [move("rise", 181, 20), dwell(9), move("return", 100, 20), dwell(70)]
TWO = [move("rise", 60, 20), move("rise", 60, 20), move("return", 100, 40), dwell(140)]
LINES = [straight(60, 20), dwell(40), straight(100, -20), dwell(160)]  # velocities may jump
OVER = [move("rise", 60, 20, overshoot=True), move("return", 60, 20), dwell(240)]


@pytest.mark.parametrize(
    ("program", "rest", "follower", "code"),
    [
        (MOVES, rest_of(), CLOSED, 0),
        (MOVES, rest_of(end=0), CLOSED, 0),
        (MOVES, rest_of(factor=-1), CLOSED, 1),
        (MOVES, rest_of(end=2), CLOSED, 2),
        (MOVES, rest_of(limit="limits/1"), CLOSED, 1),
        (MOVES, rest_of(), ROLLER | {"offset_mm": 0}, 1),
        (LONG, rest_of(), CLOSED, 1),
        (TWO, rest_of(), CLOSED, 1),
        (TWO, rest_of(end=0), CLOSED, 0),
        (OVER, rest_of(), CLOSED, 1),
        (LINES, rest_of(), CLOSED, 1),
    ],
)
def test_a_move_comes_to_rest_where_its_velocity_is_known(
    program: list[Json], rest: Json, follower: Json, code: int
) -> None:
    """At least 0.1 mm, or whatever: what is asked is whether the step is allowed at all."""
    limits = {**RADIUS, "min_mm": 90}, {**ANGLE, "dwell_deg": None}
    part = {"segment": 0, "rows": [], "ends": [], "rest": rest}
    witness = {"at_least": 30, "multipliers": {"order": 3, "segments": [part]}}
    file = document("objective/0", program, [None] * len(program), *limits, witness=witness,
                    follower=follower, base_radius_mm={"min": 0, "max": 220})  # fmt: skip
    assert verdict(file)[0] == code


def test_no_smaller_radius_is_asked_for(face: Json) -> None:
    """Below the smallest one of the question there is none, without any multipliers."""
    file = deepcopy(face)
    file["question"]["base_radius_mm"] = {"min": 7.5, "max": 60.0}
    for claim in file["claims"]:
        claim.update(proven=False, reason="-")
    for value, code in ((7.5, 0), (7.500001, 1)):
        claim_of(file).update(proven=True, at_least=value, multipliers={"order": 3, "segments": []})
        assert verdict(file)[0] == code


def test_where_nothing_limits_the_jerk_no_row_acts_at_a_point(slide: Json) -> None:
    """Without a limit on a derivative of a law ψ has to vanish: any density would cost all."""
    file = deepcopy(slide)
    row = {"limit": "limits/0", "side": 1, "multipliers": [[0.5, 1e-9]]}
    cells_of(file)[0]["rows"] = [row]
    code, said = verdict(file)
    assert (code, "nothing limits the jerk of every law" in said) == (1, True)


def test_the_file_of_a_design_without_caps_has_the_answers_bound() -> None:
    design = synthesise(DesignSpec.model_validate(asked(FACE, RADIUS, rise=60.0)))
    file = json.loads(json.dumps(proof(design)))
    assert verdict(file)[0] == 0
    assert design.certificate.lower_bound is not None
    assert claim_of(file)["at_least"] > design.certificate.lower_bound * (1.0 - 1e-5)
    assert "note" not in claim_of(file)


def test_rows_of_the_acceleration_are_densities_where_it_is_limited() -> None:
    """Under a flat face the radius is a limit on it; at points it says nothing of a law."""
    body = asked(FACE, {**RADIUS, "min_mm": 2.0}, {"kind": "acceleration", "max_mm_per_s2": 8e3},
                 proof="quick", tolerance=0.005)  # fmt: skip
    design = synthesise(DesignSpec.model_validate(body))
    file = json.loads(json.dumps(proof(design)))
    assert verdict(file)[0] == 0
    claim = claim_of(file)
    assert design.certificate.lower_bound is not None
    assert claim["at_least"] > design.certificate.lower_bound * (1.0 - 1e-4)
    assert claim["multipliers"]["order"] == 2
    rows = [r for part in claim["multipliers"]["segments"] for r in part["rows"]]
    (of_radius, *_) = (r for r in rows if r["limit"] == "limits/0")
    x, _, factor, _ = next(each for each in of_radius["multipliers"] if each[2] > 0.0)
    of_radius["multipliers"].append([x, factor])
    code, said = verdict(file)
    assert (code, "too high a derivative" in said) == (1, True)


@pytest.mark.parametrize("family", ["no objective, swinging face", "no objective, arm, conjugate"])
def test_the_least_rms_of_what_swings_is_that_of_degrees(family: str) -> None:
    """It rests on the motion alone, whose lifts are degrees in the file."""
    design = synthesise(DesignSpec.model_validate({**random_scene(family, 1), "proof": "quick"}))
    file = json.loads(json.dumps(proof(design)))
    assert verdict(file)[0] == 0
    (known,) = (o for o in design.certificate.other_objectives if "rms_jerk" in o.objective)
    assert known.lower_bound is not None
    assert claim_of(file)["at_least"] > known.lower_bound * (1.0 - 1e-4)


def test_a_bound_that_another_limit_raises_is_proven_without_it() -> None:
    scene = random_scene("slide, residual vibration", 1)
    file = json.loads(json.dumps(proof(synthesise(DesignSpec.model_validate(scene)))))
    assert verdict(file)[0] == 0
    claim = claim_of(file)
    assert claim["at_least"] > 1.0
    assert "is not covered" in claim["note"]
