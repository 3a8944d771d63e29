"""Trade-offs of a sweep, read back from the drawing."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from synthesis.exporters.diagrams.tradeoff import Aim, TradeOff, trade_off
from synthesis.exporters.options import Theme
from synthesis.studies.sweeps.pareto import non_dominated
from tests.exporters.test_drawings import SVG, floats, of_class, path_points, text_boxes, texts

AIMS = (Aim("base_radius_mm", False), Aim("peak_jerk_mm_per_s3", False), Aim("arm_deg", True))
LEFT_OUT = {"infeasible": 12, "failed": 0, "without one of these": 3}


def drawn(values: np.ndarray, aims: tuple[Aim, ...], theme: Theme = "auto") -> ET.Element:
    signs = np.array([-1.0 if aim.maximise else 1.0 for aim in aims])
    front = non_dominated(values * signs)
    found = TradeOff("a < b", aims, range(100, 100 + len(values)), values, front, LEFT_OUT, front)
    return ET.fromstring(trade_off(found, theme))


def cloud(count: int, seed: int = 7) -> np.ndarray:
    random = np.random.default_rng(seed)
    size = random.uniform(17.3, 61.9, count)
    jerk = 3.1e6 / np.sqrt(size - 11.0) * random.uniform(1.0, 1.7, count)
    return np.stack([size, jerk, random.uniform(-3.0, 8.0, count)], axis=1)


def axis(root: ET.Element, anchor: str, name: str) -> np.ndarray:
    """Slope and start of values over places, from the numbers at an axis."""
    found = [(float(t.get(name)), float("".join(t.itertext()).replace("−", "-")))
             for t in of_class(root, "text", "tick")
             if t.get("text-anchor") == anchor and "halo" not in t.get("class")]  # fmt: skip
    places, values = np.array(found).T
    slope, start = np.polyfit(places, values, 1)
    assert np.max(np.abs(slope * places + start - values)) < 1e-3 * np.ptp(values)
    return np.array([slope, start])


@pytest.mark.parametrize("maximise", [(False, False), (True, False), (False, True), (True, True)])
def test_the_front_is_where_its_numbers_are(maximise: tuple[bool, bool]) -> None:
    values = cloud(60)[:, :2] / np.array([1.0, 1e6])
    aims = (Aim("base_radius_mm", maximise[0]), Aim("torque_n", maximise[1]))
    root = drawn(values, aims)
    across, up = axis(root, "middle", "x"), axis(root, "end", "y")
    up = up + np.array([0.0, 0.9 * up[0]])  # baselines stand below their line
    signs = np.array([-1.0 if each else 1.0 for each in maximise])
    costs = values * signs
    best = [k for k, row in enumerate(costs)
            if not np.any(np.all(costs <= row, axis=1) & np.any(costs < row, axis=1))]  # fmt: skip
    middles = np.array([path_points(each).mean(axis=0)
                        for each in of_class(root, "path", "mark")][:-1])  # fmt: skip
    shown = np.stack([np.polyval(across, middles[:, 0]), np.polyval(up, middles[:, 1])], axis=1)
    assert sorted(map(tuple, np.round(shown, 1))) == sorted(map(tuple, np.round(values[best], 1)))
    assert len(of_class(root, "circle", "item")) == len(values) - len(best) + 1
    # no item lies on the better side of the line
    (line,) = of_class(root, "path", "curve")
    corners = path_points(line)
    corners = np.stack([np.polyval(across, corners[:, 0]), np.polyval(up, corners[:, 1])], axis=1)
    for corner in corners * signs:
        beats = np.all(costs < corner - 1e-3 * np.ptp(costs, axis=0), axis=1)
        assert not beats.any()
        reached = np.all(costs < corner + 1e-3 * np.ptp(costs, axis=0), axis=1)
        assert reached.any()


def test_three_quantities_make_three_panels() -> None:
    root = drawn(cloud(50), AIMS)
    reported = texts(root)
    assert reported.count("base radius, mm (smaller is better)") == 2
    assert reported.count("peak jerk, 10⁶ mm/s³ (smaller is better)") == 2
    assert reported.count("arm, ° (larger is better)") == 2
    assert not of_class(root, "path", "line", "curve")
    assert "not shown: 12 infeasible, 3 without one of these" in reported
    assert "a < b" in reported


@pytest.mark.parametrize("count", [1, 12])
def test_texts_neither_overlap_nor_leave_the_sheet(count: int) -> None:
    root = drawn(cloud(count)[:, :2], AIMS[:2])
    _, _, width, height = (float(n) for n in root.get("viewBox").split())
    turned = [each for each in root if each.tag == SVG + "g"]
    for each in turned:
        root.remove(each)
    boxes = text_boxes(root)
    for k, (a, (left, low, right, high)) in enumerate(boxes):
        assert 0.0 < left < right < width, a
        assert 0.0 < low < high < height, a
        for b, (x0, y0, x1, y1) in boxes[k + 1 :]:
            apart = right <= x0 or x1 <= left or high <= y0 or y1 <= low
            assert apart, f"{a!r} overlaps {b!r}"
    assert "100" in texts(root)


def test_nothing_certified_is_an_empty_sheet() -> None:
    root = drawn(np.zeros((0, 2)), AIMS[:2])
    assert "0 certified designs, 0 of them on the front" in texts(root)
    assert len(of_class(root, "path", "mark")) == 1


def test_many_items_make_no_large_file() -> None:
    values = cloud(40_000)[:, :2]
    root = drawn(values, AIMS[:2])
    items = of_class(root, "circle", "item")
    assert 5_000 < len(items) < 30_000
    places = np.array([floats(each, "cx", "cy") for each in items[:-1]])
    assert len(np.unique(places, axis=0)) == len(places)


def test_print_is_black_on_white() -> None:
    style = drawn(cloud(9)[:, :2], AIMS[:2], "print").find(SVG + "style").text
    assert "prefers-color-scheme" not in style
