"""Point files for CAD: where they begin, that nothing is repeated, and how near they keep."""

from __future__ import annotations

import io
import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters import PROFILE_FORMATS, PointOptions, ProfileOptions

CURVES = pytest.mark.parametrize("curve", ["profile", "pitch"])


def points(design: Design, **options: Any) -> np.ndarray:
    """(n, 2), read by NumPy."""
    data = PROFILE_FORMATS["txt"].write(design, PointOptions(**options))
    table = np.loadtxt(io.BytesIO(data))
    assert table.shape[1] == 3
    assert not table[:, 2].any()
    return table[:, :2]


def away(from_points: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Distance of each point from the closed polyline: from both chords at its nearest corners.

    No chord is as long as the distance between two parts of a cam's outline, so that another
    chord is nowhere nearer; where it were, the distance found would be too large.
    """
    _, corners = cKDTree(ring).query(from_points, k=3)
    least = np.full(len(from_points), np.inf)
    for first in (corners, corners - 1):
        a = ring[first]
        d = ring[(first + 1) % len(ring)] - a
        to = from_points[:, None] - a
        part = np.clip(np.sum(to * d, axis=2) / np.sum(d * d, axis=2), 0.0, 1.0)
        near = np.hypot(*np.moveaxis(to - part[:, :, None] * d, 2, 0))
        least = np.minimum(least, near.min(axis=1))
    return least


def rise_and_return(*dwells: float, order: str = "rtd") -> list[dict[str, Any]]:
    parts = {
        "r": [{"kind": "rise", "angle_deg": 80.0, "lift_mm": 12.3, "law": {"kind": "cycloidal"}}],
        "t": [{"kind": "return", "angle_deg": 95.0, "lift_mm": 12.3, "law": {"kind": "cycloidal"}}],
    }
    left = iter(dwells)
    program = []
    for letter in order:
        program += parts.get(letter) or [{"kind": "dwell", "angle_deg": next(left)}]
    return program


@CURVES
def test_written_digits(curve: str, cam: Design, truth) -> None:
    ring = points(cam, points_per_degree=2.7, curve=curve)
    mid = {"p1": 255.0, "unspecial": 320.0}["p1" if cam.name == "example 13-6" else "unspecial"]
    degrees = (mid + np.arange(972) * 360.0 / 972) % 360.0
    borders = np.array([segment.start_deg for segment in cam.motion])
    near = np.min(np.abs((degrees[:, None] - borders + 180.0) % 360.0 - 180.0), axis=1)
    degrees = np.concatenate([degrees[near > 0.25 * 360.0 / 972], np.unique(borders)])
    ahead = (degrees - mid) % 360.0
    right = truth(cam).points(degrees[np.argsort(ahead)], curve)
    assert ring.shape == right.shape
    np.testing.assert_allclose(ring, right, rtol=0.0, atol=0.51e-10)


def test_zero_has_no_sign(build) -> None:
    """At cam angle 0 and 180° x is 0 but for rounding, of either sign."""
    for rotation in ("ccw", "cw"):
        data = PROFILE_FORMATS["txt"].write(build(rotation=rotation, offset=0.0), PointOptions())
        assert b"\n0.0000000000 " in data
        assert b"-0.0000000000" not in data


def test_form(cam: Design) -> None:
    data = PROFILE_FORMATS["txt"].write(cam, PointOptions())
    text = data.decode("ascii")
    assert "\r" not in text
    assert text.endswith("\n")
    for line in text.splitlines():
        x, y, z = line.split(" ")
        assert z == "0.0000000000"
        for number in (x, y):
            assert len(number.split(".")[1]) == 10


@pytest.mark.parametrize(
    ("order", "dwells", "seam"),
    [
        ("rdtd", (60.0, 125.0), 297.5),  # the longer of two
        ("rdtd", (125.0, 60.0), 142.5),
        ("drtd", (100.0, 85.0), 7.5),  # one dwell across cam angle 0
        ("drtd", (30.0, 155.0), 297.5),
        ("rddtd", (40.0, 41.0, 104.0), 308.0),
        ("rddtd", (90.0, 30.0, 65.0), 140.0),  # two that touch
        ("rddtd", (60.0, 60.0, 65.0), 140.0),  # … and meet in their middle
    ],
)
@CURVES
def test_seam(build, truth, order: str, dwells: tuple[float, ...], seam: float, curve: str) -> None:
    design = build(rise_and_return(*dwells, order=order), offset=4.4, limits=[])
    ring = points(design, curve=curve)
    right = truth(design).points(np.array([seam, seam + 0.25]), curve)
    np.testing.assert_allclose(ring[:2], right, rtol=0.0, atol=1e-9)


def test_seam_without_a_dwell(build, truth) -> None:
    program = [
        {"kind": "rise", "angle_deg": 170, "lift_mm": 12.3, "law": {"kind": "cycloidal"}},
        {"kind": "return", "angle_deg": 190, "lift_mm": 12.3, "law": {"kind": "cycloidal"}},
    ]
    design = build(program, limits=[])
    right = truth(design).points(np.array([0.0, 0.25]))
    np.testing.assert_allclose(points(design)[:2], right, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    "options",
    [{}, {"points_per_degree": 0.7}, {"points_per_degree": 33.0}, {"tolerance_um": 0.5}],
    ids=str,
)
@CURVES
def test_no_point_twice_and_none_crowded(options, curve: str, cam: Design) -> None:
    ring = points(cam, curve=curve, **options)
    assert len(np.unique(ring, axis=0)) == len(ring)
    step = np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)
    assert step.min() > 0.02 * step.max()


def test_a_knife_edge_at_a_corner_gives_one_point(build) -> None:
    """With constant velocity s' jumps; the pitch curve has a corner there, but no gap."""
    program = [
        {"kind": "rise", "angle_deg": 120, "lift_mm": 9.9, "law": {"kind": "constant_velocity"}},
        {"kind": "return", "angle_deg": 140, "lift_mm": 9.9, "law": {"kind": "constant_velocity"}},
        {"kind": "dwell", "angle_deg": 100},
    ]
    design = build(program, roller=0.0, limits=[])
    ring = points(design)
    assert len(np.unique(ring, axis=0)) == len(ring) == 1440


def test_a_roller_at_a_corner_gives_both_ends_of_the_gap(build) -> None:
    program = [
        {"kind": "rise", "angle_deg": 120, "lift_mm": 9.9, "law": {"kind": "constant_velocity"}},
        {"kind": "return", "angle_deg": 140, "lift_mm": 9.9, "law": {"kind": "constant_velocity"}},
        {"kind": "dwell", "angle_deg": 100},
    ]
    design = build(program, limits=[])
    assert len(points(design)) == 1440 + 3
    assert len(points(design, curve="pitch")) == 1440


@pytest.mark.parametrize("tolerance", [300.0, 20.0, 1.0, 0.1])
@CURVES
def test_chords_keep_the_tolerance(tolerance: float, curve: str, cam: Design, truth) -> None:
    ring = points(cam, tolerance_um=tolerance, curve=curve)
    fine = np.linspace(0.0, 360.0, 10 * len(ring) + 1)[:-1]
    worst = away(truth(cam).points(fine, curve), ring).max()
    assert worst <= 1e-3 * tolerance
    if tolerance < 50.0:  # and not much better than asked: points are not wasted
        assert worst >= 0.7e-3 * tolerance


@CURVES
def test_chords_are_few(curve: str, cam: Design, truth) -> None:
    """About as many as ∫ √(κ / 8 tol) ds asks for, here from the angles between fine chords."""
    tolerance = 0.2
    fine = truth(cam).points(np.linspace(0.0, 360.0, 200001), curve)
    step = np.diff(fine, axis=0)
    heading = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
    bend = np.abs(np.diff(heading)) * np.hypot(*step[1:].T)
    needed = np.sum(np.sqrt(bend)) / math.sqrt(8e-3 * tolerance)
    assert len(points(cam, tolerance_um=tolerance, curve=curve)) <= 1.12 * needed + 10


def test_tables_keep_the_tolerance_too(cam: Design, truth) -> None:
    data = PROFILE_FORMATS["csv"].write(cam, ProfileOptions(tolerance_um=2.0))
    table = np.loadtxt(io.BytesIO(data), delimiter=",", skiprows=1)
    fine = np.linspace(0.0, 360.0, 20001)[:-1]
    order = np.unique(table[:, 0], return_index=True)[1]
    ring = table[order, 5:7][:-1]
    assert away(truth(cam).points(fine), ring).max() <= 2e-3
    for segment in cam.motion:
        assert np.min(np.abs(table[:, 0] - segment.start_deg)) < 1e-12


def test_a_clockwise_cam_is_the_mirror_image(build) -> None:
    one, other = (points(build(rotation=r, offset=13.7)) for r in ("ccw", "cw"))
    np.testing.assert_array_equal(other, one * [-1.0, 1.0])


def test_the_ring_begins_where_it_is_told_to(cam: Design, truth) -> None:
    ring = points(cam, start_deg=77.7, points=361)
    right = truth(cam).points(np.array([77.7, 77.7 + 360.0 / 361.0]))
    np.testing.assert_allclose(ring[:2], right, rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(points(cam, start_deg=77.7 - 360.0, points=361), ring)


def test_points_past_the_end_are_the_first_ones(cam: Design) -> None:
    ring = points(cam, points=500)
    closed = points(cam, points=500, closed=True)
    np.testing.assert_array_equal(closed, np.vstack([ring, ring[:1]]))
    over = points(cam, points=500, overlap_points=17)
    np.testing.assert_array_equal(over, np.vstack([ring, ring[:18]]))
    with pytest.raises(InputError, match="no more than"):
        points(cam, points=500, overlap_points=len(ring))


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
def test_points_run_round_as_asked(build, rotation: str) -> None:
    design = build(rotation=rotation)
    rings = {sense: points(design, direction=sense, points=400) for sense in ("ccw", "cw")}
    for sense, ring in rings.items():
        x, y = ring.T
        turned = np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
        assert (turned > 0.0) == (sense == "ccw")
    np.testing.assert_array_equal(rings["ccw"][0], rings["cw"][0])
    np.testing.assert_array_equal(rings["ccw"][1:], rings["cw"][:0:-1])
    plain = points(design, points=400)
    np.testing.assert_array_equal(plain, rings["cw" if rotation == "ccw" else "ccw"])


def test_decimals(cam: Design) -> None:
    text = PROFILE_FORMATS["txt"].write(cam, PointOptions(decimals=3, points=360)).decode()
    assert all(len(n.split(".")[1]) == 3 for line in text.splitlines() for n in line.split())
    ring, exact = points(cam, decimals=3, points=360), points(cam, points=360)
    assert np.max(np.abs(ring - exact)) <= 0.5e-3
    coarse = points(cam, decimals=0, points=3000)  # many fall together
    assert np.all(np.any(coarse != np.roll(coarse, 1, axis=0), axis=1))


def test_rounding_is_within_the_chord_tolerance(cam: Design, truth) -> None:
    ring = points(cam, tolerance_um=2.0, decimals=3)
    fine = np.linspace(0.0, 360.0, 20001)[:-1]
    worst = away(truth(cam).points(fine), ring).max()
    assert worst <= 2e-3
    with pytest.raises(InputError, match=r"Rounding alone moves points by up to 0\.707 µm"):
        points(cam, tolerance_um=1.0, decimals=3)
