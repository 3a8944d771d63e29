"""Forces: the checker holds a limit just beyond the product's own extremes, and not one within."""

import copy
import json
from functools import cache
from typing import Any
from unittest import mock

import numpy as np
import pytest

from synthesis import DesignSpec, proof, synthesise
from synthesis.pipeline.proof_file import claims
from synthesis.pipeline.proof_file.checker import checker
from tests.checker.run import verdict
from tests.checker.test_holes import SMOOTH, document, moves, straight
from tests.checker.test_limits import accepts
from tests.checker.truth import broken, contradiction, motion

Json = dict[str, Any]
NEAR = 1e-6  # relative
SPLINE, SINE = {"kind": "spline"}, {"kind": "modified_sine"}
POWERS = {"kind": "polynomial_3_4_5"}  # of a low degree: the checker takes a tenth of the time
JERK = {"kind": "jerk", "max_mm_per_s3": 3e7}
ANGLE = {"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 45.0}
RADIUS = {"kind": "profile_radius", "min_mm": 5.0}
ROLLER = {"kind": "translating_roller", "roller_radius_mm": 10.0, "offset_mm": 4.0}
FACE = {"kind": "translating_flat_face", "tilt_deg": 12.0}
ARM = {"kind": "oscillating_roller", "roller_radius_mm": 10.0, "arm_mm": 100.0,
       "centre_distance_mm": 120.0}  # fmt: skip
SWINGING = {"kind": "oscillating_flat_face", "centre_distance_mm": 100.0, "face_offset_mm": 5.0}
JUMPING = ((20.0, -30.0), (60.0, 90.0), (90.5, 40.0), (90.5, -20.0))


def load(arm: bool, rate: float = 2.0, preload: float = 300.0, **more: Any) -> Json:
    """Mass, damping, spring and a process force that jumps; of an arm of 100 mm about its pivot."""
    contact = {"width_mm": 12.0}
    if arm:
        spring = {"rate_n_m_per_rad": 10.0 * rate, "preload_n_m": 0.1 * preload}
        process = [{"angle_deg": x, "moment_n_m": 0.1 * y} for x, y in JUMPING]
        return {"kind": "arm", "moment_of_inertia_kg_m2": 0.01, "damping_n_m_s_per_rad": 0.3,
                "spring": spring, "process": process, "contact": contact, **more}  # fmt: skip
    return {"kind": "slide", "moving_mass_kg": 1.0, "damping_n_s_per_m": 20.0, "contact": contact,
            "spring": {"rate_n_per_mm": rate, "preload_n": preload}, "rise_from_vertical_deg": 30.0,
            "process": [{"angle_deg": x, "force_n": y} for x, y in JUMPING], **more}  # fmt: skip


def scene(follower: Json, *limits: Json, law: Json = POWERS, **more: Any) -> Json:
    arm = follower["kind"].startswith("oscillating")
    lift = {"lift_deg": 15.0} if arm else {"lift_mm": 30.0}
    program = [{"kind": "rise", "angle_deg": 70.0, **lift, "law": law},
               {"kind": "dwell", "angle_deg": 30.0},
               {"kind": "return", "angle_deg": 80.0, **lift, "law": law},
               {"kind": "dwell", "angle_deg": 180.0}]  # fmt: skip
    known = ({k.replace("mm_per", "deg_per"): v for k, v in each.items()} for each in limits)
    return {"speed_rpm": 300.0, "program": program, "follower": follower, "load": load(arm),
            "limits": [*known] if arm else [*limits], "tolerance": 0.02, "proof": "quick",
            **more}  # fmt: skip


SCENES = {
    "roller": scene(ROLLER, ANGLE),
    "roller, sine": scene(ROLLER, ANGLE, law=SINE),
    "roller, spline": scene(ROLLER, ANGLE, JERK, law=SPLINE),
    "ring": scene({**ROLLER, "closure": {"kind": "force", "contact": "inside",
                                         "rim_mm": 4.0}}, ANGLE),
    "groove": scene({**ROLLER, "closure": {"kind": "groove", "rim_mm": 4.0}}, ANGLE),
    "groove, clearance": scene({**ROLLER, "closure": {"kind": "groove", "rim_mm": 4.0,
                                                      "clearance_mm": 3.0}}, ANGLE),
    "groove, pulled": scene({**ROLLER, "closure": {"kind": "groove", "rim_mm": 4.0}}, ANGLE,
                            load=load(arm=False, preload=0.0,
                                      process=[{"angle_deg": 0.0, "force_n": -900.0}])),
    "conjugate": scene({**ROLLER, "closure": {"kind": "conjugate", "roller_radius_mm": 8.0,
                                              "offset_mm": -2.0}}, ANGLE),
    "face": scene(FACE, RADIUS, JERK, law=SPLINE),
    "arm": scene(ARM, ANGLE, JERK, law=SPLINE),
    "arm, free length": scene({**ARM, "arm_mm": {"min": 80.0, "max": 120.0}}, ANGLE),
    "arm, conjugate": scene({**ARM, "closure": {"kind": "conjugate", "arm_mm": 90.0,
                                                "roller_radius_mm": 8.0}},
                            {**ANGLE, "rise_deg": 40.0}),
    "swinging face": scene(SWINGING, RADIUS),
}  # fmt: skip


@cache
def made(name: str) -> tuple[Json, Any]:
    """The file of a scene, and the product's own forces."""
    design = synthesise(DesignSpec.model_validate(SCENES[name]))
    with mock.patch.object(claims, "_attempts", return_value=()):  # no bounds: they take long
        return json.loads(json.dumps(proof(design))), design.forces


def limit(kind: str, **bounds: float | None) -> Json:
    none = {"max_n": None, "min_n": None} if kind == "contact_force" else {}
    return {"kind": kind, **none, **bounds}


def is_sharp(found: Json, loose: Json, tight: Json, *, sampled: bool) -> bool:
    """Whether one limit holds and the other does not, to the checker and to sampling.

    ``sampled``: whether samples find extremes as near, where accelerations have no corners.
    """
    told = []
    for each in (loose, tight):
        changed = copy.deepcopy(found)
        changed["question"]["limits"] = [each]
        told.append((accepts(changed, "limits/0"), not broken(changed, "limits/0")))
    return told == [(True, True), (False, not sampled and told[1][1])]


@pytest.mark.parametrize("name", SCENES)
def test_limits_are_sharp(name: str) -> None:
    found, forces = made(name)
    flanks = forces.flanks

    def sharp(kind: str, field: str, extreme: float, size: float, way: float = 1.0) -> bool:
        both = (limit(kind, **{field: extreme + way * k * size}) for k in (NEAR, -20.0 * NEAR))
        return is_sharp(found, *both, sampled="spline" not in str(found["question"]["program"]))

    largest = max(flank.largest_n.value for flank in flanks)
    assert sharp("contact_force", "max_n", largest, largest)
    pressure = max(flank.largest_pressure_mpa.value for flank in flanks)
    assert sharp("hertz_pressure", "max_mpa", pressure, pressure)
    peaks = (forces.torque.largest_n_m.value, -forces.torque.smallest_n_m.value)
    assert sharp("camshaft_torque", "max_n_m", max(peaks), max(peaks))
    if len(flanks) == 1:
        least = flanks[0].smallest_n.value
        assert least > 0.0
        assert sharp("contact_force", "min_n", least, largest, way=-1.0)


@pytest.mark.parametrize("name", ["roller", "ring", "swinging face"])
def test_every_number_of_a_load_counts(name: str) -> None:
    """A limit at the extreme is broken once a mass, a spring or a force is another one."""
    found, forces = made(name)
    body = copy.deepcopy(found)
    largest = max(flank.largest_n.value for flank in forces.flanks)
    body["question"]["limits"] = [limit("contact_force", max_n=largest * (1.0 + NEAR))]
    assert accepts(body, "limits/0")
    own, spring = body["question"]["load"], body["question"]["load"]["spring"]
    inertia, damping, *_ = (each for each in own if each.startswith(("mo", "damping")))
    places = [(own, inertia), (own, damping), *((spring, each) for each in spring),
              *((point, [*point][1]) for point in own["process"])]  # fmt: skip
    told = []
    for place, field in places:
        value, changes = place[field], []
        if value is None:
            continue
        for changed in (1.5 * value, 0.5 * value):
            place[field] = changed
            changes.append(accepts(body, "limits/0"))
            assert changes[-1] == (not broken(body, "limits/0"))
        place[field] = value
        told.append(changes)
    assert [True, True] not in told[:1] + told[2:4]  # mass and spring always act on the largest
    assert [False, True] in told


def test_a_spring_that_comes_with_the_cam_is_in_its_range() -> None:
    body = scene(ROLLER, ANGLE, limit("contact_force", min_n=10.0))
    spring = {"rate_n_per_mm": None, "preload_n": {"min": 50.0, "max": 900.0}}
    body["load"] = load(arm=False, spring=spring)
    found = json.loads(json.dumps(proof(synthesise(DesignSpec.model_validate(body)))))
    code, said = verdict(found)
    assert (code, contradiction(found)) == (0, ""), said
    assert [each["place"] for each in found["claims"] if not each["proven"]] == []
    place, chosen = "limits/1", found["cam"]["spring"]
    assert [*chosen] == ["rate_n_per_mm", "preload_n"]
    for name, values in {"preload_n": (900.001, 49.9, None), "rate_n_per_mm": (-1e-9,)}.items():
        for value in values:
            forged = copy.deepcopy(found)
            forged["cam"]["spring"][name] = value
            assert not accepts(forged, place), (name, value)
    assert not accepts({**found, "cam": {**found["cam"], "spring": {}}}, place)
    # a stiffer one than any that floats, in its range, but no number that the question gives
    stiff = copy.deepcopy(found)
    stiff["cam"]["spring"] = {"rate_n_per_mm": 1e3, "preload_n": 900.0}
    assert accepts(stiff, place)
    given = copy.deepcopy(found)
    given["question"]["load"]["spring"].update(chosen)
    assert accepts(given, place)
    given["question"]["load"]["spring"]["preload_n"] += 1.0
    assert not accepts(given, place)
    # a spring that the question gives may not pull
    given["question"]["load"]["spring"] = {"rate_n_per_mm": -1.0, "preload_n": 900.0}
    assert not accepts({**given, "cam": {**given["cam"], "spring": {}}}, place)


def test_what_makes_no_polynomial_is_not_covered_and_said_so() -> None:
    """Friction: other claims of the question are proven all the same."""
    found, _ = made("roller")
    body = copy.deepcopy(SCENES["roller"])
    body["limits"] = [ANGLE, limit("contact_force", max_n=2e3)]
    body["load"]["friction"] = {"coefficient": 0.1}
    rubbed = json.loads(json.dumps(proof(synthesise(DesignSpec.model_validate(body)))))
    missing = {each["place"]: each["reason"] for each in rubbed["claims"] if not each["proven"]}
    assert [*missing] == ["limits/1"]
    assert "friction" in missing["limits/1"]
    # names that nobody knows, points out of order, other loads, no contact
    steel = found["question"]["load"]["contact"]
    weak = {"elastic_modulus_mpa": -2e5, "poisson_ratio": 0.3}
    for change in ({"drag_n": 3.0}, {"kind": "arm"}, {"contact": None},
                   {"contact": {**steel, "width_mm": -12.0}}, {"contact": {**steel, "cam": weak}},
                   {"moving_mass_kg": -1.0}, {"damping_n_s_per_m": -1.0},
                   {"process": [{"angle_deg": 90.0, "force_n": 0.0},
                                {"angle_deg": 10.0, "force_n": 0.0}]},
                   {"process": [{"angle_deg": 361.0, "force_n": 0.0}]}):  # fmt: skip
        forged = copy.deepcopy(found)
        forged["question"]["limits"] = [limit("hertz_pressure", max_mpa=1e5)]
        assert accepts(forged, "limits/0")
        forged["question"]["load"].update(change)
        judge = checker()
        judge.spent.clear()
        asked = judge.read(json.dumps(forged).encode())
        with pytest.raises((judge.Failure, TypeError)):
            judge.Cam(judge.Question(asked["question"]), asked["cam"]).check("limits/0")


def press(rate: float, preload: float, **more: Any) -> Json:
    spring = {"rate_n_per_mm": rate, "preload_n": preload}
    return {"kind": "slide", "moving_mass_kg": 2.0, "spring": spring, **more}


def heavy(size: float, most: float, press: float, *, straight_lines: bool = False) -> Json:
    """A file with a contact force, at 0.1 rpm, that a process force alone gives."""
    own = load(arm=False, rate=0.0, preload=0.0, process=[{"angle_deg": 0, "force_n": press}])
    own = {**own, "damping_n_s_per_m": 0, "rise_from_vertical_deg": None}
    program, laws = moves(smoothness=1), [SMOOTH] * 2
    if straight_lines:
        program, laws = [straight(180, 10), straight(180, -10)], [None] * 2
    force = limit("contact_force", max_n=most)
    return document("limits/0", program, laws, force, size=(0, size), load=own, speed_rpm=0.1)


def test_an_infinite_force_and_a_roller_driven_inwards_are_seen() -> None:
    assert verdict(heavy(100, 1010, 1000))[0] == 0
    assert verdict(heavy(100, 999, 1000))[0] == 1
    code, said = verdict(heavy(100, 1010, 1000, straight_lines=True))
    assert (code, "derivative 1 jumps" in said) == (1, True)
    # beyond the axis the roller's normal is turned round, and so is the force's sense
    assert verdict(heavy(-100, 10, 1000))[0] == 1
    assert verdict(heavy(-100, 10, -1000))[0] == 1


BOUND = {
    "roller, no float": (scene(ROLLER, ANGLE, JERK, limit("contact_force", min_n=0.0), law=SPLINE),
                         press(1.0, 120.0)),
    "face, most": (scene(FACE, RADIUS, JERK, limit("contact_force", min_n=20.0),
                         limit("contact_force", max_n=560.0), law=SPLINE),
                   press(1.0, 260.0, damping_n_s_per_m=20.0, rise_from_vertical_deg=30.0)),
    "groove, most": (scene({**ROLLER, "closure": {"kind": "groove", "rim_mm": 4.0}}, ANGLE, JERK,
                           limit("contact_force", max_n=260.0), law=SPLINE),
                     press(0.0, 20.0)),
}  # fmt: skip


@pytest.mark.parametrize("name", BOUND)
def test_forces_raise_the_bound(name: str) -> None:
    body, own = BOUND[name]
    spec = DesignSpec.model_validate({**body, "load": own})
    design = synthesise(spec)
    found = json.loads(json.dumps(proof(design)))
    code, said = verdict(found)
    assert code == 0, said
    (claim,) = (each for each in found["claims"] if each["place"] == "objective/0")
    parts = claim["multipliers"]["segments"]
    used = {row["limit"] for part in parts for row in part["rows"]}
    forces = {f"limits/{k}" for k, each in enumerate(body["limits"]) if each["kind"][0] == "c"}
    assert used & forces
    assert claim["at_least"] > design.certificate.lower_bound * (1.0 - 1e-4)
    plain = {**body, "load": own, "limits": [x for x in body["limits"] if x["kind"][0] != "c"]}
    without = synthesise(DesignSpec.model_validate(plain))
    assert claim["at_least"] > without.objectives["base_radius_mm"]


def test_a_question_whose_forces_exclude_each_other_has_no_cam() -> None:
    body = {**scene(ROLLER, ANGLE, limit("contact_force", min_n=0.0)), "load": press(0.0, 20.0)}
    found = json.loads(json.dumps(proof(synthesise(DesignSpec.model_validate(body)))))
    assert [(each["place"], each["proven"]) for each in found["claims"]] == [("infeasible", True)]
    assert verdict(found)[0] == 0
    found["question"]["load"]["spring"]["preload_n"] = 300.0
    assert verdict(found)[0] == 1


@pytest.mark.parametrize("name", ["roller, spline", "ring", "groove", "conjugate", "face"])
def test_rows_of_forces_hold_for_the_cam_and_nearly_bind(name: str) -> None:
    found, forces = made(name)
    largest = max(flank.largest_n.value for flank in forces.flanks)
    least = min(flank.smallest_n.value for flank in forces.flanks)
    bounds = {"max_n": largest} if len(forces.flanks) > 1 else {"max_n": largest, "min_n": least}
    body = copy.deepcopy(found)
    body["question"]["limits"] = [limit("contact_force", **bounds)]
    judge = checker()
    judge.spent.clear()
    asked = judge.read(json.dumps(body).encode())
    question = judge.Question(asked["question"])
    s, _, _ = motion(found["question"], found["cam"])
    count, nearest = s.shape[1] // len(question.turning), {}
    for k, segment in enumerate(question.turning):
        own = s[:3, k * count : (k + 1) * count] * (np.pi / 180.0) ** np.arange(3)[:, None]
        for side in (1, -1):
            row = question.row(segment, question.limits["limits/0"], side)
            if row is None:
                continue
            alpha, size, most = row
            assert size == [0, 0]
            spare = float(most) - np.array([float(f) for f in alpha[:3]]) @ own
            assert np.min(spare) > -1e-9 * largest
            nearest[side] = min(nearest.get(side, np.inf), float(np.min(spare)) / largest)
    assert set(nearest) == {1, -1}
    assert min(nearest.values()) < 0.4  # the pressure angle, and the course of the process force
    # from the other side nothing is asked, unless another flank is there
    question.limits["limits/0"]["min_n"] = None
    sides = {flank * (-1 if path else 1) for flank, _, _, path in question.flanks}
    for side in (1, -1):
        row = question.row(question.turning[0], question.limits["limits/0"], side)
        assert (row is not None) == (side in sides)


@pytest.mark.parametrize("level", [50.0, 45.0])
def test_a_flank_that_is_undercut_has_no_finite_pressure(level: float) -> None:
    """A groove with clearance: where force and acceleration jump together to beyond the undercut,
    the inequality that is multiplied by the sign of the radius holds for the wrong side."""
    steel = {"elastic_modulus_mpa": 200000, "poisson_ratio": 0}
    process = ((0, 1), (31.5, 1), (31.5, 1000), (45, 1000), (45, 1), (360, 1))
    spline = {"kind": "spline", "smoothness": 1, "overshoot": False}
    polynomial = {"kind": "polynomial_3_4_5", "inflection": 0.5}
    question = {
        "speed_rpm": 60, "base_radius_mm": None, "continuity": None, "objective": None,
        "program": [{"kind": "rise", "angle_deg": 45, "lift_mm": 10, "law": spline},
                    {"kind": "dwell", "angle_deg": 60},
                    {"kind": "return", "angle_deg": 200, "lift_mm": 10, "law": polynomial},
                    {"kind": "dwell", "angle_deg": 55}],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 5, "offset_mm": 0,
                     "closure": {"kind": "groove", "clearance_mm": 60, "rim_mm": 0}},
        "load": {"kind": "slide", "moving_mass_kg": 0, "damping_n_s_per_m": 0, "spring": None,
                 "rise_from_vertical_deg": None,
                 "process": [{"angle_deg": x, "force_n": y} for x, y in process],
                 "contact": {"width_mm": 10, "cam": steel, "follower": steel}},
        "limits": [{"kind": "hertz_pressure", "max_mpa": 437}],
    }  # fmt: skip
    law = {"degree": 2, "knots": [0, 0.7, 1], "coefficients": [0, 0, 1, 1]}
    cam = {"size": [0, level], "laws": [law, None, None, None]}
    others = ("objective/0", "no_undercut", "self_crossing", "motion", "size")
    claims_of = [{"place": each, "proven": False, "reason": "not asked"} for each in others]
    file = {"format": "camwright-proof", "version": 1, "question": question, "cam": cam,
            "claims": [{"place": "limits/0", "proven": True}, *claims_of]}  # fmt: skip
    code, said = verdict(file)
    assert (code, "limits/0" in said) == (1, True)


