"""What the picture is drawn from: the grid is the body, and rollers are where they belong."""

from __future__ import annotations

import base64
import json
import math

import numpy as np
import pytest

from synthesis.machines.spatial.files.body_mesh import SURFACES, SurfaceOptions
from synthesis.machines.spatial.pipeline import synthesise_spatial
from synthesis.machines.spatial.spec import SpatialCamSpec
from tests.machines.spatial.test_cam import body
from tests.machines.spatial.test_flank_files import SIZES, turret_angle

WHOLE = 300_000  # bytes that a page may be sent


def test_the_grid_is_the_body_and_rollers_stand_in_their_grooves() -> None:
    design = synthesise_spatial(SpatialCamSpec(**body()))
    data = SURFACES.write(design, SurfaceOptions())
    assert len(data) < WHOLE
    found = json.loads(data)
    grid, follower = found["body"], found["follower"]
    shape = grid["rows"], grid["columns"], 3
    points = grid["unit_mm"] * np.frombuffer(base64.b64decode(grid["points"]), "<i2").reshape(shape)
    outline = points[17]
    radius = np.hypot(outline[:, 0], outline[:, 1])
    depth = np.hypot(SIZES["distance"] - radius, outline[:, 2])
    tops = [strip for strip in grid["strips"] if strip["kind"] == "top"]
    for strip in tops:
        inside = slice(strip["first"], strip["last"] + 1)
        assert depth[inside] == pytest.approx(SIZES["inner"], abs=0.01)
    # the last row is the first, but for which column a rib's points stand in
    ends = [{tuple(point) for point in points[row].round(2)} for row in (0, -1)]
    assert ends[0] == ends[1]

    a, b, c, d = np.array(follower["along"])
    theta = np.radians(follower["theta_deg"])
    for seat in follower["seats"][:3]:
        q = (np.array(follower["q"]) + seat["start"])[:, None]
        along = a + b * np.cos(q) + c * np.sin(q) + d * q
        turned = turret_angle(theta, seat["number"])
        expected = np.column_stack([-np.cos(turned), 0.0 * turned, np.sin(turned)])
        assert along == pytest.approx(expected, abs=2e-6)
    assert np.array(follower["origin_mm"])[0] == pytest.approx([SIZES["distance"], 0.0, 0.0])
    assert follower["q"][-1] - follower["q"][0] == pytest.approx(math.radians(60.0), abs=1e-5)
