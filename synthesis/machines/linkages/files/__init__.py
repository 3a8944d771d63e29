"""Files of linkages, by kind and file name.

In: the answer about a linkage and a format's options. Out: bytes. ``linkage_file`` is what a file
provides; a new one is a module and its name here. ``*_tables`` are CSV and JSON, ``*_pictures``
drawings and animations, ``scene_json`` what the studio draws, ``shaper_cam`` the ram's motion as a
cam's spec.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from synthesis.machines.linkages.files import (
    arm_pictures,
    arm_tables,
    scene_json,
    shaper_cam,
    shaper_pictures,
    shaper_tables,
)
from synthesis.machines.linkages.files.linkage_file import LinkageFile


def _named(*files: LinkageFile) -> Mapping[str, LinkageFile]:
    return MappingProxyType({each.name: each for each in files})


LINKAGE_FILES: Mapping[str, Mapping[str, LinkageFile]] = MappingProxyType(
    {
        "six-bar-shapers": _named(
            shaper_tables.CSV,
            shaper_tables.JSON,
            shaper_cam.CAM,
            shaper_pictures.MOTION,
            shaper_pictures.ANIMATION,
            shaper_pictures.PAGE,
            scene_json.SHAPER,
        ),
        "palletising-arms": _named(
            arm_tables.WORKSPACE,
            arm_tables.SOLUTIONS,
            arm_pictures.WORKSPACE,
            arm_pictures.ANIMATION,
            arm_pictures.PAGE,
            scene_json.ARM,
        ),
    }
)

__all__ = ["LINKAGE_FILES", "LinkageFile"]
