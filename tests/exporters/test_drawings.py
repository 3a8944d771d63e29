"""Drawings, read back as XML with an own reading of paths, axes and texts."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from synthesis.design.design import Design
from synthesis.exporters import MOTION_FORMATS, PROFILE_FORMATS
from synthesis.exporters.drawing.canvas import shown_at
from synthesis.exporters.options import CamDrawingOptions, DiagramOptions
from tests.exporters.conftest import P1_PROGRAM

SVG = "{http://www.w3.org/2000/svg}"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
SHEETS = ("profile", "motion")

Box = tuple[float, float, float, float]


def drawn(sheet: str, design: Design, **options: Any) -> ET.Element:
    if sheet == "profile":
        return ET.fromstring(PROFILE_FORMATS["svg"].write(design, CamDrawingOptions(**options)))
    return ET.fromstring(MOTION_FORMATS["svg"].write(design, DiagramOptions(**options)))


def of_class(root: ET.Element, tag: str, *names: str) -> list[ET.Element]:
    return [
        each for each in root.iter(SVG + tag) if set(names) <= set(each.get("class", "").split())
    ]


def path_points(path: ET.Element) -> np.ndarray:
    steps = path.get("d", "")
    assert set(re.sub(r"[-\d. ]", "", steps)) <= set("MLZ")
    return np.array([float(n) for n in NUMBER.findall(steps)]).reshape(-1, 2)


def floats(element: ET.Element, *names: str) -> list[float]:
    return [float(element.get(name, "nan")) for name in names]


def text_of(element: ET.Element) -> str:
    return "".join(element.itertext())


def texts(root: ET.Element) -> list[str]:
    return [text_of(each) for each in root.iter(SVG + "text")]


def text_boxes(root: ET.Element) -> list[tuple[str, Box]]:
    """Extent of every text when set in DejaVu Sans, the widest of the fonts asked for."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    style = text_of(root.find(SVG + "style"))
    found = []
    for element in root.iter(SVG + "text"):
        kind = element.get("class", "").split()[0]
        size = float(re.search(rf"\.{kind}{{font-size:([\d.]+)px", style).group(1))
        bold = "bold" if kind == "title" else "normal"
        content = text_of(element)
        font = FontProperties(family="DejaVu Sans", weight=bold)
        extent = TextPath((0, 0), content, size=size, prop=font).get_extents()
        x, y = floats(element, "x", "y")
        x -= {"start": 0.0, "middle": 0.5, "end": 1.0}[element.get("text-anchor")] * extent.x1
        found.append((content, (x, y - extent.y1, x + extent.x1, y - extent.y0)))
    return found


@pytest.fixture(scope="module")
def crowd(build) -> Design:
    """36 segments and a long name."""
    program: list[dict[str, Any]] = []
    for k in range(12):
        law = {"kind": "cycloidal"}
        program.append({"kind": "rise", "angle_deg": 15, "lift_mm": 3 + k % 3, "law": law})
        program.append({"kind": "return", "angle_deg": 12, "lift_mm": 3 + k % 3, "law": law})
        program.append({"kind": "dwell", "angle_deg": 3})
    limits = [{"kind": "velocity", "max_mm_per_s": 300}]
    return build(program, name="Many W" * 30, offset=0.0, roller=0.0, limits=limits)


@pytest.fixture(scope="module")
def rough(build) -> Design:
    """Acceleration and velocity jump; limits that are reached by infinite values."""
    program = [
        {"kind": "rise", "angle_deg": 120, "lift_mm": 25, "law": {"kind": "parabolic"}},
        {"kind": "return", "angle_deg": 130, "lift_mm": 25, "law": {"kind": "constant_velocity"}},
        {"kind": "dwell", "angle_deg": 110},
    ]
    return build(program, name="rough", roller=0.0)


ALL = pytest.mark.parametrize("named", ["p1", "unspecial", "crowd", "rough"])


# --- every sheet ---------------------------------------------------------------------------------


@ALL
@pytest.mark.parametrize("sheet", SHEETS)
def test_sheet_is_shown_at_a_stated_scale(sheet: str, named: str, request) -> None:
    root = drawn(sheet, request.getfixturevalue(named))
    x, y, width, height = (float(n) for n in root.get("viewBox").split())
    assert (x, y) == (0.0, 0.0)
    scale = stated_scale(root)
    for name, length in (("width", width), ("height", height)):
        number, unit = re.fullmatch(r"([\d.]+)(mm)", root.get(name)).groups()
        assert unit == "mm"
        assert float(number) == pytest.approx(scale * length, rel=1e-6, abs=1e-4)
    assert 100.0 < scale * width < 430.0
    ground = of_class(root, "rect", "ground")[0]
    assert floats(ground, "width", "height") == [width, height]
    assert not [each for each in root.iter() if each.get("id")]


