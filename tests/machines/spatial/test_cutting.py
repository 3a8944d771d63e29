"""Cutters: of the roller's form, and thinner ones, against the walls they are to leave."""

from __future__ import annotations

import csv
import io
import math

import numpy as np
import pytest

from synthesis.errors import InputError
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.cutter_path import (
    CSV,
    STEP,
    CutterOptions,
    CutterPoses,
    envelope_error,
    flank_poses,
    roller_poses,
)
from tests.machines.spatial.drums import INNER, OUTER, RADIUS, SAMPLES, Array, cam_points, designed

THIN = 6.1


@pytest.fixture(scope="module", params=["slide in a groove", "arm astride a rib", "turret"])
def design(request: pytest.FixtureRequest) -> SpatialDesign:
    return designed(request.param)


def read(design: SpatialDesign, options: CutterOptions) -> tuple[dict[str, Array], float]:
    made = CSV.make(design, options)
    rows = list(csv.DictReader(io.StringIO(made.data.decode())))
    columns = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    return columns, float(made.metadata["Wall-Error-Mm"])


def lines(columns: dict[str, Array], here: Array) -> tuple[Array, Array]:
    """Points (n, 3) and directions (n, 3) of the cutter's axis."""
    points = np.stack([columns[f"{name}_mm"][here] for name in "xyz"], axis=1)
    return points, np.stack([columns[name][here] for name in "ijk"], axis=1)


def test_a_thin_cutter_leaves_the_wall_within_what_is_told(design: SpatialDesign) -> None:
    """By a fine sweep of the lines in the file: no wall's point nearer, or left, by more."""
    cam, options = design.cam, CutterOptions(cutter_diameter_mm=2 * THIN, points_per_degree=8.0)
    columns, reported = read(design, options)
    assert reported < 2e-3
    for wall in cam.walls[:2]:
        here = (columns["roller"] == wall.seat.number) & (columns["side"] == wall.side)
        at, along = lines(columns, here)
        angles = np.concatenate([np.linspace(a, b, 25)[1:-1] for a, b in wall.spans])
        found = cam_points(cam, wall, angles, np.linspace(INNER, OUTER, 5))
        gap = nearest(found.reshape(3, -1).T, at, along) - THIN
        assert gap.min() > -1.05 * reported - 2e-6
        assert gap.max() < 1.05 * reported + 4e-4  # between two of the lines


def nearest(points: Array, at: Array, along: Array) -> Array:
    """Distance of points (k, 3) from the nearest of all axes, from the cutter's end on."""
    found = np.full(len(points), np.inf)
    for a, u in zip(at, along, strict=True):
        away = np.linalg.norm(np.cross(points - a, u), axis=1)
        found = np.where((points - a) @ u > -0.5, np.minimum(found, away), found)
    return found


def test_it_stays_off_the_other_wall_of_the_groove() -> None:
    design = designed("slide in a groove")
    options = CutterOptions(cutter_diameter_mm=2 * THIN, flank="1R")
    columns, _ = read(design, options)
    assert set(columns["side"]) == {1.0}
    at, along = lines(columns, columns["side"] == 1.0)
    other = next(wall for wall in design.cam.walls if wall.name == "1L")
    found = cam_points(design.cam, other, np.linspace(0.0, 6.2, 61), np.linspace(INNER, OUTER, 3))
    gap = nearest(found.reshape(3, -1).T, at, along) - THIN
    assert gap.min() > 2.0 * (RADIUS - THIN) - 0.1


def test_without_its_tilt_it_would_leave_forty_times_as_much() -> None:
    cam = SAMPLES["slide in a groove"].cam()
    wall, theta = cam.walls[0], np.linspace(0.3, 1.9, 60)

    def worst(upright: bool) -> float:
        poses = []
        for step in (-STEP, 0.0, STEP):
            tilted = flank_poses(cam, wall, theta + step, THIN)
            roller = roller_poses(cam, wall, theta + step)
            offset = cam.contacts(wall, theta + step, np.array([cam.swept.roller.middle]))
            centre = (offset.point - THIN * offset.normal)[:, :, 0]
            poses.append(CutterPoses(tilted.theta, centre, roller.direction) if upright else tilted)
        return float(
            np.max(np.abs(envelope_error(cam, wall, (poses[0], poses[1], poses[2]), THIN)))
        )

    # its normals turn by β from the middle to the inner end: (Rr − Rc)(1 − cos β)
    slope = np.max(cam.place(wall.seat, theta).q1)
    beta = math.atan(slope / INNER) - math.atan(slope / (0.5 * (INNER + OUTER)))
    assert worst(upright=True) == pytest.approx((RADIUS - THIN) * (1.0 - math.cos(beta)), rel=0.02)
    assert 30.0 * worst(upright=False) < worst(upright=True)


def test_one_of_the_roller_s_form_goes_where_the_roller_goes(design: SpatialDesign) -> None:
    sample = SAMPLES[design.name]
    columns, reported = read(design, CutterOptions(frame="machine"))
    assert reported == 0.0
    assert set(columns["side"]) == {0.0}
    turns = design.cam.swept.hand
    assert columns["c_deg"] == pytest.approx(turns * columns["theta_deg"])
    ways = sample.ways(np.radians(columns["theta_deg"] - 1e-9))
    spread = [np.hypot(y - columns["y_mm"], z - columns["z_mm"]) for y, z in ways]
    assert np.min(spread, axis=0).max() < 1e-6
    assert columns["x_mm"] == pytest.approx(np.full(len(columns["x_mm"]), INNER))
    assert columns["i"] == pytest.approx(np.ones(len(columns["i"])))


def test_a_cutter_thicker_than_the_roller_is_refused(design: SpatialDesign) -> None:
    with pytest.raises(InputError, match=r"thinner than the roller, 17.4 mm"):
        CSV.make(design, CutterOptions(cutter_diameter_mm=17.5))
