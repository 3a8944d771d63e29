"""Files made from a spatial cam: one format a file. A new one is a file and its name here."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from synthesis.exporters.exporter import FileFormat
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.files import (
    body_step,
    body_stl,
    cutter_path,
    developed,
    developed_svg,
    flanks_ibl,
    flanks_step,
    flanks_table,
    motion,
    surfaces_json,
)
from synthesis.spatial.machines import MACHINES

Format = FileFormat[SpatialDesign, Any]
UNROLLED: tuple[Format, ...] = (developed.JSON, developed.CSV, developed_svg.SVG)
MOTION: tuple[Format, ...] = (motion.JSON, motion.CSV, motion.SVG)
WHOLE: tuple[Format, ...] = (
    flanks_ibl.FLANKS,
    flanks_table.CSV,
    flanks_table.JSON,
    flanks_step.STEP,
    body_stl.STL,
    body_step.STEP,
    surfaces_json.SURFACES,
)
FORMATS: Mapping[str, Format] = MappingProxyType(
    {each.name: each for each in (*MOTION, *UNROLLED, *WHOLE, cutter_path.CSV)}
)
"""Every format by the name of its file."""

_UNROLLING = {each.model_fields["kind"].default for each in MACHINES if each.unrolls}


def formats_of(machine: str) -> list[str]:
    """Names of the files that cams of a kind of machine can be had as."""
    drawn = {each.name for each in UNROLLED}
    return [name for name in FORMATS if name not in drawn or machine in _UNROLLING]
