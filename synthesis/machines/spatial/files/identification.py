"""What files of a spatial cam begin with: JSON files, and the heading of drawings."""

from __future__ import annotations

from typing import Any

from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import TURNS, two_lines
from synthesis.exporters.exporter import compact_json
from synthesis.machines.spatial.design import SpatialDesign


def origin(design: SpatialDesign) -> dict[str, Any]:
    """Identification of the cam for JSON files."""
    return {
        "id": design.id,
        "name": design.name,
        "engine_version": design.engine_version,
        "status": design.status,
        "machine": design.machine,
        "dimensions": design.dimensions,
        "rotation": design.rotation,
        "speed_rpm": design.speed_rpm,
    }


def json_file(design: SpatialDesign, kind: str, frame: str, body: dict[str, Any]) -> bytes:
    """A JSON file: its kind, the frame of its coordinates, its cam, then the body."""
    whole = {"kind": kind, "frame": frame, "design": origin(design), **body}
    return compact_json(whole)


def above(design: SpatialDesign, left: float, right: float, u: float) -> list[str]:
    """Heading of a drawing between two abscissae: name, machine, speed, status, id."""
    kind = design.spec.machine.title
    line = (
        f"{kind} · cam turns {TURNS[design.rotation]} at {svg.figure(design.speed_rpm, 6)} rpm · "
        f"{design.status} · {design.id[:8]}"
    )
    return two_lines(design.name.strip() or kind.capitalize(), line, left, right, u)
