"""What every drawing says above: the design's name, and what the numbers belong to."""

from __future__ import annotations

from synthesis.design import Design
from synthesis.exporters import svg_canvas as svg

BOLD = 1.15  # how much wider bold letters are
TURNS = {"ccw": "counter-clockwise", "cw": "clockwise"}


def heading(design: Design, left: float, right: float, u: float) -> list[str]:
    """Two lines between two abscissae, cut where they do not fit."""
    kind = f"{design.follower.replace('_', ' ')} follower"
    told = (
        f"{kind} · cam turns {TURNS[design.rotation]} at {svg.figure(design.speed_rpm, 6)} rpm · "
        f"{'certified' if design.certificate.certified else 'not certified'} · {design.id[:8]}"
    )
    return headed(design.name.strip() or kind.capitalize(), told, left, right, u)


def headed(name: str, told: str, left: float, right: float, u: float) -> list[str]:
    """The same two lines, of anything that has a name."""
    width = right - left
    return [
        svg.text("title", left, 8.0 * u, svg.shortened(name, width, BOLD * svg.TITLE * u)),
        svg.text("quiet", left, 13.0 * u, svg.shortened(told, width, svg.LABEL * u)),
    ]
