"""SVG by hand: elements, numbers, text that fits, ticks, and one style for all drawings.

The style has colours, lines and letters for a screen, a dark screen and print. It has no ids and no
CSS variables, so that drawings can stand side by side in one page and plain viewers show them as
well as browsers do. Kinds of lines differ in width and pattern too, never in colour alone. Lengths
are multiples of a sheet's unit u.
"""

from __future__ import annotations

import base64
import math
import re
import tomllib
from collections.abc import Sequence
from typing import NamedTuple
from unicodedata import east_asian_width
from xml.sax.saxutils import escape

from synthesis.design.design import Design
from synthesis.exporters.exporter import asset
from synthesis.exporters.options import Theme
from synthesis.numerics.piecewise import Array

NARROW = frozenset("ijlftr.,:;'|!()[]· \u202f")
SPACE = re.compile(r"[^\S\u202f]+")
EXPONENT = re.compile(r"e\+?(-?)0*")
FROM_MM, TO_MM, SHOWN_MM = 110.0, 420.0, 300.0  # widths of sheets: see ``shown_at``
NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
PICTURE = "data:image/svg+xml;base64,"  # how the address of a drawing inside another begins
TURNS = {"ccw": "counter-clockwise", "cw": "clockwise"}

GROUPED = 1e9  # from here on a number has an exponent: nobody counts so many groups
TITLE, LABEL, TICK = 4.4, 2.9, 2.6  # heights of letters, in u
BOLD = 1.15  # how much wider bold letters are
SIZES = {"title": TITLE, "label": LABEL, "quiet": LABEL, "tick": TICK, "alarm": LABEL}
_STYLE = tomllib.loads(asset("style.toml"))
# Kinds of areas and letters: colour on a light screen, on a dark one, in print.
FILLS: dict[str, list[str]] = _STYLE["fills"]
# Kinds of lines: the same, width and dashes in u.
STROKES: dict[str, tuple[str, str, str, float, str]] = _STYLE["strokes"]
COLUMN: dict[Theme, int] = {"auto": 0, "light": 0, "dark": 1, "print": 2}


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
    text = asset("drawing.svg").format(
        shown_width=num(scale * width), shown_height=num(scale * height), width=num(width),
        height=num(height), title=plain(title), description=plain(description),
        style=style(u, theme) + rules, body="\n".join(body),
    )  # fmt: skip
    return text.encode()


def plain(text: str) -> str:
    """Any text as XML character data on one line; what XML cannot hold is shown as U+FFFD."""
    return escape(SPACE.sub(" ", NOT_XML.sub("\ufffd", text)).strip())


def figure(value: float, digits: int = 4) -> str:
    """A number for people: so many significant digits, groups of three, a true minus sign."""
    rounded = float(f"{value:.{digits}g}") + 0.0
    if abs(rounded) >= GROUPED:
        text = f"{rounded:.{digits}g}"
    else:
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
    text = SPACE.sub(" ", text).strip()
    if width_of(text, size) <= width:
        return text
    while text and width_of(text + "…", size) > width:
        text = text[:-1]
    return text.rstrip() + "…"


class Sheet(NamedTuple):
    """A drawing with its size, in units of its coordinates."""

    data: bytes
    width: float
    height: float


def picture(sheet: Sheet, x: float, y: float, width: float, height: float, content: str) -> str:
    """A drawing as large as fits into a box, in its middle; ``content``: for those who see none."""
    scale = min(width / sheet.width, height / sheet.height)
    across, down = scale * sheet.width, scale * sheet.height
    place = (
        f'x="{num(x + 0.5 * (width - across))}" y="{num(y + 0.5 * (height - down))}" '
        f'width="{num(across)}" height="{num(down)}"'
    )
    data = base64.b64encode(sheet.data).decode()
    title = f"<title>{plain(content)}</title>"
    return f'<image {place} href="{PICTURE}{data}">{title}</image>'


def wrapped(content: str, width: float, size: float) -> list[str]:
    """A text in lines that fit; a word that is too long for one is cut."""
    lines, words = [""], content.split()
    for word in words:
        longer = f"{lines[-1]} {word}".strip()
        if width_of(longer, size) <= width:
            lines[-1] = longer
        else:
            lines.append(shorten(word, width, size))
    return [each for each in lines if each]


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


def spaced_texts(
    at: Sequence[float], texts: Sequence[str], y: float, gap: float, end: float = math.inf
) -> list[str]:
    """Small texts above rising abscissae, those left out that would overlap or pass ``end``."""
    body, free = [], -math.inf
    for x, each in zip(at, texts, strict=True):
        half = 0.5 * width_of(each, TICK)
        if x - half >= free and x + half + gap <= end:
            body.append(text("tick", x, y, each, "middle"))
            free = x + half + gap
    return body


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


