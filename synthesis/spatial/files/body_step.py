"""STEP AP242: the whole cam as one solid, smooth where it can be, else of flat faces, in mm.

Of flat faces it is the mesh of ``body.stl`` as a faceted boundary representation: faces share their
points, so that readers share their edges.
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
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.facets import Facet, facets_of, thinnest
from synthesis.spatial.files.body_mesh import Levels, MeshOptions, Rows, meshed
from synthesis.spatial.files.body_smooth import smooth
from synthesis.spatial.smooth.sheets import NotSmooth

MAX_TRIANGLES = 100_000
DIGITS = 12  # of normals


@dataclass(frozen=True, kw_only=True)
class FacetedOptions(MeshOptions):
    """What the solid is bounded by; rows and depths are of a faceted one, coarser than a mesh's.

    Attributes:
        form: smooth or faceted; None: smooth where that can be. tolerance_um: of smooth walls.
    """

    form: Annotated[
        Literal["smooth", "faceted"] | None,
        Field(
            description="smooth: true surfaces, walls as B-splines within tolerance_um; faceted: "
            "flat faces, by points_per_degree and depths. Left out: smooth where that can be. The "
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
            "Take form=faceted, or a larger tolerance_um.",
        ) from None  # fmt: skip


def _faceted(design: SpatialDesign, options: FacetedOptions) -> Made:
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
    "One closed solid in mm, bounded by the cam's true surfaces within tolerance_um; where walls "
    "cannot be told so, the body of body.stl in flat faces. Which it is, and how far it is from "
    "the true surface, is told in the file's header, in Camwright-Body and "
    "Camwright-Surface-Error-Mm.",
    usual=False,
    apart=True,
)  # fmt: skip
