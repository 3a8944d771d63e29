"""PNG: the pixels are where the drawing's own numbers say, in its own colours."""

from __future__ import annotations

import io
import math
import re
import sys
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from synthesis.errors import ExtraMissing, InputError
from synthesis.exporters import DRAWINGS, PICTURES
from synthesis.exporters.drawing.raster import rasterise
from tests.exporters.test_drawings import NUMBER, SVG, floats, of_class, path_points

WIDTH = 1100


def pixels(content: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGB"), dtype=int)


def darkest(picture: np.ndarray, x: float, y: float) -> int:
    """Within a pixel of a place [px]."""
    i, j = round(y), round(x)
    return int(picture[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2].sum(axis=2).min())


@pytest.mark.parametrize("theme", ["light", "dark", "print"])
def test_the_motion_is_where_the_drawing_has_it(theme: str, unspecial) -> None:
    drawing = DRAWINGS["motion.svg"]
    root = ET.fromstring(drawing.write(unspecial, drawing.options(theme=theme)))
    motion = PICTURES["motion.png"]
    picture = pixels(motion.write(unspecial, motion.options(theme=theme, width_px=WIDTH)))
    _, _, width, height = (float(n) for n in root.get("viewBox").split())
    scale = WIDTH / width
    assert picture.shape == (round(height * scale), WIDTH, 3)
    style = root.find(SVG + "style").text
    ground, line = (
        tuple(int(found[k : k + 2], 16) for k in (0, 2, 4))
        for found in (re.search(rule, style).group(1)
                      for rule in (r"\.ground{fill:#(\w{6})", r"\.curve{stroke:#(\w{6})"))
    )  # fmt: skip
    assert tuple(picture[3, 3]) == ground
    curves = [path_points(each) * scale for each in of_class(root, "path", "curve")]
    points = np.concatenate([each for each in curves if len(each) > 30])[::7]
    assert len(points) > 300
    near = [
        np.abs(picture[round(y) - 1 : round(y) + 2, round(x) - 1 : round(x) + 2] - np.array(line))
        .sum(axis=2)
        .min()
        for x, y in points
    ]
    assert np.mean(np.array(near) < 60) > 0.99


def test_arcs_circles_and_letters_are_painted(p1) -> None:
    drawing = DRAWINGS["profile.svg"]
    content = drawing.write(p1, drawing.options(theme="light"))
    root = ET.fromstring(content)
    picture = pixels(rasterise(content, WIDTH))
    _, _, width, _ = (float(n) for n in root.get("viewBox").split())
    scale = WIDTH / width
    shift = floats_of(root.find(SVG + "g").get("transform"))[:2]

    def seen(x: float, y: float) -> int:
        return darkest(picture, scale * (shift[0] + x), scale * (shift[1] - y))

    blank = seen(-55.0, 55.0)
    assert blank == 3 * 255
    arc = next(p for p in of_class(root, "path", "line", "outline") if "A" in p.get("d"))
    x1, y1, radius, *_ = (float(n) for n in NUMBER.findall(arc.get("d")))
    start = math.atan2(y1, x1)
    on = [seen(radius * math.cos(start + t), radius * math.sin(start + t))
          for t in np.linspace(0.05, 1.5, 40)]  # fmt: skip
    assert max(on) < 350
    off = [seen(radius * math.cos(start - t), radius * math.sin(start - t)) for t in (0.3, 1.0)]
    assert min(off) > 600
    (roller,) = [c for c in of_class(root, "circle", "outline") if floats(c, "r") == [10.0]]
    x, y = floats(roller, "cx", "cy")
    assert max(seen(x + 10 * math.cos(t), y + 10 * math.sin(t)) for t in range(20)) < 350
    title = of_class(root, "text", "title")[0]
    x, y = (scale * n for n in floats(title, "x", "y"))
    letters = picture[round(y - 3 * scale) : round(y), round(x) : round(x + 20 * scale)]
    assert 0.1 < np.mean(letters.sum(axis=2) < 300) < 0.6


def floats_of(text: str) -> list[float]:
    return [float(n) for n in NUMBER.findall(text)]


def test_same_pixels_and_any_name(build) -> None:
    exporter = PICTURES["contact.png"]
    options = exporter.options(width_px=300)
    first, again = (exporter.write(build(name="凸轮 $x^2$ <b>"), options) for _ in range(2))
    assert first == again
    assert first.startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("options", "said"),
    [({"theme": "auto"}, "light, dark, print"), ({"width_px": 0}, "at least 200"),
     ({"width_px": 10**9}, "at most 6000")],
)  # fmt: skip
def test_pixels_that_make_no_sense(options: dict, said: str) -> None:
    with pytest.raises(InputError, match=said):
        PICTURES["contact.png"].options(**options)


def test_without_matplotlib_it_says_how(monkeypatch: pytest.MonkeyPatch, p1) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    exporter = PICTURES["motion.png"]
    with pytest.raises(ExtraMissing, match=r"pip install 'camwright\[plots\]'"):
        exporter.write(p1, exporter.options())