@ALL
@pytest.mark.parametrize("sheet", SHEETS)
def test_texts_neither_overlap_nor_leave_the_sheet(sheet: str, named: str, request) -> None:
    root = drawn(sheet, request.getfixturevalue(named))
    _, _, width, height = (float(n) for n in root.get("viewBox").split())
    boxes = text_boxes(root)
    assert len(boxes) > 8
    for content, (left, top, right, bottom) in boxes:
        assert left > 0.0, content
        assert top > 0.0, content
        assert right < width, content
        assert bottom < height, content
    for (one, a), (other, b) in combinations(boxes, 2):
        apart = a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
        assert apart, (one, other)


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("<&\"'>", "<&\"'>"),
        ("]]></text><script>alert(1)</script>", "]]></text><script>alert(1)</script>"),
        ("two\nlines\tand  spaces", "two lines and spaces"),
        ("bell \x07 and \x00 zero \ufffe", "bell \ufffd and \ufffd zero \ufffd"),
        ("凸轮 Nockenwelle 🎡", "凸轮 Nockenwelle 🎡"),
    ],
)
@pytest.mark.parametrize("sheet", SHEETS)
def test_any_name(sheet: str, name: str, shown: str, build) -> None:
    root = drawn(sheet, build(name=name))
    assert texts(root)[:1] == [shown] or shown in texts(root)
    assert text_of(root.find(SVG + "title")).endswith(shown)
    assert not list(root.iter(SVG + "script"))


@pytest.mark.parametrize("sheet", SHEETS)
def test_a_long_name_is_cut_and_told_in_full(sheet: str, crowd: Design) -> None:
    root = drawn(sheet, crowd)
    title = text_of(of_class(root, "text", "title")[0])
    assert title.endswith("…")
    assert crowd.name.startswith(title[:-1])
    assert text_of(root.find(SVG + "title")).endswith(crowd.name)


@pytest.mark.parametrize("sheet", SHEETS)
def test_a_cam_without_a_name_or_a_certificate(sheet: str, build) -> None:
    design = build(name="")
    certificate = design.certificate.model_copy(update={"certified": False})
    root = drawn(sheet, design.model_copy(update={"certificate": certificate}))
    assert text_of(of_class(root, "text", "title")[0]) == "Translating roller follower"
    assert "not certified" in texts(root)[1] + " ".join(texts(root))


# --- the cam -------------------------------------------------------------------------------------


def beside(point: np.ndarray, curve: np.ndarray) -> float:
    """Distance from a closely sampled curve, measured square to it."""
    nearest = int(np.hypot(*(curve - point).T).argmin())
    along = curve[(nearest + 1) % (len(curve) - 1)] - curve[nearest - 1]
    gap = point - curve[nearest]
    return abs(along[0] * gap[1] - along[1] * gap[0]) / math.hypot(*along)


