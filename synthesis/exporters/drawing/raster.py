"""A drawing as PNG: our own SVG read again and painted by matplotlib (extra ``plots``).

There is no second drawing: lines, colours and texts are those of the SVG, its style sheet included.
Only what our canvas writes is understood. Letters are those of DejaVu Sans, which comes along.
"""

from __future__ import annotations

import base64
import io
import math
import re
import threading
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from synthesis.design.design import Design
from synthesis.errors import ExtraMissing
from synthesis.exporters.drawing.canvas import PICTURE
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.options import PixelOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.path import Path
    from matplotlib.transforms import Affine2D

SVG = "{http://www.w3.org/2000/svg}"
DPI = 100.0  # pixels per inch of a PNG
POINTS = 72.0  # in an inch: the unit of a PDF
MM_PER_INCH = 25.4
TRUETYPE = 42  # matplotlib's number for fonts whose texts can be searched and copied
RULE = re.compile(r"\.camwright \.(\w+){([^}]*)}")
FACTOR = re.compile(r"(\w+)\(([^)]*)\)")
FACTORS = {"scale": "scale", "translate": "translate", "rotate": "rotate_deg"}  # of Affine2D
STEP = re.compile(r"([MLAZ])([^MLAZ]*)")
UNKNOWN = "\u25a1"  # for a letter that the font has not
FONT = "DejaVu Sans"
ANCHORS = {"start": 0.0, "middle": 0.5, "end": 1.0}
Look = Mapping[str, str]
ONE_AT_A_TIME = threading.Lock()  # matplotlib's fonts are shared


def rasterise(drawing: bytes, width_px: int) -> bytes:
    """The PNG of a drawing whose theme is not ``auto``; ExtraMissing without matplotlib."""
    _require("A PNG")
    root = ET.fromstring(drawing)
    with ONE_AT_A_TIME:
        figure = _painted(root, width_px / _size(root)[0], DPI)
        packed = io.BytesIO()
        figure.savefig(packed, format="png", dpi=DPI, metadata={"Software": None})
    return packed.getvalue()


def as_pdf(drawing: bytes, title: str) -> bytes:
    """A drawing whose theme is not ``auto`` as a PDF page of its true size, its texts as texts.

    The same drawing gives the same bytes. ExtraMissing without matplotlib.
    """
    _require("A PDF")
    import matplotlib as mpl

    root = ET.fromstring(drawing)
    facts = {"Title": title, "Creator": "Camwright", "Producer": None, "CreationDate": None}
    with ONE_AT_A_TIME, mpl.rc_context({"pdf.fonttype": TRUETYPE}):
        figure = _painted(root, POINTS / MM_PER_INCH, POINTS, texts=True)
        packed = io.BytesIO()
        figure.savefig(packed, format="pdf", metadata=facts)
    return packed.getvalue()


def _require(what: str) -> None:
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError as error:
        raise ExtraMissing(what, "plots") from error


def _painted(root: ET.Element, scale: float, dpi: float, texts: bool = False) -> Figure:
    """A drawing on a figure, ``scale`` pixels for a unit; ``texts``: as such, else as outlines."""
    from matplotlib.figure import Figure
    from matplotlib.transforms import Affine2D

    width, height = _size(root)
    height_px = round(height * scale) if not texts else height * scale
    figure = Figure(figsize=(width * scale / dpi, height_px / dpi), dpi=dpi)
    _paint_all(
        figure, root, Affine2D().scale(scale, -scale).translate(0.0, height_px), scale, texts
    )
    return figure


def _size(root: ET.Element) -> tuple[float, float]:
    _, _, width, height = (float(n) for n in root.get("viewBox", "").split())
    return width, height


