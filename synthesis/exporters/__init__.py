"""Files made from a design: one format a file. A new one is a file and its name here.

PROFILE_FORMATS["csv"].write(design, ProfileOptions(points_per_degree=10.0))
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from synthesis.exporters import (
    animation_page,
    animation_svg,
    csv_table,
    json_table,
    svg_contact,
    svg_motion,
    svg_profile,
    txt_points,
    txt_table,
)
from synthesis.exporters.cam import profiles
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.options import CurveName, MotionOptions, PictureOptions, ProfileOptions
from synthesis.exporters.report import report

PROFILE_FORMATS: Mapping[str, Exporter[ProfileOptions]] = MappingProxyType(
    {
        each.name: each
        for each in (json_table.PROFILE, csv_table.PROFILE, txt_points.PROFILE, svg_profile.PROFILE)
    }
)
MOTION_FORMATS: Mapping[str, Exporter[MotionOptions]] = MappingProxyType(
    {
        each.name: each
        for each in (json_table.MOTION, csv_table.MOTION, txt_table.MOTION, svg_motion.MOTION)
    }
)
PICTURES: Mapping[str, Exporter[PictureOptions]] = MappingProxyType(
    {
        each.name: each
        for each in (
            svg_contact.CONTACT,
            animation_svg.ANIMATION,
            animation_page.PAGE,
            report(PROFILE_FORMATS, MOTION_FORMATS),
        )
    }
)

__all__ = [
    "MOTION_FORMATS",
    "PICTURES",
    "PROFILE_FORMATS",
    "CurveName",
    "Exporter",
    "MotionOptions",
    "PictureOptions",
    "ProfileOptions",
    "profiles",
]
