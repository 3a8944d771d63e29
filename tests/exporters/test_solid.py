"""Solid cams, read back by OpenCASCADE: sound, of the right volume, walls where they belong."""

from __future__ import annotations

import math
import pickle
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from synthesis import Design, synthesise
from synthesis.errors import ExtraMissing, InputError
from synthesis.exporters import SOLID_FORMATS
from synthesis.exporters.curves.exact import ExactCurve, ExactOptions
from synthesis.exporters.solids import solid_step
from synthesis.exporters.solids.blank import SolidOptions, blank, bore, bores
from tests.exporters.kernel import OCP, shape
from tests.exporters.test_flanks import CLOSURES, question

STEP = SOLID_FORMATS["step"]
SOME = np.random.default_rng(5).uniform(0.0, 360.0, 9)


@pytest.fixture(scope="module")
def cams() -> dict[str, Design]:
    return {name: synthesise(question(closure, "cw")) for name, closure in CLOSURES.items()}


def faces_of(body: Any) -> list[Any]:
    found, each = [], OCP.TopExp.TopExp_Explorer(body, OCP.TopAbs.TopAbs_FACE)
    while each.More():
        found.append(each.Current())
        each.Next()
    return found


def volume(body: Any) -> float:
    reported = OCP.GProp.GProp_GProps()
    OCP.BRepGProp.BRepGProp.VolumePropertiesGK_s(body, reported, 1e-9, True, True)
    return float(reported.Mass())


def from_skin(body: Any, points: np.ndarray) -> np.ndarray:
    """Distances of points (n, 3) from the faces of a body."""
    skin, builder = OCP.TopoDS.TopoDS_Compound(), OCP.BRep.BRep_Builder()
    builder.MakeCompound(skin)
    for face in faces_of(body):
        builder.Add(skin, face)
    vertices = [
        OCP.BRepBuilderAPI.BRepBuilderAPI_MakeVertex(OCP.gp.gp_Pnt(*map(float, point))).Vertex()
        for point in points
    ]
    return np.array(
        [OCP.BRepExtrema.BRepExtrema_DistShapeShape(each, skin).Value() for each in vertices]
    )


def made(design: Design, folder: Path, **options: Any) -> Any:
    body = shape(STEP.write(design, SolidOptions(**options)), ".step", folder)
    assert body.ShapeType() == OCP.TopAbs.TopAbs_SOLID
    assert OCP.BRepCheck.BRepCheck_Analyzer(body).IsValid()
    return body


def polygon_area(points: np.ndarray) -> float:
    x, y = points.T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def test_a_plate_with_bore_keyway_and_hub(unspecial: Design, truth, tmp_path: Path) -> None:
    options: dict[str, Any] = {
        "thickness_mm": 7.9, "bore_mm": 18.5, "keyway": True, "keyway_deg": 71.0,
        "hub_diameter_mm": 31.0, "hub_length_mm": 5.3, "turn_deg": 17.0, "z_mm": 2.25,
    }  # fmt: skip
    body = made(unspecial, tmp_path, **options)
    area = polygon_area(truth(unspecial).points(np.linspace(0.0, 360.0, 90_001)[:-1]))
    # a keyway 6 mm wide and 2.8 mm deep beyond the bore, as a polygon
    x = np.linspace(-3.0, 3.0, 20_001)
    beyond = 9.25 + 2.8 - np.sqrt(9.25**2 - x**2)
    hole = math.pi * 9.25**2 + float(np.sum(0.5 * (beyond[1:] + beyond[:-1]) * np.diff(x)))
    expected = (area - hole) * 7.9 + (math.pi * 15.5**2 - hole) * 5.3
    assert volume(body) == pytest.approx(expected, rel=1e-6)
    assert blank(unspecial, SolidOptions(**options)).volume == pytest.approx(expected, rel=1e-8)
    turn = np.exp(1j * math.radians(17.0))
    edge = truth(unspecial).points(SOME) @ np.array([1.0, 1j]) * turn
    corner = (9.25 + 2.8 + 3j) * np.exp(1j * math.radians(71.0 + 17.0))
    rows = [[p.real, p.imag, 2.25 + 3.1] for p in (*edge, corner)]
    assert np.max(from_skin(body, np.array(rows))) < 1e-6
    back = np.array([[0.0, 12.4, 2.25 - 5.3], [0.0, 26.0, 2.25], [0.0, 20.0, 2.25 + 7.9]])
    assert np.max(from_skin(body, back)) < 1e-9


def test_a_grooved_disc(cams, tmp_path: Path) -> None:
    options = {"thickness_mm": 13.0, "groove_depth_mm": 4.7, "outer_diameter_mm": 173.0}
    body = made(cams["groove"], tmp_path, bore_mm=9.0, **options)
    planned = blank(cams["groove"], SolidOptions(bore_mm=9.0, **options))
    assert volume(body) == pytest.approx(planned.volume, rel=1e-8)
    inner, outer = (planned.slabs[i] for i in (1, 2))
    disc = math.pi * (86.5**2 - 4.5**2) * 13.0
    groove = (outer.holes[0].area - inner.outside.area) * 4.7
    assert planned.volume == pytest.approx(disc - groove, rel=1e-12)
    # Steiner: a band of constant width about a curve
    pitch = ExactCurve.of(cams["groove"], ExactOptions(curve="pitch")).spline.length
    assert groove == pytest.approx(4.7 * 14.5 * pitch, rel=1e-7)


