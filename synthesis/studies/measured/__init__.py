"""Measured: the motion that a measured profile gives a follower.

    points -> outline (smooth curve) -> contact (follower on it) -> motion (spline) -> report

In: a MeasuredCam, points of a profile and a follower given in full. Out: a ProfileAnalysis: motion,
extremes with their uncertainty, dwells, and what the follower does not touch.
"""

from __future__ import annotations

from math import inf

import numpy as np

from synthesis.catalogue.ranges import ends
from synthesis.errors import InputError
from synthesis.studies.measured.contact import follow_outline
from synthesis.studies.measured.motion import fit_motion
from synthesis.studies.measured.outline import outline
from synthesis.studies.measured.report import ProfileAnalysis, report_profile
from synthesis.studies.measured.spec import MeasuredCam

__all__ = ["MeasuredCam", "ProfileAnalysis", "read_back"]

MOTION_SHARE = 0.1  # of the tolerance: allowed distance of the spline from the positions


def read_back(cam: MeasuredCam) -> ProfileAnalysis:
    """The motion that a follower makes on a measured profile.

    Raises:
        InputError: a dimension of the follower is left free, or it is form-closed; the points are
            no
            closed curve around the axis, or scatter beyond the tolerance; the follower does not
            reach the profile.
    """
    searched = cam.follower.searched_dimensions((-inf, inf)).items()
    free = {
        **cam.follower.adjustable_dimensions(),
        **{name: asked for name, (asked, _) in searched},
    }
    for name, value in free.items():
        low, high = ends(value)
        if low != high:
            raise InputError(
                f"/follower/{name}", None, "A measured profile needs a follower given in full.",
                "Give this dimension as a number.",
            )  # fmt: skip
    follower = cam.follower
    if follower.active_closure.counter_paths or [one.side for one in follower.flanks] != [1]:
        raise InputError(
            "/follower/closure", cam.follower.kind,
            "A measured profile is read with one roller that touches it from outside.",
            "Leave closure out: for a groove send its inner flank, for a counter roller its own "
            "cam with its own follower.",
        )  # fmt: skip
    points = np.array(cam.points_mm, dtype=float) * np.array([cam.mirror, 1.0])
    shape = outline(points, cam.tolerance_mm)
    path = follow_outline(shape, cam.follower, cam.tolerance_mm)
    found = fit_motion(path, MOTION_SHARE * cam.tolerance_mm)
    return report_profile(cam, shape, path, found)
