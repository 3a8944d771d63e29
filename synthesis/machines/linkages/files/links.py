"""Shapes of rigid links for drawings with y upwards: bars, pins, bearings, slides."""

from __future__ import annotations

from collections.abc import Sequence

from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures.parts import Box, Point

ACROSS = 92.0  # units from side to side of a machine


def bar(length: float, half: float) -> list[str]:
    """A bar along x from one pin to the other, round at its ends."""
    x, y = svg.num(length), svg.num(half)
    steps = f"M0 {y}H{x}A{y} {y} 0 0 0 {x} -{y}H0A{y} {y} 0 0 0 0 {y}Z"
    return [
        svg.path("outline rest", steps),
        pin(0.0, 0.0, 0.45 * half),
        pin(length, 0.0, 0.45 * half),
    ]


def pin(x: float, y: float, radius: float) -> str:
    """A pin."""
    return svg.circle("outline metal", x, y, radius)


def bearing(x: float, y: float, u: float) -> list[str]:
    """A pivot on the ground."""
    foot = [(x, y), (x - 3.0 * u, y - 4.6 * u), (x + 3.0 * u, y - 4.6 * u)]
    steps = "L".join(f"{svg.num(a)} {svg.num(b)}" for a, b in foot)
    return [
        svg.path("outline rest", f"M{steps}Z"),
        *hatched(x - 4.0 * u, x + 4.0 * u, y - 4.6 * u, u),
    ]


def hatched(left: float, right: float, y: float, u: float) -> list[str]:
    """Ground below a level."""
    count = max(1, round((right - left) / (1.6 * u)))
    at = [left + (right - left) * k / count for k in range(count + 1)]
    return [svg.line("line border", left, y, right, y),
            *(svg.line("line border", x, y, x - 1.2 * u, y - 1.4 * u) for x in at[1:])]  # fmt: skip


def block(width: float, height: float) -> list[str]:
    """A block about its middle."""
    return [svg.box("outline metal", -0.5 * width, -0.5 * height, width, height),
            pin(0.0, 0.0, 0.2 * height)]  # fmt: skip


def unit_and_extent(points: Sequence[Point], margin: float) -> tuple[float, Box]:
    """Unit of line widths and symbols of a machine, and its bounding box with a margin of these."""
    xs, ys = zip(*points, strict=True)
    u = max(max(xs) - min(xs), max(ys) - min(ys)) / ACROSS
    edge = margin * u
    return u, (min(xs) - edge, min(ys) - edge, max(xs) + edge, max(ys) + edge)
