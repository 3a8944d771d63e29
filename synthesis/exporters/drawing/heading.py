"""What every drawing says above: the design's name, and what the numbers belong to."""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.drawing import canvas as svg

BOLD = 1.15  # how much wider bold letters are
TURNS = {"ccw": "counter-clockwise", "cw": "clockwise"}


def heading(design: Design, left: float, right: float, u: float) -> list[str]:
    """Two lines between two abscissae, cut where they do not fit."""
    name = design.name.strip() or _kind(design).capitalize()
    return two_lines(name, about(design), left, right, u)


def about(design: Design) -> str:
    """What the numbers of a drawing belong to."""
    return (
        f"{_kind(design)} · cam turns {TURNS[design.rotation]} at "
        f"{svg.figure(design.speed_rpm, 6)} rpm · "
        f"{'certified' if design.certificate.certified else 'not certified'} · {design.id[:8]}"
    )


def _kind(design: Design) -> str:
    return f"{design.follower.replace('_', ' ')} follower"


def two_lines(name: str, text: str, left: float, right: float, u: float) -> list[str]:
    """A name and a line about it between two abscissae, cut where they do not fit."""
    width = right - left
    return [
        svg.text("title", left, 8.0 * u, svg.shorten(name, width, BOLD * svg.TITLE * u)),
        svg.text("quiet", left, 13.0 * u, svg.shorten(text, width, svg.LABEL * u)),
    ]
