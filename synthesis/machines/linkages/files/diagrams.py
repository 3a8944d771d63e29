"""Diagrams of a linkage over one turn, on a sheet and next to an animation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.exporters.animations.panels import DIAGRAMS, GAP, HEIGHT, LEFT, RIGHT, TOP
from synthesis.exporters.animations.scene import grouped
from synthesis.exporters.diagrams.diagram import Frame, diagram, ranged
from synthesis.exporters.diagrams.plot import NOWHERE, Plot
from synthesis.exporters.diagrams.readings import Trace
from synthesis.exporters.diagrams.sheet import FOOTER, WIDTH, angle_axis
from synthesis.exporters.diagrams.sheet import GAP as APART
from synthesis.exporters.diagrams.sheet import HEIGHT as TALL
from synthesis.exporters.diagrams.sheet import LEFT as FROM
from synthesis.exporters.diagrams.sheet import RIGHT as UNTIL
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.theme import Theme
from synthesis.exporters.figures.machine import Moving, Tag
from synthesis.numerics.piecewise import Array

HEADER = 24.0
Grounds = Callable[[Frame], list[str]]


def plot(title: str, unit: str, degrees: Array, values: Array, extremes: bool = True) -> Plot:
    """A diagram of one quantity over the turn."""
    trace = Trace(degrees, np.zeros(len(degrees), dtype=np.int64), values)
    ends = (("max", True), ("min", False)) if extremes else ()
    return Plot(title, unit, trace, trace, NOWHERE, ends=ends)


def sheet(
    plots: Sequence[Plot],
    heading: Sequence[str],
    told: tuple[str, str],
    shaft: str,
    grounds: Grounds,
    theme: Theme,
) -> bytes:
    """Diagrams below each other; ``told`` is the title and description for screen readers."""
    body = list(heading)
    first = Frame(FROM, HEADER, WIDTH - FROM - UNTIL, TALL)
    frames = [replace(first, top=HEADER + k * (TALL + APART)) for k in range(len(plots))]
    for frame, each in zip(frames, plots, strict=True):
        body += [*grounds(frame), *diagram(each, frame)]
    body += angle_axis(frames[-1], name=shaft)
    height = frames[-1].top + TALL + FOOTER
    return svg.document(WIDTH, height, 1.0, *told, body, theme=theme)


@dataclass(frozen=True, eq=False)
class TracedDiagrams:
    """Diagrams next to an animation, with a cursor and a moving point on each."""

    plots: tuple[Plot, ...]
    shaft: str
    grounds: Grounds

    @property
    def _frames(self) -> list[Frame]:
        wide = DIAGRAMS[0] - LEFT - RIGHT
        frames = [
            Frame(LEFT, TOP + k * (HEIGHT + GAP), wide, HEIGHT) for k in range(len(self.plots))
        ]
        return [ranged(frame, each) for frame, each in zip(frames, self.plots, strict=True)]

    def moving(self) -> list[Moving]:
        """Cursor and points."""
        across = self._frames[0].x(self.plots[0].curve.degrees)
        found = [Moving("cursor", "shift", np.stack([across, 0.0 * across], axis=1))]
        for k, (frame, each) in enumerate(zip(self._frames, self.plots, strict=True)):
            steps = np.stack([across, frame.y(each.curve.values)], axis=1)
            found.append(Moving(f"dot{k}", "shift", steps))
        return found

    def panel(self, tag: Tag) -> list[str]:
        """Their elements."""
        body: list[str] = []
        for frame, each in zip(self._frames, self.plots, strict=True):
            body += [*self.grounds(frame), *diagram(each, frame)]
        last, moving = self._frames[-1], self.moving()
        body += angle_axis(last, every=60, name=self.shaft)
        bottom = last.top + last.height
        body += grouped("cursor", tag, moving, [svg.line("phase", 0.0, TOP, 0.0, bottom)])
        for k in range(len(self.plots)):
            body += grouped(f"dot{k}", tag, moving, [svg.circle("mark", 0.0, 0.0, 1.3)])
        return body
