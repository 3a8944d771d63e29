"""Diagrams of the motion as SVG: s, v, a and j over the cam angle, stacked on one sheet (mm)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from synthesis.design.design import Design, SegmentMotion
from synthesis.exporters.diagrams.plot import Bound, Plot, Trace, claimed_bounds
from synthesis.exporters.diagrams.sheet import DRAWN_PER_DEGREE, LEFT, RIGHT, WIDTH, stack
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.heading import heading
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.options import DiagramOptions
from synthesis.exporters.samples.cam import Cam, Turn
from synthesis.exporters.samples.sampling import in_degrees, motion_rows

MEASURED_PER_DEGREE = 20.0  # rows at which the extremes are read
QUANTITIES = ("displacement", "velocity", "acceleration", "jerk")  # by the order of derivative


def _motion(design: Design, options: DiagramOptions) -> bytes:
    cam, above = Cam.of(design), heading(design, LEFT, WIDTH - RIGHT, 1.0)
    limits = partial(motion_bounds, design)
    return motion_sheet(cam, design.name or design.id, design.motion, above, options, limits)


def motion_sheet(
    turn: Turn,
    name: str,
    motion: Sequence[SegmentMotion],
    above: Sequence[str],
    options: DiagramOptions,
    limits: Callable[[int], Sequence[Bound]] = lambda order: (),
) -> bytes:
    """The four diagrams of a motion under a heading; ``limits``: of each derivative of s."""
    per_degree = max(options.count / 360.0, DRAWN_PER_DEGREE)
    plots = [motion_plot(turn, k, per_degree, limits(k)) for k in range(len(QUANTITIES))]
    text = "Displacement, velocity, acceleration and jerk of the follower over the cam angle."
    title_and_text = f"Motion of {name}", text
    return stack(motion, turn.travel.unit, above, plots, title_and_text, options.theme)


def motion_bounds(design: Design, order: int) -> list[Bound]:
    """The bounds of the spec's limits on a derivative of s by time."""
    return claimed_bounds(design, lambda claim: claim.quantity == QUANTITIES[order])


def motion_plot(
    turn: Turn, order: int, per_degree: float = DRAWN_PER_DEGREE, limits: Sequence[Bound] = ()
) -> Plot:
    """The diagram of a derivative of s by time, drawn with so many rows per degree."""

    def trace(per_degree: float) -> Trace:
        rows = motion_rows(turn, 360.0 * per_degree)
        values = turn.derivatives(rows.theta, rows.left)[order] * turn.rate(order)
        return Trace(rows.degrees, rows.side, values)

    # Where a lower derivative jumps the value is infinite, with the sign of the jump.
    theta = turn.joints.breaking(order - 1)
    lower = turn.joints.order[turn.joints.order < order]
    left, right = (turn.motion.derivatives(theta, 3, side) for side in ("left", "right"))
    jump = (right - left)[lower, np.arange(len(theta))]
    return Plot(
        title=f"{QUANTITIES[order].capitalize()} {'svaj'[order]}",
        unit=svg.unit(turn.travel.derivative_unit(order)),
        curve=trace(per_degree),
        fine=trace(MEASURED_PER_DEGREE),
        infinite=Trace.infinite(in_degrees(theta), jump),
        limits=limits,
        ends=(("max", True), ("min", False))[: 2 if order else 1],
    )


MOTION = Exporter("svg", "Diagrams of the motion", "image/svg+xml", ".svg", _motion, DiagramOptions)
