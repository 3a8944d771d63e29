"""SVG by hand: elements, numbers, text that fits, ticks."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from unicodedata import east_asian_width
from xml.sax.saxutils import escape

from synthesis.exporters.drawing.theme import LABEL, TICK, TITLE, num, style
from synthesis.exporters.options import Theme
from synthesis.numerics.piecewise import Array

__all__ = ["LABEL", "TICK", "TITLE", "num"]

NARROW = frozenset("ijlftr.,:;'|!()[]· \u202f")
SPACE = re.compile(r"[^\S\u202f]+")
EXPONENT = re.compile(r"e\+?(-?)0*")
NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def document(
    width: float,
    height: float,
    u: float,
    title: str,
    description: str,
    body: Sequence[str],
    scale: float = 1.0,
    theme: Theme = "auto",
    rules: str = "",
) -> bytes:
    """A sheet of the given size [mm], shown ``scale`` times as large; coordinates stay as they are.

    The origin is its upper left corner. ``rules`` are added to the style.
    """
    w, h = num(width), num(height)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" class="camwright" role="img" '
        f'width="{num(scale * width)}mm" height="{num(scale * height)}mm" '
        f'viewBox="0 0 {w} {h}">',
        f"<title>{plain(title)}</title>",
        f"<desc>{plain(description)}</desc>",
        f"<style>{style(u, theme)}{rules}</style>",
        f'<rect class="ground" width="{w}" height="{h}"/>',
        *body,
        "</svg>",
    ]
    return ("\n".join(lines) + "\n").encode()


def plain(text: str) -> str:
    """Any text as XML character data on one line; what XML cannot hold is shown as U+FFFD."""
    return escape(SPACE.sub(" ", NOT_XML.sub("\ufffd", text)).strip())


def figure(value: float, digits: int = 4) -> str:
    """A number for people: so many significant digits, groups of three, a true minus sign."""
    rounded = float(f"{value:.{digits}g}") + 0.0
    text = f"{rounded:,.12g}" if abs(rounded) >= 1e5 else f"{rounded:.12g}"
    text = EXPONENT.sub(r"e\1", text)
    return text.replace(",", "\u202f").replace("inf", "∞").replace("-", "−")


def unit(name: str) -> str:
    """A unit as a drawing writes it."""
    return name.replace("deg", "°")


def with_unit(value: float, name: str, digits: int = 6) -> str:
    """A value with its unit: 30 mm, 45°."""
    return f"{figure(value, digits)}{'' if name == 'deg' else ' '}{unit(name)}"


def width_of(text: str, size: float) -> float:
    """Width that a text needs at most; of the usual fonts DejaVu Sans is the widest."""
    return size * sum(_width(char) for char in text)


def _width(char: str) -> float:
    if char in NARROW:
        return 0.42
    if east_asian_width(char) in "WF":
        return 1.05
    return 0.86 if char.isupper() or char in "mw—…" else 0.64


def first_fitting(texts: Sequence[str], width: float, size: float) -> str:
    """The first text that fits, or nothing."""
    return next((text for text in texts if width_of(text, size) <= width), "")


def shorten(text: str, width: float, size: float) -> str:
    """The text, cut with an ellipsis if it does not fit."""
    text = " ".join(text.split())
    if width_of(text, size) <= width:
        return text
    while text and width_of(text + "…", size) > width:
        text = text[:-1]
    return text.rstrip() + "…"


def line(kind: str, x1: float, y1: float, x2: float, y2: float) -> str:
    """A straight line."""
    return f'<line class="{kind}" x1="{num(x1)}" y1="{num(y1)}" x2="{num(x2)}" y2="{num(y2)}"/>'


def circle(kind: str, x: float, y: float, radius: float) -> str:
    """A circle."""
    return f'<circle class="{kind}" cx="{num(x)}" cy="{num(y)}" r="{num(radius)}"/>'


def box(kind: str, x: float, y: float, width: float, height: float) -> str:
    """A rectangle."""
    place = f'x="{num(x)}" y="{num(y)}" width="{num(width)}" height="{num(height)}"'
    return f'<rect class="{kind}" {place}/>'


def path(kind: str, steps: str) -> str:
    """A path."""
    return f'<path class="{kind}" d="{steps}"/>'


def text(kind: str, x: float, y: float, content: str, anchor: str = "start") -> str:
    """One line of text; y is its baseline."""
    where = f'x="{num(x)}" y="{num(y)}" text-anchor="{anchor}"'
    return f'<text class="{kind}" {where}>{plain(content)}</text>'


def steps(x: Array, y: Array, decimals: int = 4, closed: bool = False) -> str:
    """Path data through the points."""
    row = f"%.{decimals}f %.{decimals}f"
    points = [row % point for point in zip(x.tolist(), y.tolist(), strict=True)]
    return "M" + "L".join(points) + ("Z" if closed else "")


def arrow_head(kind: str, x: float, y: float, angle: float, size: float) -> str:
    """A filled arrow head with its tip at (x, y), pointing along ``angle`` [rad, y down]."""
    turned = [angle + turn for turn in (math.pi - 0.3, math.pi + 0.3)]
    corners = [(x, y), *((x + size * math.cos(t), y + size * math.sin(t)) for t in turned)]
    return path(kind, "M" + "L".join(f"{num(a)} {num(b)}" for a, b in corners) + "Z")


def ticks(low: float, high: float, most: int) -> list[float]:
    """At most ``most`` + 1 round numbers between two ends, evenly spaced."""
    rough = (high - low) / most
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(k * power for k in (1.0, 2.0, 2.5, 5.0, 10.0) if k * power >= rough * (1 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [k * step for k in range(first, last + 1)]
