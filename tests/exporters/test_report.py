"""The report, read back: its numbers, its pictures, its files, and texts that are not elements."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import xml.etree.ElementTree as ET
from html.parser import HTMLParser

import pytest

from synthesis.design.analysis import Sensitivities, Sensitivity
from synthesis.design.design import Conflict, Design, Effort, Relaxation, Report
from synthesis.exporters import (
    MOTION_FORMATS,
    PICTURES,
    PROFILE_FORMATS,
    PictureOptions,
    report_with,
)
from synthesis.exporters.drawing.canvas import figure
from synthesis.spec.design_spec import DesignSpec
from tests.exporters.conftest import extreme
from tests.exporters.test_mechanism import drawn_cam

NASTY = "</td><script>alert(1)</script><img src=x onerror=alert(1)> \x07 & \"quoted\" 'so'"
VOID = {"meta", "img", "link"}


class Page(HTMLParser):
    """Elements in order, tables by the heading above them, and nothing left open."""

    def __init__(self, content: bytes) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.headings: list[str] = []
        self.tables: dict[str, list[list[str]]] = {}
        self.text = ""
        self.feed(content.decode())
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)
        if tag == "h2":
            self.headings.append("")
        if tag == "tr":
            self.tables.setdefault(self.headings[-1], []).append([])
        if tag in ("td", "th"):
            self.tables[self.headings[-1]][-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" in self.open:
            return
        self.text += data
        if self.open and self.open[-1] == "h2":
            self.headings[-1] += data
        if self.open and self.open[-1] in ("td", "th"):
            self.tables[self.headings[-1]][-1][-1] += data


def page(design: Design, **options: object) -> Page:
    return Page(PICTURES["report.html"].write(design, PictureOptions(**options)))


@pytest.fixture(scope="module")
def judged(build) -> Design:
    held = extreme("pressure_angle_rise", "deg", 28.75, 21.4, 30.0, "pressure_angle/rise_deg")
    missed = extreme("jerk", "mm/s³", 1.5e6, 12.5, 1.2e6, "jerk/max_mm_per_s3")
    return build(extremes=[held, missed], name="lifter")


def test_numbers_of_the_design(judged: Design) -> None:
    reported = page(judged)
    assert reported.headings == [
        "Dimensions", "The cam", "Limits", "Certificate", "Program", "Motion",
        "Pressure angle and profile radius", "What was asked", "Files",
    ]  # fmt: skip
    for name, value in judged.dimensions.items():
        stem = name.removesuffix("_mm").replace("_", " ")
        assert f"{stem}{figure(value, 8)} mm" in reported.text
    _, held, missed = reported.tables["Limits"]
    assert held == ["pressure angle rise", "28.75°", "21.4°", "30°", "1.25°", "±1e−9", "holds"]
    assert missed[1:5] == ["1\u202f500\u202f000 mm/s³", "12.5°", "1\u202f200\u202f000 mm/s³",
                           "−300\u202f000 mm/s³"]  # fmt: skip
    assert missed[-1] == "broken"
    rows = [given["class"] for tag, given in reported.tags if tag == "tr" and given.get("class")]
    assert rows == ["holds", "broken"]
    program = reported.tables["Program"]
    assert program[1] == ["rise", "0°", "60°", "0 mm", "30 mm", "cycloidal"]
    assert program[4] == ["dwell", "150°", "210°", "0 mm", "0 mm", "–"]
    assert judged.id in reported.text


def test_what_each_stage_has_bought_is_told(judged: Design) -> None:
    assert "What it took" not in page(judged).headings
    each = {"solver": "Clarabel", "unknowns": 71, "rows": 305, "iterations": 13, "status": "solved"}
    stages = [
        Effort(stage="convex 1", model="SOCP", seconds=0.0371, **each),
        Effort(
            stage="implied rows", model="LPs", seconds=1.73, nodes=7, gap=0.0049213,
            exit="tolerance", **each,
        ),
    ]  # fmt: skip
    reported = page(judged.model_copy(update={"report": Report(stages=stages, seconds=2.13)}))
    _, first, last = reported.tables["What it took"]
    assert first == ["convex 1", "SOCP", "0.0371 s", "–", "–", ""]
    assert last == ["implied rows", "LPs", "1.73 s", "7", "0.492 %", "tolerance"]
    assert "2.13 s in all" in reported.text


def test_files_have_the_hashes_of_what_is_downloaded() -> None:
    design = drawn_cam("translating_roller", 3)
    rows = {name: digest for name, _, digest in page(design).tables["Files"][1:]}
    assert {"profile.csv", "profile-outer.csv", "motion.csv", "profile.svg"} <= set(rows)
    csv, table = PROFILE_FORMATS["csv"], MOTION_FORMATS["csv"]
    outer = csv.write(design, csv.options(curve="outer"))
    motion = table.write(design, table.options())
    assert rows["profile-outer.csv"] == hashlib.sha256(outer).hexdigest()
    assert rows["motion.csv"] == hashlib.sha256(motion).hexdigest()


def test_pictures_are_inside(p1: Design) -> None:
    pictures = [given["src"] for tag, given in page(p1, theme="dark").tags if tag == "img"]
    assert len(pictures) == 3
    for source in pictures:
        kind, _, data = source.partition(",")
        assert kind == "data:image/svg+xml;base64"
        root = ET.fromstring(base64.b64decode(data))
        assert "#15191e" in root.find("{http://www.w3.org/2000/svg}style").text


def test_what_was_asked_can_be_asked_again(unspecial: Design) -> None:
    text = page(unspecial).text
    spec = re.search(r"What was asked\s*({.*?\n})", text, re.S).group(1)
    assert DesignSpec.model_validate(json.loads(spec)) == unspecial.spec


@pytest.mark.parametrize("infeasible", [False, True])
def test_no_text_becomes_an_element(build, infeasible: bool) -> None:
    design = build(name=NASTY)
    if infeasible:
        change = Relaxation(
            limit=NASTY, field=NASTY, unit="mm", requested=1.0, needed=None, note=NASTY
        )
        conflict = Conflict(limits=[NASTY], relaxations=[change], evidence=NASTY, proven=True)
        design = design.model_copy(update={"conflict": conflict})
    reported = page(design)
    names = {tag for tag, _ in reported.tags}
    assert "script" not in names
    assert all(given["src"].startswith("data:") for tag, given in reported.tags if tag == "img")
    assert not [given for _, given in reported.tags if any(key.startswith("on") for key in given)]
    assert "alert(1)" in reported.text
    assert "\x07" not in reported.text


def test_nothing_reaches_outside(p1: Design) -> None:
    content = PICTURES["report.html"].write(p1, PictureOptions()).decode()
    assert not re.search(r"https?:|@import|url\(|href=(?!proof\.json)", content)
    policy = next(given["content"] for tag, given in page(p1).tags if "http-equiv" in given)
    assert policy == "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


def test_where_nothing_fits_it_says_what_would(build) -> None:
    helps = Relaxation(
        limit="jerk", field="limits/1/max_mm_per_s3", unit="mm/s³", requested=6e5, needed=8.3596e5
    )
    idle = helps.model_copy(update={"limit": "pressure_angle_rise", "needed": None, "unit": "deg"})
    conflict = Conflict(limits=["jerk"], relaxations=[helps, idle], evidence="proven", proven=True)
    none = build(status="infeasible").model_copy(update={"conflict": conflict})
    reported = page(none)
    assert reported.headings == ["Why nothing fits", "What was asked"]
    _, first, second = reported.tables["Why nothing fits"]
    assert first[:5] == [
        "jerk",
        "600\u202f000 mm/s³",
        "835\u202f960 mm/s³",
        "–",
        "limits/1/max_mm_per_s3",
    ]
    assert second[2] == "–"
    assert not [tag for tag, _ in reported.tags if tag == "img"]


def test_a_given_cam_says_what_it_breaks(judged: Design) -> None:
    conflict = Conflict(limits=["jerk"], relaxations=[], evidence="proven", proven=True)
    reported = page(judged.model_copy(update={"status": "infeasible", "conflict": conflict}))
    assert "this cam was given, and breaks jerk." in reported.text
    assert reported.headings[:2] == ["What would mend it", "Dimensions"]


def test_sensitivities_are_told_if_they_are_there(p1: Design) -> None:
    one = Sensitivity(
        field="limits/0/rise_deg",
        requested=30.0,
        per_unit=-0.8,
        per_unit_more=-0.8,
        per_unit_less=-0.8,
        sentence="1 deg more: so",
    )
    found = Sensitivities(
        objective="base_radius_mm", value=50.0, sensitivities=[one], evidence="LP", unconfirmed=[]
    )
    costs = report_with(PROFILE_FORMATS, MOTION_FORMATS, found)
    reported = Page(costs.write(p1, costs.options()))
    assert reported.tables["What each limit costs"][1] == [
        "limits/0/rise_deg",
        "30",
        "1 deg more: so",
    ]
    assert "What each limit costs" not in page(p1).headings
