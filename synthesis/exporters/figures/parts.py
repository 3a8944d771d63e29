"""Parts that the cam's drawing and the machine in motion have in common; points are x + i y."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from synthesis.catalogue.followers.kinematics import Flank
from synthesis.catalogue.profile import CamProfile
from synthesis.exporters.drawing import canvas as svg

STEM, HUB = 15.0, 1.1  # a stem's length and the shaft's radius, in units of the sheet
PIVOT = 0.25  # radius of a pivot's eye, of the stem's length
RIM = 0.6  # of the roller: wall that is drawn where none was asked for
NEAR = (5.0, 2000.0)  # sizes of machines that are drawn in their mm

Box = tuple[float, float, float, float]  # left, bottom, right, top
Flanks = tuple[tuple[Flank, CamProfile], ...]


def rim_of(flanks: Flanks) -> float:
    """Radius of the material around flanks that are touched from inside [mm]; 0 without any."""
    around = [
        float(np.hypot(curve.x, curve.y).max()) + (flank.rim or RIM * flank.distance)
        for flank, curve in flanks
        if flank.side < 0
    ]
    return max(around, default=0.0)


def outline(flanks: Flanks, rotation: float, decimals: int) -> str:
    """The first cam as an area: its profile, or a rim, less what an outer flank leaves open."""
    first, rim, steps = flanks[0][0], rim_of(flanks), ""
    for flank, curve in flanks:
        if flank.path == first.path:  # holes run the other way round
            x, y = curve.x[:: flank.side], curve.y[:: flank.side]
            steps += svg.steps(x, y, decimals, closed=True)
    if rim > 0.0:
        r, sweep = svg.num(rim), int(rotation < 0.0)
        steps += f"M{r} 0A{r} {r} 0 0 {sweep} -{r} 0A{r} {r} 0 0 {sweep} {r} 0Z"
    return svg.path("outline body", steps)


def pitch_curve(curve: CamProfile, decimals: int) -> str:
    """The path of a roller's centre."""
    return svg.path("line pitch", svg.steps(curve.pitch_x, curve.pitch_y, decimals, closed=True))


def profile_curve(curve: CamProfile, decimals: int) -> str:
    """The profile of a second cam on the shaft."""
    return svg.path("line curve", svg.steps(curve.x, curve.y, decimals, closed=True))


def bar(centre: complex, pivot: complex, roller: float, u: float) -> list[str]:
    """The two edges of an arm, from a roller's rim to the eye at the pivot."""
    length, half, eye = abs(pivot - centre), half_width(roller, u), PIVOT * STEM * u
    foot = math.sqrt(max(roller**2 - half**2, 0.0))
    end = length - math.sqrt(max(eye**2 - half**2, 0.0))
    up = (pivot - centre) / length
    return edges(centre, up, (foot, end), half)


def edges(origin: complex, up: complex, along: tuple[float, float], half: float) -> list[str]:
    """Both edges of a stem or an arm: from and to so far along a direction, so far aside."""
    foot, end = along
    return [
        polygon("line outline", origin, up, [(end, side), (foot, side)], closed=False)
        for side in (-half, half)
    ]


def eye(pivot: complex, u: float) -> list[str]:
    """What turns about a pivot, and the pin in it."""
    return [circle("outline metal", pivot, radius) for radius in (PIVOT * STEM * u, HUB * u)]


def half_width(roller: float, u: float) -> float:
    """Half the width of a stem or an arm [mm]."""
    return min(max(0.3 * roller, 1.2 * u), 2.5 * u, 0.8 * roller or math.inf)


def polygon(
    kind: str,
    origin: complex,
    up: complex,
    corners: Sequence[tuple[float, float]],
    closed: bool = True,
) -> str:
    """A line through corners, so far along a direction and across it to the right of an origin."""
    points = (place(origin + complex(along, -across) * up) for along, across in corners)
    return svg.path(kind, f"M{'L'.join(points)}{'Z' if closed else ''}")


def place(point: complex, decimals: int = 4) -> str:
    """A point as a path or a shift has it."""
    return f"{svg.num(point.real, decimals)} {svg.num(point.imag, decimals)}"


def line(kind: str, start: complex, end: complex) -> str:
    """A straight line."""
    return svg.line(kind, start.real, start.imag, end.real, end.imag)


def circle(kind: str, centre: complex, radius: float) -> str:
    """A circle."""
    return svg.circle(kind, centre.real, centre.imag, radius)


def box_around(points: Iterable[complex], edge: float = 0.0) -> Box:
    """The smallest box with all points, and an edge around them."""
    xs, ys = zip(*((point.real, point.imag) for point in points), strict=True)
    return min(xs) - edge, min(ys) - edge, max(xs) + edge, max(ys) + edge


def display_scale(reach: float) -> float:
    """A power of ten that scales a machine of this size [mm] to what browsers draw precisely.

    They draw what is scaled by a thousand coarsely, and SVG has no small numbers.
    """
    return 1.0 if NEAR[0] < reach < NEAR[1] else 10.0 ** -round(math.log10(reach / NEAR[0]) - 1.0)


def scale_in(extent: Box, size: tuple[float, float]) -> float:
    """How many times its size a machine has in a panel of this width and height."""
    left, bottom, right, top = extent
    return min(size[0] / (right - left), size[1] / (top - bottom))


def line_style(extent: Box, size: tuple[float, float]) -> str:
    """Style of a machine's lines in a panel: their widths are the sheet's, their lengths scaled."""
    return "".join(svg.line_rules(1.0 / scale_in(extent, size), ".camwright .mechanism"))


def place_in_panel(
    shapes: Sequence[str], extent: Box, size: tuple[float, float], mirror: float = 1.0
) -> list[str]:
    """A machine's elements, y upwards, in the middle of a panel of this width and height [mm]."""
    (left, bottom, right, top), k = extent, scale_in(extent, size)
    x = 0.5 * size[0] - 0.5 * mirror * k * (left + right)
    y = 0.5 * size[1] + 0.5 * k * (bottom + top)
    place = f"translate({svg.num(x)} {svg.num(y)}) scale({svg.num(mirror * k, 9)} "
    return [f'<g class="mechanism" transform="{place}{svg.num(-k, 9)})">', *shapes, "</g>"]
