"""Plain points for the curve import of a CAD system: x y z in mm, ASCII, ten decimals.

z is 0, or what is asked for: the cam's position along its shaft.

A closed ring: the last point joins the first, which is not repeated. The seam lies in the middle
of the longest dwell, where the natural end of a CAD spline does least harm. No header.
"""

from __future__ import annotations

import numpy as np

from synthesis.design import Design
from synthesis.exporters.cam import Cam
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.options import ProfileOptions
from synthesis.exporters.sampling import RING_DECIMALS, ring_points


def _profile(design: Design, options: ProfileOptions) -> bytes:
    cam = Cam.of(design, options.curve)
    points = np.round(ring_points(cam, options), RING_DECIMALS) + 0.0  # no −0
    z = round(options.z_mm or 0.0, RING_DECIMALS) + 0.0
    row = f"%.{RING_DECIMALS}f %.{RING_DECIMALS}f {z:.{RING_DECIMALS}f}\n"
    return (row * len(points) % tuple(points.ravel().tolist())).encode("ascii")


PROFILE = Exporter("txt", "Points x y z for CAD", "text/plain; charset=us-ascii", ".txt", _profile)
