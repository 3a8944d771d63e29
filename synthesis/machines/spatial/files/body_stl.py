"""STL, binary: the whole cam as a closed triangle mesh, for viewing, printing and measuring."""

from __future__ import annotations

import numpy as np

from synthesis.exporters.exporter import FileFormat, Made
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.body_mesh import MeshOptions, mesh_body
from synthesis.machines.spatial.triangulation import Mesh

MAX_TRIANGLES = 1_000_000
HEADER = 80  # bytes
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])


def _body(design: SpatialDesign, options: MeshOptions) -> Made:
    made = mesh_body(design, options, MAX_TRIANGLES)
    return Made(_written(made.mesh, f"Camwright {design.engine_version}, {design.id}"), made.told)


def _written(mesh: Mesh, title: str) -> bytes:
    corners = mesh.points[mesh.triangles]
    records = np.zeros(len(corners), dtype=RECORD)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    records["normal"] = normal / np.where(length > 0.0, length, 1.0)
    records["corners"] = corners
    head = title.encode("ascii", "replace")[:HEADER].ljust(HEADER)
    return head + np.uint32(len(records)).tobytes() + records.tobytes()


STL = FileFormat(
    "body.stl", "STL, the whole cam", "model/stl", ".stl", _body, MeshOptions,
    "The cam with its hub, cut from a turned blank, as a closed mesh in mm: for viewers, printing, "
    "or a first look in CAD. The header Camwright-Surface-Error-Mm gives its distance from the "
    "true surface.",
    apart=True,
)  # fmt: skip
