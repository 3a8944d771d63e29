"""STEP AP242: the whole cam as one solid, smooth where possible, otherwise faceted, in mm.

The smooth solid is bounded by the cam's true surfaces. It is written without a geometry kernel:
Boolean differences fail where walls leave the blank at a grazing angle. Tops and floors are the
turned surfaces themselves, walls are B-splines whose boundary curves are the faces' edges, and
every edge is made once for both of its faces.

The faceted solid is the mesh of ``body.stl`` as a boundary representation whose faces share points,
so that readers recognise common edges. Coplanar triangles across the cam's axis are one face.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from synthesis.errors import InputError
from synthesis.exporters.curves.exact import FINEST
from synthesis.exporters.curves.step import Entities, many, real, shape_file, text
from synthesis.exporters.exporter import FileContent, FileFormat
from synthesis.machines.spatial.body import Blank, BlankOptions, Mesh, Whole
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.body_mesh import Levels, MeshOptions, Rows, mesh_body
from synthesis.machines.spatial.grooves import GrooveSections
from synthesis.machines.spatial.solid.build import Builder
from synthesis.machines.spatial.solid.geometry import NotSmooth, Shell
from synthesis.machines.spatial.solid.sheets import (
    TooFewDepths,
    WallSheets,
    cluster_at_ends,
)
from synthesis.numerics.piecewise import Array

DEPTHS = 65  # of a smooth solid, from the ribs' tops to the floor
STRIDES = (4, 2, 1)  # every so many depths are used: coarse first, for small files
MAX_TRIANGLES = 100_000  # of a faceted solid
DIGITS = 12  # decimals of normals
Loop = list[int]


@dataclass(frozen=True, kw_only=True)
class FacetedOptions(MeshOptions):
    """The boundary of the solid; rows and depths are those of a faceted one."""

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


def _body(design: SpatialDesign, options: FacetedOptions) -> FileContent:
    if options.form == "faceted":
        return _faceted(design, options)
    try:
        return _smooth(design, options, 1e-3 * options.tolerance_um)
    except NotSmooth as why:
        if options.form is None:
            return _faceted(design, options)
        raise InputError(
            "/form", options.form, f"This cam has no smooth solid: {why}.",
            "Choose form=faceted, or a larger tolerance_um.",
        ) from None  # fmt: skip


def _smooth(design: SpatialDesign, options: BlankOptions, tolerance: float) -> FileContent:
    shell, largest = build_solid(design, options, tolerance)

    def write(data: Entities) -> str:
        name = text(design.name or f"cam {design.id}")
        return data.add("MANIFOLD_SOLID_BREP", name, shell.to_step(data))

    error = f"{largest:.3g}"
    title = f"Spatial cam, a solid of its true surfaces, walls within {error} mm"
    metadata = {"Body": "smooth", "Surface-Error-Mm": error, "Faces": str(len(shell.faces))}
    kind = "ADVANCED_BREP_SHAPE_REPRESENTATION"
    return FileContent(shape_file(design, title, kind, write, largest), metadata)


def build_solid(
    design: SpatialDesign, options: BlankOptions, tolerance: float
) -> tuple[Shell, float]:
    """The body with its walls within a tolerance, and their largest distance from the true ones.

    Raises:
        NotSmooth: the body has no smooth boundary.
        InputError: there is no body.
    """
    cuts = GrooveSections.of(design.cam, design.spec.machine, straight=True)
    sheets = WallSheets.of(cuts, Blank.of(cuts, options, DEPTHS, cluster_at_ends))
    for stride in STRIDES:
        builder = Builder(sheets, tolerance, stride)
        try:
            return builder.build(), max(builder.errors)
        except TooFewDepths:
            if stride == STRIDES[-1]:
                raise
    raise AssertionError


def _faceted(design: SpatialDesign, options: FacetedOptions) -> FileContent:
    made = mesh_body(design, options, MAX_TRIANGLES)
    thin = thinnest(made.mesh)
    if thin < FINEST:
        raise InputError(
            "/points_per_degree", options.points_per_degree,
            f"The narrowest face would be {thin:.2g} mm wide; a solid needs {FINEST:.2g} mm.",
            "Change the number of points, the width or the bore, or use the mesh in STL.",
        )  # fmt: skip
    facets = merge_planar_faces(made.mesh)

    def write(data: Entities) -> str:
        points = [
            data.add("CARTESIAN_POINT", "''", many(map(real, point)))
            for point in made.mesh.points.tolist()
        ]
        shell = data.add("CLOSED_SHELL", "''", many([_face(data, each, points) for each in facets]))
        return data.add("FACETED_BREP", text(design.name or f"cam {design.id}"), shell)

    title = (
        f"Spatial cam, faceted: flat faces, {made.metadata['Surface-Error-Mm']} mm measured to the "
        "true surface; the smooth walls are in flanks.step"
    )
    metadata = {"Body": "faceted", **made.metadata, "Faces": str(len(facets))}
    kind, meaning = "FACETED_BREP_SHAPE_REPRESENTATION", "points nearer to each other are one"
    return FileContent(shape_file(design, title, kind, write, meaning=meaning), metadata)


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


@dataclass(frozen=True, eq=False)
class Facet:
    """A flat face.

    Attributes:
        normal: (3,) outward unit normal. loops: points of the mesh, the outer boundary first,
            counter-clockwise seen from outside, then holes, clockwise.
    """

    normal: Array
    loops: list[Loop]


def merge_planar_faces(mesh: Mesh) -> list[Facet]:
    """All faces of a mesh without degenerate triangles.

    Only planes perpendicular to the axis are merged, where heights are equal to the bit. A part
    whose boundary touches itself in a point stays in triangles.
    """
    normals = _area_normals(mesh)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    whole: list[Facet] = []
    single = np.ones(len(mesh.triangles), dtype=bool)
    for part in _coplanar_parts(mesh, normals):
        loops = _boundary(mesh, mesh.triangles[part], float(normals[part[0], 2]))
        if loops:
            whole.append(Facet(normals[part[0]], loops))
            single[part] = False
    rest = zip(normals[single], mesh.triangles[single].tolist(), strict=True)
    return whole + [Facet(normal, [corners]) for normal, corners in rest]


def thinnest(mesh: Mesh) -> float:
    """Least height of any triangle [mm]."""
    corners = mesh.points[mesh.triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    return float(np.min(np.linalg.norm(_area_normals(mesh), axis=1) / np.max(sides, axis=1)))


def _area_normals(mesh: Mesh) -> Array:
    """(k, 3) outward normals, of twice the triangles' areas."""
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    return np.asarray(np.cross(b - a, c - a))


