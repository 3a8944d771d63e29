"""SVG by hand: elements, numbers, text that fits, ticks, and one style for all drawings.

No ids and no CSS variables, so that drawings can stand side by side in one page and plain viewers
show them as well as browsers do. Lengths in the style are multiples of a sheet's unit u.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from unicodedata import east_asian_width
from xml.sax.saxutils import escape

from synthesis.numerics.piecewise import Array

FONT = "'Helvetica Neue',Helvetica,Arial,'Liberation Sans','DejaVu Sans',sans-serif"
TITLE, LABEL, TICK = 4.4, 2.9, 2.6  # heights of letters, in u
NARROW = frozenset("ijlftr.,:;'|!()[]· \u202f")
SPACE = re.compile(r"[^\S\u202f]+")
NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

# class: (light, dark)
FILLS = {
    "ground": ("#ffffff", "#15191e"),
    "title": ("#14181d", "#f0f3f6"),
    "label": ("#14181d", "#f0f3f6"),
    "quiet": ("#565e68", "#a4adb8"),
    "tick": ("#565e68", "#a4adb8"),
    "alarm": ("#b3261e", "#ff8f85"),
    "body": ("#0b57a4", "#82bbf5"),
    "metal": ("#ffffff", "#15191e"),
    "rest": ("#f1f3f5", "#1d2228"),
    "solid": ("#14181d", "#f0f3f6"),
    "start": ("#0b57a4", "#82bbf5"),
    "several": ("#cfe0f0", "#24405c"),
}
STROKES = {
    "outline": ("#14181d", "#f0f3f6", 0.5, ""),
    "curve": ("#0b57a4", "#82bbf5", 0.5, ""),
    "pitch": ("#0b57a4", "#82bbf5", 0.3, ""),
    "circle": ("#565e68", "#a4adb8", 0.25, "1.6 1"),
    "prime": ("#565e68", "#a4adb8", 0.25, "4 1.2"),
    "axis": ("#565e68", "#a4adb8", 0.2, ""),
    "centre": ("#8a939d", "#78828d", 0.15, "5 1 1 1"),
    "grid": ("#dde2e7", "#2b323a", 0.15, ""),
    "border": ("#8a939d", "#78828d", 0.2, ""),
    "jump": ("#0b57a4", "#82bbf5", 0.2, "0.6 0.6"),
    "phase": ("#0b57a4", "#82bbf5", 0.3, "1.6 0.8"),
    "limit": ("#b3261e", "#ff8f85", 0.3, "2.4 1.2"),
    "broken": ("#b3261e", "#ff8f85", 1.1, ""),
    "halo": ("#ffffff", "#15191e", 1.2, ""),
    "inner": ("#ebf2f8", "#202831", 1.2, ""),
}


def style(u: float) -> str:
    """The style sheet for a sheet whose unit is ``u`` mm; dark only on a dark screen."""
    light = [f".camwright text{{font-family:{FONT};font-variant-numeric:tabular-nums}}"]
    sizes = {"title": TITLE, "label": LABEL, "quiet": LABEL, "tick": TICK, "alarm": LABEL}
    light += [f".camwright .{name}{{font-size:{num(k * u)}px}}" for name, k in sizes.items()]
    light.append(".camwright .title{font-weight:600}")
    light += [f".camwright .{name}{{fill:{fill[0]}}}" for name, fill in FILLS.items()]
    dark = [f".camwright .{name}{{fill:{fill[1]}}}" for name, fill in FILLS.items()]
    for name, (day, night, width, pattern) in STROKES.items():
        dashes = " ".join(num(float(k) * u) for k in pattern.split())
        dashed = f";stroke-dasharray:{dashes}" if dashes else ""
        light.append(f".camwright .{name}{{stroke:{day};stroke-width:{num(width * u)}{dashed}}}")
        dark.append(f".camwright .{name}{{stroke:{night}}}")
    light.append(".camwright path{stroke-linejoin:round;stroke-linecap:round}")
    light.append(".camwright .line{fill:none}.camwright .body{fill-opacity:.08}")
    light.append(".camwright text{paint-order:stroke;stroke-linejoin:round}")
    return "".join(light) + f"@media screen and (prefers-color-scheme:dark){{{''.join(dark)}}}"


def document(
    width: float,
    height: float,
    u: float,
    title: str,
    description: str,
    body: Sequence[str],
    scale: float = 1.0,
) -> bytes:
    """A sheet of the given size [mm], shown ``scale`` times as large; coordinates stay as they are.

    The origin is its upper left corner.
    """
    w, h = num(width), num(height)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" class="camwright" role="img" '
        f'width="{num(scale * width)}mm" height="{num(scale * height)}mm" '
        f'viewBox="0 0 {w} {h}">',
        f"<title>{plain(title)}</title>",
        f"<desc>{plain(description)}</desc>",
        f"<style>{style(u)}</style>",
        f'<rect class="ground" width="{w}" height="{h}"/>',
        *body,
        "</svg>",
    ]
    return ("\n".join(lines) + "\n").encode()


def plain(text: str) -> str:
    """Any text as XML character data on one line; what XML cannot hold is shown as U+FFFD."""
    return escape(SPACE.sub(" ", NOT_XML.sub("\ufffd", text)).strip())


def num(value: float, decimals: int = 4) -> str:
    """A coordinate without trailing zeros."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def figure(value: float, digits: int = 4) -> str:
    """A number for people: so many significant digits, groups of three, a true minus sign."""
    rounded = float(f"{value:.{digits}g}") + 0.0
    text = f"{rounded:,.12g}" if abs(rounded) >= 1e5 else f"{rounded:.12g}"
    return text.replace(",", "\u202f").replace("inf", "∞").replace("e+", "e").replace("-", "−")


def unit(name: str) -> str:
    """A unit as a drawing writes it."""
    return name.replace("deg", "°")


def measured(value: float, name: str, digits: int = 6) -> str:
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


def fitting(texts: Sequence[str], width: float, size: float) -> str:
    """The first text that fits, or nothing."""
    return next((text for text in texts if width_of(text, size) <= width), "")


def shortened(text: str, width: float, size: float) -> str:
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
