"""Where a follower does not reach the ground: against polygons, circles and rotation matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from synthesis.studies.measured import ProfileAnalysis
from tests.numerics.geometry import touch
from tests.studies.measured.cams import ARM, EDGE, FACE, VALLEY, motion_of, profile, read, spec

TOLERANCE = 2e-3
SMALL = {"kind": "translating_roller", "roller_radius_mm": 2.1, "offset_mm": 4.3}
LARGE = SMALL | {"roller_radius_mm": 22.3}
HOLLOW = 12.16  # mm, smallest hollow radius of the valley


@pytest.fixture(scope="module")
def valley() -> np.ndarray:
    """A profile made for a roller of 2.1 mm, with a valley of hollow radius 12.16 mm."""
    return profile(spec(SMALL, program=VALLEY, base_radius_mm=37.1), 2400)


@pytest.fixture(scope="module")
def spanned(valley: np.ndarray) -> ProfileAnalysis:
    return read(valley, LARGE, tolerance_mm=TOLERANCE)


def test_a_hollow_too_narrow_for_the_roller_is_found(
    valley: np.ndarray, spanned: ProfileAnalysis
) -> None:
    (place,) = spanned.unreached_hollows
    assert place.hollow_radius_mm == pytest.approx(HOLLOW, rel=0.01)
    assert place.roller_radius_mm == 22.3
    # by touch: let down at this angle, the circle meets the polygon on both sides of the valley
    angles = np.radians(place.angle_deg + np.array([-0.05, 0.0, 0.05]))
    roller = touch.Roller(4.3, 22.3)
    heights = touch.lifts(valley, angles, roller)
    before, after = heights[1] - heights[0], heights[2] - heights[1]
    assert before < 0.0 < after, "it goes down into the valley and up again, with a jump of speed"
    centre = touch.turned(np.array([[4.3, heights[1]]]), -angles[1])[0]
    away = np.hypot(*(valley - centre).T) - 22.3
    inside = np.flatnonzero(np.hypot(*(valley - [place.x_mm, place.y_mm]).T) < 3.0)
    assert np.max(away[inside]) >= place.gap_mm - 1e-3
    near = int(np.argmin(np.hypot(*(valley - [place.x_mm, place.y_mm]).T)))
    assert away[near] == pytest.approx(place.gap_mm, abs=3e-3)
    touching = np.flatnonzero(away < 2e-3)
    assert touching.min() < near < touching.max()


def test_the_motion_is_that_of_touch(valley: np.ndarray, spanned: ProfileAnalysis) -> None:
    angles = np.radians(spanned.table["angle_deg"])
    heights = touch.lifts(valley, angles, touch.Roller(4.3, 22.3))
    read_ = np.array(spanned.table["s_mm"]) + spanned.dimensions["s0_mm"]
    assert np.max(np.abs(read_ - heights)) < TOLERANCE
    assert all(peak.error is None for peak in spanned.peaks[1:]), "the velocity jumps"


def test_a_roller_that_fits_touches_everywhere(valley: np.ndarray) -> None:
    fits = read(valley, LARGE | {"roller_radius_mm": 0.97 * HOLLOW}, tolerance_mm=TOLERANCE)
    assert not fits.unreached_hollows
    angles = np.radians(fits.table["angle_deg"])
    heights = touch.lifts(valley, angles, touch.Roller(4.3, 0.97 * HOLLOW))
    read_ = np.array(fits.table["s_mm"]) + fits.dimensions["s0_mm"]
    assert np.max(np.abs(read_ - heights)) < TOLERANCE


def test_a_flat_face_spans_every_hollow(valley: np.ndarray) -> None:
    found = read(valley, FACE, tolerance_mm=TOLERANCE)
    (place,) = found.unreached_hollows
    turned = touch.turned(valley, np.radians(place.angle_deg))
    highest = np.max(turned[:, 1])
    top = turned[turned[:, 1] > highest - 2e-3]
    assert np.min(top[:, 0]) < -5.0 < 5.0 < np.max(top[:, 0]), "it rests on both rims"
    between = turned[(turned[:, 1] > 0.0) & (abs(turned[:, 0]) < 5.0)]
    assert place.gap_mm == pytest.approx(highest - np.min(between[:, 1]), abs=1e-2)
    heights = [np.max(touch.turned(valley, a)[:, 1]) for a in np.radians(found.table["angle_deg"])]
    read_ = np.array(found.table["s_mm"]) + found.dimensions["base_radius_mm"]
    assert np.max(np.abs(read_ - heights)) < TOLERANCE


def test_several_hollows_and_the_turns_end() -> None:
    """Two valleys, one of them across cam angle 0; of each the ground is touched, no corner."""
    program = [
        {"kind": "rise", "angle_deg": 33.0, "lift_mm": 9.1, "law": {"kind": "cycloidal"}},
        {"kind": "dwell", "angle_deg": 121.0},
        {"kind": "return", "angle_deg": 31.0, "lift_mm": 8.3, "law": {"kind": "cycloidal"}},
        {"kind": "rise", "angle_deg": 31.0, "lift_mm": 8.3, "law": {"kind": "cycloidal"}},
        {"kind": "dwell", "angle_deg": 111.0},
        {"kind": "return", "angle_deg": 33.0, "lift_mm": 9.1, "law": {"kind": "cycloidal"}},
    ]
    points = profile(spec(SMALL, program=program, base_radius_mm=33.7), 2400)
    found = read(points, LARGE, tolerance_mm=TOLERANCE)
    at = [place.angle_deg for place in found.unreached_hollows]
    assert len(at) == 4
    assert at == sorted(at)
    angles = np.radians(found.table["angle_deg"])
    heights = touch.lifts(points, angles, touch.Roller(4.3, 22.3))
    read_ = np.array(found.table["s_mm"]) + found.dimensions["s0_mm"]
    assert np.max(np.abs(read_ - heights)) < TOLERANCE


def test_a_knife_edge_reaches_what_no_roller_does(valley: np.ndarray) -> None:
    found = read(valley, EDGE, tolerance_mm=TOLERANCE)
    assert not found.unreached_hollows


def test_an_arm_spans_a_hollow_too(valley: np.ndarray) -> None:
    arm: dict[str, Any] = ARM | {"roller_radius_mm": 22.3}
    (place,) = read(valley, arm, tolerance_mm=TOLERANCE).unreached_hollows
    assert place.hollow_radius_mm == pytest.approx(HOLLOW, rel=0.01)
    assert place.gap_mm > 0.3


def test_contact_that_leaves_the_face_is_named() -> None:
    question = spec(FACE)
    found = read(
        profile(question), FACE, tolerance_mm=1e-3,
        face_width={"kind": "face_width", "left_mm": 60.0, "right_mm": 21.0},
    )  # fmt: skip
    (off,) = found.contact_off_face
    theta = np.linspace(0.0, 2.0 * np.pi, 200_001)
    contact = motion_of(question).derivatives(theta)[1]
    beyond = np.degrees(theta[contact > 21.0])
    assert off.side == "right"
    assert (off.from_deg, off.to_deg) == pytest.approx((beyond[0], beyond[-1]), abs=0.2)
    assert off.excess_mm == pytest.approx(np.max(contact) - 21.0, abs=0.03)
    assert off.worst_deg == pytest.approx(np.degrees(theta[np.argmax(contact)]), abs=2.0)
    assert found.dimensions["face_right_mm"] == pytest.approx(np.max(contact), abs=0.03)
