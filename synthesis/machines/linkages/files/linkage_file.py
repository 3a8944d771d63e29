"""Files of linkages: their format, and what pictures of any kind of linkage share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synthesis.exporters.animations import scene
from synthesis.exporters.animations.scene import DIAGRAMS, EDGE, MACHINE, Body, Scene
from synthesis.exporters.diagrams.plot import Frame, Plot
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import two_lines
from synthesis.exporters.exporter import FileFormat, compact_json
from synthesis.exporters.figures import parts
from synthesis.exporters.figures.machine import Moving
from synthesis.exporters.figures.parts import Box, box_around
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

SVG = "image/svg+xml"
CSV = "text/csv; charset=utf-8; header=present"
PIN = "outline metal"  # kind of a pin's circle
DECIMALS = 4  # of coordinates, which are about as large as those of a sheet in mm
ACROSS = 92.0  # units of line widths and symbols from side to side of a machine
Reading = tuple[str, str, str, Array]  # key, title, unit and values over the turn


@dataclass(frozen=True)
class LinkageFile(FileFormat[Any, Any]):
    """A file made from the answer about a linkage; its name is the file name: ``motion.csv``."""

    suits: Callable[[Any], bool] = lambda _: True  # can it be made of an answer with a linkage?


@dataclass(frozen=True, eq=False)
class Drawing:
    """A linkage seen from the side, in mm times ``by``."""

    by: float
    extent: Box  # of its whole motion
    moving: Sequence[Moving]
    shapes: Body


def scene_json(answer: Any, frame: str, scale: float, extent: Box, **parts: Any) -> bytes:
    """A linkage as data for other viewers; ``frame`` says what ``parts`` mean."""
    body = {
        "kind": "animation",
        "linkage": {"id": answer.id, "name": answer.name, "status": answer.status},
        "frame": "shapes: SVG elements, y upwards, scale times as large as in mm; parts carry "
        f"data-part. extent: left, bottom, right and top, in the same scale. {frame}",
        "scale": scale,
        "extent": list(extent),
        **parts,
    }
    return compact_json(body) + b"\n"


def linkage_scene(
    answer: Any,
    title: str,
    about: str,
    drawing: Drawing,
    plots: Sequence[Plot],
    readings: Sequence[Reading],
    grounds: Callable[[Frame], list[str]] = lambda _: [],
    **texts: Any,
) -> Scene:
    """A linkage in motion beside diagrams, on which points run.

    Args:
        title: name of a linkage that has none. about: the answer in a line.
        plots: with one abscissa. readings: numbers that follow the motion.
        grounds: background of a diagram. texts: other fields of the scene.
    """
    values = [plot.curve.values for plot in plots]
    points, diagrams = scene.traced_diagrams(
        plots, plots[0].curve.degrees, values, grounds, texts["shaft"]
    )
    name = answer.name.strip() or title
    return Scene(
        name=name,
        about=about,
        key=answer.id,
        heading=two_lines(name, about, EDGE, EDGE + MACHINE[0] + DIAGRAMS[0], 1.0),
        machine=lambda tag: parts.place_in_panel(drawing.shapes(tag), drawing.extent, MACHINE),
        diagrams=diagrams,
        moving=[part for part in (*drawing.moving, *points) if part.moves],
        readings=[
            scene.reading(key, title, unit, values, float(np.max(np.abs(values))))
            for key, title, unit, values in readings
        ],
        decimals=DECIMALS,
        rules=parts.line_style(drawing.extent, MACHINE),
        **texts,
    )


def moving_parts(values: Mapping[str, Array]) -> list[Moving]:
    """Parts that turn, by angles (n,) [rad], and parts that shift, to points x + i y (n,)."""
    return [
        Moving(name, "shift", np.stack([each.real, each.imag], axis=1))
        if np.iscomplexobj(each) else Moving(name, "turn", each[:, None] / DEGREE)
        for name, each in values.items()
    ]  # fmt: skip


def unit_and_extent(points: Array, margin: float) -> tuple[float, Box]:
    """Unit of line widths and symbols of a machine, and its bounding box with a margin of these.

    Points x + i y, y upwards as in all shapes below.
    """
    left, bottom, right, top = box_around(points.tolist())
    u = max(right - left, top - bottom) / ACROSS
    return u, box_around(points.tolist(), margin * u)


def shifted(x: float, y: float, body: Sequence[str]) -> list[str]:
    """Shapes with their origin at a point."""
    return [f'<g transform="translate({svg.num(x)} {svg.num(y)})">', *body, "</g>"]


def bar(length: float, half: float) -> list[str]:
    """A link along x from one pin to the other, round at its ends."""
    x, y = svg.num(length), svg.num(half)
    steps = f"M0 {y}H{x}A{y} {y} 0 0 0 {x} -{y}H0A{y} {y} 0 0 0 0 {y}Z"
    pins = [svg.circle(PIN, at, 0.0, 0.45 * half) for at in (0.0, length)]
    return [svg.path("outline rest", steps), *pins]


def bearing(x: float, y: float, u: float) -> list[str]:
    """A pivot on the ground."""
    foot = [(0.0, 0.0), (-4.6 * u, -3.0 * u), (-4.6 * u, 3.0 * u)]
    ground = hatched(x - 4.0 * u, x + 4.0 * u, y - 4.6 * u, u)
    return [parts.polygon("outline rest", complex(x, y), 1j, foot), *ground]


def hatched(left: float, right: float, y: float, u: float) -> list[str]:
    """Ground below a level."""
    count = max(1, round((right - left) / (1.6 * u)))
    at = [left + (right - left) * k / count for k in range(count + 1)]
    return [svg.line("line border", left, y, right, y),
            *(svg.line("line border", x, y, x - 1.2 * u, y - 1.4 * u) for x in at[1:])]  # fmt: skip


def block(width: float, height: float) -> list[str]:
    """A sliding block about its middle."""
    return [svg.box("outline metal", -0.5 * width, -0.5 * height, width, height),
            svg.circle(PIN, 0.0, 0.0, 0.2 * height)]  # fmt: skip
