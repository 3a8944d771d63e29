"""Both animations, taken apart: every frame is put together again from the file and measured."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import xml.etree.ElementTree as ET
from functools import cache
from html.parser import HTMLParser

import numpy as np
import pytest

from synthesis.exporters import PICTURES, PictureOptions
from synthesis.exporters.samples.cam import Cam
from tests.catalogue.followers.samples import SAMPLES, spec
from tests.exporters.test_drawings import SVG, of_class, path_points, text_boxes
from tests.exporters.test_mechanism import CAMS, drawn_cam

FACTORS = re.compile(r"(\w+)\(([^)]*)\)")
Matrix = np.ndarray


def matrix(transform: str) -> Matrix:
    found = np.eye(3)
    for name, numbers in FACTORS.findall(transform):
        a, *more = (float(n.removesuffix("px").removesuffix("deg"))
                    for n in re.split(r"[ ,]+", numbers.strip()))  # fmt: skip
        b = more[0] if more else 0.0 if name == "translate" else a
        turn = np.radians(a)
        found = found @ {
            "translate": np.array([[1, 0, a], [0, 1, b], [0, 0, 1]]),
            "scale": np.diag([a, b, 1.0]),
            "rotate": np.array([[np.cos(turn), -np.sin(turn), 0],
                                [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]),
        }[name]  # fmt: skip
    return found


def placed(root: ET.Element, moved: dict[str, str]) -> dict[ET.Element, Matrix]:
    """Every element with what takes its coordinates to the sheet; parts stand as ``moved`` says."""
    found: dict[ET.Element, Matrix] = {}

    def down(element: ET.Element, outer: Matrix) -> None:
        part = element.get("data-part") or element.get("class", "").partition("-")[2]
        own = moved.get(part) or element.get("transform", "")
        found[element] = outer @ matrix(own)
        for child in element:
            down(child, found[element])

    down(root, np.eye(3))
    return found


def at(where: Matrix, x: float, y: float) -> complex:
    px, py, _ = where @ np.array([x, y, 1.0])
    return complex(px, py)


def line_through(where: Matrix, points: np.ndarray) -> np.ndarray:
    return where[:2, :2] @ points.T + where[:2, 2:]


def distance(point: complex, line: np.ndarray) -> float:
    """From a polygon's edges."""
    p = line[0] + 1j * line[1]
    a, b = p, np.roll(p, -1)
    keep = np.abs(b - a) > 0.0
    a, b = a[keep], b[keep]
    t = np.clip(np.real((point - a) * np.conj(b - a)) / np.abs(b - a) ** 2, 0.0, 1.0)
    return float(np.min(np.abs(point - a - t * (b - a))))


