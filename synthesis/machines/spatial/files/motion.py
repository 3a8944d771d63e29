"""The follower's motion as tables and diagrams: displacement, velocity, acceleration, jerk."""

from __future__ import annotations

from dataclasses import asdict

from synthesis.exporters.diagrams.motion import motion_plot
from synthesis.exporters.diagrams.readings import QUANTITIES
from synthesis.exporters.diagrams.sheet import DRAWN_PER_DEGREE, LEFT, RIGHT, WIDTH, Moved, stacked
from synthesis.exporters.drawing.picture_options import DiagramOptions
from synthesis.exporters.exporter import FileFormat
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.samples.columns import motion_columns
from synthesis.exporters.samples.turn import Turn
from synthesis.exporters.tables.formats import csv_table, json_table
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.identification import above, origin


def _turn(design: SpatialDesign) -> Turn:
    return Turn(design.curve, design.spec.machine.travel, design.spec.omega)


def _csv(design: SpatialDesign, options: MotionOptions) -> bytes:
    return csv_table(motion_columns(_turn(design), options))


def _json(design: SpatialDesign, options: MotionOptions) -> bytes:
    columns = motion_columns(_turn(design), options)
    body = {
        "kind": "motion",
        "segments": [each.model_dump(mode="json", exclude_none=True) for each in design.motion],
        "design": origin(design),
        "sampling": asdict(options),
        "rows": len(columns[0].values),
    }
    return json_table(body, columns)


def _svg(design: SpatialDesign, options: DiagramOptions) -> bytes:
    turn = _turn(design)
    drawn = MotionOptions(max(options.count / 360.0, DRAWN_PER_DEGREE))
    plots = [motion_plot(turn, quantity, drawn, ()) for quantity in QUANTITIES]
    title_and_text = (
        f"Motion of {design.name or design.id}",
        "Displacement, velocity, acceleration and jerk of the follower over the cam angle.",
    )
    moved = Moved(design.motion, turn.travel.unit)
    heading = above(design, LEFT, WIDTH - RIGHT, 1.0)
    return stacked(moved, heading, plots, title_and_text, options.theme)


PURPOSE = "The follower's displacement, velocity, acceleration and jerk over the cam angle."
JSON = FileFormat(
    "motion.json", "Motion, columns with units and metadata", "application/json", ".json",
    _json, MotionOptions, PURPOSE,
)  # fmt: skip
CSV = FileFormat(
    "motion.csv", "Motion, comma separated", "text/csv; charset=utf-8; header=present", ".csv",
    _csv, MotionOptions, PURPOSE,
)  # fmt: skip
SVG = FileFormat(
    "motion.svg", "Diagrams of the motion", "image/svg+xml", ".svg", _svg, DiagramOptions,
    PURPOSE,
)  # fmt: skip
