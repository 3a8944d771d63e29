"""Cams on their shaft, run by touch: at shaft angle Θ every follower stands at s(Θ − phase)."""

from __future__ import annotations

import io
import math

import numpy as np
import pytest

from synthesis import CamSet, synthesise_set
from synthesis.design.cam_set import MountedCam
from synthesis.exporters import PROFILE_FORMATS, PointOptions
from tests.numerics.geometry import touch
from tests.studies.cam_sets import question

SHAFT_DEG = 360.0 * (np.arange(19) + 0.414213562) / 19


@pytest.fixture(scope="module", params=["ccw", "cw"])
def found(request: pytest.FixtureRequest) -> CamSet:
    return synthesise_set(question(rotation=request.param))


def on_the_shaft(cam: MountedCam) -> np.ndarray:
    """Points (n, 2) as the file for the shaft's frame has them."""
    options = PointOptions(8.0, turn_deg=cam.turn_deg, z_mm=cam.axial_mm)
    points = np.loadtxt(io.BytesIO(PROFILE_FORMATS["txt"].write(cam.design, options)))
    assert np.all(points[:, 2] == cam.axial_mm)
    return points[:, :2]


def lifts(found: CamSet, cam: MountedCam, points: np.ndarray) -> np.ndarray:
    """Measured displacement of the follower over SHAFT_DEG.

    The shaft turns as a rigid body with all that sits on it; then the machine is looked at with
    the follower upwards. Its offset lies to the right on a ccw shaft, to the left on a cw one.
    """
    sense = 1.0 if found.rotation == "ccw" else -1.0
    upright = math.radians(90.0 - cam.follower_direction_deg)
    size = cam.design.dimensions
    roller = touch.Roller(sense * size["offset_mm"], size["roller_radius_mm"])
    angles = [sense * math.radians(degrees) + upright for degrees in SHAFT_DEG]
    return touch.lifts(points, np.array(angles), roller) - size["s0_mm"]


def law(cam: MountedCam) -> np.ndarray:
    return cam.design.curve.derivatives(np.radians(SHAFT_DEG - cam.phase_deg))[0]


@pytest.mark.parametrize("position", [0, 1])
def test_every_follower_moves_at_its_phase(found: CamSet, position: int) -> None:
    cam = found.cams[position]
    points = on_the_shaft(cam)
    allowed = 3.0 * touch.coarseness(points)
    assert allowed < 1e-2
    np.testing.assert_allclose(lifts(found, cam, points), law(cam), rtol=0.0, atol=allowed)


def test_the_measurement_would_notice_one_degree(found: CamSet) -> None:
    cam = found.cams[1]
    options = PointOptions(8.0, turn_deg=cam.turn_deg + 1.0)
    points = np.loadtxt(io.BytesIO(PROFILE_FORMATS["txt"].write(cam.design, options)))[:, :2]
    assert np.max(np.abs(lifts(found, cam, points) - law(cam))) > 0.05


def test_the_mark_lies_along_the_follower_when_the_program_starts(found: CamSet) -> None:
    sense = 1.0 if found.rotation == "ccw" else -1.0
    for cam in found.cams:
        in_the_machine = cam.mark_deg + sense * cam.phase_deg
        assert (in_the_machine - cam.follower_direction_deg) % 360.0 == pytest.approx(0.0, abs=1e-9)


def test_the_keyway_of_every_cam_meets_the_same_key(found: CamSet) -> None:
    """Cut at keyway_deg in its own frame and turned on the shaft, it points along the shaft's y."""
    for cam in found.cams:
        assert (cam.keyway_deg + cam.turn_deg) % 360.0 == pytest.approx(90.0, abs=1e-9)
        assert 0.0 <= cam.keyway_deg < 360.0
        assert -180.0 < cam.turn_deg <= 180.0


def test_a_phase_turns_against_the_rotation() -> None:
    """By hand: cam angle 0 has to wait for 60° of a ccw turn, so the cam lies 60° clockwise."""
    cams = [{**question().cams[0].model_dump(mode="json", exclude={"spec"}), "phase_deg": 60.0}]
    for rotation, turn in (("ccw", -60.0), ("cw", 60.0)):
        spec = question().cams[0].spec.model_dump(mode="json") | {"rotation": rotation}
        spec["speed_rpm"] = 143.7
        (cam,) = synthesise_set(question(rotation=rotation, cams=[cams[0] | {"spec": spec}])).cams
        assert (cam.turn_deg, cam.mark_deg) == (turn, 90.0 + turn)
        assert cam.keyway_deg == 90.0 - turn


def test_mirrored_shafts_mirror_their_cams() -> None:
    """Sense, direction and offset mirrored; offsets are defined to mirror with the sense."""
    one, other = synthesise_set(question()), question(rotation="cw")
    direction = {"follower_direction_deg": 180.0 - 208.6}
    mirrored = other.model_copy(
        update={"cams": [other.cams[0], other.cams[1].model_copy(update=direction)]}
    )
    for cam, image in zip(one.cams, synthesise_set(mirrored).cams, strict=True):
        there, here = on_the_shaft(image), on_the_shaft(cam)
        np.testing.assert_allclose(there * [-1.0, 1.0], here, rtol=0.0, atol=1e-9)
