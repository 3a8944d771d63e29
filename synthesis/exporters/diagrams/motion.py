"""Diagrams of the motion as SVG: s, v, a and j over the cam angle, stacked on one sheet (mm)."""

from __future__ import annotations

from collections.abc import Sequence

from synthesis.design.design import Design
from synthesis.exporters.diagrams.plot import Plot
from synthesis.exporters.diagrams.readings import (
    QUANTITIES,
    Bound,
    Quantity,
    bounds,
    impulses,
    trace,
)
from synthesis.exporters.diagrams.sheet import DRAWN_PER_DEGREE, sheet
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.picture_options import DiagramOptions
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.turn import Turn

MEASURED_PER_DEGREE = 20.0  # at which the extremes are read


def _motion(design: Design, options: DiagramOptions) -> bytes:
    cam = Cam.of(design)
    per_degree = MotionOptions(max(options.count / 360.0, DRAWN_PER_DEGREE))
    plots = [
        motion_plot(cam, quantity, per_degree, bounds(design, quantity)) for quantity in QUANTITIES
    ]
    title = f"Motion of {design.name or design.id}"
    told = "Displacement, velocity, acceleration and jerk of the follower over the cam angle."
    return sheet(design, plots, title, told, options.theme)


def motion_plot(
    turn: Turn, quantity: Quantity, options: MotionOptions, limits: Sequence[Bound]
) -> Plot:
    """The diagram of the displacement or of one of its derivatives."""
    return Plot(
        title=f"{quantity.title} {quantity.symbol}",
        unit=svg.unit(turn.travel.derivative_unit(quantity.order)),
        curve=trace(turn, quantity, options),
        fine=trace(turn, quantity, MotionOptions(MEASURED_PER_DEGREE)),
        infinite=impulses(turn, quantity),
        limits=limits,
        ends=(("max", True), ("min", False))[: 2 if quantity.order else 1],
    )


MOTION = Exporter("svg", "Diagrams of the motion", "image/svg+xml", ".svg", _motion, DiagramOptions)
