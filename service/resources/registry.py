"""Every kept resource of the service, by its path."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from service.resources.cam_sets import CAM_SETS
from service.resources.designs import ANALYSES, DESIGNS, PROFILE_ANALYSES
from service.resources.machines import LINKAGE_RESOURCES, SPATIAL_CAMS, TRAIN_RESPONSES
from service.resources.resource import Resource

ALL = (
    DESIGNS, CAM_SETS, ANALYSES, PROFILE_ANALYSES, SPATIAL_CAMS, TRAIN_RESPONSES,
    *LINKAGE_RESOURCES,
)  # fmt: skip
RESOURCES: Mapping[str, Resource] = MappingProxyType({each.path: each for each in ALL})
