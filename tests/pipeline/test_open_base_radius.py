"""Base radii that are open below: bounds hold down to 0, and cams come near an infimum."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from synthesis import Design, DesignSpec, synthesise
from synthesis.certify.second import confirm

Spec = dict[str, Any]
SPLINE, CYCLOID = {"kind": "spline"}, {"kind": "cycloidal"}


def question(follower: Spec, *limits: Spec, **program: Any) -> Spec:
    """A rise, a dwell, a return of the same lift and a dwell, at 60 rpm."""
    rise, dwell, back = program.get("angles", (90.0, 30.0, 90.0))
    unit = "deg" if follower["kind"].startswith("oscillating") else "mm"
    move = {f"lift_{unit}": program["lift"], "law": program.get("law", SPLINE)}
    segments = [
        {"kind": "rise", "angle_deg": rise, **move},
        {"kind": "dwell", "angle_deg": dwell},
        {"kind": "return", "angle_deg": back, **move},
        {"kind": "dwell", "angle_deg": 360.0 - rise - dwell - back},
    ]
    return {"program": segments, "follower": follower, "limits": list(limits)}


def roller(radius: float, **more: Any) -> Spec:
    return {"kind": "translating_roller", "roller_radius_mm": radius, **more}


def arm(length: float, radius: float, distance: float) -> Spec:
    return {
        "kind": "oscillating_roller", "arm_mm": length, "roller_radius_mm": radius,
        "centre_distance_mm": distance,
    }  # fmt: skip


def face(**more: Any) -> Spec:
    return {"kind": "translating_flat_face", **more}


def steep(rise: float, back: float | None = None) -> Spec:
    return {"kind": "pressure_angle", "rise_deg": rise, "return_deg": back or rise}


def jerk(most: float, unit: str = "mm") -> Spec:
    return {"kind": "jerk", f"max_{unit}_per_s3": most}


def answer(spec: Mapping[str, Any], **changes: Any) -> Design:
    return synthesise(DesignSpec.model_validate({**spec, **changes}))


LONG, WIDE = (101.0, 20.0, 93.0), (151.0, 20.0, 153.0)
GROOVE, PAIR = {"kind": "groove"}, {"kind": "conjugate", "roller_radius_mm": 14.0}
VANISHING: dict[str, Spec] = {
    "nearly any pressure angle": question(roller(2.0), steep(89.999), jerk(30720.0), lift=10.0),
    "unequal angles": question(
        roller(9.3), steep(41.0, 52.0), jerk(61000.0), lift=7.7, angles=LONG
    ),
    "offset given": question(
        roller(5.1, offset_mm=1.3), steep(61.0, 58.0), jerk(90000.0), lift=7.7, angles=LONG
    ),
    "offset in a range": question(
        roller(25.1, offset_mm={"min": 1.3, "max": 9.0}), steep(31.0, 38.0), jerk(90000.0),
        lift=7.7, angles=LONG,
    ),
    "large roller": question(
        roller(210.0), steep(33.0), jerk(205000.0), lift=30.5, angles=(131.0, 20.0, 120.0)
    ),
    "small lift": question(roller(9.3e-5), steep(41.0), jerk(0.61), lift=7.7e-5, angles=LONG),
    "large lift": question(roller(9.3e3), steep(41.0), jerk(6.1e7), lift=7.7e3, angles=LONG),
    "knife edge": question(roller(0.0), steep(89.99), jerk(90000.0), lift=7.7, angles=LONG),
    "groove": question(
        roller(15.0, closure=GROOVE), steep(70.0), jerk(45000.0), lift=7.7, angles=LONG
    ),
    "pair of cams": question(
        roller(15.0, closure=PAIR), steep(70.0), jerk(45000.0), lift=7.7, angles=LONG
    ),
    "cutter": question(
        roller(15.0), steep(70.0), jerk(45000.0), {"kind": "cutter_radius", "radius_mm": 21.0},
        lift=7.7, angles=LONG,
    ),
    "face": question(face(), jerk(30000.0), lift=7.7, angles=WIDE),
    "face, small": question(face(), jerk(0.03), lift=8.3e-6, angles=WIDE),
    "face, tilted": question(face(tilt_deg=10.0), jerk(30000.0), lift=7.7, angles=WIDE),
    "face, wide enough": question(
        face(), jerk(30000.0), {"kind": "face_width", "left_mm": 9.0, "right_mm": 9.0}, lift=7.7,
        angles=WIDE,
    ),
    "face, offset": question(face(offset_mm=4.4), jerk(21000.0), lift=5.9, angles=(160.0, 9, 155)),
    "arm through the axis": question(
        arm(61.0, 2.2, 61.0), steep(80.0), jerk(60000.0, "deg"), lift=11.0, angles=(81.0, 40, 93)
    ),
    "arm with a knife edge": question(
        arm(61.0, 0.0, 61.0), steep(89.0), jerk(90000.0, "deg"), lift=5.0, angles=(81.0, 40, 93)
    ),
    "small arm": question(
        arm(0.61, 0.022, 0.61), steep(80.0), jerk(60000.0, "deg"), lift=11.0, angles=(81.0, 40, 93)
    ),
    "arm, pivot in a range": question(
        {"kind": "oscillating_roller", "arm_mm": 67.1, "roller_radius_mm": 11.9,
         "centre_distance_mm": {"min": 60.4, "max": 90.6}},
        steep(36.3, 40.0), jerk(119_000.0, "deg"), lift=15.5, angles=(120.0, 19.4, 86.2),
    ),
    "a maximum alone": question(roller(2.0), steep(89.9), jerk(30720.0), lift=10.0)
    | {"base_radius_mm": {"max": 0.007}},
    "a least radius of 0": question(roller(2.0), steep(89.9), jerk(30720.0), lift=10.0)
    | {"base_radius_mm": {"min": 0.0}},
}  # fmt: skip


@cache
def vanishing(name: str) -> Design:
    return answer(VANISHING[name])


def stroke(design: Design) -> float:
    return design.spec.stroke()


@pytest.mark.parametrize("name", VANISHING)
def test_a_cam_that_can_vanish_is_said_to_have_an_infimum(name: str) -> None:
    design = vanishing(name)
    proof = design.certificate
    assert proof.certified
    assert proof.infimum
    assert design.status == "feasible"
    assert proof.lower_bound == pytest.approx(0.0, abs=1e-12 * stroke(design))
    assert proof.value is not None
    assert 0.0 < proof.value <= 1.01e-4 * stroke(design)


@pytest.mark.parametrize("name", ["nearly any pressure angle", "offset given", "face", "groove"])
def test_no_bound_lies_above_a_cam_with_named_radii(name: str) -> None:
    spec = VANISHING[name]
    proof, length = vanishing(name).certificate, stroke(vanishing(name))
    for low, high in ((1e-7, 1e-4), (1e-5, 1e-3)):
        named = {"min": low * length, "max": high * length}
        smaller = answer(spec, base_radius_mm=named, proof="quick")
        assert smaller.certificate.certified
        assert smaller.certificate.value is not None
        assert smaller.certificate.value <= high * length
        assert proof.lower_bound is not None
        assert proof.lower_bound <= smaller.certificate.value


@pytest.mark.parametrize("name", ["offset given", "unequal angles"])
def test_a_range_that_is_named_changes_no_cam_near_an_infimum(name: str) -> None:
    value = vanishing(name).certificate.value
    assert value is not None
    design = answer(VANISHING[name], base_radius_mm={"min": 0.2 * value, "max": 20.0 * value})
    assert design.certificate.certified
    assert not design.certificate.infimum
    assert design.certificate.value == pytest.approx(value, rel=1e-6)
    assert design.report.stages[-1].exit == "sufficient"  # no more is sought of so small a cam


@pytest.mark.parametrize("name", ["offset given", "face", "arm through the axis", "knife edge"])
def test_the_second_judge_confirms_cams_near_an_infimum(name: str) -> None:
    pytest.importorskip("flint")
    assert confirm(vanishing(name)).verdict == "confirmed"


def test_a_harmonic_cam_under_a_face_may_be_as_small_as_one_likes() -> None:
    # s = h (1 − cos θ)/2 has s + s'' = h/2: its profile is a circle of radius Rb + h/2
    law = {"law": {"kind": "simple_harmonic"}, "angle_deg": 180.0, "lift_mm": 7.7}
    spec = {
        "program": [{"kind": "rise", **law}, {"kind": "return", **law}], "follower": face(),
        "limits": [],
    }  # fmt: skip
    proof = answer(spec).certificate
    assert proof.infimum
    assert proof.lower_bound == 0.0
    assert proof.value == pytest.approx(7.7e-9, rel=1e-6)


def least_face_radius(angle: float) -> float:
    """Of a cycloidal rise over an angle [deg], over its lift: the largest of −(s + s'')."""
    beta, x = np.radians(angle), np.linspace(0.0, 1.0, 400001)
    s = x - np.sin(2.0 * np.pi * x) / (2.0 * np.pi)
    return float(np.max(-s - 2.0 * np.pi * np.sin(2.0 * np.pi * x) / beta**2))


@pytest.mark.parametrize("share", [4.7e-4, 2.1e-4])
def test_a_best_cam_below_where_the_search_begins_is_found(share: float) -> None:
    angle = brentq(lambda a: least_face_radius(a) - share, 100.0, 179.0)
    spec = question(face(), lift=13.0, law=CYCLOID, angles=(angle, 2.0, angle))
    design = answer(spec)
    assert design.status == "optimal"
    assert not design.certificate.infimum
    assert design.certificate.value == pytest.approx(13.0 * share, rel=1e-4)


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e4])
def test_questions_scaled_in_length_have_the_scaled_answer(factor: float) -> None:
    first = question(
        roller(9.3), steep(41.0, 52.0), jerk(61000.0), lift=7.7, angles=LONG
    )  # fmt: skip
    scaled = question(
        roller(9.3 * factor), steep(41.0, 52.0), jerk(61000.0 * factor), lift=7.7 * factor,
        angles=LONG,
    )  # fmt: skip
    one, other = answer(first).certificate, answer(scaled).certificate
    assert (one.infimum, one.lower_bound) == (other.infimum, other.lower_bound) == (True, 0.0)
    assert one.value is not None
    assert other.value == pytest.approx(factor * one.value, rel=1e-5)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_questions_scaled_in_time_have_the_same_cam(factor: float) -> None:
    spec = question(roller(9.3), steep(41.0, 52.0), jerk(61000.0), lift=7.7, angles=LONG)
    faster = question(
        roller(9.3), steep(41.0, 52.0), jerk(61000.0 * factor**3), lift=7.7, angles=LONG
    )
    one, other = answer(spec).certificate, answer(faster, speed_rpm=60.0 * factor).certificate
    assert (one.infimum, one.lower_bound) == (other.infimum, other.lower_bound)
    assert one.value is not None
    assert other.value == pytest.approx(one.value, rel=1e-5)
