"""Files made from answers about linkages, by kind and by name of the file."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from synthesis.exporters.linkages import (
    arm_pictures,
    arm_tables,
    scene_json,
    shaper_cam,
    shaper_pictures,
    shaper_tables,
)
from synthesis.exporters.linkages.file import LinkageFile


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
