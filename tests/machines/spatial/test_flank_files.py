"""Points of flanks, read back: where rollers touch, and the same in every file."""

from __future__ import annotations

import csv
import io
import json
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from synthesis.errors import InputError
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.flanks import CSV, FLANKS, JSON, patches
from synthesis.machines.spatial.pipeline import synthesise_spatial
from synthesis.machines.spatial.spec import SpatialCamSpec
from tests.machines.spatial.test_cam import body

Array = NDArray[np.float64]
SIZES = {"distance": 181.3, "radius": 29.1, "inner": 71.9, "outer": 102.4}
INDEX, SPACING = math.radians(120.0), math.radians(60.0)


@pytest.fixture(scope="module")
def design() -> SpatialDesign:
    return synthesise_spatial(SpatialCamSpec(**body(mesh_angle_deg=53.7)))


def read_ibl(text: str) -> list[list[Array]]:
    """Sections, their curves, and of each the points (n, 3)."""
    lines = text.splitlines()
    assert lines[0] == "Open Arclength"
    sections: list[list[list[list[float]]]] = []
    for line in lines[1:]:
        if line.startswith("begin section ! "):
            assert int(line.split()[-1]) == len(sections) + 1
            sections.append([])
        elif line.startswith("begin curve ! "):
            assert int(line.split()[-1]) == len(sections[-1]) + 1
            sections[-1].append([])
        else:
            number, *place = line.split()
            assert int(number) == len(sections[-1][-1]) + 1
            sections[-1][-1].append([float(value) for value in place])
    return [[np.array(curve) for curve in section] for section in sections]


def turret_angle(theta: Array, roller: int) -> Array:
    """Of a roller in the first turn, by the cycloidal law."""
    x = np.clip(theta / INDEX, 0.0, 1.0)
    moved = SPACING * (x - np.sin(2.0 * math.pi * x) / (2.0 * math.pi))
    return np.asarray(moved + 0.5 * SPACING - (roller - 1) * SPACING)


def seen_by_roller(points: Array, theta: Array, roller: int) -> tuple[Array, Array, Array]:
    """Distance from the roller's axis, place along it, and place across it in the turret's plane.

    The right-hand cam turns by −θ about z; the turret stands at x = 181.3 mm and turns about −y.
    """
    away = (points[:, 0] + 1j * points[:, 1]) * np.exp(-1j * theta)
    inward = SIZES["distance"] - away.real
    turned = (inward + 1j * points[:, 2]) * np.exp(-1j * turret_angle(theta, roller))
    return np.hypot(turned.imag, away.imag), turned.real, turned.imag


def test_every_point_lies_on_its_roller(design: SpatialDesign) -> None:
    made = FLANKS.content(design, FLANKS.options(points=41, depths=3))
    sections = read_ibl(made.data.decode("ascii"))
    names = made.metadata["Sections"].split()
    assert len(sections) == len(names) == len(set(names))
    spans = {wall.name: wall.arcs for wall in design.walls}
    for name, section in zip(names, sections, strict=True):
        flank, _, part = name.partition("-")
        arc = spans[flank][int(part or 1) - 1]
        theta = np.radians(np.linspace(arc.start_deg, arc.end_deg, 41))
        for curve, place in zip(section, np.linspace(71.9, 102.4, 3), strict=True):
            away, along, across = seen_by_roller(curve, theta, int(flank[:-1]))
            assert away == pytest.approx(SIZES["radius"], abs=1e-9)
            assert along == pytest.approx(place, abs=1e-9)
            assert np.all(across > 0.0) == (flank[-1] == "R")
    assert 0.0 < float(made.metadata["Spline-Error-Mm"]) < 0.1


def test_tables_tell_the_same(design: SpatialDesign) -> None:
    options: dict[str, Any] = {"points": 7, "depths": 4, "flank": "2L"}
    rows = list(csv.DictReader(io.StringIO(CSV.write(design, CSV.options(**options)).decode())))
    whole = json.loads(JSON.write(design, JSON.options(**options)))
    (flank,) = whole["flanks"]
    (section,) = read_ibl(FLANKS.write(design, FLANKS.options(**options)).decode())
    points = np.array(flank["points_mm"])
    assert points.shape == (7, 4, 3)
    assert np.stack(section, axis=1) == pytest.approx(points, abs=1e-9)
    table = np.array([[float(row[f"{axis}_mm"]) for axis in "xyz"] for row in rows])
    assert np.array_equal(table, points.reshape(-1, 3))
    assert {(row["roller"], row["side"]) for row in rows} == {("2", "-1")}
    assert [float(row["rho_mm"]) for row in rows[:4]] == flank["rho_mm"]
    # out of the cam is towards the roller's axis
    theta = np.radians(np.repeat(flank["theta_deg"], 4))
    off = (points + 0.7 * np.array(flank["normals"])).reshape(-1, 3)
    assert seen_by_roller(off, theta, 2)[0] == pytest.approx(SIZES["radius"] - 0.7, abs=1e-9)
    # a chord is square to the mean of the normals at its ends, but for its cube
    normals = np.array(flank["normals"])
    assert np.linalg.norm(normals, axis=-1) == pytest.approx(1.0, abs=1e-12)
    chord, both = np.diff(points, axis=1), normals[:, 1:] + normals[:, :-1]
    assert np.einsum("nmi,nmi->nm", chord, both) == pytest.approx(0.0, abs=1e-3)


def test_the_error_of_a_spline_falls_with_the_fourth_power(design: SpatialDesign) -> None:
    errors = [
        float(FLANKS.content(design, FLANKS.options(points=count)).metadata["Spline-Error-Mm"])
        for count in (61, 121)
    ]
    assert 8.0 < errors[0] / errors[1] < 40.0


@pytest.mark.parametrize(
    ("options", "reported"),
    [
        ({"flank": "9L"}, "The flanks of this cam are 1L, 1R"),
        ({"points": 30_000}, "a file has at most 200000"),
        ({"points_per_degree": 99.0, "depths": 150}, "Request at most"),
    ],
)
def test_what_cannot_be_had_is_told_with_what_can(
    design: SpatialDesign, options: dict[str, Any], reported: str
) -> None:
    with pytest.raises(InputError, match=reported) as refused:
        CSV.write(design, CSV.options(**options))
    if "points" in options:
        most = int(refused.value.remedy.split()[3].rstrip(","))
        assert patches(design, CSV.options(points=most))
        with pytest.raises(InputError, match=reported):
            patches(design, CSV.options(points=most + 1))
