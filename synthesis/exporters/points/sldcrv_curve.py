"""SLDCRV: a curve through points for SOLIDWORKS.

x, y and z with the unit after each, tabs between them, CRLF; no header and no comments. The first
point stands at the end once more: so the curve is closed. Points closer than 0.01 mm are refused
there, and so they are here.
"""

from __future__ import annotations

import numpy as np

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.fidelity.told import fidelity_told
from synthesis.exporters.options import PointOptions
from synthesis.exporters.points.rows import point_rows
from synthesis.exporters.samples.cutting import chosen
from synthesis.exporters.samples.sampling import in_degrees, written_points

NEAREST_MM = 0.01


def _profile(design: Design, options: PointOptions) -> bytes:
    cam = chosen(design, options)
    written = written_points(cam, options)
    steps = np.hypot(*(np.roll(written.points, -1, axis=0) - written.points).T)
    if steps.min() < NEAREST_MM:
        at = in_degrees(written.theta[int(np.argmin(steps))])
        raise InputError(
            "/points" if options.tolerance_um is None else "/tolerance_um",
            options.points if options.tolerance_um is None else options.tolerance_um,
            f"SOLIDWORKS takes no points nearer to each other than {NEAREST_MM} mm; at cam angle "
            f"{at:.6g}° there would be {steps.min():.3g} mm between two.",
            "Ask for fewer points.",
        )
    points = written.ended(options, closed=True)
    return point_rows(points, options, "{x}mm\t{y}mm\t{z}mm\r\n")


PROFILE = Exporter(
    "sldcrv", "Curve for SOLIDWORKS", "text/plain; charset=us-ascii", ".sldcrv", _profile,
    PointOptions, "SOLIDWORKS: Insert, Curve, Curve Through XYZ Points.", by_default=False,
    measure=fidelity_told,
)  # fmt: skip
