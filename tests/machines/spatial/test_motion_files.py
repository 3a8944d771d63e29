"""Motion of spatial cams as files, against the law written down by itself."""

from __future__ import annotations

import csv
import io
import json
import math

import numpy as np
import pytest

from synthesis.exporters.options import DiagramOptions, MotionOptions
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.motion import CSV, JSON, SVG
from tests.machines.spatial.drums import INDEX, SWING, cycloid, designed, there_and_back


@pytest.fixture(scope="module")
def arm() -> SpatialDesign:
    return designed("arm astride a rib")


def read(design: SpatialDesign, per_degree: float) -> dict[str, np.ndarray]:
    made = CSV.write(design, MotionOptions(per_degree))
    rows = list(csv.DictReader(io.StringIO(made.decode())))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def test_the_table_is_the_law_at_the_cam_s_speed(arm: SpatialDesign) -> None:
    found, h = read(arm, 1.0), 1e-4
    theta, omega = np.radians(found["theta_deg"]), 83.0 * math.pi / 30.0
    s = there_and_back(SWING)
    assert found["s_deg"] == pytest.approx(s(theta), abs=1e-9)
    inside = slice(1, -1)
    speed = (s(theta + h) - s(theta - h))[inside] / (2.0 * h) * omega
    assert found["v_deg_per_s"][inside] == pytest.approx(speed, abs=1e-4 * omega)


def test_an_indexer_goes_on_to_the_end_of_the_turn() -> None:
    found = read(designed("turret"), 0.5)
    expected = 45.0 * cycloid(np.clip(found["theta_deg"] / INDEX, 0.0, 1.0))
    assert found["s_deg"] == pytest.approx(expected, abs=1e-9)


def test_json_and_diagrams_say_the_same(arm: SpatialDesign) -> None:
    reported = json.loads(JSON.write(arm, MotionOptions(1.0)))
    columns = {column["name"]: column["values"] for column in reported["columns"]}
    table = read(arm, 1.0)
    assert {name: list(values) for name, values in table.items()} == columns
    assert reported["design"]["id"] == arm.id
    drawn = SVG.write(arm, DiagramOptions(1.0)).decode()
    max_speed = float(np.max(table["v_deg_per_s"]))
    assert f"max {max_speed:.4g} at" in drawn
    assert "dwell 68°" in drawn
