"""Files of linkages: their format, and what animations of any kind of linkage share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synthesis.exporters.animations.scene import (
    DIAGRAMS,
    EDGE,
    MACHINE,
    Body,
    Scene,
    reading,
    traced_diagrams,
)
from synthesis.exporters.diagrams.diagram import Frame
from synthesis.exporters.diagrams.plot import Plot
from synthesis.exporters.drawing.heading import two_lines
from synthesis.exporters.drawing.theme import lines
from synthesis.exporters.exporter import FileFormat, compact_json
from synthesis.exporters.figures.machine import Moving
from synthesis.exporters.figures.parts import Box, place_in_panel, scale_in
from synthesis.numerics.piecewise import Array

SVG = "image/svg+xml"
CSV = "text/csv; charset=utf-8; header=present"
DECIMALS = 4  # of coordinates, which are about as large as those of a sheet in mm
Reading = tuple[str, str, str, Array]  # key, title, unit and values over the turn


@dataclass(frozen=True)
class LinkageFile(FileFormat[Any, Any]):
    """A file made from the answer about a linkage; its name is the file name: ``motion.csv``.

    Attributes:
        suits: whether it can be made from an answer that has a linkage. Others as ``FileFormat``.
    """

    suits: Callable[[Any], bool] = lambda _: True


def scene_json(found: Any, frame: str, scale: float, extent: Box, **parts: Any) -> bytes:
    """A linkage as data for other viewers; ``frame`` says what ``parts`` mean."""
    body = {
        "kind": "animation",
        "linkage": {"id": found.id, "name": found.name, "status": found.status},
        "frame": "shapes: SVG elements, y upwards, scale times as large as in mm; parts carry "
        f"data-part. extent: left, bottom, right and top, in the same scale. {frame}",
        "scale": scale,
        "extent": list(extent),
        **parts,
    }
    return compact_json(body) + b"\n"


def linkage_scene(
    found: Any,
    title: str,
    about: str,
    machine: tuple[Box, Sequence[Moving], Body],
    plots: Sequence[Plot],
    readings: Sequence[Reading],
    grounds: Callable[[Frame], list[str]] = lambda _: [],
    **texts: Any,
) -> Scene:
    """A linkage in motion beside diagrams, on which points run.

    Args:
        found: the answer. title: name of a linkage that has none. about: it in a line.
        machine: bounding box of the whole motion, the parts that move, and all shapes.
        plots: the diagrams, with one abscissa. readings: numbers that follow the motion.
        grounds: background of a diagram. texts: other fields of the scene.
    """
    extent, parts, shapes = machine
    first, values = plots[0].curve, [plot.curve.values for plot in plots]
    points, diagrams = traced_diagrams(plots, first.degrees, values, grounds, texts["shaft"])
    name = found.name.strip() or title
    return Scene(
        name=name,
        about=about,
        key=found.id,
        heading=two_lines(name, about, EDGE, EDGE + MACHINE[0] + DIAGRAMS[0], 1.0),
        machine=lambda tag: place_in_panel(shapes(tag), extent, MACHINE),
        diagrams=diagrams,
        moving=[part for part in (*parts, *points) if part.moves],
        readings=[
            reading(key, title, unit, values, float(np.max(np.abs(values))))
            for key, title, unit, values in readings
        ],
        decimals=DECIMALS,
        rules=line_rules(extent, MACHINE),
        **texts,
    )


def line_rules(extent: Box, size: tuple[float, float]) -> str:
    """Style of a machine's lines, whose width is the sheet's while their lengths are scaled."""
    return "".join(lines(1.0 / scale_in(extent, size), ".camwright .mechanism"))
