"""Measured profile points back to the motion that they give a follower.

points -> smooth outline -> postures of the follower -> motion -> ProfileAnalysis
"""

from __future__ import annotations

from math import inf

import numpy as np

from synthesis.errors import InputError
from synthesis.measured.contact import ride
from synthesis.measured.motion import read
from synthesis.measured.outline import outline
from synthesis.measured.reading import ProfileAnalysis
from synthesis.measured.spec import MeasuredCam
from synthesis.measured.telling import told
from synthesis.ranges import ends

__all__ = ["MeasuredCam", "ProfileAnalysis", "read_back"]

MOTION_SHARE = 0.1  # of the tolerance: how far the motion's spline may pass from what was read


def read_back(cam: MeasuredCam) -> ProfileAnalysis:
    """The motion that a follower makes on a measured profile.

    Raises:
        InputError: a dimension of the follower is left free, or it is not pressed on from outside;
            points that are no closed curve round the axis, or scatter beyond the tolerance; a
            follower that does not reach them.
    """
    searched = cam.follower.left_open((-inf, inf)).items()
    free = {**cam.follower.adjustable(), **{name: asked for name, (asked, _) in searched}}
    for name, value in free.items():
        low, high = ends(value)
        if low != high:
            raise InputError(
                f"/follower/{name}", None, "A profile is read back for a follower that is given.",
                "Give this dimension as a number.",
            )  # fmt: skip
    if cam.follower.companions or [flank.side for flank in cam.follower.flanks] != [1]:
        raise InputError(
            "/follower/closure", cam.follower.kind,
            "A profile is read back for one roller that touches it from outside.",
            "Leave closure out: for a groove send its inner flank, for a counter roller its own "
            "cam with its own follower.",
        )  # fmt: skip
    points = np.array(cam.points_mm, dtype=float) * np.array([cam.mirror, 1.0])
    shape = outline(points, cam.tolerance_mm)
    rode = ride(shape, cam.follower, cam.tolerance_mm)
    found = read(rode, MOTION_SHARE * cam.tolerance_mm)
    return told(cam, shape, rode, found)