def _paint_all(
    figure: Figure, root: ET.Element, place: Affine2D, scale: float, texts: bool
) -> None:
    """Paint a drawing, and those inside it, each with the style of its own."""
    from matplotlib.transforms import Affine2D

    looks = _looks(root)
    for element, where in _elements(root, place):
        if element.tag == f"{SVG}image":
            inner = ET.fromstring(base64.b64decode(element.get("href", "").removeprefix(PICTURE)))
            x, y, width = (float(element.get(name, 0.0)) for name in ("x", "y", "width"))
            by = width / _size(inner)[0]
            own = Affine2D().scale(by).translate(x, y)
            within = Affine2D(where.get_matrix() @ own.get_matrix())
            _paint_all(figure, inner, within, scale * by, texts)
        elif texts and element.tag == f"{SVG}text":
            _write(figure, element, where, looks, scale)
        else:
            _paint(figure, element, where, looks, scale)


def _write(
    figure: Figure, element: ET.Element, where: Affine2D, looks: Mapping[str, Look], scale: float
) -> None:
    """A line of text as text."""
    look = _look_of(element, looks)
    at = where.transform((float(element.get("x", 0.0)), float(element.get("y", 0.0))))
    width, height = figure.get_size_inches() * figure.dpi
    size = float(look["font-size"].removesuffix("px")) * scale * POINTS / figure.dpi
    anchor = {"start": "left", "middle": "center", "end": "right"}
    figure.text(
        at[0] / width, at[1] / height, (element.text or "").replace("$", r"\$"),
        family=FONT, fontsize=size,
        weight="bold" if look.get("font-weight") == "600" else "normal",
        color=look.get("fill", "#000000"), va="baseline",
        ha=anchor[element.get("text-anchor", "start")],
    )  # fmt: skip


def _look_of(element: ET.Element, looks: Mapping[str, Look]) -> dict[str, str]:
    """Properties of an element, by its classes in their order."""
    look: dict[str, str] = {}
    for name in element.get("class", "").split():
        look |= looks.get(name, {})
    return look


def painted(name: str, drawing: Exporter[Any]) -> Exporter[PixelOptions]:
    """A drawing's format as pixels, for where vectors are not taken."""

    def write(design: Design, options: PixelOptions) -> bytes:
        return rasterise(drawing.write_like(design, options), options.width_px)

    return Exporter(
        f"{name}.png", f"{drawing.title}, pixels", "image/png", ".png", write, PixelOptions,
        "Needs the optional part plots; without it the answer is 501.", by_default=False,
        in_worker=True,
    )  # fmt: skip


def _looks(root: ET.Element) -> dict[str, dict[str, str]]:
    """Properties by class, later rules over earlier ones."""
    looks: dict[str, dict[str, str]] = {}
    for name, body in RULE.findall(root.findtext(f"{SVG}style", "")):
        pairs = (each.partition(":") for each in body.split(";") if each)
        looks.setdefault(name, {}).update({key: value for key, _, value in pairs})
    return looks


def _elements(root: ET.Element, place: Affine2D) -> Iterator[tuple[ET.Element, Affine2D]]:
    """Every element in the order of painting, with what takes its coordinates to pixels."""
    from matplotlib.transforms import Affine2D

    for element in root:
        own = Affine2D()
        for name, numbers in reversed(FACTOR.findall(element.get("transform", ""))):
            getattr(own, FACTORS[name])(*map(float, numbers.split()))
        where = Affine2D(place.get_matrix() @ own.get_matrix())
        yield element, where
        yield from _elements(element, where)


def _paint(
    figure: Figure, element: ET.Element, where: Affine2D, looks: Mapping[str, Look], scale: float
) -> None:
    from matplotlib.patches import PathPatch

    look = _look_of(element, looks)
    shape = _shape(element, look)
    if shape is None:
        return
    filled = look.get("fill", "none" if element.tag == f"{SVG}line" else "#000000")
    stroke, width = look.get("stroke", "none"), float(look.get("stroke-width", 0.0))
    points = POINTS / figure.dpi * scale
    dashes = [points * float(n) for n in look.get("stroke-dasharray", "").split()]
    common: dict[str, Any] = {"transform": where, "linewidth": points * width,
                              "joinstyle": "round", "capstyle": "butt",
                              "linestyle": (0.0, dashes) if dashes else "solid"}  # fmt: skip
    layers = []
    if filled != "none":
        opacity = float(look.get("fill-opacity", 1.0))
        fill = {"facecolor": filled, "edgecolor": "none", "alpha": opacity}
        layers.append(PathPatch(shape, transform=where, **fill))
    if stroke != "none":
        layers.append(PathPatch(shape, facecolor="none", edgecolor=stroke, **common))
    if element.tag == f"{SVG}text":  # a halo lies under its letters
        layers.reverse()
    for layer in layers:
        figure.add_artist(layer)


