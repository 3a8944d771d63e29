"""Diagrams of the benchmarks: curves over two logarithmic axes, drawn with the core's own canvas.

Series differ by colour, by mark and by line, so that they are distinguished in print as well; the
style follows a dark screen. The same figures give the same bytes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, floor, isfinite, log10

import numpy as np

from benchmarks.axis import Axis
from synthesis.exporters.drawing import canvas as svg

WIDTH, LEFT, RIGHT, TOP, HEIGHT = 160.0, 25.0, 9.0, 14.0, 84.0
BELOW, ROW = 15.0, 4.8  # from the plot to the legend, and of its rows
COLUMN = 0.5 * (WIDTH - LEFT - RIGHT)  # of the legend
EDGE = 5.5  # of title and name of the ordinate to the sheet's left edge
SAMPLE = 9.0  # length of a line in the legend
MARK = 1.15  # half the width of a mark
APART = 0.15  # decades that stay free beyond the outermost points
SERIES = (  # light, dark, dashes
    ("#0b57a4", "#82bbf5", ""),
    ("#b34700", "#f5a65b", "3.2 1.2"),
    ("#00695c", "#5fd0ae", "1.2 1"),
    ("#8a2f8f", "#dd9fe2", "5 1.2 1.2 1.2"),
    ("#6b5900", "#d9c65a", "2 2"),
    ("#565e68", "#a4adb8", "0.6 1"),
)


@dataclass(frozen=True)
class Point:
    """One measurement; ``low`` and ``high`` are the quartiles of x, ``label`` stands beside it."""

    x: float
    y: float
    low: float | None = None
    high: float | None = None
    label: str = ""


@dataclass(frozen=True)
class Series:
    """Points that are joined by a line."""

    name: str
    points: Sequence[Point]


@dataclass(frozen=True)
class Diagram:
    """Curves over two axes.

    Attributes:
        name: of its file, without the ending. title: shown above it.
        description: what it shows, for those who do not see it.
        x, y: axes. series: at most as many as there are colours.
    """

    name: str
    title: str
    description: str
    x: Axis
    y: Axis
    series: Sequence[Series]

    def markdown(self) -> str:
        return f"![{self.title}. {self.description}]({self.name}.svg)"

    def files(self) -> Mapping[str, bytes]:
        return {f"{self.name}.svg": self.svg()}

    def svg(self) -> bytes:
        """The drawing."""
        frame = _Frame.of(self)
        foot = TOP + HEIGHT + BELOW
        body = [
            f"<style>{_style()}</style>",
            svg.text("title", EDGE, 7.5, svg.shorten(self.title, WIDTH - 2.0 * EDGE, svg.TITLE)),
            *frame.grid(),
            *(line for k, one in enumerate(self.series) for line in frame.drawn(k, one)),
            *_legend(self.series, foot),
        ]
        height = foot + ROW * _rows(self.series) + 2.0
        return svg.document(WIDTH, height, 1.0, self.title, self.description, body)


@dataclass(frozen=True)
class _Frame:
    """Where the axes lie: logarithms to base 10 of the values at the plot's edges."""

    x: Axis
    y: Axis
    left: float
    right: float
    bottom: float
    top: float

    @classmethod
    def of(cls, diagram: Diagram) -> _Frame:
        points = [point for one in diagram.series for point in one.points]
        across = [v for p in points for v in (p.x, p.low or p.x, p.high or p.x)]
        left, right = _range(diagram.x, across)
        bottom, top = _range(diagram.y, [p.y for p in points])
        return cls(diagram.x, diagram.y, left, right, bottom, top)

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Where on the sheet [mm]; what is below the axis' least value lies on its edge."""
        across = (log10(max(x, 10.0**self.left)) - self.left) / (self.right - self.left)
        up = (log10(max(y, 10.0**self.bottom)) - self.bottom) / (self.top - self.bottom)
        return LEFT + across * (WIDTH - LEFT - RIGHT), TOP + (1.0 - up) * HEIGHT

    def grid(self) -> list[str]:
        """Lines, numbers and names of both axes."""
        low, high = TOP + HEIGHT, WIDTH - RIGHT
        body = []
        for value in _ticks(self.left, self.right):
            at, _ = self.at(value, 1.0)
            body.append(svg.line("grid", at, TOP, at, low))
            body.append(svg.text("tick", at, low + 4.2, self.x.number(value), "middle"))
        for value in _ticks(self.bottom, self.top):
            _, at = self.at(1.0, value)
            body.append(svg.line("grid", LEFT, at, high, at))
            body.append(svg.text("tick", LEFT - 1.5, at + 0.9, self.y.number(value), "end"))
        body += [svg.line("axis", LEFT, low, high, low), svg.line("axis", LEFT, TOP, LEFT, low)]
        body.append(svg.text("label", 0.5 * (LEFT + high), low + 9.5, self.x.name, "middle"))
        middle = svg.num(TOP + 0.5 * HEIGHT)
        turned = svg.text("label", 0.0, 0.0, self.y.name, "middle")
        return [*body, f'<g transform="translate({EDGE} {middle}) rotate(-90)">{turned}</g>']

    def drawn(self, k: int, series: Series) -> list[str]:
        """Line, spreads, marks and labels of one series."""
        places = np.array([self.at(p.x, p.y) for p in series.points])
        body = []
        if len(places) > 1:
            body.append(svg.path(f"line s{k}", svg.steps(places[:, 0], places[:, 1], 3)))
        for point, (x, y) in zip(series.points, places.tolist(), strict=True):
            if point.low is not None and point.high is not None:
                ends = self.at(point.low, point.y)[0], self.at(point.high, point.y)[0]
                body.append(svg.line(f"spread s{k}", ends[0], y, ends[1], y))
            body.append(_mark(k, x, y))
            if point.label:
                body.append(svg.text("tick", x + 1.8, y - 1.4, point.label))
        return body


