"""Where contact leaves a flat face."""

from __future__ import annotations

from typing import Literal

import numpy as np

from synthesis.followers.base import Follower
from synthesis.limits.face_width import FaceWidth
from synthesis.measured.reading import OffFace
from synthesis.numerics.piecewise import Array
from synthesis.profile import CamProfile
from synthesis.units import DEGREE


def off_face(
    width: FaceWidth, follower: Follower, size: tuple[float, ...], fine: CamProfile
) -> list[OffFace]:
    """Arcs along which contact lies beyond an end of the face.

    Args:
        width: the face. follower, size: what rides. fine: the cam at many even angles.
    """
    (x, y), *_ = follower.traced_point(fine.s, size)
    (gx, gy), _ = follower.direction(fine.s, size)
    along = x * gy - y * gx  # positive to the right
    half = None if width.width_mm is None else 0.5 * width.width_mm
    ends: tuple[tuple[Literal["left", "right"], float | None, Array], ...] = (
        ("left", width.left_mm, -along),
        ("right", width.right_mm, along),
    )
    found: list[OffFace] = []
    for side, reach, contact in ends:
        allowed = [each for each in (half, reach) if each is not None]
        if allowed:
            found += _arcs(side, contact - min(allowed), fine.theta / DEGREE)
    return found


def _arcs(side: Literal["left", "right"], beyond: Array, degrees: Array) -> list[OffFace]:
    """Runs, round the turn, in which something is positive."""
    over = beyond > 0.0
    if not over.any():
        return []
    if over.all():
        worst = int(np.argmax(beyond))
        return [OffFace(side=side, from_deg=0.0, to_deg=360.0, worst_deg=float(degrees[worst]),
                        beyond_mm=float(beyond[worst]))]  # fmt: skip
    found = []
    for first in np.flatnonzero(over & ~np.roll(over, 1)):
        length = int(np.argmin(np.roll(over, -int(first))))
        arc = (first + np.arange(length)) % len(over)
        worst = int(arc[np.argmax(beyond[arc])])
        found.append(
            OffFace(
                side=side, from_deg=float(degrees[arc[0]]), to_deg=float(degrees[arc[-1]]),
                worst_deg=float(degrees[worst]), beyond_mm=float(beyond[worst]),
            )
        )  # fmt: skip
    return found
