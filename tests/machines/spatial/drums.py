"""Cylindrical cams at unspecial sizes, and what their rollers do, written down by itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.motion import Motion
from synthesis.machines.spatial.cam import SpatialCam, Wall, build_cam
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.pipeline import synthesise_spatial
from synthesis.machines.spatial.spec import SpatialCamSpec

Array = NDArray[np.float64]
Ways = Callable[[Array], list[tuple[Array, Array]]]
SIZES = {"cylinder_radius_mm": 61.3, "roller_radius_mm": 8.7, "roller_width_mm": 13.9}
INNER, OUTER = SIZES["cylinder_radius_mm"] - SIZES["roller_width_mm"], SIZES["cylinder_radius_mm"]
RADIUS = SIZES["roller_radius_mm"]
RISE, REST, BACK = 118.0, 31.0, 143.0
LIFT, SWING, ARM, PIVOT, START = 33.7, 21.3, 96.1, 94.7, -8.9
INDEX, STATIONS, TURRET, CENTRE = 150.0, 8, 103.7, 99.1


def cycloid(x: Array) -> Array:
    return np.asarray(x - np.sin(2.0 * math.pi * x) / (2.0 * math.pi))


def there_and_back(lift: float) -> Callable[[Array], Array]:
    """Displacement at cam angles [rad] of one turn."""

    def of(theta: Array) -> Array:
        deg = np.degrees(theta) % 360.0
        up = cycloid(np.clip(deg / RISE, 0.0, 1.0))
        down = cycloid(np.clip((deg - RISE - REST) / BACK, 0.0, 1.0))
        return np.asarray(lift * (up - down))

    return of


def program(unit: str, lift: float) -> list[dict[str, Any]]:
    law = {"law": {"kind": "cycloidal"}, f"lift_{unit}": lift}
    return [
        {"kind": "rise", "angle_deg": RISE, **law},
        {"kind": "dwell", "angle_deg": REST},
        {"kind": "return", "angle_deg": BACK, **law},
        {"kind": "dwell", "angle_deg": 360.0 - RISE - REST - BACK},
    ]


def index() -> list[dict[str, Any]]:
    rise = {"kind": "rise", "angle_deg": INDEX, "lift_deg": 45.0, "law": {"kind": "cycloidal"}}
    return [rise, {"kind": "dwell", "angle_deg": 360.0 - INDEX}]


def slide(apart: float = 0.0) -> Ways:
    """y and z of the axes of all rollers at cam angles."""
    s = there_and_back(LIFT)
    return lambda t: [(0.0 * t, s(t) + off) for off in sorted({apart / 2, -apart / 2})]


def swinging(apart: float = 0.0) -> Ways:
    """The same on an arm, by complex numbers: the arm lies along −y where it is square."""
    s = there_and_back(math.radians(SWING))

    def of(t: Array) -> list[tuple[Array, Array]]:
        turn = np.exp(-1j * (math.radians(START) + s(t)))
        ends = [1j * 0.0 - ARM + 1j * off for off in sorted({apart / 2, -apart / 2})]
        found = [PIVOT + turn * end for end in ends]
        return [(each.real, each.imag) for each in found]

    return of


def turning(t: Array) -> list[tuple[Array, Array]]:
    """The same on a turret, whose first roller is half a spacing ahead, turn by turn."""
    deg = np.degrees(t) % 360.0
    q = np.radians(45.0) * cycloid(np.clip(deg / INDEX, 0.0, 1.0))
    found = []
    for i in range(STATIONS):
        at = q + math.pi / STATIONS - 2.0 * math.pi * i / STATIONS
        found.append((CENTRE - TURRET * np.cos(at), TURRET * np.sin(at)))
    return found


@dataclass(frozen=True)
class Sample:
    """A cam's body, and where its rollers' axes are."""

    body: dict[str, Any]
    ways: Ways
    near: float = math.inf  # |z| within which a roller meets the cam

    def turning(self, rotation: str, **machine: Any) -> dict[str, Any]:
        """Changes that make the cam turn about z, ccw or cw: of a turret its thread decides."""
        thread = {"hand": "left" if rotation == "ccw" else "right"}
        given = self.body["machine"] | (thread if "hand" in self.body["machine"] else {})
        return {"rotation": rotation, "machine": given | machine}

    def spec(self, **changes: Any) -> SpatialCamSpec:
        return SpatialCamSpec(**(self.body | changes))

    def cam(self, **changes: Any) -> SpatialCam:
        spec = self.spec(**changes)
        sizes = spec.given_sizes()
        assert sizes is not None
        return build_cam(spec, sizes, Motion.of(spec.placed_segments()))


def of(kind: str, steps: list[dict[str, Any]], ways: Ways, **machine: Any) -> Sample:
    return Sample({"program": steps, "machine": {"kind": kind, **SIZES, **machine}}, ways)


ARM_SIZES = {"arm_mm": ARM, "pivot_distance_mm": PIVOT, "initial_angle_deg": START}
SLIDE, SWING_ARM = "cylindrical_translating", "cylindrical_oscillating"
APART = 29.3
SAMPLES = {
    "slide in a groove": of(SLIDE, program("mm", LIFT), slide()),
    "slide astride a rib": of(
        SLIDE, program("mm", LIFT), slide(APART), roller_distance_mm=APART
    ),
    "arm in a groove": of(SWING_ARM, program("deg", SWING), swinging(), **ARM_SIZES),
    "arm astride a rib": of(
        SWING_ARM, program("deg", SWING), swinging(APART), **ARM_SIZES, roller_distance_mm=APART
    ),
    "turret": of(
        "cylindrical_indexer", index(), turning, rollers=STATIONS, hand="left",
        turret_radius_mm=TURRET, centre_distance_mm=CENTRE,
    ),
}  # fmt: skip


def sag(x: Array, crown: float) -> Array:
    """By how much a crowned roller is thinner than in its middle."""
    off = x - 0.5 * (INNER + OUTER)
    return np.asarray(crown - np.sqrt(crown**2 - off**2)) if crown else 0.0 * x


def least_gap(sample: Sample, points: Array, turns: int, crown: float) -> Array:
    """Of points (3, n) of the cam, to all rollers in one turn: (n,)."""
    least = np.full(points.shape[1], np.inf)
    for t in np.array_split(np.linspace(0.0, 2.0 * math.pi, 2161), 8):
        turn = np.exp(1j * turns * t)[:, None]
        there = turn * (points[0] + 1j * points[1])
        x, y, z = there.real, there.imag, points[2]
        within = (x > INNER) & (x < OUTER)
        for at_y, at_z in sample.ways(t):
            away = np.hypot(y - at_y[:, None], z - at_z[:, None]) - RADIUS
            away += sag(np.where(within, x, 0.5 * (INNER + OUTER)), crown)
            least = np.minimum(least, np.where(within, away, np.inf).min(axis=0))
    return least


def cam_points(cam: SpatialCam, wall: Wall, theta: Array, rho: Array) -> Array:
    """Contacts of a wall at cam angles and places, as the cam has them: (3, n, m)."""
    return cam.swept.on_cam(theta, cam.contacts(wall, theta, rho).point)


@cache
def designed(name: str) -> SpatialDesign:
    """The answer to a sample, once for all tests."""
    return synthesise_spatial(SAMPLES[name].spec(name=name, speed_rpm=83.0))
