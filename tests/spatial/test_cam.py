"""Which rollers meet a spatial cam when, and what a program must do for its machine."""

from __future__ import annotations

import math
from typing import Any

import pytest
from pydantic import ValidationError

from synthesis.motion import Motion
from synthesis.spatial.cam import SpatialCam, settled
from synthesis.spatial.spec import SpatialCamSpec


def body(**changes: Any) -> dict[str, Any]:
    """Six rollers, an index of 60° in 120° of the cam."""
    machine = {
        "kind": "globoidal_indexer", "rollers": 6, "centre_distance_mm": 181.3,
        "roller_radius_mm": 29.1, "roller_inner_mm": 71.9, "roller_width_mm": 30.5,
    }  # fmt: skip
    rise = {"kind": "rise", "angle_deg": 120, "lift_deg": 60, "law": {"kind": "cycloidal"}}
    return {
        "program": [rise, {"kind": "dwell", "angle_deg": 240}],
        "machine": machine | changes,
    }


def cam_of(spec: SpatialCamSpec) -> SpatialCam:
    sizes = spec.given_sizes()
    assert sizes is not None
    return settled(spec, sizes, Motion.of(spec.stretches()))


def test_three_rollers_meet_a_cam_with_a_rib_in_the_dwell() -> None:
    spans = {wall.name: wall.spans for wall in cam_of(SpatialCamSpec(**body())).walls}
    index, turn = 2.0 * math.pi / 3.0, 2.0 * math.pi
    assert {name[0] for name in spans} == {"1", "2", "3"}
    assert spans["1L"] == spans["1R"] == ((0.0, pytest.approx(index)),)
    assert spans["2L"] == ((0.0, pytest.approx(turn)),)


def test_a_narrower_blank_lets_rollers_enter_and_leave_on_the_way() -> None:
    cam = cam_of(SpatialCamSpec(**body(mesh_angle_deg=50.0)))
    (span,) = next(wall.spans for wall in cam.walls if wall.name == "1L")
    assert cam.motion.curve(span[1]) == pytest.approx(math.radians(20.0), abs=1e-12)


def test_a_gain_that_is_no_whole_number_of_rollers_is_refused() -> None:
    with pytest.raises(ValidationError, match=r"0.833333333 times the 72.0° between two of 5"):
        SpatialCamSpec(**body(rollers=5))
