"""JSON: the exact curve as plain numbers, with how true it is."""

from __future__ import annotations

import json

from synthesis.design.design import Design
from synthesis.exporters.curves.exact import exact_curve, facts
from synthesis.exporters.curves.exact_options import ExactOptions
from synthesis.exporters.exporter import Exporter, FileContent
from synthesis.exporters.tables.formats import origin

MEANING = (
    "A clamped B-spline in the cam's frame, no weights: its parameter is the arc length in mm, its "
    "last control point is its first. Inner knots stand once where it has four continuous "
    "derivatives, three times where curvature is continuous, four times where curvature jumps, "
    "five times at a corner. error_mm is the largest distance from the true curve, along its "
    "normal, measured on every piece."
)


def _profile(design: Design, options: ExactOptions) -> FileContent:
    curve = exact_curve(design, options)
    spline = curve.spline
    body = {
        "kind": "exact_curve",
        "curve": curve.name,
        "meaning": MEANING,
        "design": origin(design),
        "tolerance_mm": options.tolerance_mm,
        "error_mm": spline.error,
        "length_mm": spline.length,
        "enclosed_area_mm2": spline.area,
        "nodes": spline.nodes,
        "turn_deg": options.turn_deg,
        "degree": spline.degree,
        "closed": True,
        "rational": False,
        "knots_mm": spline.knots.tolist(),
        "control_points_mm": curve.points.tolist(),
    }
    text = json.dumps(body, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return FileContent(text.encode() + b"\n", facts(curve))


PROFILE = Exporter(
    "nurbs.json",
    "Exact curve as B-spline",
    "application/json",
    ".nurbs.json",
    _profile,
    ExactOptions,
    by_default=False,
    purpose="Degree, knots and control points of the exact curve, for programs: with its error, "
    "length and the area it encloses.",
)
