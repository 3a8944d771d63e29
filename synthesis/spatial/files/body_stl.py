"""STL, binary: the whole cam as a closed mesh of triangles, for looking, printing and measuring."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.exporter import FileFormat, Made
from synthesis.spatial.blank import Blank, BlankOptions
from synthesis.spatial.body import body_of, flank_error
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.grooves import Cuts
from synthesis.spatial.mesh import Mesh, mesh_of

MAX_TRIANGLES = 1_000_000
HEADER = 80  # bytes
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])


@dataclass(frozen=True, kw_only=True)
class StlOptions(BlankOptions):
    """As ``BlankOptions``, and how fine the mesh is.

    Attributes:
        points_per_degree: rows of points round the cam. depths: rows from a rib's top to the floor.
    """

    points_per_degree: Annotated[
        float, Field(ge=0.1, le=20.0, description="Rows of points per degree of cam angle.")
    ] = 1.0
    depths: Annotated[
        int, Field(ge=2, le=100, description="Rows of points from a rib's top to the floor.")
    ] = 7


def _body(design: SpatialDesign, options: StlOptions) -> Made:
    _check(design, options)
    cuts = Cuts.of(design.cam, design.spec.machine)
    blank = Blank.of(cuts, options, options.depths)
    body = body_of(cuts, blank, round(360.0 * options.points_per_degree))
    mesh = mesh_of(body)
    told = {
        "Surface-Error-Mm": f"{flank_error(cuts, body):.3g}",
        "Volume-Mm3": f"{mesh.volume:.10g}",
        "Triangles": str(len(mesh.triangles)),
    }
    return Made(_written(mesh, f"Camwright {design.engine_version}, {design.id}"), told)


def _written(mesh: Mesh, title: str) -> bytes:
    corners = mesh.points[mesh.triangles]
    records = np.zeros(len(corners), dtype=RECORD)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    records["normal"] = normal / np.where(length > 0.0, length, 1.0)
    records["corners"] = corners
    head = title.encode("ascii", "replace")[:HEADER].ljust(HEADER)
    return head + np.uint32(len(records)).tobytes() + records.tobytes()


def _check(design: SpatialDesign, options: StlOptions) -> None:
    """Refuse before anything is computed."""
    parts = design.spec.machine.chart(design.cam.sizes).parts
    grooves = len(design.walls) // 2 + 2
    columns = (grooves + 1) * 2 * (options.depths - 1 + parts)
    count = 2 * columns * 360.0 * options.points_per_degree
    if count > MAX_TRIANGLES:
        most = options.points_per_degree * MAX_TRIANGLES / count
        raise InputError(
            "/points_per_degree",
            options.points_per_degree,
            f"This may make {count:.2g} triangles; a file has at most {MAX_TRIANGLES}.",
            f"Ask for at most {most:.3g}, or for fewer depths.",
        )


STL = FileFormat(
    "body.stl", "STL, the whole cam", "model/stl", ".stl", _body, StlOptions,
    "The cam with its hub, cut from a turned blank, as a closed mesh in mm: for viewers, printing, "
    "or a first look in CAD. How far it is from the true surface is told in the header "
    "Camwright-Surface-Error-Mm.",
    apart=True,
)  # fmt: skip
