"""Where contact leaves a flat face."""

from __future__ import annotations

import math
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
    half = math.inf if width.width_mm is None else 0.5 * width.width_mm
    left, right = (min(half, each or math.inf) for each in (width.left_mm, width.right_mm))
    found: list[OffFace] = []
    sides: tuple[Literal["left", "right"], ...] = ("left", "right")
    for side, row in zip(sides, follower.contact_rows(left, right), strict=False):
        fixed = sum(c * z for c, z in zip(row.size, size, strict=False))
        along = np.array(row.coefficients) @ fine.s + fixed
        if math.isfinite(row.upper):
            found += _arcs(side, along - row.upper, fine.theta / DEGREE)
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
