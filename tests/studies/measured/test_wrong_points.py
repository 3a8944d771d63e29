"""Points that are no cam's profile are refused, each with its reason, place and way out."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from synthesis.catalogue.profile import cam_profile
from synthesis.errors import InputError
from synthesis.studies.analyse import given_cam
from synthesis.studies.measured.follower_path import first_crossing
from tests.studies.measured.cams import ARM, ROLLER, profile, read, spec


def refused(points: np.ndarray, follower: dict[str, Any] = ROLLER, **more: Any) -> InputError:
    with pytest.raises(InputError) as caught:
        read(points, follower, **more)
    return caught.value


@pytest.fixture(scope="module")
def points() -> np.ndarray:
    return profile(spec(ROLLER), 700)


def test_too_few(points: np.ndarray) -> None:
    error = refused(points[::40])
    assert (error.field, error.value) == ("/points_mm", 18)
    assert "fewer than" in error.rule


def test_the_same_point_again_and_again(points: np.ndarray) -> None:
    assert refused(np.repeat(points[:7], 9, axis=0)).value == 7


def test_not_closed(points: np.ndarray) -> None:
    error = refused(points[:600])
    assert "not closed" in error.rule
    first, last = points[0], points[599]
    assert error.value == pytest.approx(np.hypot(*(last - first)), abs=1e-5)
    assert f"{last[0]:.6g}" in error.rule


def test_crossing_itself(points: np.ndarray) -> None:
    crossed = points.copy()
    crossed[300:310] = crossed[300:310][::-1]
    error = refused(crossed)
    assert "crosses itself" in error.rule
    assert np.min(np.hypot(*(points - np.array(error.value)).T)) < 2.0


def test_ends_that_overlap(points: np.ndarray) -> None:
    error = refused(np.vstack([points, points[:20] + 1e-3]))
    assert "the whole profile" in error.remedy


def test_an_axis_outside(points: np.ndarray) -> None:
    error = refused(points + np.array([200.0, 0.0]))
    assert "axis" in error.rule
    assert "origin" in error.remedy


def test_scatter_beyond_the_tolerance(points: np.ndarray) -> None:
    bad = points.copy()
    bad[123] *= 1.01
    error = refused(bad, tolerance_mm=5e-3)
    assert error.field == "/tolerance_mm"
    assert error.value == 5e-3
    x, y = (float(cell) for cell in re.findall(r"[xy] = (-?[\d.]+)", error.rule))
    assert np.hypot(*(bad[123] - [x, y])) < 2.0


def test_a_follower_that_is_not_given(points: np.ndarray) -> None:
    error = refused(points, {"kind": "translating_roller", "roller_radius_mm": 9.3})
    assert error.field == "/follower/offset_mm"


@pytest.mark.parametrize(
    "closure",
    [{"kind": "groove"}, {"kind": "force", "contact": "inside"},
     {"kind": "conjugate", "roller_radius_mm": 3.0, "offset_mm": 0.0}],
)  # fmt: skip
def test_what_is_not_one_roller_from_outside(points: np.ndarray, closure: dict[str, Any]) -> None:
    assert refused(points, ROLLER | {"closure": closure}).field == "/follower/closure"


@pytest.mark.parametrize(
    "follower",
    [
        ROLLER | {"offset_mm": 66.0},
        ARM | {"arm_mm": 20.0},
        ARM | {"centre_distance_mm": 200.0},
        ARM | {"centre_distance_mm": -100.0},
    ],
)
def test_a_follower_that_does_not_reach(points: np.ndarray, follower: dict[str, Any]) -> None:
    error = refused(points, follower)
    assert error.field == "/follower"
    assert "cannot touch x = " in error.rule


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
def test_an_arm_that_reaches_only_the_nose_is_told_from_which_cam_angle_on(rotation: str) -> None:
    question = spec(ARM, rotation=rotation)
    distance, cam = 140.0, given_cam(question)
    error = refused(
        profile(question, 1800), ARM | {"centre_distance_mm": distance}, rotation=rotation
    )
    # stretched along the line of centres it just reaches; there the roller stands before its pivot
    theta = np.linspace(0.0, 2.0 * np.pi, 200_001)
    p = cam_profile(cam.motion, question.follower, cam.size, "ccw", theta)
    near = np.hypot(p.pitch_x, p.pitch_y) < distance - ARM["arm_mm"]
    edges = np.flatnonzero(near[1:] != near[:-1])
    assert len(edges) == 2
    heading = np.degrees(np.arctan2(p.pitch_y, p.pitch_x))[edges]
    reported = [
        float(cell)
        for cell in re.findall(r"cam angles? (-?[\d.]+)° and (-?[\d.]+)°", error.rule)[0]
    ]
    assert sorted(reported) == pytest.approx(sorted((31.0 - heading) % 360.0), abs=1.5)
    x, y = (float(cell) for cell in re.findall(r"[xy] = (-?[\d.]+)", error.rule))
    assert np.hypot(x, y) < 45.0  # on the base circle


def test_an_arm_that_reaches_nothing_is_told_so(points: np.ndarray) -> None:
    assert "at no cam angle" in refused(points, ARM | {"centre_distance_mm": 200.0}).rule


def test_crossings_against_every_pair_of_sides() -> None:
    rng = np.random.default_rng(8)
    reported = []
    for _ in range(60):
        count = int(rng.integers(5, 130))
        angle = 2.0 * np.pi * np.arange(count) / count
        radius = 1.0 + rng.uniform(0.0, 1.0) * rng.uniform(-0.9, 0.9, count)
        ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
        if rng.uniform() < 0.5:
            i, j = rng.integers(0, count, 2)
            ring[[i, j]] = ring[[j, i]]
        reported.append(first_crossing(ring) is not None)
        assert reported[-1] == any(
            meets(ring[i], ring[i + 1 - count], ring[j], ring[j + 1 - count])
            for i in range(count) for j in range(i + 2, count) if (i, j) != (0, count - 1)
        )  # fmt: skip
    assert 10 < sum(reported) < 50


def meets(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> bool:
    """By the signs of four triangles."""

    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0


def test_a_length_left_free_is_told_to_be_given(points: np.ndarray) -> None:
    error = refused(points, ARM | {"arm_mm": {"min": 80.0, "max": 90.0}})
    assert error.field == "/follower/arm_mm"
    assert "number" in error.remedy


def test_points_that_repeat_to_within_rounding_are_one() -> None:
    """The first point given again at the end, and a point given twice in a row."""
    points = profile(spec(ROLLER), 700)
    again = np.vstack([points[:300], points[299:300] + 1e-12, points[300:], points[:1]])
    assert read(again, ROLLER).fit.points == 700
