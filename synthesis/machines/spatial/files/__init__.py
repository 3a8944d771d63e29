"""Files of a spatial cam; a new format: a module, an entry in ``formats.toml``, its name here.

In: a SpatialDesign and the options of a format. Out: bytes with metadata. Open ``flanks`` first:
points of the flanks. ``step`` holds surfaces of the flanks and the cam as a solid, ``body_mesh``
the cam as a mesh, ``developed*`` the development of cylindrical cams, ``cutter_path`` cutter poses,
``motion`` the follower's motion.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from synthesis.exporters.exporter import FileFormat
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files import (
    body_mesh,
    cutter_path,
    developed,
    developed_svg,
    flanks,
    motion,
    step,
)
from synthesis.machines.spatial.spec import MACHINES

Format = FileFormat[SpatialDesign, Any]
DEVELOPED: tuple[Format, ...] = (developed.JSON, developed.CSV, developed_svg.SVG)
_ALL: tuple[Format, ...] = (
    motion.JSON, motion.CSV, motion.SVG, *DEVELOPED, flanks.FLANKS, flanks.CSV, flanks.JSON,
    step.FLANKS, body_mesh.STL, step.BODY, body_mesh.SURFACES, cutter_path.CSV,
)  # fmt: skip
FORMATS: Mapping[str, Format] = MappingProxyType({each.name: each for each in _ALL})
"""Every format by the name of its file."""

_DEVELOPABLE = {each.model_fields["kind"].default for each in MACHINES if each.developable}


def formats_of(machine: str) -> list[str]:
    """Names of the files available for a kind of machine."""
    drawn = {each.name for each in DEVELOPED}
    return [name for name in FORMATS if name not in drawn or machine in _DEVELOPABLE]
