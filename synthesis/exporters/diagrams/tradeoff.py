"""What a sweep trades for what, as SVG: the front among all its certified designs (mm).

A panel for every pair of quantities. With two of them a line shows what is not beaten: nothing was
found on its better side.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from synthesis.exporters.diagrams.plot import Frame, linear
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import two_lines
from synthesis.exporters.options import Theme
from synthesis.numerics.piecewise import Array
from synthesis.units import split_unit

PANEL, LEFT, RIGHT, HEADER, BELOW, GAP = (104.0, 80.0), 24.0, 8.0, 24.0, 12.0, 6.0  # mm
FOOTER = 12.0  # mm
CELL = 0.3  # [mm]: items nearer to each other are drawn as one
NAMED = 16  # on a front with more, items have no numbers
PAD = 0.06  # of the range, on either side


@dataclass(frozen=True)
class Aim:
    """A quantity, by its name on the wire, and whether it is to be large."""

    quantity: str
    maximise: bool

    @property
    def label(self) -> str:
        """Name, unit and which way is better."""
        name, unit = split_unit(self.quantity)
        label = ", ".join(filter(None, (name.replace("_", " "), svg.unit(unit))))
        return f"{label} ({'larger' if self.maximise else 'smaller'} is better)"


@dataclass(frozen=True, eq=False)
class TradeOff:
    """The certified designs of a sweep in the quantities that are traded.

    Attributes:
        name: of the sweep. aims: k quantities, at least two.
        numbers: (n,) of the items. values: (n, k) in the units of the quantities' names.
        front: indices of those that none of the others beats, and that differ noticeably.
        left_out: what else is finished, in words, and how many.
        edge: indices of all that none of the others beats: beyond them nothing was found.
    """

    name: str
    aims: Sequence[Aim]
    numbers: Sequence[int]
    values: Array
    front: NDArray[np.intp]
    left_out: Mapping[str, int]
    edge: NDArray[np.intp]


def trade_off(trade: TradeOff, theme: Theme = "auto") -> bytes:
    """The drawing."""
    pairs = list(combinations(range(len(trade.aims)), 2))
    columns = 1 if len(pairs) == 1 else 2
    step = LEFT + PANEL[0] + RIGHT, PANEL[1] + BELOW + GAP
    rows = -(-len(pairs) // columns)
    width, height = columns * step[0], HEADER + rows * step[1] + FOOTER
    body = _heading(trade, width)
    for k, (i, j) in enumerate(pairs):
        left = (k % columns) * step[0] + LEFT
        top = HEADER + (k // columns) * step[1]
        body += _panel(trade, (i, j), left, top, lined=len(pairs) == 1)
    body += _legend(height - 0.5 * FOOTER + 1.0, len(pairs) == 1)
    title = f"Trade-offs of {trade.name or 'a sweep'}"
    text = "Certified designs of a sweep; marked are those that no other beats in everything named."
    return svg.document(width, height, 1.0, title, text, body, theme=theme)


def _heading(trade: TradeOff, width: float) -> list[str]:
    """Name, and how many items are shown and not shown."""
    shown = f"{len(trade.numbers)} certified designs, {len(trade.front)} of them on the front"
    body = two_lines(trade.name.strip() or "Sweep", shown, 8.0, width - 8.0, 1.0)
    hidden = [f"{count} {why}" for why, count in trade.left_out.items() if count]
    if hidden:
        text = svg.shorten(f"not shown: {', '.join(hidden)}", width - 16.0, svg.LABEL)
        body.append(svg.text("quiet", 8.0, 17.4, text))
    return body


def _range(values: Array) -> tuple[float, float]:
    """The ends of an axis on which these values lie."""
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    wide = high - low if high - low > 1e-9 * max(abs(low), abs(high)) else abs(low) or 1.0
    return low - PAD * wide, high + PAD * wide


def _panel(
    trade: TradeOff, pair: tuple[int, int], left: float, top: float, lined: bool
) -> list[str]:
    """One quantity over another."""
    across, up = trade.values[:, pair].T
    frame = Frame(left, top, *PANEL, *_range(up), *_range(across))
    x, y = frame.x(across), frame.y(up)
    body = _axes(frame, [trade.aims[k].label for k in pair])
    rest = np.setdiff1d(np.arange(len(x)), trade.front)
    cells = np.unique(np.round(np.stack([x[rest], y[rest]], axis=1) / CELL), axis=0) * CELL
    body += [svg.circle("item", a, b, 0.75) for a, b in cells.tolist()]
    best = trade.front[np.argsort(x[trade.front], kind="stable")]
    if lined and len(best):
        edge = trade.edge[np.argsort(x[trade.edge], kind="stable")]
        body.append(svg.path("line curve", _stairs(trade, x[edge], y[edge])))
    body += [svg.path("mark", _diamond(a, b)) for a, b in zip(x[best], y[best], strict=True)]
    # numbers of the items on a small front; those that would overlap are left out
    free = -np.inf
    for k in best.tolist() if len(best) <= NAMED else []:
        text = str(trade.numbers[k])
        if x[k] + 2.0 >= free:
            body.append(svg.text("tick halo", x[k] + 2.0, y[k] - 1.4, text))
            free = x[k] + 2.6 + svg.width_of(text, svg.TICK)
    return body


def _axes(frame: Frame, names: Sequence[str]) -> list[str]:
    """Grid, numbers and names; a power of ten of the numbers stands before the unit."""
    left, right, top, low = frame.left, frame.right, frame.top, frame.bottom
    scales = linear(frame.start, frame.end), linear(frame.low, frame.high)
    body = []
    for value, text in scales[0].ticks:
        x = frame.x(value)
        body += [svg.line("grid", x, low, x, top), svg.text("tick", x, low + 4.0, text, "middle")]
    for value, text in scales[1].ticks:
        y = frame.y(value)
        body += [svg.line("grid", left, y, right, y),
                 svg.text("tick", left - 1.5, y + 0.9, text, "end")]  # fmt: skip
    body += [svg.line("axis", left, low, right, low), svg.line("axis", left, low, left, top)]
    x_name, y_name = (
        svg.shorten(name.replace(", ", f", {scale.factor}", 1), room, svg.LABEL)
        for name, scale, room in zip(names, scales, PANEL, strict=True)
    )
    body.append(svg.text("label", 0.5 * (left + right), low + 9.0, x_name, "middle"))
    place = f"translate({svg.num(left - 16.5)} {svg.num(0.5 * (low + top))}) rotate(-90)"
    return [*body, f'<g transform="{place}">{svg.text("label", 0.0, 0.0, y_name, "middle")}</g>']


def _stairs(trade: TradeOff, x: Array, y: Array) -> str:
    """Between two of the front nothing better is known than the worse of both in either."""
    corner_first = trade.aims[0].maximise  # from left to right: level, then the step; or the step
    # every place twice, one of the two coordinates a step behind the other
    across, up = np.repeat(x, 2), np.repeat(y, 2)
    return svg.steps(*((across[:-1], up[1:]) if corner_first else (across[1:], up[:-1])), 3)


def _diamond(x: float, y: float) -> str:
    xs, ys = np.array([x, x + 1.35, x, x - 1.35]), np.array([y - 1.6, y, y + 1.6, y])
    return svg.steps(xs, ys, 3, closed=True)


def _legend(y: float, lined: bool) -> list[str]:
    body = [
        svg.path("mark", _diamond(LEFT, y)),
        svg.text("label", LEFT + 4.0, y + 1.0, "on the front"),
        svg.circle("item", LEFT + 32.0, y, 0.75),
        svg.text("label", LEFT + 36.0, y + 1.0, "beaten"),
        svg.line("line curve", LEFT + 55.0, y, LEFT + 63.0, y),
        svg.text("label", LEFT + 66.0, y + 1.0, "nothing was found beyond"),
    ]
    return body if lined else body[:4]
