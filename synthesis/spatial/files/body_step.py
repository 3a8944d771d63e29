"""STEP AP242: the whole cam as one solid of flat faces, in mm. No kernel is needed.

The mesh of ``body.stl`` as a faceted boundary representation: faces share their points, so that
readers share their edges. A boolean difference of smooth surfaces is not tried: kernels make no
sound solid of it where walls run out of the blank at a grazing angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.errors import InputError
from synthesis.exporters.curves.part21 import Entities, exchange_file, many, real, text
from synthesis.exporters.curves.step_curve import FINEST, SCHEMA, axes, context, product
from synthesis.exporters.exporter import FileFormat, Made
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.facets import Facet, facets_of, thinnest
from synthesis.spatial.files.body_mesh import Levels, MeshOptions, Rows, meshed

MAX_TRIANGLES = 100_000
DIGITS = 12  # of normals


@dataclass(frozen=True, kw_only=True)
class FacetedOptions(MeshOptions):
    """As ``MeshOptions``, coarser: a face takes six times the room that it takes in an STL file."""

    points_per_degree: Rows = 0.4
    depths: Levels = 4


def _body(design: SpatialDesign, options: FacetedOptions) -> Made:
    made = meshed(design, options, MAX_TRIANGLES)
    thin = thinnest(made.mesh)
    if thin < FINEST:
        raise InputError(
            "/points_per_degree", options.points_per_degree,
            f"A face {thin:.2g} mm wide comes about; solids need {FINEST:.2g} mm.",
            "Change the number of points, the width or the bore, or take the mesh as STL.",
        )  # fmt: skip
    facets = facets_of(made.mesh)
    data = Entities()
    shared = context(data, FINEST, "points nearer to each other are one")
    name = text(design.name or f"cam {design.id}")
    origin = data.add("CARTESIAN_POINT", "''", many(map(real, (0.0, 0.0, 0.0))))
    placed = data.add("AXIS2_PLACEMENT_3D", "''", origin, *axes(data))
    points = [
        data.add("CARTESIAN_POINT", "''", many(map(real, point)))
        for point in made.mesh.points.tolist()
    ]
    shell = data.add("CLOSED_SHELL", "''", many([_face(data, each, points) for each in facets]))
    solid = data.add("FACETED_BREP", name, shell)
    shape = data.add("FACETED_BREP_SHAPE_REPRESENTATION", name, many([placed, solid]), shared)
    data.add("SHAPE_DEFINITION_REPRESENTATION", product(data, design), shape)
    title = (
        f"Spatial cam, faceted: flat faces, {made.told['Surface-Error-Mm']} mm measured to the "
        "true surface; the smooth walls are in flanks.step"
    )
    told = {**made.told, "Faces": str(len(facets))}
    return Made(exchange_file(design, title, SCHEMA, data.lines()), told)


def _face(data: Entities, facet: Facet, points: list[str]) -> str:
    normal = np.round(facet.normal, DIGITS) + 0.0
    axis = data.add("DIRECTION", "''", many(map(real, normal.tolist())))
    placed = data.add("AXIS2_PLACEMENT_3D", "''", points[facet.loops[0][0]], axis, "$")
    plane = data.add("PLANE", "''", placed)
    bounds = []
    for i, loop in enumerate(facet.loops):
        way = data.add("POLY_LOOP", "''", many([points[corner] for corner in loop]))
        bounds.append(data.add("FACE_BOUND" if i else "FACE_OUTER_BOUND", "''", way, ".T."))
    return data.add("FACE_SURFACE", "''", many(bounds), plane, ".T.")


STEP = FileFormat(
    "body.step", "STEP AP242, the whole cam as a faceted solid", "model/step", ".step",
    _body, FacetedOptions,
    "The body of body.stl as one closed solid of flat faces in mm: for assemblies, mass and "
    "collisions in CAD. Not for machining: smooth walls are in flanks.step. How far it is from "
    "the true surface is told in the file's header and in Camwright-Surface-Error-Mm.",
    usual=False,
    apart=True,
)  # fmt: skip
