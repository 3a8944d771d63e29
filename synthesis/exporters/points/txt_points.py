"""Plain points for the curve import of a CAD system: x y z in mm, ASCII, ten decimals.

z is 0, or what is asked for: the cam's position along its shaft.

A closed ring: the last point joins the first, which is not repeated unless it is asked for. The
seam lies in the middle of the longest dwell, where the natural end of a CAD spline does least harm.
No header.
"""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.fidelity.told import fidelity_told
from synthesis.exporters.options import PointOptions
from synthesis.exporters.points.rows import point_rows
from synthesis.exporters.samples.cutting import chosen
from synthesis.exporters.samples.sampling import written_points


def _profile(design: Design, options: PointOptions) -> bytes:
    cam = chosen(design, options)
    points = written_points(cam, options).ended(options, closed=False)
    return point_rows(points, options, "{x} {y} {z}\n")


PROFILE = Exporter(
    "txt", "Points x y z for CAD", "text/plain; charset=us-ascii", ".txt",
    _profile, PointOptions,
    "Curve through points in most CAD systems and in coordinate measuring machines.",
    measure=fidelity_told,
)  # fmt: skip