def test_curves_of_the_cam(cam: Design, truth) -> None:
    root = drawn("profile", cam, points_per_degree=3.0)
    group = root.find(SVG + "g")
    assert re.fullmatch(r"translate\([\d.]+ [\d.]+\) scale\(1 -1\)", group.get("transform"))
    degrees = np.linspace(0.0, 360.0, 100001)
    for kind, curve in (("outline body", "profile"), ("line pitch", "pitch")):
        (path,) = of_class(group, "path", *kind.split())
        assert path.get("d").endswith("Z")
        found, right = path_points(path), truth(cam).points(degrees, curve)
        assert len(found) >= 1080
        for point in found[::7]:
            assert beside(point, right) < 1e-5
        area = 0.5 * np.sum(found[:, 0] * np.roll(found[:, 1], -1))
        area -= 0.5 * np.sum(found[:, 1] * np.roll(found[:, 0], -1))
        whole = 0.5 * np.sum(right[:-1, 0] * right[1:, 1] - right[:-1, 1] * right[1:, 0])
        assert area == pytest.approx(whole, rel=1e-4)
        assert (area < 0.0) == (cam.rotation == "ccw")  # run against the turning


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("offset", [13.7, -13.7, 0.0])
def test_figure_of_the_cam(rotation: str, offset: float, build) -> None:
    root = drawn("profile", build(rotation=rotation, offset=offset, prime=61.0, roller=9.0))
    sign = 1.0 if rotation == "ccw" else -1.0
    height = math.sqrt(61.0**2 - offset**2)
    roller = [c for c in of_class(root, "circle", "outline") if floats(c, "r") == [9.0]]
    assert floats(roller[0], "cx", "cy") == pytest.approx([sign * offset, height], abs=1e-4)
    assert floats(of_class(root, "circle", "line", "circle")[0], "cx", "cy", "r") == [0, 0, 52]
    assert floats(of_class(root, "circle", "line", "prime")[0], "cx", "cy", "r") == [0, 0, 61]
    upright = [
        line
        for line in of_class(root.find(SVG + "g"), "line", "centre")
        if line.get("x1") == line.get("x2")
    ]
    assert sorted(floats(line, "x1")[0] for line in upright) == pytest.approx(
        sorted({0.0, sign * offset})
    )
    assert ("13.7" in texts(root)) == (offset != 0.0)
    arc = next(p for p in of_class(root, "path", "line", "outline") if "A" in p.get("d"))
    x1, y1, _, _, _, large, sweep, x2, y2 = (float(n) for n in NUMBER.findall(arc.get("d")))
    assert (large, sweep) == (0.0, 1.0 if rotation == "ccw" else 0.0)
    assert (x1 * y2 - y1 * x2 > 0.0) == (rotation == "ccw")


def test_words_of_the_cam(p1: Design, crowd: Design) -> None:
    reported = texts(drawn("profile", p1))
    for line in (
        "profile, radius 50 to 78.849 mm",
        "base circle, radius 50 mm",
        "prime circle, radius 60 mm",
        "roller radius 10 mm",
        "stroke 30 mm",
        "cam angles run clockwise",
    ):
        assert line in reported
    assert {"60°", "90°", "150°", "rise", "return", "dwell"} <= set(reported)
    assert "knife edge" in texts(drawn("profile", crowd))


@pytest.mark.parametrize("scale", [0.013, 1.0, 310.0])
def test_the_scale_bar_and_the_sheet_grow_with_the_cam(scale: float, build) -> None:
    law = {"kind": "cycloidal"}
    program = [
        {"kind": "rise", "angle_deg": 150, "lift_mm": 20 * scale, "law": law},
        {"kind": "return", "angle_deg": 150, "lift_mm": 20 * scale, "law": law},
        {"kind": "dwell", "angle_deg": 60},
    ]
    sizes = {"offset": 7.0 * scale, "prime": 60.0 * scale, "roller": 10.0 * scale}
    root = drawn("profile", build(program, limits=[], **sizes))
    width = float(root.get("viewBox").split()[2])
    assert 140.0 * scale < width < 220.0 * scale
    bars = [line for line in of_class(root, "line", "outline") if line.get("y1") == line.get("y2")]
    x1, x2 = floats(bars[-1], "x1", "x2")
    label = next(t for t in texts(root) if " : " in t)
    assert float(label.partition(" mm")[0]) == pytest.approx(x2 - x1, rel=1e-3)
    assert 0.08 < (x2 - x1) / width < 0.25
    shown = float(root.get("width")[:-2])
    assert shown == pytest.approx(stated_scale(root) * width, rel=1e-4)
    assert stated_scale(root) == {0.013: 100.0, 1.0: 1.0, 310.0: 0.005}[scale]
    assert 120.0 < shown <= 300.0


@pytest.mark.parametrize(
    ("width", "scale"),
    [(110.0, 1.0), (420.0, 1.0), (109.9, 2.0), (61.0, 2.0), (60.0, 5.0), (2.31, 100.0),
     (420.1, 0.5), (600.0, 0.5), (601.0, 0.2), (7e4, 2e-3)],
)  # fmt: skip
def test_a_sheet_is_shown_at_true_size_or_at_a_round_scale(width: float, scale: float) -> None:
    assert shown_at(width) == pytest.approx(scale, rel=1e-12)


def stated_scale(root) -> float:
    """The scale that a drawing of a cam states beside its bar; diagrams have none."""
    stated = [t.rpartition("scale ")[2].split(" : ") for t in texts(root) if " : " in t]
    if not stated:
        return 1.0
    ((drawn_as, true),) = stated
    return float(drawn_as) / float(true)


