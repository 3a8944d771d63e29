"""Leading a cutter in and out along quarter circles that are tangent to its path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.errors import InputError
from synthesis.exporters.machining.program import reach
from synthesis.exporters.samples.cam import Cam
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

LOOKED_AT = 1440  # places of the profile from which the lead has to keep away
ALONG = np.linspace(0.05, 1.0, 20) * 0.5 * np.pi
ROOM = 1e-3  # [mm]


@dataclass(frozen=True, eq=False)
class Lead:
    """A quarter circle; all (2,) [mm].

    Attributes:
        start, centre, end: of the arc. ccw: in which sense it runs.
    """

    start: Array
    centre: Array
    end: Array
    ccw: bool


def leads(point: Array, along: Array, away: Array, radius: float) -> tuple[Lead, Lead]:
    """The arcs that lead to a point and from it, on the side ``away`` of the path.

    Args:
        along, away: (2,) unit vectors of the motion there and off the cam.
    """
    away = away - np.dot(away, along) * along
    away = away / np.hypot(*away)
    centre = point + radius * away
    ccw = bool(along[0] * away[1] - along[1] * away[0] > 0.0)
    return (
        Lead(centre - radius * along, centre, point, ccw),
        Lead(point, centre, centre + radius * along, ccw),
    )


def checked(cam: Cam, lead: Lead, point: Array, radius: float, turn: Array) -> None:
    """InputError where the cutter would touch the cam on its way.

    Args:
        point: of the path, where the lead ends or begins. turn: (2, 2) from the cam's frame into
            the program's.
    """
    theta = FULL_TURN * np.arange(LOOKED_AT) / LOOKED_AT
    walls = [each.at(theta) for each in cam.flanks() if each.flank.path == cam.flank.path]
    cam_points = np.hstack([np.stack([wall.x, wall.y]) for wall in walls])
    start = (lead.start if np.any(lead.start != point) else lead.end) - lead.centre
    end = point - lead.centre
    arc = lead.centre[:, None] + end[:, None] * np.cos(ALONG) + start[:, None] * np.sin(ALONG)
    arc = turn.T @ arc
    apart = np.hypot(
        arc[0][:, None] - cam_points[0][None, :], arc[1][:, None] - cam_points[1][None, :]
    )
    if apart.min() < reach(cam) - ROOM:
        raise InputError(
            "/lead_mm", radius,
            "On a lead of this radius the tool would cut into the cam: there is not so much room "
            f"where the path begins (it would be {reach(cam) - apart.min():.3g} mm inside).",
            "Take a shorter one, another start_deg, or 0 for none.",
        )  # fmt: skip
