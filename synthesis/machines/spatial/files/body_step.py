"""STEP AP242: the whole cam as one solid, smooth where possible, otherwise faceted, in mm.

The faceted solid is the mesh of ``body.stl`` as a boundary representation whose faces share points,
so that readers recognise common edges.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.curves.part21 import Entities, exchange_file, many, real, text
from synthesis.exporters.curves.step_curve import FINEST, SCHEMA, axes, context, product
from synthesis.exporters.exporter import FileFormat, Made
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.body_mesh import Levels, MeshOptions, Rows, mesh_body
from synthesis.machines.spatial.files.body_smooth import smooth
from synthesis.machines.spatial.planar_faces import Facet, merge_planar_faces, thinnest
from synthesis.machines.spatial.solid.sheets import NotSmooth

MAX_TRIANGLES = 100_000
DIGITS = 12  # decimals of normals


@dataclass(frozen=True, kw_only=True)
class FacetedOptions(MeshOptions):
    """The boundary of the solid; rows and depths are those of a faceted one.

    Attributes:
        form: smooth or faceted; None: smooth where possible. tolerance_um: of smooth walls.
    """

    form: Annotated[
        Literal["smooth", "faceted"] | None,
        Field(
            description="smooth: true surfaces, walls as B-splines within tolerance_um; faceted: "
            "flat faces, by points_per_degree and depths. Left out: smooth where possible. The "
            "header Camwright-Body says which it is."
        ),
    ] = None
    tolerance_um: Annotated[
        float,
        Field(ge=0.1, le=1e3, description="Largest distance of smooth walls from the true ones."),
    ] = 1.0
    points_per_degree: Rows = 0.4
    depths: Levels = 4


def _body(design: SpatialDesign, options: FacetedOptions) -> Made:
    if options.form == "faceted":
        return _faceted(design, options)
    try:
        return smooth(design, options, 1e-3 * options.tolerance_um)
    except NotSmooth as why:
        if options.form is None:
            return _faceted(design, options)
        raise InputError(
            "/form", options.form, f"This cam has no smooth solid: {why}.",
            "Choose form=faceted, or a larger tolerance_um.",
        ) from None  # fmt: skip


def _faceted(design: SpatialDesign, options: FacetedOptions) -> Made:
    made = mesh_body(design, options, MAX_TRIANGLES)
    thin = thinnest(made.mesh)
    if thin < FINEST:
        raise InputError(
            "/points_per_degree", options.points_per_degree,
            f"The narrowest face would be {thin:.2g} mm wide; a solid needs {FINEST:.2g} mm.",
            "Change the number of points, the width or the bore, or use the mesh in STL.",
        )  # fmt: skip
    facets = merge_planar_faces(made.mesh)
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
    told = {"Body": "faceted", **made.told, "Faces": str(len(facets))}
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
    "body.step", "STEP AP242, the whole cam as a solid", "model/step", ".step",
    _body, FacetedOptions,
    "One closed solid in mm, bounded by the cam's true surfaces within tolerance_um; where that is "
    "not possible, the body of body.stl in flat faces. The file's header, Camwright-Body and "
    "Camwright-Surface-Error-Mm say which it is and its distance from the true surface.",
    usual=False,
    apart=True,
)  # fmt: skip
