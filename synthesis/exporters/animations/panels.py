"""What both animations show: the machine, and two diagrams with moving points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from synthesis.design.design import Design
from synthesis.exporters.animations.scene import Scene, grouped, lasting
from synthesis.exporters.diagrams.contact import DRAWN, pressure_plot
from synthesis.exporters.diagrams.diagram import Frame, diagram, ranged
from synthesis.exporters.diagrams.motion import motion_plot
from synthesis.exporters.diagrams.plot import Plot
from synthesis.exporters.diagrams.readings import QUANTITIES, bounds
from synthesis.exporters.diagrams.sheet import angle_axis, grounds
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.heading import about, heading
from synthesis.exporters.drawing.theme import lines
from synthesis.exporters.figures.machine import Moving, Stage, Tag
from synthesis.exporters.samples.cam import Cam
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

MACHINE = (112.0, 122.0)  # width and height of the panels [mm]
DIAGRAMS = (112.0, 122.0)
EDGE = 8.0  # beside both [mm]
LEFT, RIGHT, TOP, HEIGHT, GAP = 15.0, 4.0, 8.0, 38.0, 11.0
LEGEND = (
    ("line circle", "base circle"),
    ("line pitch", "path of the roller's centre"),
    ("line normal", "common normal"),
    ("line front", "follower is driven this way"),
)


@dataclass(frozen=True, eq=False)
class Panels:
    """The machine and its diagrams.

    Attributes:
        stage: the machine. plots: displacement, and pressure angle of the first traced curve.
        frames: where they lie on their panel.
    """

    stage: Stage
    plots: tuple[Plot, ...]
    frames: tuple[Frame, ...]

    @classmethod
    def of(cls, design: Design, count: int) -> Panels:
        """The panels of a design, with ``count`` + 1 positions of everything that moves."""
        cam = Cam.of(design)
        shown = (
            motion_plot(cam, QUANTITIES[0], DRAWN, bounds(design, QUANTITIES[0])),
            pressure_plot(design, cam),
        )
        plots = tuple(replace(plot, ends=()) for plot in shown)
        frames = [
            Frame(LEFT, TOP + k * (HEIGHT + GAP), DIAGRAMS[0] - LEFT - RIGHT, HEIGHT)
            for k in range(len(plots))
        ]
        placed = [ranged(frame, plot) for frame, plot in zip(frames, plots, strict=True)]
        stage = Stage.of(cam, design.dimensions["base_radius_mm"], count)
        return cls(stage, plots, tuple(placed))

    @property
    def values(self) -> tuple[Array, ...]:
        """What the moving points show: displacement, pressure angle [deg]; (n,) each."""
        machine = self.stage.mechanism
        return machine.s, machine.contacts[0].curve.pressure_angle / DEGREE

    def moving(self) -> list[Moving]:
        """Everything that moves, in machine and diagrams."""
        degrees = self.stage.mechanism.theta / DEGREE
        frame = self.frames[0]
        across = frame.x(degrees)
        found = [*self.stage.moving(),
                 Moving("cursor", "shift", np.stack([across, 0.0 * across], axis=1))]  # fmt: skip
        for k, (frame, values) in enumerate(zip(self.frames, self.values, strict=True)):
            found.append(Moving(f"dot{k}", "shift", np.stack([across, frame.y(values)], axis=1)))
        return [part for part in found if part.moves]

    def machine(self, tag: Tag) -> list[str]:
        """The machine's panel."""
        return self.stage.placed(*MACHINE, tag)

    def diagrams(self, design: Design, tag: Tag) -> list[str]:
        """The diagrams' panel."""
        body = []
        for frame, plot in zip(self.frames, self.plots, strict=True):
            body += [*grounds(design.motion, frame), *diagram(plot, frame)]
        last = self.frames[-1]
        body += angle_axis(last, every=60)
        bottom = last.top + last.height
        body += grouped("cursor", tag, self.moving(), [svg.line("phase", 0.0, TOP, 0.0, bottom)])
        for k in range(len(self.plots)):
            body += grouped(f"dot{k}", tag, self.moving(), [svg.circle("mark", 0.0, 0.0, 1.3)])
        return [*body, *self._legend(bottom + 14.5)]

    def rules(self) -> str:
        """Style of the machine's lines, whose unit is the sheet's while its mm are the cam's."""
        return "".join(lines(1.0 / self.stage.scale(*MACHINE), ".camwright .mechanism"))

    def _legend(self, top: float) -> list[str]:
        """Kinds of lines in two columns; without a roller there is no path of its centre."""
        rows = [row for row in LEGEND if self.stage.prime > 0.0 or row[0] != "line pitch"]
        body = []
        for k, (kind, told) in enumerate(rows):
            x, y = 4.0 + (k % 2) * 0.5 * DIAGRAMS[0], top + (k // 2) * 5.0
            body += [svg.line(kind, x, y, x + 9.0, y), svg.text("tick", x + 11.0, y + 0.9, told)]
        return body


def cam_scene(design: Design, count: int, panels: Panels | None = None) -> Scene:
    """A cam in motion, at ``count`` + 1 angles; its readings are left out."""
    shown = panels or Panels.of(design, count)
    return Scene(
        name=design.name.strip(),
        about=about(design),
        key=design.id,
        heading=heading(design, EDGE, EDGE + MACHINE[0] + DIAGRAMS[0], 1.0),
        shaft="Cam angle",
        titles=("Cam and follower", "Displacement and pressure angle"),
        described="The cam turns, the follower with its roller moves, and points run on its "
        "diagrams.",
        machine=shown.machine,
        diagrams=partial(shown.diagrams, design),
        moving=shown.moving(),
        readings=(),
        decimals=shown.stage.decimals,
        rules=shown.rules(),
        footer=lasting(60.0 / design.speed_rpm),
    )
