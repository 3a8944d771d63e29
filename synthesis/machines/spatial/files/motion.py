"""The follower's motion as tables and diagrams: displacement, velocity, acceleration, jerk."""

from __future__ import annotations

from dataclasses import asdict

from synthesis.design.warnings import labelled_status
from synthesis.exporters.diagrams.sheet import LEFT, RIGHT, WIDTH, motion_sheet
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import TURNS, two_lines
from synthesis.exporters.exporter import machine_format
from synthesis.exporters.options import DiagramOptions, MotionOptions
from synthesis.exporters.samples.cam import Turn
from synthesis.exporters.samples.columns import motion_table
from synthesis.exporters.tables import csv_table, json_table
from synthesis.machines.spatial.design import SpatialDesign


def _turn(design: SpatialDesign) -> Turn:
    return Turn(design.curve, design.spec.machine.travel, design.spec.omega)


def _csv(design: SpatialDesign, options: MotionOptions) -> bytes:
    return csv_table(motion_table(_turn(design), options))


def _json(design: SpatialDesign, options: MotionOptions) -> bytes:
    columns = motion_table(_turn(design), options)
    body = {
        "kind": "motion",
        "segments": [each.model_dump(mode="json", exclude_none=True) for each in design.motion],
        "design": design.identification,
        "sampling": asdict(options),
        "rows": len(columns[0].values),
    }
    return json_table(body, columns)


def _svg(design: SpatialDesign, options: DiagramOptions) -> bytes:
    heading = above(design, LEFT, WIDTH - RIGHT, 1.0)
    name = design.name or design.id
    return motion_sheet(_turn(design), name, design.motion, heading, options)


def above(design: SpatialDesign, left: float, right: float, u: float) -> list[str]:
    """Heading of a drawing between two abscissae: name, machine, speed, status, id."""
    kind = design.spec.machine.title
    line = (
        f"{kind} · cam turns {TURNS[design.rotation]} at {svg.figure(design.speed_rpm, 6)} rpm · "
        f"{labelled_status(design.status, design.severity)} · {design.id[:8]}"
    )
    return two_lines(design.name.strip() or kind.capitalize(), line, left, right, u)


JSON = machine_format("spatial", "motion.json", _json, MotionOptions)
CSV = machine_format("spatial", "motion.csv", _csv, MotionOptions)
SVG = machine_format("spatial", "motion.svg", _svg, DiagramOptions)