def _range(axis: Axis, values: Sequence[float]) -> tuple[float, float]:
    """Logarithms of the axis' ends: around all values, but not below its least one."""
    shown = [v for v in values if isfinite(v) and v > (axis.least or 0.0)]
    low = log10(min(shown)) - APART if shown else 0.0
    high = log10(max(shown)) + APART if shown else 1.0
    if axis.least is not None and len(shown) < len(values):
        low = log10(axis.least)
    return low, high


def _ticks(low: float, high: float) -> list[float]:
    """Round numbers between two powers of ten: of tens alone where that is enough."""
    every = max(1, ceil((high - low) / 9.0))
    tens = [10.0**k for k in range(ceil(low), floor(high) + 1) if k % every == 0]
    if len(tens) >= 3:
        return tens
    factors = (1.0, 2.0, 5.0) if high - low > 0.5 else (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0)
    spots = [f * 10.0**k for k in range(floor(low), ceil(high) + 1) for f in factors]
    return [v for v in spots if low <= log10(v) <= high]


def _mark(k: int, x: float, y: float) -> str:
    """Circle, square, triangle, diamond, triangle upside down, cross."""
    m = MARK
    corners = (
        [],
        [(-m, -m), (m, -m), (m, m), (-m, m)],
        [(0.0, -1.2 * m), (1.1 * m, m), (-1.1 * m, m)],
        [(0.0, -1.4 * m), (1.2 * m, 0.0), (0.0, 1.4 * m), (-1.2 * m, 0.0)],
        [(0.0, 1.2 * m), (1.1 * m, -m), (-1.1 * m, -m)],
        [(-m, -m), (m, m), (0.0, 0.0), (m, -m), (-m, m), (0.0, 0.0)],
    )[k]
    if not corners:
        return svg.circle(f"mark s{k}", x, y, MARK)
    points = np.array(corners) + np.array((x, y))
    return svg.path(f"mark s{k}", svg.steps(points[:, 0], points[:, 1], 3, closed=True))


def _rows(series: Sequence[Series]) -> int:
    """Rows of the legend."""
    widest = max(svg.width_of(one.name, svg.LABEL) for one in series)
    return ceil(len(series) / 2) if SAMPLE + 4.0 + widest <= COLUMN else len(series)


def _legend(series: Sequence[Series], top: float) -> list[str]:
    """In two columns if the names are short."""
    body, rows = [], _rows(series)
    for k, one in enumerate(series):
        x = LEFT + (k // rows) * COLUMN
        y = top + (k % rows) * ROW
        body.append(svg.line(f"line s{k}", x, y, x + SAMPLE, y))
        body.append(_mark(k, x + 0.5 * SAMPLE, y))
        body.append(svg.text("label", x + SAMPLE + 2.0, y + 1.0, one.name))
    return body


def _style() -> str:
    """Colours and lines of the series, in both themes."""
    light = [
        ".camwright .line{stroke-width:.45}.camwright .mark{stroke-width:.25;stroke-dasharray:none}"
    ]
    light.append(".camwright .spread{stroke-width:.9;stroke-opacity:.35;stroke-dasharray:none}")
    dark = []
    for k, (day, night, dashes) in enumerate(SERIES):
        dashed = f".camwright .line.s{k}{{stroke-dasharray:{dashes}}}" if dashes else ""
        light.append(f".camwright .s{k}{{stroke:{day}}}.camwright .mark.s{k}{{fill:{day}}}{dashed}")
        dark.append(f".camwright .s{k}{{stroke:{night}}}.camwright .mark.s{k}{{fill:{night}}}")
    return "".join(light) + f"@media screen and (prefers-color-scheme:dark){{{''.join(dark)}}}"
