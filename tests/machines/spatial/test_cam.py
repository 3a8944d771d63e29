"""Which rollers meet a spatial cam when, and what a program must do for its machine."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pydantic import ValidationError

from synthesis.catalogue.motion import Motion
from synthesis.machines.spatial.cam import SpatialCam, build_cam
from synthesis.machines.spatial.spec import SpatialCamSpec
from tests.machines.spatial.drums import cam_points

Array = NDArray[np.float64]


def body(**changes: Any) -> dict[str, Any]:
    """Six rollers, an index of 60° in 120° of the cam."""
    machine = {
        "kind": "globoidal_indexer", "rollers": 6, "centre_distance_mm": 181.3,
        "roller_radius_mm": 29.1, "roller_inner_mm": 71.9, "roller_width_mm": 30.5,
    }  # fmt: skip
    rise = {"kind": "rise", "angle_deg": 120, "lift_deg": 60, "law": {"kind": "cycloidal"}}
    return {"program": [rise, {"kind": "dwell", "angle_deg": 240}], "machine": machine | changes}


def cam_of(spec: SpatialCamSpec) -> SpatialCam:
    sizes = spec.given_sizes()
    assert sizes is not None
    return build_cam(spec, sizes, Motion.of(spec.placed_segments()))


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


def names(**changes: Any) -> set[str]:
    """Rollers that meet the cam in a turn."""
    return {wall.name[:-1] for wall in cam_of(SpatialCamSpec(**changes)).walls}


def test_a_turret_that_goes_back_meets_the_rollers_on_the_other_side() -> None:
    question = body(mesh_angle_deg=85.0)
    assert names(**question) == {"1", "2", "3"}
    back = question["program"][0] | {"kind": "return"}
    assert names(**question | {"program": [back, question["program"][1]]}) == {"6", "1", "2"}


def test_a_turret_of_three_meets_each_roller_though_it_goes_on_by_a_whole_turn() -> None:
    rise = {"kind": "rise", "angle_deg": 120, "lift_deg": 120, "law": {"kind": "modified_sine"}}
    rises = [rise] * 3
    cam = cam_of(SpatialCamSpec(program=rises, machine=body(rollers=3)["machine"]))
    spans = {wall.name: wall.spans for wall in cam.walls}
    assert {name[0] for name in spans} == {"1", "2", "3"}
    total = sum(end - start for arcs in spans.values() for start, end in arcs) / 2.0
    at = np.linspace(0.0, 2.0 * math.pi, 2001)[:-1] + 1e-4
    q = cam.motion.derivatives(at, 0)[0]
    there = [np.cos(wall.seat.start + q) > 0.0 for wall in cam.walls[::2]]
    assert total / (2.0 * math.pi) == pytest.approx(np.sum(there) / len(at), abs=2e-3)


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("hand", ["left", "right"])
@pytest.mark.parametrize("kind", ["globoidal_indexer", "cylindrical_indexer"])
def test_a_right_hand_thread_is_a_right_hand_screw(kind: str, hand: str, rotation: str) -> None:
    """Along a groove, away from the eye, the thread turns clockwise: a right-hand helix."""
    sizes = {"globoidal_indexer": {}, "cylindrical_indexer": {
        "turret_radius_mm": 87.1, "centre_distance_mm": 83.9,
        "cylinder_radius_mm": 101.3}}[kind]  # fmt: skip
    machine = body(kind=kind, hand=hand)["machine"] | sizes
    if kind == "cylindrical_indexer":
        machine = {k: v for k, v in machine.items() if k not in ("roller_inner_mm",)}
    cam = cam_of(SpatialCamSpec(**body() | {"machine": machine, "rotation": rotation}))
    e = cam.swept.axis
    wall = next(wall for wall in cam.walls if wall.name == "2L")
    theta = np.linspace(0.6, 1.4, 9)
    points = cam_points(cam, wall, theta, np.array([cam.swept.roller.middle]))
    along = e @ points[:, :, 0]
    across = points[:, :, 0] - np.outer(e, along)
    turn = np.cross(across[:, :-1], across[:, 1:], axis=0)
    helix = np.sign((e @ turn) * np.diff(along))
    assert np.all(helix == (1.0 if hand == "right" else -1.0))


@pytest.mark.parametrize(("rollers", "steps"), [(4, 1), (5, -2), (6, 2), (8, 3), (7, -1)])
@pytest.mark.parametrize("dwell_on", ["rib", "groove"])
def test_walls_are_met_when_rollers_are_there(rollers: int, steps: int, dwell_on: str) -> None:
    """Threads and senses of all kinds: by counting rollers in the mesh, whatever their numbers."""
    lift = abs(steps) * 360.0 / rollers
    kind = "rise" if steps > 0 else "return"
    move = {"kind": kind, "angle_deg": 217.0, "lift_deg": lift, "law": {"kind": "cycloidal"}}
    machine = body(rollers=rollers, roller_radius_mm=11.3, dwell_on=dwell_on, mesh_angle_deg=71.0)
    question = machine | {"program": [move, {"kind": "dwell", "angle_deg": 143.0}]}
    cam = cam_of(SpatialCamSpec(**question))
    theta = np.linspace(0.0, 2.0 * math.pi, 811)[1:-1]
    reported = sum(
        ((theta > a) & (theta < b)).astype(int)
        for wall in cam.walls if wall.letter == "L" for a, b in wall.spans
    )  # fmt: skip
    first = 0.5 if dwell_on == "rib" else 0.0
    q = lift * np.sign(steps) * np.interp(theta, *law_of(217.0))
    places = q[:, None] + 360.0 / rollers * (first - np.arange(rollers))
    near = np.abs((places + 180.0) % 360.0 - 180.0) < 71.0
    assert (
        np.mean(reported != near.sum(axis=1)) < 0.01
    )  # within a sample of where one comes or goes


def law_of(angle: float) -> tuple[Array, Array]:
    """The cycloidal law as many points."""
    x = np.linspace(0.0, 1.0, 4001)
    return np.radians(angle) * x, x - np.sin(2.0 * math.pi * x) / (2.0 * math.pi)


def test_seen_from_the_other_end_the_cam_is_the_same() -> None:
    points = []
    for rotation in ("ccw", "cw"):
        cam = cam_of(SpatialCamSpec(**body(), rotation=rotation))
        points.append(cam_points(cam, cam.walls[3], np.array([0.7]), np.array([80.0])))
    assert np.array_equal(*points)


def test_a_gain_that_is_no_whole_number_of_rollers_is_refused() -> None:
    with pytest.raises(ValidationError, match=r"0.833333333 times the 72.0° between two of 5"):
        SpatialCamSpec(**body(rollers=5))


def test_rollers_go_on_from_turn_to_turn() -> None:
    cam = cam_of(SpatialCamSpec(**body()))
    theta, seat = np.array([0.3, 2.0 * math.pi]), cam.walls[0].seat
    here, later = cam.place(seat, theta), cam.place(seat, theta + 2.0 * math.pi)
    assert later.q == pytest.approx(here.q + math.radians(60.0), abs=1e-13)
    assert here.q[1] == pytest.approx(math.radians(90.0), abs=1e-13)
