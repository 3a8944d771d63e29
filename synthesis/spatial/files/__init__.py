"""Files made from a spatial cam: one format a file. A new one is a file and its name here.

SPATIAL_FILES["flanks.csv"].write(design, TableOptions(depths=3))
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from synthesis.exporters.exporter import FileFormat
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.files import body_stl, flanks_ibl, flanks_table

SPATIAL_FILES: Mapping[str, FileFormat[SpatialDesign, Any]] = MappingProxyType(
    {
        each.name: each
        for each in (flanks_ibl.FLANKS, flanks_table.CSV, flanks_table.JSON, body_stl.STL)
    }
)
