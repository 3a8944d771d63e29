"""What drawings of a spatial cam say above."""

from __future__ import annotations

from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.heading import TURNS, two_lines
from synthesis.spatial.design import SpatialDesign


def above(design: SpatialDesign, left: float, right: float, u: float) -> list[str]:
    """Name, and what the numbers belong to, between two abscissae."""
    kind = design.spec.machine.title
    told = (
        f"{kind} · cam turns {TURNS[design.rotation]} at {svg.figure(design.speed_rpm, 6)} rpm · "
        f"{design.status} · {design.id[:8]}"
    )
    return two_lines(design.name.strip() or kind.capitalize(), told, left, right, u)
