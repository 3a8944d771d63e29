"""A known cam's points, rounded and shaken, come back as its motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BSpline

from synthesis import DesignSpec, synthesise
from synthesis.catalogue.profile import cam_profile
from synthesis.exporters import PROFILE_FORMATS, PointOptions
from synthesis.studies.analyse import given_cam
from synthesis.studies.measured import ProfileAnalysis
from tests.studies.measured.cams import ARM, EDGE, FACE, ROLLER, motion_of, profile, read, spec

TOLERANCE = 6e-3  # mm
TILTED = FACE | {"tilt_deg": 11.3, "offset_mm": 4.7}
FOLLOWERS = [ROLLER, EDGE, FACE, TILTED, ARM, ARM | {"sense": "same"}]


def names(follower: dict[str, Any]) -> str:
    reported = (follower.get(name, "") for name in ("roller_radius_mm", "sense", "tilt_deg"))
    return "-".join(str(each) for each in (follower["kind"], *reported))


def exported(question: DesignSpec) -> np.ndarray:
    """What the point file holds, rounded to 1 µm, with 1 µm of noise in each coordinate."""
    text = PROFILE_FORMATS["txt"].write(synthesise(question), PointOptions(points_per_degree=2.5))
    points = np.array([[float(cell) for cell in row.split()[:2]] for row in text.splitlines()])
    return np.round(points, 3) + 1e-3 * np.random.default_rng(5).standard_normal(points.shape)


def table(question: DesignSpec, found: ProfileAnalysis) -> list[tuple[np.ndarray, np.ndarray]]:
    """Displacement to jerk as read, and as the law has them, in the wire's units."""
    travel, omega = question.follower.travel, question.machine().omega
    true = motion_of(question).derivatives(np.radians(found.table["angle_deg"]))
    read_ = [np.array(c) for name, c in found.table.items() if name[1] == "_"]
    return [
        (r, t * travel.wire_factor(k, omega))
        for k, (r, t) in enumerate(zip(read_, true, strict=True))
    ]


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("follower", FOLLOWERS, ids=names)
def test_the_motion_comes_back(follower: dict[str, Any], rotation: str) -> None:
    question = spec(follower, rotation=rotation)
    found = read(exported(question), follower, rotation=rotation, tolerance_mm=TOLERANCE)
    pairs = table(question, found)
    within = TOLERANCE / question.follower.travel.per_unit
    assert np.max(np.abs(pairs[0][0] - pairs[0][1])) < within
    # within what is told to be hidden by the tolerance, and far better than that says nothing
    for (read_, true), peak in zip(pairs, found.peaks, strict=False):
        assert peak.error is not None
        assert np.max(np.abs(read_ - true)) < peak.error
        top = peak.largest, peak.smallest
        assert top == pytest.approx((np.max(true), np.min(true)), abs=peak.error)
    for order, share in ((1, 0.01), (2, 0.11)):
        read_, true = pairs[order]
        assert np.max(np.abs(read_ - true)) < share * np.ptp(true)
    assert found.dimensions["base_radius_mm"] == pytest.approx(
        question.base_radius_mm, abs=TOLERANCE
    )
    assert not found.unreached_hollows
    assert 0.8e-3 < found.fit.rms_mm < 2e-3
    assert found.fit.largest_mm <= TOLERANCE


@pytest.mark.parametrize("follower", FOLLOWERS, ids=names)
def test_pressure_angles_and_dwells_come_back(follower: dict[str, Any]) -> None:
    question = spec(follower)
    found = read(exported(question), follower, tolerance_mm=TOLERANCE)
    cam = given_cam(question)
    theta = np.radians(found.table["angle_deg"])
    true = cam_profile(cam.motion, question.follower, cam.size, "ccw", theta).pressure_angle
    assert np.allclose(found.table["pressure_angle_deg"], np.degrees(true), atol=0.15)
    upper, lower = found.dwells
    for dwell, (start, angle) in ((upper, (73.3, 41.2)), (lower, (203.4, 156.6))):
        # the law itself leaves a dwell so slowly that its end is not seen to the degree
        assert start - 9.0 < dwell.start_deg < start + 1.0
        assert start + angle - 1.0 < dwell.start_deg + dwell.angle_deg < start + angle + 9.0
    assert upper.s - lower.s == pytest.approx(16.1 if "arm_mm" in follower else 23.7, abs=TOLERANCE)


def test_start_direction_and_spacing_do_not_matter() -> None:
    question = spec(ROLLER)
    even = read(profile(question), ROLLER, tolerance_mm=1e-3)
    ring = np.roll(profile(question, 1100, uneven=0.9), 417, axis=0)
    closed = np.vstack([ring, ring[:1]])
    for points in (ring, ring[::-1], closed):
        found = read(points, ROLLER, tolerance_mm=1e-3)
        assert np.allclose(found.table["s_mm"], even.table["s_mm"], atol=3e-4)


def test_the_spline_is_the_table() -> None:
    """By SciPy alone, as the description of the answer says."""
    found = read(profile(spec(ROLLER)), ROLLER, tolerance_mm=1e-3)
    knots, c, p = np.array(found.spline.knots_deg), found.spline.coefficients, found.spline.degree
    n, theta = len(knots), np.array(found.table["angle_deg"])
    index = np.arange(-p, n + p + 1)
    around = knots[index % n] + 360.0 * (index // n)
    spline = BSpline(around, np.array([c[i % n] for i in range(n + p)]), p)
    assert np.allclose(spline(theta), found.table["s_mm"], atol=1e-9)
    speed = 6.0 * 97.0  # deg/s
    assert np.allclose(spline(theta, nu=1) * speed, found.table["v_mm_per_s"], atol=1e-6)


def test_mirroring_mirrors() -> None:
    question = spec(ROLLER)
    points = profile(question)
    here = read(points, ROLLER, tolerance_mm=1e-3)
    there = read(points * [-1.0, 1.0], ROLLER, rotation="cw", tolerance_mm=1e-3)
    assert np.allclose(here.table["s_mm"], there.table["s_mm"], atol=1e-9)
    assert np.allclose(here.table["pressure_angle_deg"], there.table["pressure_angle_deg"])


def test_better_points_give_better_derivatives() -> None:
    question = spec(ROLLER)
    clean = profile(question, 1440)
    noise = np.random.default_rng(2).standard_normal(clean.shape)
    worst = []
    for scatter in (3e-3, 3e-4, 3e-5):
        found = read(clean + scatter * noise, ROLLER, tolerance_mm=6.0 * scatter)
        read_, true = table(question, found)[2]
        worst.append(np.max(np.abs(read_ - true)))
    assert worst[0] > 1.5 * worst[1] > 2.0 * worst[2]


def test_turning_the_points_shifts_the_motion() -> None:
    turn = np.radians(17.0)
    cos, sin = np.cos(turn), np.sin(turn)
    points = profile(spec(ROLLER))
    here = read(points, ROLLER, tolerance_mm=1e-3)
    there = read(points @ np.array([[cos, sin], [-sin, cos]]), ROLLER, tolerance_mm=1e-3)
    assert np.allclose(np.roll(here.table["s_mm"], -17), there.table["s_mm"], atol=1e-4)
