"""The whole cam as a closed triangle mesh, and its STL file for viewing, printing and measuring."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.exporter import FileContent, FileFormat
from synthesis.machines.spatial.body import (
    Blank,
    BlankOptions,
    Mesh,
    build_body,
    flank_error,
    triangulate,
)
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.grooves import GrooveSections

MAX_TRIANGLES = 1_000_000  # of an STL file
HEADER = 80  # bytes
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])

Rows = Annotated[
    float, Field(ge=0.1, le=20.0, description="Rows of points per degree of cam angle.")
]
Levels = Annotated[
    int, Field(ge=2, le=100, description="Rows of points from a rib's top to the floor.")
]


@dataclass(frozen=True, kw_only=True)
class MeshOptions(BlankOptions):
    """As ``BlankOptions``, and how fine the mesh is."""

    points_per_degree: Rows = 1.0
    depths: Levels = 7


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """A mesh and its distance from the true surface.

    Attributes:
        error: largest measured distance [mm].
    """

    mesh: Mesh
    error: float

    @property
    def metadata(self) -> Mapping[str, str]:
        """Metadata of every file of a body."""
        return {
            "Surface-Error-Mm": f"{self.error:.3g}",
            "Volume-Mm3": f"{self.mesh.volume:.10g}",
            "Triangles": str(len(self.mesh.triangles)),
        }


def mesh_body(design: SpatialDesign, options: MeshOptions, most: int) -> BodyMesh:
    """The cam's surface with at most so many triangles.

    Raises:
        InputError: there may be more (checked before anything is computed), or there is no body.
    """
    parts = design.spec.machine.chart(design.cam.sizes).parts
    grooves = len(design.walls) // 2 + 2
    columns = (grooves + 1) * 2 * (options.depths - 1 + parts)
    count = 2 * columns * 360.0 * options.points_per_degree
    if count > most:
        fewer = options.points_per_degree * most / count
        raise InputError(
            "/points_per_degree",
            options.points_per_degree,
            f"This may make {count:.2g} triangles; a file has at most {most}.",
            f"Request at most {fewer:.3g}, or fewer depths.",
        )
    cuts = GrooveSections.of(design.cam, design.spec.machine)
    blank = Blank.of(cuts, options, options.depths)
    body = build_body(cuts, blank, round(360.0 * options.points_per_degree))
    return BodyMesh(triangulate(body), flank_error(cuts, body))


def _stl(design: SpatialDesign, options: MeshOptions) -> FileContent:
    made = mesh_body(design, options, MAX_TRIANGLES)
    corners = made.mesh.points[made.mesh.triangles]
    records = np.zeros(len(corners), dtype=RECORD)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    records["normal"] = normal / np.where(length > 0.0, length, 1.0)
    records["corners"] = corners
    title = f"Camwright {design.engine_version}, {design.id}"
    head = title.encode("ascii", "replace")[:HEADER].ljust(HEADER)
    return FileContent(head + np.uint32(len(records)).tobytes() + records.tobytes(), made.metadata)


STL = FileFormat(
    "body.stl", "STL, the whole cam", "model/stl", ".stl", _stl, MeshOptions,
    "The cam with its hub, cut from a turned blank, as a closed mesh in mm: for viewers, printing, "
    "or a first look in CAD. The header Camwright-Surface-Error-Mm gives its distance from the "
    "true surface.",
    in_worker=True,
)  # fmt: skip
