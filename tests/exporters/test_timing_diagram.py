"""The timing diagram, read back as XML."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import combinations

import numpy as np
import pytest

from synthesis import CamSet, synthesise_set
from synthesis.exporters.diagrams.timing import LEFT, RIGHT, WIDTH, displacement, timing_diagram
from tests.exporters.test_bundle import STEEP
from tests.exporters.test_drawings import SVG, floats, of_class, path_points, text_boxes, texts
from tests.studies.cam_sets import INLET, body, question

PER_DEGREE = (WIDTH - LEFT - RIGHT) / 360.0
BUSY = {
    "program": [
        {"kind": kind, "angle_deg": angle, **({} if kind == "dwell" else
         {"lift_mm": 3.0 + 0.5 * (k // 3), "law": {"kind": "cycloidal"}})}
        for k in range(24)
        for kind, angle in ((("rise", 6.0), ("dwell", 3.0), ("return", 6.0))[k % 3],)
    ] + [{"kind": "dwell", "angle_deg": 240.0}],
    "follower": INLET["follower"],
    "base_radius_mm": 90.0,
}  # fmt: skip


@pytest.fixture(scope="module")
def found() -> CamSet:
    cams = body()["cams"]
    cams.append({"name": "W" * 60, "phase_deg": -17.25, "axial_mm": 123456.75, "spec": BUSY})
    cams.append({"name": "steep", "spec": STEEP})
    with pytest.MonkeyPatch.context() as patch:  # nobody asks why the last has no cam
        patch.setattr("synthesis.pipeline.oracle.Oracle.is_late", lambda oracle: True)
        return synthesise_set(question(name="Every cam " * 20, cams=cams))


@pytest.fixture(scope="module")
def sheet(found: CamSet) -> ET.Element:
    return ET.fromstring(timing_diagram(found))


def degrees(x: np.ndarray | float) -> np.ndarray:
    return (np.asarray(x) - LEFT) / PER_DEGREE


def test_every_curve_is_the_law_at_its_phase(found: CamSet, sheet: ET.Element) -> None:
    drawn = of_class(sheet, "path", "curve")
    cams = [cam for cam in found.cams if cam.has_cam]
    assert len(drawn) == len(cams) == 3
    for path, cam in zip(drawn, cams, strict=True):
        x, y = path_points(path).T
        law = cam.design.curve.derivatives(np.radians(degrees(x) - cam.phase_deg))[0]
        scale = (y.max() - y.min()) / law.max()
        np.testing.assert_allclose(y.max() - y, scale * law, rtol=0.0, atol=8e-3)
        assert (x[0], x[-1]) == (LEFT, WIDTH - RIGHT)
        assert np.all(np.diff(x) > -1e-9)


def test_joints_are_among_the_points(found: CamSet) -> None:
    shaft, _ = displacement(found.cams[0])
    for event in found.timing.events:
        if event.cam == 0:
            assert np.min(np.abs(shaft - event.shaft_deg)) < 1e-9


def test_programs_start_at_their_phases(found: CamSet, sheet: ET.Element) -> None:
    marks = of_class(sheet, "line", "phase")
    at = [float(degrees(floats(mark, "x1")[0])) for mark in marks]
    assert at == pytest.approx([37.9, 216.8, 342.75], abs=1e-3)


def test_dwells_are_shaded(found: CamSet, sheet: ET.Element) -> None:
    """Inlet: 222.2° over the turn's end to 37.9°, and 109.2° to 133.8°."""
    lane = floats(of_class(sheet, "line", "phase")[0], "y1", "y2")
    boxes = [floats(box, "x", "y", "width") for box in of_class(sheet, "rect", "rest")]
    spans = {
        (round(float(degrees(x)), 2), round(float(degrees(x + w)), 2))
        for x, y, w in boxes
        if lane[0] < y < lane[1]
    }
    assert spans == {(222.2, 360.0), (0.0, 37.9), (109.2, 133.8)}


def test_what_moves_together_is_counted(found: CamSet, sheet: ET.Element) -> None:
    boxes = [floats(box, "x", "width") for box in of_class(sheet, "rect", "several")]
    drawn = sum(width for _, width in boxes) / PER_DEGREE
    reported = sum(arc.angle_deg for arc in found.timing.arcs if len(arc.moving) > 1)
    assert drawn == pytest.approx(reported, abs=1e-3)
    assert reported > 30.0


def test_texts_are_on_the_sheet_and_apart(sheet: ET.Element) -> None:
    _, _, width, height = (float(n) for n in sheet.get("viewBox", "").split())
    boxes = text_boxes(sheet)
    for content, (left, top, right, bottom) in boxes:
        assert min(left, top, width - right, height - bottom) >= 0.0, content
    for (one, a), (other, b) in combinations(boxes, 2):
        apart = a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
        assert apart, (one, other)


def test_captions(sheet: ET.Element) -> None:
    reported = texts(sheet)
    for caption in ("inlet", "stroke 13.7 mm", "phase −143.2°", "z −31.25 mm",
                    "follower at 208.6°", "nothing fits: no cam", "rise 71.3°"):  # fmt: skip
        assert caption in reported, reported
    assert any("4 cams on one shaft · turns counter-clockwise" in each for each in reported)


def test_one_cam_needs_no_count() -> None:
    cams = synthesise_set(question(cams=[{"spec": INLET}], rotation="cw"))
    reported = texts(ET.fromstring(timing_diagram(cams)))
    assert "followers moving" not in reported
    assert any("1 cam on one shaft · turns clockwise" in each for each in reported)


def test_what_xml_cannot_hold_does_no_harm() -> None:
    cams = synthesise_set(question(name="<&\x00>", cams=[{"name": "a\x0b<b>", "spec": INLET}]))
    root = ET.fromstring(timing_diagram(cams))
    assert "<" in "".join(text for text in texts(root))
    assert root.tag == f"{SVG}svg"
