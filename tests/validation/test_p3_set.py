"""Reference problem P3's set: two oscillating roller cams, the second rotated by 60°.

The points of the files are turned as a rigid body, and the roller is held on its arm where the
source's laws, written out here, put it: it must touch the cam and never enter it.
"""

from __future__ import annotations

import io
import math
import zipfile
from copy import deepcopy

import numpy as np
import pytest

from service.contract.examples import examples
from synthesis import CamSet, CamSetSpec, synthesise_set
from synthesis.exporters.bundle import BundleOptions, bundle
from synthesis.exporters.options import ProfileOptions
from tests.numerics.geometry import touch

ARM, DISTANCE, ROLLER, BASE, PIVOT, SWING = 85.0, 100.0, 30.0, 80.0, 30.0, 45.0
RISE, DWELL, RETURN = 80.0, 40.0, 150.0
SHAFT_DEG = 360.0 * (np.arange(90) + 0.381966) / 90


def swung(cam_deg: float) -> float:
    """Angle that the follower has swung, by the laws as printed (with 180 for 13080) [deg]."""
    at = cam_deg % 360.0
    if at < RISE:
        x = at / RISE
        return SWING * (10.0 * x**3 - 15.0 * x**4 + 6.0 * x**5)
    if at < RISE + DWELL:
        return SWING
    x = min((at - RISE - DWELL) / RETURN, 1.0)
    return SWING * (1.0 - x + math.sin(2.0 * math.pi * x) / (2.0 * math.pi))


def solved(rotation: str, sense: str) -> CamSet:
    value = deepcopy(examples("cam-sets")["p3-set"]["value"]) | {"rotation": rotation}
    for cam in value["cams"]:
        follower = cam["spec"]["follower"] | {"sense": sense}
        cam["spec"] = cam["spec"] | {"follower": follower}
    return synthesise_set(CamSetSpec.model_validate(value))


@pytest.fixture(scope="module", params=["ccw opposite", "ccw same", "cw opposite", "cw same"])
def found(request: pytest.FixtureRequest) -> CamSet:
    return solved(*request.param.split())


def shaft_points(found: CamSet) -> list[np.ndarray]:
    """Points x y z of both cams from the archive."""
    packed = bundle(found, BundleOptions(("txt",), (), ProfileOptions(10.0)))
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        names = ("01-first/shaft-profile.txt", "02-second/shaft-profile.txt")
        return [np.loadtxt(io.BytesIO(archive.read(name))) for name in names]


def gaps(found: CamSet, points: np.ndarray, phase: float) -> np.ndarray:
    """Distance of the roller from the cam at each shaft angle [mm]."""
    turns = 1.0 if found.rotation == "ccw" else -1.0
    opposite = found.spec.cams[0].spec.follower.model_dump()["sense"] == "opposite"
    direction = math.radians(PIVOT)
    pivot = (turns * DISTANCE * math.cos(direction), DISTANCE * math.sin(direction))
    swing = touch.Swing(pivot, ARM, ROLLER, turns * (1.0 if opposite else -1.0))
    prime = BASE + ROLLER
    lowest = math.acos((ARM**2 + DISTANCE**2 - prime**2) / (2.0 * ARM * DISTANCE))
    return np.array([
        touch.clearance(
            touch.turned(points, turns * math.radians(at)),
            swing.centre(lowest + math.radians(swung(at - phase))),
        ) - ROLLER
        for at in SHAFT_DEG
    ])  # fmt: skip


def test_both_rollers_touch_at_every_shaft_angle(found: CamSet) -> None:
    for points, phase in zip(shaft_points(found), (0.0, 60.0), strict=True):
        coarse = touch.coarseness(points[:, :2])
        assert coarse < 5e-3
        assert np.max(np.abs(gaps(found, points[:, :2], phase))) <= coarse


def test_a_phase_off_by_half_a_degree_would_show(found: CamSet) -> None:
    points = shaft_points(found)[1][:, :2]
    assert np.max(np.abs(gaps(found, points, 59.5))) > 0.1


def test_three_columns(found: CamSet) -> None:
    first, second = shaft_points(found)
    assert np.all(first[:, 2] == 0.0)
    assert np.all(second[:, 2] == 40.0)
    assert first.shape == second.shape


def test_the_second_cam_is_the_first_rotated_by_60_degrees(found: CamSet) -> None:
    """Against the rotation: clockwise on a shaft that turns counter-clockwise."""
    first, second = (points[:, :2] @ [1.0, 1.0j] for points in shaft_points(found))
    turns = 1.0 if found.rotation == "ccw" else -1.0
    np.testing.assert_allclose(second, first * np.exp(-1j * turns * math.pi / 3.0), atol=2e-9)
    assert [cam.turn_deg for cam in found.cams] == [0.0, -60.0 * turns]
    assert found.cams[0].design.motion == found.cams[1].design.motion
