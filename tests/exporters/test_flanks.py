"""Files of cams with several flanks: every curve by its name, at its distance, in the drawing."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from synthesis import Design, DesignSpec, synthesise
from synthesis.errors import InputError
from synthesis.exporters import PROFILE_FORMATS, PointOptions
from synthesis.exporters.options import CamDrawingOptions
from synthesis.exporters.samples.cam import profiles
from synthesis.exporters.tables import JsonOptions
from tests.exporters.test_drawings import drawn, text_boxes
from tests.exporters.test_points import away

CLOSURES: dict[str, dict[str, Any]] = {
    "ring": {"kind": "force", "contact": "inside", "rim_mm": 4.3},
    "groove": {"kind": "groove", "clearance_mm": 0.3},
    "pair": {"kind": "conjugate", "roller_radius_mm": 5.3, "offset_mm": -2.9},
}
GAPS = {
    "ring": {"profile": 7.1},
    "groove": {"inner": 7.25, "outer": 7.25, "profile": 7.25},
    "pair": {"main": 7.1, "profile": 7.1, "counter": 5.3},
}
NAMED = [(name, curve) for name, curves in GAPS.items() for curve in curves]


def question(closure: dict[str, Any], rotation: str) -> DesignSpec:
    return DesignSpec.model_validate(
        {
            "rotation": rotation,
            "program": [
                {"kind": "rise", "angle_deg": 93.0, "lift_mm": 17.9, "law": {"kind": "cycloidal"}},
                {"kind": "return", "angle_deg": 101.0, "lift_mm": 17.9,
                 "law": {"kind": "modified_sine"}},
                {"kind": "dwell", "angle_deg": 166.0},
            ],
            "follower": {
                "kind": "translating_roller", "roller_radius_mm": 7.1, "offset_mm": 4.7,
                "closure": closure,
            },
            "base_radius_mm": 47.3,
            "limits": [{"kind": "pressure_angle", "rise_deg": 40.0, "return_deg": 40.0}],
        }
    )  # fmt: skip


@pytest.fixture(scope="module", params=["ccw", "cw"])
def designs(request: pytest.FixtureRequest) -> dict[str, Design]:
    """As they come back from a store: read from their own JSON."""
    return {
        name: Design.model_validate_json(
            synthesise(question(closure, request.param)).model_dump_json()
        )
        for name, closure in CLOSURES.items()
    }


def points(design: Design, curve: str, **options: Any) -> np.ndarray:
    data = PROFILE_FORMATS["txt"].write(design, PointOptions(curve=curve, **options))
    return np.loadtxt(io.BytesIO(data))[:, :2]


@pytest.mark.parametrize(("name", "curve"), NAMED)
def test_a_flank_lies_at_its_distance_from_its_pitch_curve(designs, name, curve) -> None:
    pitch = "counter_pitch" if curve == "counter" else "pitch"
    flank = points(designs[name], curve, points_per_degree=2.0)
    path = points(designs[name], pitch, points_per_degree=8.0)
    np.testing.assert_allclose(away(flank, path), GAPS[name][curve], rtol=0, atol=2e-3)
    inside = np.min(np.hypot(*flank.T)) < np.min(np.hypot(*path.T))
    assert inside == (curve not in ("outer",) and name != "ring")


def test_the_counter_roller_stays_at_its_distance(designs) -> None:
    design = designs["pair"]
    apart = design.dimensions["counter_distance_mm"]
    main, counter = (
        points(design, curve, points_per_degree=4.0) for curve in ("pitch", "counter_pitch")
    )
    assert main.shape == counter.shape
    found = np.hypot(*(main - counter).T)
    np.testing.assert_allclose(found, np.hypot(apart, 4.7 + 2.9), rtol=1e-9)


@pytest.mark.parametrize(("name", "curve"), NAMED)
def test_chords_keep_their_tolerance_on_every_flank(designs, name, curve) -> None:
    coarse = points(designs[name], curve, tolerance_um=20.0)
    fine = points(designs[name], curve, points_per_degree=5.0)
    assert len(coarse) < len(fine) / 4
    assert np.max(away(fine, coarse)) <= 20e-3


@pytest.mark.parametrize(
    ("name", "curve"), [("ring", "inner"), ("groove", "counter"), ("pair", "outer")]
)
def test_a_curve_that_the_cam_has_not_is_refused_with_those_that_it_has(
    designs, name, curve
) -> None:
    grinding = PROFILE_FORMATS["grinding.nc"]
    with pytest.raises(InputError, match="curve=pitch for a wheel"):  # whatever the cam
        grinding.options(curve=curve)
    for exporter in PROFILE_FORMATS.values():  # the drawing too, though it shows all of them
        if exporter is grinding:
            continue
        with pytest.raises(InputError, match="profile, pitch") as caught:
            exporter.write(designs[name], exporter.options(curve=curve))
        assert caught.value.field == "/curve"
        assert all(known in caught.value.rule for known in GAPS[name])


def test_every_flank_has_a_file_of_its_own(designs) -> None:
    reported = {name: list(profiles(design).items()) for name, design in designs.items()}
    assert reported == {
        "ring": [("profile", "profile")],
        "groove": [("profile", "profile"), ("profile-outer", "outer")],
        "pair": [("profile", "profile"), ("profile-counter", "counter")],
    }


def test_tables_tell_the_flank_s_own_radius(designs) -> None:
    for curve, side in (("inner", 1.0), ("outer", -1.0)):
        data = PROFILE_FORMATS["json"].write(designs["groove"], JsonOptions(curve=curve))
        table = json.loads(data)
        assert table["curve"] == curve
        columns = {c["name"]: np.array(c["values"], float) for c in table["columns"]}
        bend = side * columns["pitch_curvature_per_mm"]
        np.testing.assert_allclose((columns["profile_radius_mm"] + 7.25) * bend, 1.0, rtol=1e-9)


def paths(drawing: str, kind: str) -> list[np.ndarray]:
    """Polygons of all paths of a class."""
    found = []
    for steps in re.findall(rf'<path class="[^"]*\b{kind}" d="([^"]*)"', drawing):
        for ring in re.findall(r"M([^MA]*)Z", steps):
            found.append(np.array([p.split() for p in ring.split("L")], float))
    return found


def area(ring: np.ndarray) -> float:
    x, y = ring.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def test_the_drawing_shows_every_flank(designs) -> None:
    shown = {}
    for name, design in designs.items():
        drawing = PROFILE_FORMATS["svg"].write(design, CamDrawingOptions()).decode()
        shown[name] = paths(drawing, "body"), paths(drawing, "curve"), drawing
        for reported in re.findall(r"(\w*) ?profile, radius", drawing):
            assert reported in ("", "inner", "outer", "main", "counter")
    inner, outer = shown["groove"][0]
    assert area(inner) * area(outer) < 0.0  # what lies between is open
    assert abs(area(inner)) < abs(area(outer))
    (ring,) = shown["ring"][0]
    largest = np.max(np.hypot(*ring.T))
    rim = float(re.findall(r"ZM([\d.]+) 0A", shown["ring"][2])[0])
    assert rim == pytest.approx(largest + 4.3, abs=1e-3)  # as asked for
    assert len(shown["pair"][0]) == 1
    (counter,) = shown["pair"][1]
    reported = points(designs["pair"], "counter")
    np.testing.assert_allclose(np.sort(counter, axis=0), np.sort(reported, axis=0), atol=1e-3)


@pytest.mark.usefixtures("unexplained")
def test_the_legend_of_many_curves_keeps_its_columns_apart() -> None:
    body = json.loads(Path("openapi/examples/conjugate.json").read_text())["value"]
    for segment in body["program"]:
        if segment["kind"] != "dwell":
            segment["law"] = {"kind": "modified_sine"}
    body["tolerance"] = 0.3
    root = drawn("profile", synthesise(DesignSpec.model_validate(body)))
    boxes = text_boxes(root)
    longest = max(box[2] for reported, box in boxes if " profile, radius" in reported)
    (second,) = (box[0] for reported, box in boxes if reported.startswith("stroke"))
    assert longest < second
    assert max(box[2] for _, box in boxes) < float(root.get("viewBox").split()[2])