def style(u: float, theme: Theme = "auto") -> str:
    """The style sheet for a sheet whose unit is ``u`` mm; ``auto`` is dark only on a screen."""
    sheet = [_STYLE["letters"]]
    sheet += [f".camwright .{name}{{font-size:{num(k * u)}px}}" for name, k in SIZES.items()]
    sheet += [_STYLE["bold"], *_colours(COLUMN[theme]), *line_rules(u), _STYLE["shapes"]]
    if theme == "auto":
        dark = "".join(_colours(COLUMN["dark"]))
        sheet.append(f"@media screen and (prefers-color-scheme:dark){{{dark}}}")
    return "".join(sheet)


def line_rules(u: float, within: str = ".camwright") -> list[str]:
    """Rules for widths and dashes of all kinds of lines, of a unit of ``u`` mm."""
    rules = []
    for name, (*_, width, pattern) in STROKES.items():
        dashes = " ".join(num(float(k) * u) for k in pattern.split())
        dashed = f";stroke-dasharray:{dashes}" if dashes else ""
        rules.append(f"{within} .{name}{{stroke-width:{num(width * u)}{dashed}}}")
    return rules


def _colours(column: int) -> list[str]:
    rules = [f".camwright .{name}{{fill:{fill[column]}}}" for name, fill in FILLS.items()]
    strokes = ((name, kind[:3][column]) for name, kind in STROKES.items())
    return rules + [f".camwright .{name}{{stroke:{colour}}}" for name, colour in strokes]


def num(value: float, decimals: int = 4) -> str:
    """A coordinate without trailing zeros."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def heading(design: Design, left: float, right: float, u: float) -> list[str]:
    """Two lines between two abscissae, cut where they do not fit."""
    name = design.name.strip() or _kind(design).capitalize()
    return two_lines(name, about(design), left, right, u)


def about(design: Design) -> str:
    """What the numbers of a drawing belong to."""
    return (
        f"{_kind(design)} · cam turns {TURNS[design.rotation]} at "
        f"{figure(design.speed_rpm, 6)} rpm · "
        f"{'certified' if design.certificate.certified else 'not certified'} · {design.id[:8]}"
    )


def stroke(design: Design) -> str:
    """How far the follower moves, with its unit."""
    levels = [end for segment in design.motion for end in segment.levels]
    return with_unit(max(levels) - min(levels), design.spec.follower.travel.unit)


def _kind(design: Design) -> str:
    return f"{design.follower.replace('_', ' ')} follower"


def two_lines(name: str, about: str, left: float, right: float, u: float) -> list[str]:
    """A name and a line about it between two abscissae, cut where they do not fit."""
    width = right - left
    return [
        text("title", left, 8.0 * u, shorten(name, width, BOLD * TITLE * u)),
        text("quiet", left, 13.0 * u, shorten(about, width, LABEL * u)),
    ]


def shown_at(width: float) -> float:
    """How many times its true size a sheet [mm] is shown: 1 where that can be read.

    Otherwise the largest round number at which it is no wider than ``SHOWN_MM``.
    """
    if FROM_MM <= width <= TO_MM:
        return 1.0
    return _round_number(SHOWN_MM / width)


def _round_number(most: float) -> float:
    """The largest of 1, 2, 5, 10, … that is no larger, but for rounding."""
    power = 10.0 ** math.floor(math.log10(most))
    return max(k * power for k in (1.0, 2.0, 5.0) if k * power <= most * (1.0 + 1e-9))


def ratio(scale: float) -> str:
    """A scale as on a technical drawing (ISO 5455)."""
    enlarged, reduced = figure(max(scale, 1.0)), figure(max(1.0 / scale, 1.0))
    return f"{enlarged} : {reduced}"


def scale_bar(x: float, y: float, u: float, drawn: str) -> list[str]:
    """A bar of round length, at most 32 units long, and the sheet's scale."""
    length = _round_number(32.0 * u)
    mid, end = x + 0.5 * length, x + length
    body = [line("line outline", x, y + 2.0 * u, end, y + 2.0 * u)]
    body += [line("line outline", a, y + 1.2 * u, a, y + 2.8 * u) for a in (x, mid, end)]
    label = f"{figure(length)} mm, scale {drawn}"
    return [*body, text("tick", end + 1.6 * u, y + 2.9 * u, label)]
