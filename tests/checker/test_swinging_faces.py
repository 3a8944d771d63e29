"""Faces that swing: limits just beyond the cam's extremes hold, those just within do not."""

import json
import math
from typing import Any

import numpy as np
import pytest

from synthesis import DesignSpec, proof, synthesise
from tests.checker.run import verdict
from tests.checker.test_arms import LAWS, NAMED, OF_CAM, PROGRAM
from tests.checker.test_holes import ANGLE, NOWHERE, document, dwell
from tests.checker.test_limits import is_sharp
from tests.checker.truth import broken, face_contact, motion
from tests.hard.families import random_scene

Json = dict[str, Any]
FACE: Json = {"kind": "oscillating_flat_face", "centre_distance_mm": 100, "face_offset_mm": 4,
              "sense": "opposite", "pivot_direction_deg": 0}  # fmt: skip
START = math.radians(33)
RADIUS: Json = {"kind": "profile_radius", "min_mm": 1}
WIDTH: Json = {**NOWHERE, "near_mm": 30, "far_mm": 150}
OUTER: Json = {"kind": "outer_radius", "max_mm": 90}


def face(*limits: Json, size: Any = None, named: bool = False, **changes: Any) -> Json:
    """A proof file of a face that swings from 33 to 48 degrees, by a named law if so asked."""
    size = size or (100 * math.cos(START), 100 * math.sin(START))
    places = " ".join(f"limits/{k}" for k in range(len(limits)))
    program, laws = (NAMED, [None, *LAWS[1:]]) if named else (PROGRAM, LAWS)
    program, radius = changes.pop("program", program), changes.pop("base_radius_mm", None)
    return document(f"{OF_CAM} {places}", program, laws, *limits, size=size,
                    follower={**FACE, **changes}, base_radius_mm=radius)  # fmt: skip


@pytest.mark.parametrize("sense", ["same", "opposite"])
@pytest.mark.parametrize("away", [4, -6])
def test_limits_of_a_face_that_swings_are_sharp(sense: str, away: float) -> None:
    found = face(sense=sense, face_offset_mm=away)
    s, turns, _ = motion(found["question"], found["cam"])
    along, points, radius, _ = face_contact(found["question"], found["cam"], s)
    angle = math.degrees(math.atan(abs(away) / float(np.min(along[turns == 1.0]))))
    assert is_sharp(found, "pressure_angle", "rise_deg", angle)
    size = float(np.max(np.abs(radius)))
    assert is_sharp(found, "profile_radius", "min_mm", float(np.min(radius)), most=False, size=size)
    assert is_sharp(found, "outer_radius", "max_mm", float(np.max(np.abs(points))))
    near, far = float(np.min(along)), float(np.max(along))
    assert is_sharp(found, "face_width", "far_mm", far)
    assert is_sharp(found, "face_width", "near_mm", near, most=False)


def test_what_is_true_of_a_face_that_swings_is_accepted() -> None:
    for found in (
        face(RADIUS, WIDTH, ANGLE, OUTER),
        face(RADIUS, WIDTH, ANGLE, OUTER, named=True, face_offset_mm=0),
        face(base_radius_mm={"min": 50, "max": 51}),  # 100 sin 33 degrees less the face's offset
        face(centre_distance_mm={"min": 99, "max": 101}),
    ):
        code, said = verdict(found)
        assert code == 0, said
        for claim in found["claims"]:
            assert not (claim["proven"] and broken(found, claim["place"])), claim


def test_a_face_that_swings_and_has_no_cam_has_its_file() -> None:
    """Its programs have rows that the checker does not know, some of them without a size."""
    scene = random_scene("swinging face, pivot in a range", 0)
    document = json.loads(json.dumps(proof(synthesise(DesignSpec.model_validate(scene)))))
    assert [claim["place"] for claim in document["claims"]] == ["infeasible"]
    assert verdict(document)[0] == 0


def fast() -> list[Json]:
    """A rise along which a face turns faster than a cam that turns with it."""
    quick = {**PROGRAM[0], "angle_deg": 12}
    return [quick, {**dwell(168)}, *PROGRAM[2:]]


FALSE = {
    "contact off the face": face({**WIDTH, "far_mm": 80}),
    "contact too near": face({**WIDTH, "near_mm": 60}),
    "width of a face on a slide": face({**NOWHERE, "width_mm": 500}),
    "pressure angle": face({**ANGLE, "rise_deg": 2}),
    "radius": face({**RADIUS, "min_mm": 500}),
    "outer radius": face({**OUTER, "max_mm": 60}),
    "undercut": face(size=(100, 8)),
    "a face that turns as fast as the cam": face(program=fast(), sense="same"),
    "beyond the right angle": face(size=(20, 97)),
    "a face beyond the axis": face(size=(100, 3)),
    "centre distance": face(centre_distance_mm=101),
    "base radius": face(base_radius_mm={"min": 54, "max": 60}),
    "no sense": face(sense="across"),
    "an arm's length": face(size=(100 * math.cos(START), 100 * math.sin(START), 100)),
    "a field of others": face(arm_mm=80),
}  # fmt: skip


HIDDEN = {  # each alone would be a polynomial that is nowhere negative
    "a face that turns faster than the cam": face(
        {**WIDTH, "far_mm": None}, program=fast(), sense="same"),
    "contact on the other side of the pivot": face(
        {**WIDTH, "near_mm": None}, size=(20, 97)),
    "an axis beyond the face": face({**WIDTH, "near_mm": None}, size=(100, 3)),
}  # fmt: skip


@pytest.mark.parametrize("name", HIDDEN)
def test_no_limit_is_shown_of_a_face_that_touches_nowhere(name: str) -> None:
    found = HIDDEN[name]
    for claim in found["claims"]:
        if claim["place"] != "limits/0":
            claim.update(proven=False, reason="-")
    code, said = verdict(found)
    assert code == 1, said
    assert said.splitlines()[-1].startswith("limits/0: program/")


@pytest.mark.parametrize("name", FALSE)
def test_what_is_false_of_a_face_that_swings_is_refused(name: str) -> None:
    assert verdict(FALSE[name])[0] > 0