def _coplanar_parts(mesh: Mesh, normals: Array) -> list[Whole]:
    """Sets of triangles at one height with one orientation, connected by edges."""
    heights = mesh.points[mesh.triangles, 2]
    level = np.ptp(heights, axis=1) == 0.0
    flat = np.flatnonzero(level)
    if len(flat) < 2:
        return []
    corners, up = mesh.triangles[flat], normals[flat, 2] > 0.0
    ends = np.concatenate([corners, np.roll(corners, -1, axis=1)]).reshape(2, -1)
    _, edge = np.unique(np.sort(ends, axis=0), axis=1, return_inverse=True)
    owner = np.repeat(np.arange(len(flat)), 3)
    order = np.argsort(edge, kind="stable")
    pair = np.flatnonzero(np.diff(edge[order]) == 0)
    one, other = owner[order[pair]], owner[order[pair + 1]]
    same = up[one] == up[other]
    links = coo_array((np.ones(same.sum()), (one[same], other[same])), shape=(len(flat),) * 2)
    count, part = connected_components(links, directed=False)
    parts = [flat[part == i] for i in range(count)]
    return [each for each in parts if len(each) > 1]


def _boundary(mesh: Mesh, triangles: Whole, up: float) -> list[Loop]:
    """Boundary loops of coplanar triangles, the outer one first; empty: one touches itself."""
    ends = [(a, b) for t in triangles.tolist() for a, b in zip(t, [*t[1:], t[0]], strict=True)]
    inside = set(ends)
    after = {a: b for a, b in ends if (b, a) not in inside}
    if len(after) < sum((b, a) not in inside for a, b in ends):
        return []
    loops = []
    while after:
        start, b = after.popitem()
        loop = [start]
        while b != start:
            loop.append(b)
            b = after.pop(b)
        loops.append(loop)
    areas = [up * _area(mesh.points[loop, :2]) for loop in loops]
    outer = int(np.argmax(areas))
    return [loops[outer], *loops[:outer], *loops[outer + 1 :]]


def _area(points: Array) -> float:
    x, y = points.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


STEP = FileFormat(
    "body.step", "STEP AP242, the whole cam as a solid", "model/step", ".step",
    _body, FacetedOptions,
    "One closed solid in mm, bounded by the cam's true surfaces within tolerance_um; where that is "
    "not possible, the body of body.stl in flat faces. The file's header, Camwright-Body and "
    "Camwright-Surface-Error-Mm say which it is and its distance from the true surface.",
    by_default=False,
    in_worker=True,
)  # fmt: skip