class Page(HTMLParser):
    """Scripts and policies of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.inside: dict[str, str] | None = None
        self.scripts: list[tuple[dict[str, str], str]] = []
        self.policy = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list) -> None:
        given = dict(attrs)
        assert not [name for name in given if name.startswith("on")]
        if tag == "meta" and given.get("http-equiv") == "Content-Security-Policy":
            self.policy = given["content"]
        self.inside = given if tag == "script" else None

    def handle_data(self, data: str) -> None:
        if self.inside is not None:
            self.scripts.append((self.inside, data))
            self.inside = None


@cache
def page_of(kind: str, sample: int, rotation: str = "ccw") -> tuple[str, list[ET.Element], dict]:
    text = (
        PICTURES["animation.html"]
        .write(drawn_cam(kind, sample, rotation=rotation), PictureOptions())
        .decode()
    )
    inline = [ET.fromstring(each.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1))
              for each in re.findall(r"<svg.*?</svg>", text, re.S)]  # fmt: skip
    data = next(json.loads(body) for given, body in Page(text).scripts if "id" in given)
    return text, inline, data


def frame(data: dict, part: float) -> dict[str, str]:
    """Where everything stands, a part of a turn after cam angle 0."""
    found = {}
    for each in data["parts"]:
        values = [float(np.interp(part, np.linspace(0, 1, len(c)), c)) for c in each["columns"]]
        reported = " ".join(map(str, values))
        found[each["name"]] = f"{'rotate' if each['kind'] == 'turn' else 'translate'}({reported})"
    return found


@CAMS
@pytest.mark.parametrize("part", [0.0, 97.0 / 720.0, 251.0 / 720.0])
def test_in_every_frame_the_contact_lies_on_the_cam(kind: str, sample: int, part: float) -> None:
    rotation = "cw" if sample % 2 else "ccw"
    _, (machine, diagrams), data = page_of(kind, sample, rotation)
    where = placed(machine, frame(data, part))
    outlines = [line_through(where[each], path_points(each))
                for each in of_class(machine, "path")
                if {"curve"} <= set(each.get("class", "").split())]  # fmt: skip
    body = of_class(machine, "path", "body")[0]
    for ring in re.findall(r"M[^A-Z]*(?:L[^A-Z]*)*Z", body.get("d")):
        numbers = np.array([float(n) for n in re.findall(r"-?\d+(?:\.\d+)?", ring)])
        outlines.append(line_through(where[body], numbers.reshape(-1, 2)))
    marks = of_class(machine, "circle", "mark")
    assert marks
    for mark in marks:
        spot = at(where[mark], float(mark.get("cx")), float(mark.get("cy")))
        assert min(distance(spot, line) for line in outlines) < 0.02  # [mm] on the sheet
    cam = of_class(machine, "circle", "line", "circle")[0]
    turned = np.degrees(np.angle(at(where[cam], 1, 0) - at(where[cam], 0, 0)))
    want = 360.0 * part * (1.0 if rotation == "cw" else -1.0) + (180.0 if rotation == "cw" else 0.0)
    assert (turned - want + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=1e-3)
    there = placed(diagrams, frame(data, part))
    curves = [path_points(each).T for each in of_class(diagrams, "path", "curve")]
    for mark in of_class(diagrams, "circle", "mark"):
        spot = at(there[mark], 0.0, 0.0)
        assert min(distance(spot, line) for line in curves) < 0.02


@pytest.mark.parametrize("kind", ["translating_roller", "oscillating_roller"])
def test_the_follower_moves_as_the_law_says(kind: str) -> None:
    _, (machine, _), data = page_of(kind, 0)
    cam = Cam.of(drawn_cam(kind, 0))
    wheel = next(each for each in of_class(machine, "circle", "glass"))
    outer = of_class(machine, "g", "mechanism")[0]
    scale = abs(matrix(outer.get("transform"))[0, 0])
    for part in (0.1, 0.27, 0.5):
        where = placed(machine, frame(data, part))
        axis = at(where[outer], 0.0, 0.0)
        reported = (at(where[wheel], 0.0, 0.0) - axis) / scale
        s = cam.motion.derivatives(np.array([2.0 * np.pi * part]), 3)
        (x, y), *_ = cam.flank.trace.position(s, cam.size)
        assert reported.real == pytest.approx(float(x[0]), abs=5e-3)
        assert -reported.imag == pytest.approx(float(y[0]), abs=5e-3)


@pytest.mark.parametrize("size", [1e-4, 3e-2, 1e3])
@pytest.mark.parametrize("kind", ["translating_roller", "oscillating_flat_face"])
def test_any_size_is_drawn_as_finely(kind: str, size: float) -> None:
    """Browsers paint what is scaled by a thousand coarsely; numbers end at four decimals."""
    follower, base = SAMPLES[kind][0]
    lengths = {name: value * size for name, value in follower.items()
               if name.endswith("_mm")}  # fmt: skip
    program = spec(kind).model_dump(mode="json", exclude_none=True)["program"]
    for segment in program:
        if "lift_mm" in segment:
            segment["lift_mm"] *= size
    design = drawn_cam(kind, 0, program=program, follower=follower | lengths,
                       base_radius_mm=base * size, limits=[])  # fmt: skip
    root = ET.fromstring(PICTURES["animation.svg"].write(design, PictureOptions()))
    (outer,) = of_class(root, "g", "mechanism")
    assert 0.03 < abs(matrix(outer.get("transform"))[0, 0]) < 30.0
    style = root.find(SVG + "style").text
    widths = re.findall(r"\.mechanism \.\w+{stroke-width:([\d.]+)", style)
    assert len(widths) > 10
    assert min(map(float, widths)) > 2e-3
    where = placed(root, {})
    body = of_class(outer, "path", "body")[0]
    ring = re.search(r"M[^Z]*Z", body.get("d")).group(0)
    line = np.array([float(n) for n in re.findall(r"-?\d+(?:\.\d+)?", ring)]).reshape(-1, 2)
    across = np.ptp(line_through(where[body], line), axis=1)
    assert 40.0 < across.max() < 122.0
    (mark,) = of_class(outer, "circle", "mark")
    spot = at(where[mark], float(mark.get("cx")), float(mark.get("cy")))
    assert distance(spot, line_through(where[body], line)) < 0.02


def test_readings_are_the_motion_in_the_wires_units() -> None:
    _, _, data = page_of("oscillating_roller", 1)
    cam = Cam.of(drawn_cam("oscillating_roller", 1))
    theta = np.linspace(0.0, 2.0 * np.pi, 721)
    s, read = cam.motion.derivatives(theta, 3), {each["name"]: each for each in data["readings"]}
    for order, name in enumerate("sva"):
        want = s[order] * cam.rate(order)
        column = np.array(read[name]["column"], dtype=float)
        assert np.max(np.abs(column - want)) <= 0.5001 * 10.0 ** -read[name]["digits"]
        assert read[name]["unit"] == ("deg", "deg/s", "deg/s²")[order]
    assert np.all(np.isfinite(np.array(read["alpha"]["column"], dtype=float)))


def test_the_page_runs_its_own_script_alone() -> None:
    text, inline, _ = page_of("translating_roller", 0)
    page = Page(text)
    scripts = [body for given, body in page.scripts if "id" not in given]
    assert len(scripts) == 1
    digest = base64.b64encode(hashlib.sha256(scripts[0].encode()).digest()).decode()
    assert page.policy == (
        "default-src 'none'; style-src 'unsafe-inline'; img-src data:; "
        f"script-src 'sha256-{digest}'"
    )
    assert len(inline) == 2


@CAMS
@pytest.mark.parametrize("name", ["animation.svg", "animation.html"])
def test_small_and_by_itself(kind: str, sample: int, name: str) -> None:
    content = PICTURES[name].write(drawn_cam(kind, sample), PictureOptions()).decode()
    assert len(content) < 200_000
    content = content.replace('xmlns="http://www.w3.org/2000/svg"', "")
    assert not re.search(r"https?:|//[a-z]|@import|url\(|\bsrc=|\bhref=", content)


@pytest.mark.parametrize(
    "name", ["</script><script>alert(1)</script>", '"><img src=x>', "凸轮\x00"]
)
def test_no_name_becomes_part_of_a_page(name: str, build) -> None:
    text = PICTURES["animation.html"].write(build(name=name), PictureOptions()).decode()
    assert len(Page(text).scripts) == 2
    assert "<img" not in text
    root = ET.fromstring(PICTURES["animation.svg"].write(build(name=name), PictureOptions()))
    assert not list(root.iter("script"))


# --- the one without a script --------------------------------------------------------------------


@cache
def sheet(kind: str, sample: int, rotation: str = "ccw") -> tuple[ET.Element, str]:
    design = drawn_cam(kind, sample, rotation=rotation)
    root = ET.fromstring(PICTURES["animation.svg"].write(design, PictureOptions()))
    return root, root.find(SVG + "style").text


def keyframes(style: str, name: str) -> list[tuple[float, str]]:
    body = re.search(rf"@keyframes \w+-{name}{{((?:[^{{}}]+{{[^}}]*}})*)}}", style).group(1)
    states = re.findall(r"([\d.]+|to)%?{transform:([^}]*)}", body)
    return [(1.0 if stop == "to" else float(stop) / 100.0, state) for stop, state in states]


@pytest.mark.parametrize(("kind", "sample"), [("translating_roller", 4), ("oscillating_roller", 6),
                                              ("oscillating_flat_face", 0)])  # fmt: skip
def test_keyframes_say_what_the_page_says(kind: str, sample: int) -> None:
    _, style = sheet(kind, sample)
    _, _, data = page_of(kind, sample)
    names = [
        each["name"] for each in data["parts"] if not each["name"].startswith(("cursor", "dot"))
    ]
    assert len(names) >= 3
    for name in names:
        part = next(each for each in data["parts"] if each["name"] == name)
        stops = keyframes(style, name)
        assert (stops[0][0], stops[-1][0]) == (0.0, 1.0)
        total = part["columns"][0][-1] - part["columns"][0][0]
        mean = 0.0
        if f"-{name}-mean" in style:  # an even turning beside what departs from it
            seconds = float(re.search(rf"-{name}-mean ([\d.]+)s", style).group(1))
            ((_, whole),) = keyframes(style, f"{name}-mean")
            mean = float(FACTORS.search(whole).group(2).removesuffix("deg")) * 8.0 / seconds
            assert mean == pytest.approx(total, abs=1e-3)
        for stop, state in stops[:: max(1, len(stops) // 17)]:
            given = [
                float(re.sub("[a-z]", "", n)) for n in FACTORS.search(state).group(2).split(",")
            ]
            for value, column in zip(given, part["columns"], strict=True):
                want = np.interp(stop, np.linspace(0, 1, len(column)), column)
                assert value + mean * stop == pytest.approx(want, abs=2e-3)


def test_it_stands_still_where_less_motion_is_asked_for() -> None:
    _, style = sheet("translating_roller", 0)
    moving = style[style.index("@media (prefers-reduced-motion:no-preference)") :]
    assert "animation:" not in style.replace(moving, "")
    assert moving.count("infinite") >= 6


@pytest.mark.parametrize(("kind", "sample"), [("translating_roller", 0), ("oscillating_roller", 1)])
def test_its_texts_do_not_overlap(kind: str, sample: int) -> None:
    root, _ = sheet(kind, sample)
    groups = [each for each in root if each.tag == SVG + "g"]
    assert len(groups) == 2
    for group in groups[1:]:
        panel = ET.Element(SVG + "svg")
        panel.append(root.find(SVG + "style"))
        panel.append(group)
        boxes = text_boxes(panel)
        for k, (a, (left, low, right, high)) in enumerate(boxes):
            for b, (x0, y0, x1, y1) in boxes[k + 1 :]:
                apart = right <= x0 or x1 <= left or high <= y0 or y1 <= low
                assert apart, f"{a!r} overlaps {b!r}"
