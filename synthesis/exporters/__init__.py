"""Files made from a design: one format a file. A new one is a file and its name here.

Formats stand in rooms by what comes out: ``tables``, ``points``, ``curves``, ``solids``,
``figures``, ``diagrams``, ``animations``, ``machining``, ``drives``, ``linkages``. What they share
is below them: ``samples`` (the cam at its angles), ``fidelity`` (what readers make of points) and
``drawing`` (SVG and HTML by hand); above them ``report``, ``png_picture`` and ``bundle``.

PROFILE_FORMATS["csv"].write(design, ProfileOptions(points_per_degree=10.0))
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from synthesis.exporters import png_picture
from synthesis.exporters.animations import animation_json, animation_page, animation_svg
from synthesis.exporters.curves import dxf_drawing, iges_curve, nurbs_json, step_curve
from synthesis.exporters.curves.exact_options import DrawingOptions, ExactOptions
from synthesis.exporters.diagrams import contact, motion
from synthesis.exporters.drawing.picture_options import PictureOptions
from synthesis.exporters.drives import codesys, kollmorgen, plain, rockwell, sew, twincat
from synthesis.exporters.drives import fidelity_json as drive_fidelity
from synthesis.exporters.exporter import Exporter, FileContent
from synthesis.exporters.fidelity import fidelity_json
from synthesis.exporters.figures import profile
from synthesis.exporters.machining import grinding, milling
from synthesis.exporters.options import (
    CurveName,
    MotionOptions,
    Options,
    PointOptions,
    ProfileOptions,
    form,
)
from synthesis.exporters.points import ibl_curve, sldcrv_curve, txt_points, xlsx_points
from synthesis.exporters.report import report_with
from synthesis.exporters.samples.cam import profiles
from synthesis.exporters.solids import solid_step
from synthesis.exporters.tables import csv_table, json_table, txt_table
from synthesis.exporters.tables.json_table import JsonOptions

PROFILE_FORMATS: Mapping[str, Exporter[Any]] = MappingProxyType(
    {
        each.name: each
        for each in (
            json_table.PROFILE,
            csv_table.PROFILE,
            txt_points.PROFILE,
            profile.PROFILE,
            ibl_curve.PROFILE,
            sldcrv_curve.PROFILE,
            xlsx_points.PROFILE,
            milling.PROFILE,
            grinding.PROFILE,
            fidelity_json.PROFILE,
            dxf_drawing.PROFILE,
            step_curve.PROFILE,
            iges_curve.PROFILE,
            nurbs_json.PROFILE,
        )
    }
)
SOLID_FORMATS: Mapping[str, Exporter[Any]] = MappingProxyType(
    {each.name: each for each in (solid_step.SOLID,)}
)
MOTION_FORMATS: Mapping[str, Exporter[Any]] = MappingProxyType(
    {
        each.name: each
        for each in (
            json_table.MOTION,
            csv_table.MOTION,
            txt_table.MOTION,
            motion.MOTION,
            plain.MOTION,
            twincat.MOTION,
            codesys.MOTION,
            rockwell.MOTION,
            kollmorgen.MOTION,
            sew.MOTION,
            drive_fidelity.MOTION,
        )
    }
)
PICTURES: Mapping[str, Exporter[Any]] = MappingProxyType(
    {
        each.name: each
        for each in (
            contact.CONTACT,
            animation_svg.ANIMATION,
            animation_page.PAGE,
            animation_json.DATA,
            *png_picture.PIXELS,
            report_with(PROFILE_FORMATS, MOTION_FORMATS),
        )
    }
)
# Every drawing and page by the name of its file.
DRAWINGS: Mapping[str, Exporter[Any]] = MappingProxyType(
    {"profile.svg": PROFILE_FORMATS["svg"], "motion.svg": MOTION_FORMATS["svg"], **PICTURES}
)

__all__ = [
    "DRAWINGS",
    "MOTION_FORMATS",
    "PICTURES",
    "PROFILE_FORMATS",
    "SOLID_FORMATS",
    "CurveName",
    "DrawingOptions",
    "ExactOptions",
    "Exporter",
    "FileContent",
    "JsonOptions",
    "MotionOptions",
    "Options",
    "PictureOptions",
    "PointOptions",
    "ProfileOptions",
    "form",
    "profiles",
    "report_with",
]
