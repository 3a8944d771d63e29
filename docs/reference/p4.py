"""Print the tables of p4.md: walls, what was measured, points of the flanks, the source's equation.

python docs/reference/p4.py
"""

import json
from math import atan, cos, degrees, sin
from pathlib import Path

import numpy as np

from docs.reference.tables import number, table
from synthesis import SpatialCamSpec, SpatialDesign, synthesise_spatial

EXAMPLE = Path(__file__).resolve().parents[2] / "openapi/examples/spatial-cams/p4.json"
C, RR, INNER, OUTER = 180.0, 30.0, 72.0, 102.0
UNITS = {"deg": "°", "1": ""}


def dimensions(p4: SpatialDesign) -> None:
    reported = (
        (name.removesuffix("_mm").replace("_", " "), v) for name, v in p4.dimensions.items()
    )
    table(("dimension", "mm"), *((name, number(value, 3)) for name, value in reported))


def walls(p4: SpatialDesign) -> None:
    rows = []
    for wall in p4.walls:
        (arc,) = wall.arcs
        rows.append((wall.name, number(arc.start_deg, 2), number(arc.end_deg, 2)))
    table(("flank", "from °", "to °"), *rows)


def extremes(p4: SpatialDesign) -> None:
    rows = []
    for each in p4.extremes:
        where = f"{each.roller}{each.side}" if each.side else ""
        value = number(each.value) + UNITS.get(each.unit, f" {each.unit}")
        rows.append((
            each.quantity.replace("_", " "), value, number(each.angle_deg, 2), where,
            number(each.rho_mm, 1),
        ))  # fmt: skip
    table(("quantity", "value", "at °", "flank", "ρ mm"), *rows)


def points(p4: SpatialDesign) -> None:
    """On the outer edge, every 30° of the index."""
    cam = p4.cam
    theta = np.radians([0.0, 30.0, 60.0, 90.0, 120.0])
    rows = []
    for wall in cam.walls:
        found, _ = cam.surface(wall, theta, np.array([OUTER]))
        for at, point in zip(theta, found[:, :, 0].T, strict=True):
            rows.append((wall.name, number(degrees(at), 0), *(number(x) for x in point)))
    table(("flank", "θ °", "x mm", "y mm", "z mm"), *rows)


def faulty() -> None:
    """The middle of the index, on the outer edge of 2R: ψ = 0 and ψ' = 2/3."""
    rows = []
    ratios = {"ω2/ω1": 2 / 3, "ω1/ω2, as printed": 3 / 2, "ω2/ω1 / 1800, as run": 1 / 2700}
    for name, ratio in ratios.items():
        eta, true = atan(OUTER * ratio / (C - OUTER)), atan(OUTER * 2.0 / 3.0 / (C - OUTER))
        slip = cos(eta) * OUTER * 2.0 / 3.0 - sin(eta) * (C - OUTER)  # n·v
        moved = 2.0 * RR * abs(sin(0.5 * (eta - true)))
        rows.append((name, number(degrees(eta), 3), number(slip, 3), number(moved, 3)))
    table(("ratio in tan η", "η °", "n·v mm/rad", "off by mm"), *rows)


def main() -> None:
    value = json.loads(EXAMPLE.read_text(encoding="utf-8"))["value"]
    p4 = synthesise_spatial(SpatialCamSpec.model_validate(value))
    assert abs(p4.speed_rpm * 6.0 * 4.5 - 360.0) < 1e-6
    dimensions(p4)
    walls(p4)
    extremes(p4)
    points(p4)
    faulty()


if __name__ == "__main__":
    main()
