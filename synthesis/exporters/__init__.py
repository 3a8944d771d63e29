"""Files made from a design: one format a file. A new one is a file and its name here.

PROFILE_FORMATS["csv"].write(design, ProfileOptions(points_per_degree=10.0))
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from synthesis.exporters import (
    csv_table,
    dxf_drawing,
    fidelity_json,
    ibl_curve,
    iges_curve,
    json_table,
    nurbs_json,
    sldcrv_curve,
    step_curve,
    svg_motion,
    svg_profile,
    txt_points,
    txt_table,
    xlsx_points,
)
from synthesis.exporters.cam import profiles
from synthesis.exporters.exact_options import DrawingOptions, ExactOptions
from synthesis.exporters.exporter import Exporter, Made
from synthesis.exporters.options import (
    CurveName,
    MotionOptions,
    Options,
    PointOptions,
    ProfileOptions,
    form,
)

PROFILE_FORMATS: Mapping[str, Exporter[Any]] = MappingProxyType(
    {
        each.name: each
        for each in (
            json_table.PROFILE,
            csv_table.PROFILE,
            txt_points.PROFILE,
            svg_profile.PROFILE,
            ibl_curve.PROFILE,
            sldcrv_curve.PROFILE,
            xlsx_points.PROFILE,
            fidelity_json.PROFILE,
            dxf_drawing.PROFILE,
            step_curve.PROFILE,
            iges_curve.PROFILE,
            nurbs_json.PROFILE,
        )
    }
)
MOTION_FORMATS: Mapping[str, Exporter[Any]] = MappingProxyType(
    {
        each.name: each
        for each in (json_table.MOTION, csv_table.MOTION, txt_table.MOTION, svg_motion.MOTION)
    }
)

__all__ = [
    "MOTION_FORMATS",
    "PROFILE_FORMATS",
    "CurveName",
    "DrawingOptions",
    "ExactOptions",
    "Exporter",
    "Made",
    "MotionOptions",
    "Options",
    "PointOptions",
    "ProfileOptions",
    "form",
    "profiles",
]
