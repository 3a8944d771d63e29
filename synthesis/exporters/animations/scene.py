"""A machine in motion beside its diagrams: what every animation shows, whatever the machine is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from synthesis.exporters.diagrams.diagram import Frame, diagram, with_range
from synthesis.exporters.diagrams.plot import Plot
from synthesis.exporters.diagrams.sheet import angle_axis
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures.machine import Moving, Tag, moving_group
from synthesis.numerics.piecewise import Array

Body = Callable[[Tag], list[str]]
Reading = dict[str, Any]
MACHINE = (112.0, 122.0)  # width and height of the panels [mm]
DIAGRAMS = (112.0, 122.0)
EDGE = 8.0  # beside both [mm]
LEFT, RIGHT, TOP, HEIGHT, GAP = 15.0, 4.0, 8.0, 38.0, 11.0  # of the diagrams on their panel [mm]
TURN_S = 8.0  # what one turn takes on the screen


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene over one turn of a shaft.

    Attributes:
        name, about: of the machine, in a line each. key: its id.
        heading: both as elements of a sheet. shaft: what the turn is of, as in ``Cam angle``.
        titles: of the two panels. described: what is seen, in a sentence.
        machine, diagrams: elements of the panels, their parts named by the tag.
        moving: everything that moves. readings: numbers that follow. decimals: of coordinates.
        rules: style of the machine's lines. footer: the line below.
    """

    name: str
    about: str
    key: str
    heading: Sequence[str]
    shaft: str
    titles: tuple[str, str]
    described: str
    machine: Body
    diagrams: Body
    moving: Sequence[Moving]
    readings: Sequence[Reading]
    decimals: int
    rules: str
    footer: str


def lasting(turn_s: float) -> str:
    """How long a turn takes, and how long it is shown."""
    return f"One turn is shown in {TURN_S:g} s; it takes {svg.figure(turn_s)} s."


def reading(name: str, title: str, unit: str, values: Array, size: float) -> Reading:
    """A number that follows the motion, rounded to four digits of its size."""
    digits = int(np.clip(3 - np.floor(np.log10(size)), 0, 9)) if size > 0.0 else 1
    rounded = [round(v, digits) if np.isfinite(v) else None for v in values.tolist()]
    return {"name": name, "title": title, "unit": unit, "digits": digits, "column": rounded}


def traced_diagrams(
    plots: Sequence[Plot],
    degrees: Array,
    values: Sequence[Array],
    grounds: Callable[[Frame], list[str]],
    shaft: str,
) -> tuple[list[Moving], Body]:
    """Diagrams below each other, with a cursor over all of them and a moving point on each.

    Args:
        plots: the diagrams. degrees, values: (n,) where the points run, values for each diagram.
        grounds: background of a diagram. shaft: name of the abscissa.

    Returns:
        cursor and points, and the elements of the panel.
    """
    plots = [replace(plot, ends=()) for plot in plots]
    frames = [
        with_range(Frame(LEFT, TOP + k * (HEIGHT + GAP), DIAGRAMS[0] - LEFT - RIGHT, HEIGHT), plot)
        for k, plot in enumerate(plots)
    ]
    across, bottom = frames[0].x(degrees), frames[-1].top + frames[-1].height
    heights = {"cursor": 0.0 * across}
    heights |= {f"dot{k}": frame.y(values[k]) for k, frame in enumerate(frames)}
    points = [Moving(name, "shift", np.stack([across, y], axis=1)) for name, y in heights.items()]

    def panel(tag: Tag) -> list[str]:
        body: list[str] = []
        for frame, plot in zip(frames, plots, strict=True):
            body += [*grounds(frame), *diagram(plot, frame)]
        body += angle_axis(frames[-1], every=60, name=shaft)
        body += moving_group("cursor", tag, points, [svg.line("phase", 0.0, TOP, 0.0, bottom)])
        for k in range(len(plots)):
            body += moving_group(f"dot{k}", tag, points, [svg.circle("mark", 0.0, 0.0, 1.3)])
        return body

    return points, panel
