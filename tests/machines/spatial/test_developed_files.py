"""Unrolled walls as files, read back by other readers."""

from __future__ import annotations

import csv
import io
import json
import math
from xml.etree import ElementTree

import numpy as np
import pytest

from synthesis.errors import InputError
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.developed import CSV, JSON, DevelopedOptions
from synthesis.machines.spatial.files.developed_svg import SVG, DrawnOptions
from synthesis.machines.spatial.pipeline import synthesise_spatial
from tests.machines.spatial.drums import INNER, OUTER, RADIUS, SAMPLES, TURRET, designed

SPACE = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module", params=["slide in a groove", "arm astride a rib", "turret"])
def design(request: pytest.FixtureRequest) -> SpatialDesign:
    return designed(request.param)


def test_the_table_holds_every_wall_and_its_roller_s_path(design: SpatialDesign) -> None:
    made = CSV.make(design, DevelopedOptions())
    rows = list(csv.DictReader(io.StringIO(made.data.decode())))
    found = {(int(row["roller"]), int(row["side"])) for row in rows}
    walls = {(wall.roller, {"L": -1, "R": 1}[wall.side]) for wall in design.walls}
    assert found == walls | {(roller, 0) for roller, _ in walls}
    worst = max(abs(float(row["departure_mm"])) for row in rows)
    assert made.metadata["Flat-Offset-Error-Mm"] == f"{worst:.3g}"
    for row in rows[::17]:
        arc = math.radians(float(row["angle_deg"])) * OUTER
        assert float(row["arc_mm"]) == pytest.approx(arc, abs=1e-9)


def test_the_json_says_the_same(design: SpatialDesign) -> None:
    rows = list(csv.DictReader(io.StringIO(CSV.make(design, DevelopedOptions()).data.decode())))
    reported = json.loads(JSON.make(design, DevelopedOptions()).data)
    z = [value for curve in reported["curves"] for value in curve["z_mm"]]
    assert z == [float(row["z_mm"]) for row in rows]
    assert {curve["name"] for curve in reported["curves"] if curve["side"]} == {
        wall.name for wall in design.walls
    }


def test_the_drawing_shows_each_wall_where_it_is() -> None:
    """In mm, from outside: where the cam turns ccw about its axis, angles run to the left."""
    design = synthesise_spatial(SAMPLES["slide in a groove"].spec(rotation="cw"))
    mirrored = designed("slide in a groove")
    x, z = drawn(design, 0)
    assert np.ptp(x) == pytest.approx(2.0 * math.pi * OUTER, rel=2e-3)
    assert np.ptp(z) == pytest.approx(33.7, abs=2e-3)
    assert drawn(mirrored, 0)[0] + x == pytest.approx(np.full(len(x), x[0] + x[-1]), abs=2e-3)
    left, right = (drawn(design, which)[1] for which in (1, 2))
    rest = slice(-40, None)
    assert right[rest] - left[rest] == pytest.approx(np.full(40, 2.0 * RADIUS), abs=2e-3)


def drawn(design: SpatialDesign, which: int) -> np.ndarray:
    """Points of one of the curves, x to the right and z upwards, in their order of drawing."""
    root = ElementTree.fromstring(SVG.make(design, DrawnOptions()).data)
    paths = [p.attrib for p in root.iter(f"{SPACE}path") if p.attrib["class"].startswith("line")]
    steps = paths[which]["d"].removeprefix("M").split("L")
    points = np.array([[float(number) for number in step.split()] for step in steps])
    return points.T * np.array([[1.0], [-1.0]])


def test_a_cylinder_that_the_roller_does_not_reach_is_refused(design: SpatialDesign) -> None:
    for radius in (INNER - 0.1, OUTER + 0.1):
        with pytest.raises(InputError, match=r"from 61.3 to 47.4 mm of its axis"):
            CSV.make(design, DevelopedOptions(radius_mm=radius))


def test_a_cylinder_that_all_rollers_pass_beside_is_refused() -> None:
    """44.1 mm beside the axis at least they cross the outside, but no cylinder of 31 mm."""
    changes = {"roller_width_mm": 30.9, "centre_distance_mm": TURRET + 44.1}
    machine = SAMPLES["turret"].body["machine"] | changes
    design = synthesise_spatial(SAMPLES["turret"].spec(machine=machine))
    with pytest.raises(InputError, match=r"pass beside the cylinder of this radius.*up to 61.3"):
        CSV.make(design, DevelopedOptions(radius_mm=31.0))
    assert CSV.make(design, DevelopedOptions()).data
