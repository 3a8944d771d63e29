"""The datasheet: one A4 page whose numbers are the design's; nothing of it outside the page."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from itertools import pairwise

import pytest

import synthesis as c
from synthesis.design.design import Design
from synthesis.design.warnings import DesignWarning
from synthesis.errors import ExtraMissing, InputError
from synthesis.exporters import PICTURES
from synthesis.exporters.drawing.canvas import TICK, figure, width_of
from synthesis.exporters.drawing.raster import as_pdf
from synthesis.exporters.drawing.summary_table import certificate_words, summary_tables
from tests.exporters.conftest import extreme
from tests.exporters.test_report import NASTY

SVG = "{http://www.w3.org/2000/svg}"
LOAD = {"kind": "slide", "moving_mass_kg": 2.0, "contact": {"width_mm": 12.0},
        "spring": {"rate_n_per_mm": 6.0, "preload_n": 900.0}}  # fmt: skip
LAW = {"kind": "modified_sine"}
PROGRAM = [
    {"kind": "rise", "angle_deg": 120, "lift_mm": 20, "law": LAW},
    {"kind": "dwell", "angle_deg": 60},
    {"kind": "return", "angle_deg": 100, "lift_mm": 20, "law": LAW},
    {"kind": "dwell", "angle_deg": 80},
]


def solved(program: list[dict], **fields) -> Design:
    """A cam of a given size with given laws, as it comes out of the core."""
    given = {
        "name": "press feed", "speed_rpm": 200.0, "program": program, "base_radius_mm": 50.0,
        "follower": {"kind": "translating_roller", "roller_radius_mm": 12.0, "offset_mm": 3.0},
        "load": LOAD, "body": {"thickness_mm": 15.0, "bore_mm": 25.0},
    }  # fmt: skip
    return c.synthesise(c.DesignSpec.model_validate({**given, **fields}))


@pytest.fixture(scope="module")
def design() -> Design:
    return solved(PROGRAM)


def page(design: Design) -> ET.Element:
    """The sheet inside the HTML page."""
    sheet = PICTURES["datasheet.html"]
    text = sheet.write(design, sheet.options(theme="light")).decode()
    return ET.fromstring(text[text.index("<svg") : text.rindex("</svg>") + len("</svg>")])


def texts(root: ET.Element) -> list[ET.Element]:
    return list(root.iter(f"{SVG}text"))


def words(root: ET.Element) -> str:
    return "\n".join(each.text or "" for each in texts(root))


def test_it_tells_the_designs_numbers(design: Design) -> None:
    shown = words(page(design))
    body, (flank,) = design.geometry, design.geometry.flanks
    for value in (
        design.motion_summary.acceleration.largest.value,
        design.motion_summary.jerk.rms,
        design.motion_summary.moves[1].coefficients.Cva,
    ):
        assert figure(value, 5) in shown
    for value in (
        flank.roller_speed_rpm.value, body.mass_properties.mass_kg,
        body.mass_properties.moment_of_inertia_kg_m2, design.forces.torque.rms_n_m,
    ):  # fmt: skip
        assert figure(value, 6) in shown
    for dimension in ("roller radius\n12 mm", "offset\n3 mm"):
        assert 0 < shown.find(dimension) < shown.index("Displacement")  # beside the cam
    for each in design.extremes:
        if each.field:
            assert each.limit.replace("_", " ") in shown
    assert "(gap 0 %), over all cams with the least base radius asked for" in shown


def test_what_was_asked_for_comes_before_what_follows() -> None:
    shown = words(page(solved(PROGRAM, shaft_diameter_mm=20.0)))
    assert 0 < shown.find("room for shaft") < shown.index("profile radius")


def crowded(design: Design) -> Design:
    """With a long name, forty limits, ten long warnings and twenty moves."""
    moves = [{"kind": kind, "angle_deg": 9.0, "lift_mm": 1.0, "law": LAW}
             for kind in ("rise", "return") * 20]  # fmt: skip
    warning = DesignWarning(
        code="x", severity="caution", field="limits", sentence="Nobody would build this. " * 9,
        remedy="Build another.", source="A book.",
    )  # fmt: skip
    limits = [extreme(f"limit_{k}", "mm/s³", 1.23456789e9, 123.4567, 2e9, "x") for k in range(40)]
    return solved(moves).model_copy(
        update={
            "name": NASTY * 9,
            "warnings": [warning] * 10,
            "extremes": limits,
            "assumptions": ["Much was assumed, " * 20 + "indeed. Ask otherwise."],
        }
    )


@pytest.mark.parametrize("full", [False, True])
def test_all_of_it_is_on_one_page_and_no_line_lies_on_another(design: Design, full: bool) -> None:
    root = page(crowded(design) if full else design)
    assert root.get("viewBox") == "0 0 210 297"
    lines: dict[float, list[tuple[float, float]]] = {}
    for each in texts(root):
        size = TICK if "tick" in each.get("class", "") else 2.9
        if "title" in each.get("class", ""):
            size = 4.4 * 1.15
        x, y, width = float(each.get("x")), float(each.get("y")), width_of(each.text or "", size)
        shift = {"middle": 0.5, "end": 1.0}.get(each.get("text-anchor"), 0.0)
        lines.setdefault(round(y, 2), []).append((x - shift * width, x + (1.0 - shift) * width))
    assert max(lines) <= 285.0
    for spans in lines.values():
        spans.sort()
        assert spans[0][0] >= 5.0
        assert spans[-1][1] <= 205.0
        assert all(a[1] <= b[0] for a, b in pairwise(spans))
    # below the diagrams every line of the tables and of the foot has its room
    below = [b - a for a, b in pairwise(sorted(lines)) if a > 190.0]
    assert min(below) >= 3.5
    if full:
        assert "more in the report" in words(root)
        assert "More warnings are in the report." in words(root)
        assert "Much was assumed" in words(root)


@pytest.mark.parametrize("rpm", [70.0, 700.0, 7000.0, 70000.0])
def test_no_number_and_no_unit_is_cut(rpm: float) -> None:
    """Peaks of the jerk grow with the cube of the speed: 1e6 to 1e15 mm/s³ here."""
    limit = {"kind": "jerk", "max_mm_per_s3": 5.12345e4 * rpm**2}
    cut = [
        str(each.text)
        for each in texts(page(solved(PROGRAM, speed_rpm=rpm, load=None, limits=[limit])))
        if str(each.text).endswith("…") and not str(each.text).startswith(("…", "note", "caution"))
    ]
    assert cut == []


def test_a_motion_that_nothing_limits_is_told_in_full() -> None:
    """Coefficients of 1e11 and peaks at thousandths of a degree have their room."""
    law = {"kind": "spline"}
    program = [
        {"kind": "rise", "angle_deg": 41.8, "lift_deg": 17.18, "law": law},
        {"kind": "dwell", "angle_deg": 14.5},
        {"kind": "return", "angle_deg": 54.7, "lift_deg": 17.18, "law": law},
        {"kind": "dwell", "angle_deg": 249},
    ]
    face = {"kind": "oscillating_flat_face", "centre_distance_mm": 76.6, "face_offset_mm": 4.6,
            "sense": "same"}  # fmt: skip
    made = solved(
        program, name="", follower=face, base_radius_mm=None, load=None,
        limits=[{"kind": "profile_radius", "min_mm": 6.8}], objective={"kind": "base_radius"},
    )  # fmt: skip
    found = [str(each.text) for each in texts(page(made))]
    assert found[0] == "Cam for an oscillating flat face follower"
    assert [each for each in found if each.endswith("…") and each[0] in "0123456789−"] == []


def test_a_name_that_is_too_long_for_a_title_is_written_smaller() -> None:
    for name, kind in (("short", "title"), ("Station 14, transfer left, variant B, " * 2, "label")):
        found = texts(page(solved(PROGRAM, name=name.strip(), load=None)))
        assert [each.get("class") for each in found if each.text == name.strip()] == [kind]


def test_a_stop_stands_beside_the_status(design: Design) -> None:
    stop = DesignWarning(
        code="x", severity="stop", field="limits", sentence="It breaks.", remedy="No.", source="B."
    )
    warned = design.model_copy(update={"warnings": [stop], "severity": "stop"})
    shown = words(page(warned))
    assert f"{design.status}, but STOP" in shown
    assert "stop: It breaks." in shown
    # beside limits that are broken too
    broken = [each.model_copy(update={"holds": False}) for each in design.extremes]
    shown = words(page(warned.model_copy(update={"extremes": broken})))
    assert f"{design.status}, but STOP: this cam breaks" in shown
    # nothing good comes before it
    assert "infeasible, and STOP" in words(page(warned.model_copy(update={"status": "infeasible"})))


def test_the_pdf_is_one_page_of_a4_with_texts_and_the_same_each_time(design: Design) -> None:
    pdf = PICTURES["datasheet.pdf"]
    first = pdf.write(design, pdf.options())
    assert first == pdf.write(design, pdf.options())
    assert len(re.findall(rb"/Type /Page\b", first)) == 1
    (box,) = re.findall(rb"/MediaBox \[([^\]]*)\]", first)
    assert [float(n) for n in box.split()] == pytest.approx([0, 0, 595.2756, 841.8898], abs=1e-3)
    assert b"/Type3" in first  # texts as texts, in a font that comes along
    assert b"CreationDate" not in first


def test_a_pdf_needs_matplotlib(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.figure", None)
    with pytest.raises(ExtraMissing):
        as_pdf(b"<svg/>", "")


def test_without_a_cam_there_is_none(design: Design) -> None:
    sheet = PICTURES["datasheet.html"]
    with pytest.raises(InputError):
        sheet.write(design.model_copy(update={"motion": [], "status": "unsolved"}), sheet.options())


def test_designs_of_before_the_summary_have_a_page_too(unspecial: Design) -> None:
    assert unspecial.motion_summary is None
    assert "Limit" in words(page(unspecial))
    assert summary_tables(unspecial) == []


def test_what_was_proven_in_words(design: Design) -> None:
    proof = design.certificate.model_copy(
        update={"objective": "base_radius_mm", "value": 20.0, "lower_bound": 19.0, "gap": 0.05,
                "bound_valid_for": "all motion laws"}
    )  # fmt: skip
    assert certificate_words(proof).endswith(
        "The base radius is 20 mm; no cam is below 19 mm (gap 5 %), over all motion laws."
    )
    open_end = proof.model_copy(update={"infimum": True})
    assert "its infimum lies between 19 mm and that" in certificate_words(open_end)
    unknown = proof.model_copy(update={"lower_bound": None, "certified": False})
    assert certificate_words(unknown).startswith("Not every limit holds. How near")
