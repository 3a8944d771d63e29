"""Analyses of given cams with an arm."""

from __future__ import annotations

from math import acos, degrees, pi, radians
from typing import Any

import numpy as np
import pytest

from synthesis import analyse
from synthesis.catalogue.profile import cam_profile
from synthesis.errors import InputError
from synthesis.studies.analyse import given_cam
from tests.catalogue.followers.samples import LIFTS, SAMPLES, spec

ARM, BASE = SAMPLES["oscillating_roller"][1]
PRIME = BASE + ARM["roller_radius_mm"]
ANGLE = degrees(
    acos(
        (ARM["arm_mm"] ** 2 + ARM["centre_distance_mm"] ** 2 - PRIME**2)
        / (2.0 * ARM["arm_mm"] * ARM["centre_distance_mm"])
    )
)


def arm(**changes: Any) -> dict[str, Any]:
    """The follower of the samples that lifts with the cam, changed."""
    return ARM | changes


def question(**changes: Any) -> Any:
    return spec("oscillating_roller", 1, **changes)


def test_the_angle_at_rest_says_the_same_as_the_base_radius() -> None:
    by_radius = analyse(question())
    for changes in (
        {"follower": arm(initial_angle_deg=ANGLE), "base_radius_mm": None},
        {"follower": arm(initial_angle_deg=ANGLE)},
        {"follower": arm(initial_angle_deg={"min": 20.0}), "base_radius_mm": BASE},
    ):
        found = analyse(question(**changes))
        for name, value in by_radius.dimensions.items():
            assert found.dimensions[name] == pytest.approx(value, rel=1e-12), name
        assert found.holds


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"base_radius_mm": None}, "/base_radius_mm"),
        ({"base_radius_mm": {"min": 60.0, "max": 70.0}}, "/base_radius_mm"),
        ({"follower": arm(centre_distance_mm=None)}, "/follower/centre_distance_mm"),
        (
            {"follower": arm(centre_distance_mm={"min": 90.0, "max": 95.0})},
            "/follower/centre_distance_mm",
        ),
    ],
)
def test_what_is_left_free_is_named(changes: dict[str, Any], field: str) -> None:
    with pytest.raises(InputError) as caught:
        analyse(question(**changes))
    assert caught.value.field == field


@pytest.mark.usefixtures("unmended")
def test_jumps_are_told_in_degrees() -> None:
    program = [segment.model_dump(exclude_none=True) for segment in question().program]
    program[0]["law"] = {"kind": "parabolic"}
    found = analyse(question(program=program, limits=[]))
    beta, omega = radians(97.3), question().machine().omega
    peak = 4.0 * LIFTS["oscillating_roller"] / beta**2 * omega**2
    jumps = [jump for jump in found.jumps if jump.curve == "acceleration"]
    assert [jump.unit for jump in jumps] == ["deg/s²"] * 3
    assert [jump.jump for jump in jumps] == pytest.approx([peak, -2.0 * peak, peak], rel=1e-9)
    bent = [jump for jump in found.jumps if jump.curve == "pitch_curvature"]
    assert [jump.angle_deg for jump in bent] == [jump.angle_deg for jump in jumps]
    (curve,) = (c for c in found.curves if c.curve == "velocity")
    assert curve.largest.value == pytest.approx(
        2.0 * LIFTS["oscillating_roller"] / beta * omega, rel=1e-9
    )


@pytest.mark.usefixtures("unmended")
def test_a_roller_that_is_too_large_undercuts_and_says_where() -> None:
    body = question(follower=arm(roller_radius_mm=60.0), base_radius_mm=PRIME - 60.0)
    found = analyse(body)
    cam = given_cam(body)
    theta = np.linspace(0.0, 2.0 * pi, 72_001)
    p = cam_profile(cam.motion, body.follower, cam.size, "ccw", theta)
    worst = int(np.argmax(p.curvature))
    assert p.radius[worst] < 0.0
    assert found.undercut is not None
    assert found.undercut.kind == "undercut"
    assert found.undercut.pitch_radius_mm == pytest.approx(1.0 / p.curvature[worst], rel=1e-6)
    assert found.undercut.angle_deg == pytest.approx(degrees(theta[worst]), abs=0.02)
    assert "profile_radius" in found.violated


def test_what_mends_it_names_the_arm_s_own_dimension() -> None:
    found = analyse(question(limits=[{"kind": "velocity", "max_deg_per_s": 100.0}]))
    assert found.violated == ["velocity"]
    (velocity,) = (r for r in found.remedy.relaxations if r.limit == "velocity")
    assert velocity.unit == "deg/s"
    needed = next(abs(e.value) for e in found.extremes if e.limit == "velocity")
    assert needed <= velocity.needed <= needed + 6e-4 * (needed - velocity.requested)
    assert {size.offset for size in found.remedy.sizes} == {"kept", "free"}
