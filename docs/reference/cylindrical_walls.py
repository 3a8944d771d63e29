"""Print the tables of cylindrical-walls.md: offsets drawn flat, undercut, thinner cutters.

python docs/reference/cylindrical_walls.py
"""

import json
from math import atan, cos, pi
from pathlib import Path

import numpy as np

from docs.reference.tables import table
from synthesis import SpatialCamSpec, synthesise_spatial
from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.cutter_path import CSV, CutterOptions
from synthesis.machines.spatial.files.developed import offset_errors, wall_curve

EXAMPLE = Path(__file__).resolve().parents[2] / (
    "openapi/examples/spatial-cams/cylindrical-groove.json"
)
BODY = json.loads(EXAMPLE.read_text(encoding="utf-8"))["value"]
RADII = (70.0, 66.0, 62.0, 58.0, 54.0)
CUTTERS = (20.0, 16.0, 12.0)
THETA = np.linspace(0.0, 2.0 * pi, 2401)


def design(**machine: float) -> SpatialDesign:
    question = BODY | {"machine": BODY["machine"] | machine}
    return synthesise_spatial(SpatialCamSpec.model_validate(question))


def max_speed(found: SpatialDesign) -> float:
    """Largest s' [mm/rad]."""
    return float(np.max(np.abs(found.curve.derivatives(THETA, 1)[1])))


def flat(found: SpatialDesign) -> None:
    """The offset drawn on a cylinder, and that of the outer one wrapped to it."""
    cam, outer, speed = found.cam, RADII[0], max_speed(found)
    roller = cam.swept.roller.radius
    rows = [("radius mm", "pressure angle °", "drawn there mm", "wrapped mm", "closed form mm")]
    for radius in RADII:
        own, wrapped = (
            max(float(np.max(offset_errors(
                cam, wall_curve(cam, each.seat, each.side, THETA, radius), drawn, radius)))
                for each in cam.walls)
            for drawn in (radius, outer)
        )  # fmt: skip
        alpha, drawn = atan(speed / radius), atan(speed / outer)
        closed = roller * (1.0 - cos(alpha) / cos(drawn))
        rows.append((f"{radius:.0f}", f"{alpha * 180.0 / pi:.2f}", f"{own:.4f}", f"{wrapped:.3f}",
                     f"{closed:.3f}"))  # fmt: skip
    table(*rows, first="--:")


def undercut(found: SpatialDesign) -> None:
    """Radius of the roller at which a wall begins to vanish, and that of the development."""
    _, s1, s2, _ = found.curve.derivatives(THETA, 3)
    rows = [("inner end mm", "roller mm", "unrolled there mm")]
    for width in (16.0, 26.0, 36.0):
        inner = 70.0 - width
        flat_radius = float(
            np.min((inner**2 + s1**2) ** 1.5 / np.maximum(inner * np.abs(s2), 1e-9))
        )
        low, high = 1.0, 200.0
        while high - low > 1e-4:
            radius = 0.5 * (low + high)
            low, high = (radius, high) if stands(found, radius, inner) else (low, radius)
        rows.append((f"{inner:.0f}", f"{low:.2f}", f"{flat_radius:.2f}"))
    table(*rows, first="--:")


def stands(found: SpatialDesign, radius: float, inner: float) -> bool:
    """Whether rollers of this radius leave all of both walls."""
    spec, motion = found.spec, found.curve
    swept = spec.machine.swept_roller({"cylinder_radius_mm": 70.0, "roller_radius_mm": radius}, 1)
    cam = SpatialCam(swept, motion, found.cam.walls, found.cam.sizes)
    rho = np.array([inner])
    return all(float(cam.contacts(each, THETA, rho).regular.min()) > 0.0 for each in cam.walls)


def cutters(found: SpatialDesign) -> None:
    """What cutters thinner than the roller leave on the wall."""
    speed, roller = max_speed(found), found.cam.swept.roller
    inner, middle, outer = (atan(speed / r) for r in (roller.inner, roller.middle, roller.outer))
    rows = [("cutter mm", "tilted µm", "upright µm", "led along the wrapped offset µm")]
    for diameter in CUTTERS:
        made = CSV.make(found, CutterOptions(cutter_diameter_mm=diameter))
        less = roller.radius - 0.5 * diameter
        upright, wrapped = 1.0 - cos(inner - middle), 1.0 - cos(inner) / cos(outer)
        rows.append((f"{diameter:.0f}", f"{1e3 * float(made.metadata['Wall-Error-Mm']):.2f}",
                     f"{1e3 * less * upright:.1f}", f"{1e3 * less * wrapped:.0f}"))  # fmt: skip
    table(*rows, first="--:")


if __name__ == "__main__":
    example = design()
    flat(example)
    undercut(example)
    cutters(example)
