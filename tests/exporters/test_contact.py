"""Pressure angle and profile radius, read back from the drawing; themes and hatching."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from typing import get_args

import numpy as np
import pytest

from synthesis.catalogue.followers.base import paths
from synthesis.design.design import Design
from synthesis.exporters import MOTION_FORMATS, PICTURES, PROFILE_FORMATS, PictureOptions
from synthesis.exporters.diagrams.plot import linear, radii
from synthesis.exporters.options import Theme
from synthesis.exporters.samples.cam import Cam
from tests.catalogue.followers.samples import CASES
from tests.exporters.test_drawings import (
    SVG,
    Diagram,
    floats,
    of_class,
    path_points,
    text_boxes,
    text_of,
    texts,
)
from tests.exporters.test_mechanism import drawn_cam

SHEETS = (
    PROFILE_FORMATS["svg"],
    MOTION_FORMATS["svg"],
    PICTURES["contact.svg"],
    PICTURES["animation.svg"],
)
SCENES = pytest.mark.parametrize("exporter", SHEETS, ids=lambda v: v.title)


def sheet(design: Design, **options: str) -> ET.Element:
    return ET.fromstring(PICTURES["contact.svg"].write(design, PictureOptions(**options)))


class Radius:
    """The radius diagram: its axis is even in 1/(ρ + D)."""

    def __init__(self, root: ET.Element, title: str, distance: float) -> None:
        heading = next(t for t in root.iter(SVG + "text") if text_of(t).startswith(title))
        top = float(heading.get("y"))
        reported = [(float(t.get("y")) - 0.9, text_of(t).replace("−", "-"))
                for t in of_class(root, "text", "tick")
                if t.get("text-anchor") == "end" and 0 < float(t.get("y")) - top < 47]  # fmt: skip
        reported = [(y, word) for y, word in reported if word != "undercut"]
        assert len(reported) >= 4
        y = np.array([each for each, _ in reported])
        bend = np.array(
            [0.0 if word == "∞" else 1.0 / (float(word) + distance) for _, word in reported]
        )
        self.slope, self.zero = np.polyfit(y, bend, 1)
        assert np.max(np.abs(self.slope * y + self.zero - bend)) < 2e-4 * np.max(np.abs(bend))
        assert self.slope < 0.0
        runs = [path_points(p) for p in of_class(root, "path", "line", "curve")]
        runs = [run for run in runs if top < run[0, 1] < top + 47]
        self.x, self.y = np.concatenate(runs).T
        self.distance = distance

    def bends(self) -> np.ndarray:
        return self.slope * self.y + self.zero


def test_the_curves_are_the_books(cam: Design, truth) -> None:
    root, roller = sheet(cam), cam.dimensions["roller_radius_mm"]
    pressure = Diagram(root, "Pressure angle α")
    book = truth(cam)
    for path in pressure.curves:
        degrees, angle = pressure.read(path_points(path))
        inner = slice(1, -1)
        want = book.curves(degrees[inner])["pressure_angle"]
        assert np.max(np.abs(angle[inner] - want)) < 0.05
    drawn = Radius(root, "Profile radius ρ", roller)
    degrees = np.interp(drawn.x, [pressure.left, pressure.right], [0.0, 360.0])
    want = book.curves(degrees)["curvature"]
    smooth = (
        np.min(
            np.abs(degrees[:, None] - np.array([s.start_deg for s in cam.motion] + [360.0])), axis=1
        )
        > 0.3
    )
    assert np.count_nonzero(smooth) > 600
    assert np.max(np.abs(drawn.bends() - want)[smooth]) < 4e-3 * np.max(np.abs(want))


@pytest.mark.parametrize(("kind", "sample"), CASES, ids=lambda v: str(v))
def test_every_flank_and_path_has_its_diagram(kind: str, sample: int) -> None:
    design = drawn_cam(kind, sample)
    root, cam = sheet(design), Cam.of(design)
    reported = texts(root)
    flanks = [flank.name for flank in cam.follower.flanks]
    assert len([t for t in reported if t.startswith("Profile radius ρ")]) == len(flanks)
    assert len([t for t in reported if t.startswith("Pressure angle α")]) == len(
        paths(cam.follower)
    )
    for one in cam.flanks():
        if one.follower.always_convex:
            continue
        named = " ".join(filter(None, ("Profile radius ρ", one.flank.name)))
        drawn = Radius(root, f"{named},", one.flank.distance)
        at = cam.at(np.linspace(0.0, 2.0 * np.pi, 3601)) if one is cam else one.at(
            np.linspace(0.0, 2.0 * np.pi, 3601))  # fmt: skip
        bend = 1.0 / (at.radius + one.flank.distance)
        assert drawn.bends().max() == pytest.approx(bend.max(), rel=5e-3, abs=1e-4)
        assert drawn.bends().min() == pytest.approx(bend.min(), rel=5e-3, abs=1e-4)


@pytest.mark.parametrize(
    ("kind", "sample"), [("translating_roller", 4), ("oscillating_flat_face", 1)]
)
def test_texts_do_not_overlap(kind: str, sample: int) -> None:
    root = sheet(drawn_cam(kind, sample))
    boxes = text_boxes(root)
    for k, (a, (left, low, right, high)) in enumerate(boxes):
        for b, (x0, y0, x1, y1) in boxes[k + 1 :]:
            apart = right <= x0 or x1 <= left or high <= y0 or y1 <= low
            assert apart, f"{a!r} overlaps {b!r}"


def test_limits_are_drawn_and_what_breaks_them_is_hatched(build) -> None:
    limits = [
        {"kind": "pressure_angle", "rise_deg": 20, "return_deg": 60},
        {"kind": "profile_radius", "min_mm": 13.5},
        {"kind": "cutter_radius", "radius_mm": 90},
    ]
    design = build(limits=limits)
    root = sheet(design)
    pressure = Diagram(root, "Pressure angle α")
    levels = sorted({round(float(pressure.read(np.array([floats(line, "x1", "y1")]))[1][0]), 2)
                     for line in pressure.limits})  # fmt: skip
    assert levels == pytest.approx([-60.0, -20.0, 20.0, 60.0], abs=0.02)
    assert len(pressure.broken) == 1
    degrees, angle = pressure.read(path_points(pressure.broken[0]))
    assert np.all(angle > 20.0 - 1e-2)
    assert 0.0 < degrees.min() < degrees.max() < 60.0
    hatched = pressure.inside(of_class(root, "line", "hatch"), "y1")
    assert len(hatched) >= 3
    for line in hatched:
        (x1, y1), (x2, y2) = floats(line, "x1", "y1"), floats(line, "x2", "y2")
        assert x1 == x2
        foot = float(pressure.read(np.array([[x2, y2]]))[1][0])
        assert foot == pytest.approx(20.0, abs=0.02)
        assert float(pressure.read(np.array([[x1, y1]]))[1][0]) > foot
    words = " ".join(texts(root))
    assert "limit 13.5" in words
    assert "limit −90" in words


def test_an_undercut_profile_stands_on_its_ground(build) -> None:
    root = sheet(build(prime=45.0, roller=33.0, offset=0.0))
    assert of_class(root, "rect", "undercut")
    reported = next(t for t in texts(root) if t.startswith("convex −"))
    assert float(reported.split()[1].replace("−", "-")) < 0.0
    assert not of_class(sheet(build()), "rect", "undercut")


def test_a_corner_is_infinitely_sharp(build) -> None:
    law = {"kind": "constant_velocity"}
    program = [{"kind": "rise", "angle_deg": 120, "lift_mm": 25, "law": law},
               {"kind": "return", "angle_deg": 130, "lift_mm": 25, "law": law},
               {"kind": "dwell", "angle_deg": 110}]  # fmt: skip
    root = sheet(build(program, limits=[], roller=0.0))
    heads = of_class(root, "path", "solid")
    assert len(heads) == 3
    ups = [path_points(head)[0, 1] < path_points(head)[1, 1] for head in heads]
    # hollow where the lift begins and ends, a peak between
    assert ups == [False, True, False]
    assert any("convex 0 at 120°" in each for each in texts(root))


@pytest.mark.parametrize("distance", [0.0, 8.6])
@pytest.mark.parametrize(("low", "high"), [(-0.08, 0.09), (0.0, 3.0), (-2e-4, 1e-3), (-40.0, 60.0)])
def test_numbers_of_a_radius_axis(distance: float, low: float, high: float) -> None:
    labels = radii(distance)(low, high)
    bends = [bend for bend, _ in labels.ticks]
    assert len(set(bends)) == len(bends) >= 3
    assert 0.0 in bends
    for bend, reported in labels.ticks:
        assert low <= bend <= high
        if bend:
            assert float(reported.replace("−", "-").replace("\u202f", "")) == pytest.approx(
                1.0 / bend - distance, rel=1e-4, abs=1e-9
            )
    if distance and low < 1.0 / distance < high:
        assert labels.format(1.0 / distance) == "0"


def test_numbers_of_an_even_axis() -> None:
    labels = linear(-2.4e5, 1.1e6)
    assert labels.factor == "10³ " or labels.factor == "10⁶ "
    assert [reported for value, reported in labels.ticks if value == 0.0] == ["0"]


# --- themes --------------------------------------------------------------------------------------


@SCENES
@pytest.mark.parametrize("theme", get_args(Theme))
def test_every_theme_has_its_own_ground(exporter, theme: str, p1: Design) -> None:
    root = ET.fromstring(exporter.write(p1, exporter.options(theme=theme)))
    style = root.find(SVG + "style").text
    assert ("prefers-color-scheme:dark" in style) == (theme == "auto")
    ground = re.search(r"\.ground{fill:(#\w+)}", style).group(1)
    assert ground == ("#15191e" if theme == "dark" else "#ffffff")
    if theme == "print":
        for colour in re.findall(r"#(\w{6})\b", style):
            assert colour[:2] == colour[2:4] == colour[4:], colour


def test_lines_differ_without_colour(p1: Design) -> None:
    style = sheet(p1, theme="print").find(SVG + "style").text
    seen = {}
    for kind in ("curve", "limit", "broken", "jump", "hatch", "normal", "front"):
        rule = re.search(rf"\.{kind}{{(stroke-width:[^}}]*)}}", style).group(1)
        assert rule not in seen, (kind, seen[rule])
        seen[rule] = kind
