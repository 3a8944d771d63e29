"""Files made from a design. A new format is a ``design_format`` and its name in a registry here.

In: a Design and the options of a format. Out: bytes with metadata, the same for the same question.
Formats stand in packages by what comes out: ``tables``, ``points``, ``curves``, ``solids``,
``figures``, ``diagrams``, ``animations``, ``machining``, ``drives``. What they share is below them:
``samples`` (the cam at its angles), ``fidelity`` (what readers make of points) and ``drawing`` (SVG
HTML, PNG); above them ``report`` and ``bundle``. Open ``exporter`` first, then ``samples/cam``.

PROFILE_FORMATS["csv"].write(design, ProfileOptions(points_per_degree=10.0))
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from synthesis.exporters import drives, machining, points, tables
from synthesis.exporters.animations import cam_animation
from synthesis.exporters.curves import dxf, exact, iges, step
from synthesis.exporters.diagrams import sheet
from synthesis.exporters.drawing.raster import painted
from synthesis.exporters.exporter import Exporter, FileContent
from synthesis.exporters.fidelity import report as fidelity
from synthesis.exporters.figures import profile
from synthesis.exporters.options import (
    MotionOptions,
    Options,
    PictureOptions,
    PointOptions,
    ProfileOptions,
    form,
)
from synthesis.exporters.report import report_with
from synthesis.exporters.report.datasheet import DATASHEET_HTML, DATASHEET_PDF
from synthesis.exporters.solids import solid_step

Registry = Mapping[str, Exporter[Any]]


def _registry(*formats: Exporter[Any]) -> Registry:
    return MappingProxyType({each.name: each for each in formats})


PROFILE_FORMATS = _registry(
    tables.JSON_PROFILE,
    tables.CSV_PROFILE,
    points.TXT,
    profile.PROFILE,
    points.IBL,
    points.SLDCRV,
    points.XLSX,
    machining.MILLING,
    machining.GRINDING,
    fidelity.PROFILE,
    dxf.PROFILE,
    step.PROFILE,
    iges.PROFILE,
    exact.NURBS_JSON,
)
SOLID_FORMATS = _registry(solid_step.SOLID)
MOTION_FORMATS = _registry(
    tables.JSON_MOTION, tables.CSV_MOTION, tables.TXT_MOTION, sheet.MOTION, *drives.MOTIONS
)
PICTURES = _registry(
    sheet.CONTACT,
    *cam_animation.FORMATS,
    painted("profile", profile.PROFILE),
    painted("motion", sheet.MOTION),
    painted("contact", sheet.CONTACT),
    report_with(PROFILE_FORMATS, MOTION_FORMATS),
    DATASHEET_HTML,
    DATASHEET_PDF,
)
# Every drawing and page by the name of its file.
DRAWINGS: Registry = MappingProxyType(
    {"profile.svg": PROFILE_FORMATS["svg"], "motion.svg": MOTION_FORMATS["svg"], **PICTURES}
)

__all__ = [
    "DRAWINGS",
    "MOTION_FORMATS",
    "PICTURES",
    "PROFILE_FORMATS",
    "SOLID_FORMATS",
    "Exporter",
    "FileContent",
    "MotionOptions",
    "Options",
    "PictureOptions",
    "PointOptions",
    "ProfileOptions",
    "form",
    "report_with",
]