@pytest.mark.parametrize("wrong", [{"poisson_ratio": 1}, {"elastic_modulus_mpa": -1}])
def test_a_contact_that_is_nowhere_stiff_is_refused(wrong: Json) -> None:
    steel = {"elastic_modulus_mpa": 206000.0, "poisson_ratio": 0.3}
    judge = checker()
    found = object.__new__(judge.Load)
    for cam, width in ((steel, 12.0), (steel | wrong, 12.0), (steel, -12.0)):
        contact = {"width_mm": width, "cam": cam, "follower": steel}
        found.body = judge.read(json.dumps({"contact": contact}).encode())
        if (cam, width) == (steel, 12.0):
            assert found.stiffness()
        else:
            with pytest.raises(judge.Failure, match="not positive"):
                found.stiffness()


def test_a_row_with_an_acceleration_says_nothing_of_durations() -> None:
    """It limits no speed: what a least duration rests on are rows of s and v alone."""
    body, own = BOUND["face, most"]
    found = {**made("face")[0]}
    found["question"] = json.loads(
        DesignSpec.model_validate({**body, "load": own}).model_dump_json()
    )
    judge = checker()
    for mass, refused in ((1.0, True), (0.0, False)):
        found["question"]["load"]["moving_mass_kg"] = mass
        judge.spent.clear()
        question = judge.Question(judge.read(json.dumps(found["question"]).encode()))
        cells = {"rows": [{"limit": "limits/3", "side": judge.ONE, "cells": []}]}
        if refused:
            with pytest.raises(judge.Failure, match="does not limit how fast"):
                judge.duration(question, question.program[0], cells)
        else:
            judge.duration(question, question.program[0], cells)