# --- the motion ----------------------------------------------------------------------------------

UNITS = [("Displacement s", 0), ("Velocity v", 1), ("Acceleration a", 2), ("Jerk j", 3)]


RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


class Diagram:
    """One diagram read from the sheet: scales from its ticks, curves from its paths."""

    def __init__(self, root: ET.Element, title: str) -> None:
        heading = next(t for t in root.iter(SVG + "text") if text_of(t).startswith(title))
        tens = re.search(r"10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+) ", text_of(heading))
        power = (
            int(tens.group(1).translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))) if tens else 0
        )
        self.top = float(heading.get("y"))
        self.bottom = self.top + 46.0
        ticks = [
            (float(t.get("y")) - 0.9, float(text_of(t).replace("−", "-").replace("\u202f", "")))
            for t in self.inside(of_class(root, "text", "tick"), "y")
            if t.get("text-anchor") == "end"
        ]
        (y1, v1), (y2, v2) = ticks[0], ticks[-1]
        self.per_mm = (v2 - v1) / (y2 - y1) * 10.0**power
        assert self.per_mm < 0.0  # upwards
        self.zero = y1 - v1 * 10.0**power / self.per_mm
        degrees = {
            text_of(t): float(t.get("x"))
            for t in of_class(root, "text", "tick")
            if t.get("text-anchor") == "middle"
        }
        self.left, self.right = degrees["0"], degrees["360"]
        self.reported = next(
            t
            for t in root.iter(SVG + "text")
            if t.get("y") == heading.get("y") and t is not heading
        )
        paths = [p for p in of_class(root, "path", "line") if self.holds(path_points(p)[0, 1])]
        self.curves = [p for p in paths if "curve" in p.get("class")]
        self.broken = [p for p in paths if "broken" in p.get("class")]
        self.limits = self.inside(of_class(root, "line", "limit"), "y1")
        self.jumps = self.inside(of_class(root, "line", "jump"), "y1")

    def holds(self, y: float) -> bool:
        return self.top < y < self.bottom

    def inside(self, elements: list[ET.Element], name: str) -> list[ET.Element]:
        return [each for each in elements if self.holds(float(each.get(name)))]

    def read(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        degrees = (points[:, 0] - self.left) / (self.right - self.left) * 360.0
        return degrees, (points[:, 1] - self.zero) * self.per_mm


@pytest.mark.parametrize(("title", "order"), UNITS)
def test_curves_of_the_motion(title: str, order: int, cam: Design, truth) -> None:
    diagram = Diagram(drawn("motion", cam), title)
    peak = np.max(np.abs(truth(cam).motion(np.linspace(0.0, 360.0, 7201))[order]))
    omega = cam.speed_rpm * math.pi / 30.0
    ends = []
    for path in diagram.curves:
        degrees, values = diagram.read(path_points(path))
        side = np.zeros(len(degrees))
        side[0], side[-1] = 1, -1
        ends += [degrees[0], degrees[-1]]
        degrees = np.clip(degrees, 0.0, 360.0)
        # pixels are a micrometre: a border is meant where one is near
        for segment in cam.motion:
            degrees[np.abs(degrees - segment.start_deg) < 2e-3] = segment.start_deg
        right = truth(cam).motion(degrees[1:-1], side[1:-1])[order] * omega**order
        assert np.max(np.abs(values[1:-1] - right)) < 2e-3 * peak * omega**order
    assert min(ends) == pytest.approx(0.0, abs=1e-6)
    assert max(ends) == pytest.approx(360.0, abs=1e-6)


def test_jumps_are_drawn_as_jumps(p1: Design) -> None:
    root = drawn("motion", p1)
    assert [len(Diagram(root, title).curves) for title, _ in UNITS] == [1, 1, 1, 4]
    jerk = Diagram(root, "Jerk j")
    spans = [jerk.read(path_points(path))[0][[0, -1]] for path in jerk.curves]
    np.testing.assert_allclose(spans, [[0, 60], [60, 90], [90, 150], [150, 360]], atol=1e-2)
    assert len(jerk.jumps) == 3
    # 4π²h/β³ ω³ at the rise's end, and nothing in the dwell
    peak = 4.0 * math.pi**2 * 30.0 / (math.pi / 3.0) ** 3 * 1000.0
    values = [jerk.read(path_points(path))[1][[0, -1]] for path in jerk.curves]
    expected = [[peak, peak], [0, 0], [-peak, -peak], [0, 0]]
    np.testing.assert_allclose(values, expected, atol=2e-4 * peak)


def test_limits_and_where_they_are_broken(p1: Design) -> None:
    """P1 asks |v| ≤ 650, |a| ≤ 14 000, |j| ≤ 1.2e6; the peaks are 573, 17 189 and 1.03e6."""
    root = drawn("motion", p1)
    for title, limit, broken in [
        ("Velocity v", 650.0, 0),
        ("Acceleration a", 14000.0, 4),
        ("Jerk j", 1.2e6, 0),
    ]:
        diagram = Diagram(root, title)
        levels = sorted(
            (float(n.get("y1")) - diagram.zero) * diagram.per_mm for n in diagram.limits
        )
        assert levels == pytest.approx([-limit, limit], rel=1e-3)
        for line in diagram.limits:
            assert floats(line, "x1", "x2") == pytest.approx([diagram.left, diagram.right])
        assert len(diagram.broken) == broken
        assert diagram.reported.get("class") == ("alarm" if broken else "quiet")
    acceleration = Diagram(root, "Acceleration a")
    for path in acceleration.broken:
        degrees, values = acceleration.read(path_points(path))
        assert np.all(np.abs(values) > 14000.0 * (1 - 1e-3))
        # |sin 6θ| > 14 000/17 189 from 9.09° to 20.91° and so on
        assert np.ptp(degrees) == pytest.approx(11.8, abs=0.15)
    assert text_of(acceleration.reported) == "max 17.19 at 15° · min −17.19 at 45° · limit ±14"
    assert not Diagram(root, "Displacement s").limits


def test_a_limit_far_away_is_told_and_not_drawn(build) -> None:
    root = drawn("motion", build(limits=[{"kind": "velocity", "max_mm_per_s": 5e6}]))
    velocity = Diagram(root, "Velocity v")
    assert not velocity.limits
    assert text_of(velocity.reported).endswith("limit ±5\u202f000\u202f000")


def test_a_limit_that_is_just_reached_is_not_broken(build) -> None:
    peak = 2.0 * 30.0 / (math.pi / 3.0) * 10.0
    for factor, broken in [(1.0, False), (1.0 - 1e-6, True)]:
        limits = [{"kind": "velocity", "max_mm_per_s": peak * factor}]
        velocity = Diagram(drawn("motion", build(limits=limits)), "Velocity v")
        assert (velocity.reported.get("class") == "alarm") == broken


def test_a_window_of_one_value_is_one_limit(build) -> None:
    window = {"from_deg": 21.0, "to_deg": 33.0, "velocity_mm_per_s": 412.5}
    rise = {"kind": "rise", "angle_deg": 60, "lift_mm": 30, "law": {"kind": "spline"}}
    program = [{**rise, "windows": [window]}, *P1_PROGRAM[1:]]
    reported = Diagram(drawn("motion", build(program)), "Velocity v").reported
    assert "limit 412.5" in text_of(reported)


def test_the_level_of_a_dwell_has_no_residue(p1: Design) -> None:
    motion = [each.model_copy() for each in p1.motion]
    motion[-1] = motion[-1].model_copy(update={"s_start_mm": 7.1e-15, "s_end_mm": 7.1e-15})
    reported = texts(drawn("motion", p1.model_copy(update={"motion": motion})))
    assert "at 0 mm" in reported


def test_infinite_values_are_arrows(rough: Design) -> None:
    root = drawn("motion", rough)
    reported = {title: text_of(Diagram(root, title).reported) for title, _ in UNITS}
    assert reported["Acceleration a"] == "max ∞ at 250° · min −∞ at 120° · limit ±14000"
    assert reported["Jerk j"].startswith("max ∞ at 0° · min −∞ at 60°")
    assert Diagram(root, "Velocity v").reported.get("class") == "quiet"
    assert Diagram(root, "Acceleration a").reported.get("class") == "alarm"
    heads = of_class(root, "path", "alarm")
    assert len(heads) == 2 + 4
    assert len(Diagram(root, "Velocity v").curves) == 3


def test_words_of_the_motion(p1: Design) -> None:
    reported = texts(drawn("motion", p1))
    assert {"rise 30 mm", "cycloidal", "dwell 210°", "at 0 mm", "Cam angle, degrees"} <= set(
        reported
    )
    assert {"60°", "90°", "150°"} <= set(reported)