def test_a_ring_keeps_its_rim(cams, tmp_path: Path) -> None:
    body = made(cams["ring"], tmp_path, thickness_mm=6.1)
    (slab,) = blank(cams["ring"], SolidOptions(thickness_mm=6.1)).slabs
    largest = slab.holes[0].radii[1]
    assert slab.outside.radii[1] == pytest.approx(largest + 4.3, rel=1e-9)
    expected = (math.pi * slab.outside.radii[1] ** 2 - slab.holes[0].area) * 6.1
    assert volume(body) == pytest.approx(expected, rel=1e-8)


def test_either_cam_of_a_pair(cams) -> None:
    main, counter = (
        blank(cams["pair"], SolidOptions(curve=curve)).volume for curve in ("main", "counter")
    )
    assert main != pytest.approx(counter, rel=1e-3)


def test_the_same_bytes_and_the_design_s_own_header(unspecial: Design) -> None:
    first, again = (STEP.make(unspecial, SolidOptions()) for _ in range(2))
    assert first.data == again.data
    assert unspecial.id.encode() in first.data.partition(b"DATA;")[0]
    assert b"PRODUCT('unspecial','unspecial'" in first.data
    assert float(first.metadata["Curve-Error-Mm"]) <= 1e-6
    assert float(first.metadata["Volume-Mm3"]) == blank(unspecial, SolidOptions()).volume


@pytest.mark.parametrize(
    ("closure", "options", "field"),
    [
        ("pair", {"bore_mm": 95.0}, "/bore_mm"),
        ("pair", {"bore_mm": 30.0, "hub_diameter_mm": 29.0, "hub_length_mm": 4.0}, "/bore_mm"),
        ("pair", {"hub_diameter_mm": 96.0, "hub_length_mm": 4.0}, "/hub_diameter_mm"),
        ("pair", {"hub_diameter_mm": 29.0}, "/hub_length_mm"),
        ("pair", {"keyway": True}, "/bore_mm"),
        ("pair", {"keyway": True, "bore_mm": 5.5}, "/bore_mm"),
        ("pair", {"keyway": True, "bore_mm": 9.0, "keyway_width_mm": 9.5}, "/keyway_width_mm"),
        ("groove", {"groove_depth_mm": 10.0}, "/groove_depth_mm"),
        ("groove", {"outer_diameter_mm": 100.0}, "/outer_diameter_mm"),
        ("ring", {"bore_mm": 10.0}, "/bore_mm"),
        ("ring", {"groove_depth_mm": 3.0}, "/groove_depth_mm"),
        ("pair", {"outer_diameter_mm": 200.0}, "/outer_diameter_mm"),
        ("pair", {"groove_depth_mm": 3.0}, "/groove_depth_mm"),
        ("ring", {"curve": "counter"}, "/curve"),
    ],
)  # fmt: skip
def test_bodies_that_make_no_sense(cams, closure: str, options: dict[str, Any], field: str) -> None:
    with pytest.raises(InputError) as caught:
        blank(cams[closure], SolidOptions(**options))
    assert caught.value.field == field
    assert caught.value.rule
    assert caught.value.remedy


def test_without_its_extra_it_says_how_to_get_it(unspecial: Design, monkeypatch) -> None:
    monkeypatch.setattr(solid_step, "find_spec", lambda name: None)
    with pytest.raises(ExtraMissing, match=r"camwright\[cad\]"):
        STEP.write(unspecial, SolidOptions())


def test_without_the_systems_opengl_it_says_so(unspecial: Design, monkeypatch) -> None:
    """The extra does not bring libGL: the import fails though the extra is there."""
    monkeypatch.setitem(sys.modules, "synthesis.exporters.solids.body", None)
    with pytest.raises(ExtraMissing, match=r"library of the system.*apt install libgl1") as told:
        STEP.write(unspecial, SolidOptions())
    assert str(pickle.loads(pickle.dumps(told.value))) == str(told.value)


@pytest.mark.parametrize("diameter", [6.5, 12.0, 38.0, 229.0])
def test_keyways_by_the_standard(diameter: float) -> None:
    width, depth = {6.5: (2, 1.0), 12.0: (4, 1.8), 38.0: (10, 3.3), 229.0: (50, 11.4)}[diameter]
    for given in ({}, {"keyway_width_mm": 3.0}):
        options = SolidOptions(bore_mm=diameter, keyway=True, keyway_deg=0.0, **given)
        wide = given.get("keyway_width_mm", width)
        assert bores(options) == [bore(0.5 * diameter, wide, depth, 0.0)]