def _shape(element: ET.Element, look: Look) -> Path | None:
    """The outline of an element; None of what is not painted."""
    from matplotlib.path import Path
    from matplotlib.transforms import Affine2D

    def numbers(*names: str) -> list[float]:
        return [float(element.get(name, 0.0)) for name in names]

    tag = element.tag.removeprefix(SVG)
    if tag == "line":
        x1, y1, x2, y2 = numbers("x1", "y1", "x2", "y2")
        return Path([(x1, y1), (x2, y2)])
    if tag == "rect":
        x, y, width, height = numbers("x", "y", "width", "height")
        return Path.unit_rectangle().transformed(Affine2D().scale(width, height).translate(x, y))
    if tag == "circle":
        x, y, radius = numbers("cx", "cy", "r")
        return Path.circle((x, y), radius)
    if tag == "path":
        return _path(element.get("d", ""))
    return _letters(element, look) if tag == "text" else None


def _path(steps: str) -> Path:
    """Lines and arcs of circles that are less than half a turn, or half a turn."""
    from matplotlib.path import Path

    vertices: list[tuple[float, float]] = []
    codes: list[Any] = []
    code = {"M": Path.MOVETO, "L": Path.LINETO, "A": Path.LINETO, "Z": Path.CLOSEPOLY}
    for kind, body in STEP.findall(steps):
        *form, x, y = map(float, body.split()) if body else vertices[-1]
        places = [(x, y)]
        if kind == "A":
            places = _arc(vertices[-1], (x, y), form[0], form[4] > 0.0)
        vertices += places
        codes += [code[kind]] * len(places)
    return Path(vertices, codes)


def _arc(
    start: tuple[float, float], end: tuple[float, float], radius: float, sweep: bool
) -> list[tuple[float, float]]:
    """Points after the first on the shorter arc, which turns from x to y if ``sweep``."""
    (x1, y1), (x2, y2), sign = start, end, 1.0 if sweep else -1.0
    half = 0.5 * math.hypot(x2 - x1, y2 - y1)
    away = math.sqrt(max(radius * radius - half * half, 0.0)) / (2.0 * half)
    x, y = 0.5 * (x1 + x2) - sign * away * (y2 - y1), 0.5 * (y1 + y2) + sign * away * (x2 - x1)
    first = math.atan2(y1 - y, x1 - x)
    turn = 2.0 * math.asin(min(half / radius, 1.0))
    count = max(2, math.ceil(turn / math.radians(3.0)))
    angles = [first + sign * turn * k / count for k in range(1, count + 1)]
    return [(x + radius * math.cos(t), y + radius * math.sin(t)) for t in angles]


def _letters(element: ET.Element, look: Look) -> Path | None:
    """One line of text as outlines."""
    from matplotlib.font_manager import FontProperties, findfont, get_font
    from matplotlib.textpath import TextPath
    from matplotlib.transforms import Affine2D

    bold = "bold" if look.get("font-weight") == "600" else "normal"
    properties = FontProperties(family=FONT, weight=bold)
    font = get_font(findfont(properties))
    text = "".join(c if font.get_char_index(ord(c)) else UNKNOWN for c in element.text or "")
    size = float(look["font-size"].removesuffix("px"))
    outlines = TextPath((0.0, 0.0), text.replace("$", r"\$"), size=size, prop=properties)
    if not len(outlines.vertices):
        return None
    # Curves as lines: far quicker than exact extents.
    width = float(np.max(np.asarray(outlines.cleaned().vertices)[:, 0]))
    x = float(element.get("x", 0.0)) - ANCHORS[element.get("text-anchor", "start")] * width
    upright = Affine2D().scale(1.0, -1.0).translate(x, float(element.get("y", 0.0)))
    return outlines.transformed(upright)
