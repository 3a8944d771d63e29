"""Globoidal cams of several threads, hands and dwells, run over by rollers for a whole turn."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.spec import SpatialCamSpec
from tests.machines.spatial.drums import cam_points
from tests.machines.spatial.test_cam import body, cam_of

Array = NDArray[np.float64]
DISTANCE, RADIUS, INNER, OUTER, WIDTH = 163.7, 14.9, 61.3, 82.9, 91.7
TURN = 213.0
TRIED = np.linspace(0.0, 2.0 * math.pi, 1440, endpoint=False)


def law(theta: Array) -> Array:
    """Cycloidal, of θ in one turn."""
    x = np.clip(np.degrees(theta) / TURN, 0.0, 1.0)
    return np.asarray(x - np.sin(2.0 * math.pi * x) / (2.0 * math.pi))


def indexer(rollers: int, steps: int, dwell_on: str, hand: str) -> SpatialCam:
    move: dict[str, Any] = {
        "kind": "rise" if steps > 0 else "return", "angle_deg": TURN,
        "lift_deg": abs(steps) * 360.0 / rollers, "law": {"kind": "cycloidal"},
    }  # fmt: skip
    question = body(
        rollers=rollers, dwell_on=dwell_on, hand=hand, centre_distance_mm=DISTANCE,
        roller_radius_mm=RADIUS, roller_inner_mm=INNER, roller_width_mm=OUTER - INNER,
        cam_width_mm=WIDTH, mesh_angle_deg=80.0,
    )  # fmt: skip
    program = [move, {"kind": "dwell", "angle_deg": 360.0 - TURN}]
    return cam_of(SpatialCamSpec(**question | {"program": program}))


def gaps(points: Array, places: Array, turns: int) -> Array:
    """Least distance of points (3, j) of the cam to any roller's skin, over a whole turn: (j,).

    Args:
        places: (rollers,) angles at which they start [rad], with how far each goes on last.
        turns: which way the cam turns about y.
    """
    *starts, gain = places
    least = np.full(points.shape[1], np.inf)
    for t in TRIED:
        x = DISTANCE + math.cos(t) * points[0] + turns * math.sin(t) * points[2]
        z = -turns * math.sin(t) * points[0] + math.cos(t) * points[2]
        psi = (np.array(starts) + gain * law(np.array(t)))[:, None]
        along = np.cos(psi) * x + np.sin(psi) * points[1]
        across = np.cos(psi) * points[1] - np.sin(psi) * x
        beside = (along > INNER - 1e-9) & (along < OUTER + 1e-9)
        away = np.where(beside, np.hypot(across, z) - RADIUS, np.inf)
        least = np.minimum(least, away.min(axis=0))
    return least


@pytest.mark.parametrize(
    ("rollers", "steps", "dwell_on", "hand"),
    [(6, 1, "groove", "right"), (8, 2, "rib", "left"), (7, -1, "rib", "right")],
)
def test_no_roller_cuts_a_wall_and_every_wall_is_touched(
    rollers: int, steps: int, dwell_on: str, hand: str
) -> None:
    cam = indexer(rollers, steps, dwell_on, hand)
    ahead = math.pi / rollers if dwell_on == "rib" else 0.0
    starts = ahead - 2.0 * math.pi / rollers * np.arange(rollers)
    places = np.append(starts, 2.0 * math.pi / rollers * steps)
    rho = np.array([INNER, 70.1, OUTER])
    for wall in cam.walls:
        for low, high in wall.spans:
            first, last = np.searchsorted(TRIED, (low, high))
            theta = TRIED[first + 1 : last : 37]
            inside = cam.between_faces(cam.contacts(wall, theta, rho).point)
            points = cam_points(cam, wall, theta, rho)[:, inside]
            found = gaps(points, places, 1 if hand == "left" else -1)
            assert found.min() > -1e-9, wall.name
            assert found.max() < 1e-9, wall.name
