"""Every kept resource of the service, by its path."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from service.resources.analyses import ANALYSES, PROFILE_ANALYSES
from service.resources.cam_sets import CAM_SETS
from service.resources.designs import DESIGNS
from service.resources.linkages import LINKAGE_RESOURCES
from service.resources.resource import Resource
from service.resources.spatial_cams import SPATIAL_CAMS
from service.resources.train_responses import TRAIN_RESPONSES

RESOURCES: Mapping[str, Resource] = MappingProxyType(
    {
        each.path: each
        for each in (
            DESIGNS, CAM_SETS, ANALYSES, PROFILE_ANALYSES, SPATIAL_CAMS, TRAIN_RESPONSES,
            *LINKAGE_RESOURCES,
        )
    }
)  # fmt: skip
