"""STEP AP242, in mm: every flank as B-spline surfaces, and the whole cam as one solid.

A flank's surface interpolates contacts on a grid that is refined until the surface is within the
tolerance midway between the grid lines too. Flanks are split where the motion's derivatives jump.

The smooth solid is bounded by the cam's true surfaces. It is written without a geometry kernel:
Boolean differences fail where walls leave the blank at a grazing angle. Tops and floors are the
turned surfaces themselves, walls are B-splines whose boundary curves are the faces' edges, and
every edge is made once for both of its faces.

The faceted solid is the mesh of ``body.stl`` as a boundary representation whose faces share points,
so that readers recognise common edges. Coplanar triangles across the cam's axis are one face.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field
from scipy.interpolate import NdBSpline
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from synthesis.errors import InputError
from synthesis.exporters.curves.exact import FINEST
from synthesis.exporters.curves.step import Entities, entity, many, shape_file, text, write_spline
from synthesis.exporters.exporter import FileContent, machine_format
from synthesis.exporters.options import Options
from synthesis.machines.spatial.body import Blank, BlankOptions, Mesh, Whole
from synthesis.machines.spatial.cam import Span, SpatialCam, Wall
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.body_mesh import Levels, MeshOptions, Rows, mesh_body
from synthesis.machines.spatial.files.flanks import Flank, Patch, patch, select_walls
from synthesis.machines.spatial.grooves import GrooveSections
from synthesis.machines.spatial.solid.build import Builder
from synthesis.machines.spatial.solid.geometry import NotSmooth, Shell, interpolate_surface
from synthesis.machines.spatial.solid.sheets import TooFewDepths, WallSheets, cluster_at_ends
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

DEGREES = 5, 3  # of a surface in cam angle and along the roller
FIRST, MAX_LINES = (9, 5), (577, 65)  # grid lines: of the first grid, and at most
MANY = 24  # pieces of a motion: with more, flanks are split at the program's segments only
SHORT = 1e-6  # rad: splits nearer to each other are one
DEPTHS = 65  # of a smooth solid, from the ribs' tops to the floor
STRIDES = (4, 2, 1)  # every so many depths are used: coarse first, for small files
MAX_TRIANGLES = 100_000  # of a faceted solid
DIGITS = 12  # decimals of normals
Loop = list[int]


@dataclass(frozen=True, kw_only=True)
class SurfaceOptions(Options):
    """The flanks and their tolerance; an empty ``flank`` stands for all."""

    flank: Flank = ""
    tolerance_um: Annotated[float, Field(ge=0.01, le=1e3)] = 1.0
    """Largest distance of the surfaces from the flanks, along the normal [µm]. The header
    Camwright-Surface-Error-Mm gives the one reached."""


def _fit_flank(
    cam: SpatialCam, wall: Wall, span: Span, tolerance_um: float
) -> tuple[NdBSpline, float]:
    """A spline over cam angle [rad] and place [mm], and its measured distance from the flank [mm].

    Its grid is refined until it is within the tolerance.
    """
    # Angles are moved inside the part, so that its ends belong to this piece of the motion.
    tiny = 1e-12 * (span[1] - span[0])

    def true(theta: Array, rho: Array) -> Patch:
        return patch(cam, wall, 1, np.clip(theta, span[0] + tiny, span[1] - tiny), rho)

    def distance(spline: NdBSpline, theta: Array, rho: Array) -> float:
        places = np.stack(np.meshgrid(theta, rho, indexing="ij"), axis=-1)
        return true(theta, rho).distance(np.moveaxis(spline(places), -1, 0))

    (n, m), roller = FIRST, cam.swept.roller
    while True:
        theta, rho = np.linspace(*span, n), roller.places(m)
        points = np.moveaxis(true(theta, rho).points, 0, -1)
        spline = interpolate_surface(theta, rho, points, DEGREES)
        # The distance from the flank midway between lines of cam angle, and of places.
        along = distance(spline, 0.5 * (theta[1:] + theta[:-1]), rho)
        across = distance(spline, theta, 0.5 * (rho[1:] + rho[:-1]))
        error = max(along, across)
        if error <= 1e-3 * tolerance_um:
            return spline, error
        # Refine the direction with the larger error.
        finer = (2 * n - 1, m) if along >= across else (n, 2 * m - 1)
        if finer[0] > MAX_LINES[0] or finer[1] > MAX_LINES[1]:
            raise InputError(
                "/tolerance_um",
                tolerance_um,
                f"Flank {wall.name} from {span[0] / DEGREE:.6g}° to {span[1] / DEGREE:.6g}° comes "
                f"within {1e3 * error:.3g} µm with {n} by {m} points, the most allowed.",
                "Increase tolerance_um, or use files of points.",
            )
        n, m = finer


def _flanks(design: SpatialDesign, options: SurfaceOptions) -> FileContent:
    cam, made = design.cam, []
    # Flanks are split where the motion's derivatives may jump.
    cuts = cam.motion.curve.breaks
    if len(cuts) > MANY:
        cuts = np.array([segment.end for segment in cam.motion.segments])
    for wall in select_walls(cam, options.flank):
        for start, end in wall.spans:
            inside = cuts[(cuts > start + SHORT) & (cuts < end - SHORT)]
            made += [(wall.name, *_fit_flank(cam, wall, part, options.tolerance_um))
                     for part in pairwise([start, *inside.tolist(), end])]  # fmt: skip
    error, name = max(each[2] for each in made), f"flanks of {design.name or design.id}"

    def write(data: Entities) -> str:
        surfaces = [write_spline(data, text(flank), spline) for flank, spline, _ in made]
        return data.add("GEOMETRIC_SET", text(name), many(surfaces))

    title = f"Flanks of a spatial cam, within {error:.2g} mm of the true ones"
    kind = "GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION"
    metadata = {"Surface-Error-Mm": f"{error:.3g}", "Surfaces": str(len(made))}
    return FileContent(shape_file(design, title, kind, write, error, name=name), metadata)


@dataclass(frozen=True, kw_only=True)
class FacetedOptions(MeshOptions):
    """The boundary of the solid; rows and depths are those of a faceted one."""

    form: Literal["smooth", "faceted"] | None = None
    """smooth: true surfaces, walls as B-splines within tolerance_um; faceted: flat faces, by
    points_per_degree and depths. Left out: smooth where possible. The header Camwright-Body says
    which it is."""
    tolerance_um: Annotated[float, Field(ge=0.1, le=1e3)] = 1.0
    """Largest distance of smooth walls from the true ones."""
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
    cuts = GrooveSections(design.cam, design.spec.machine, straight=True)
    sheets = WallSheets.of(cuts, Blank.of(cuts, options, DEPTHS, cluster_at_ends))
    for stride in STRIDES:
        builder = Builder(sheets, tolerance, stride)
        try:
            return builder.build(), max(builder.errors)
        except TooFewDepths as why:
            too_few = why
    raise too_few


def _faceted(design: SpatialDesign, options: FacetedOptions) -> FileContent:
    mesh, metadata = mesh_body(design, options, MAX_TRIANGLES)
    if (thin := thinnest(mesh)) < FINEST:
        raise InputError(
            "/points_per_degree", options.points_per_degree,
            f"The narrowest face would be {thin:.2g} mm wide; a solid needs {FINEST:.2g} mm.",
            "Change the number of points, the width or the bore, or use the mesh in STL.",
        )  # fmt: skip
    facets = merge_planar_faces(mesh)

    def write(data: Entities) -> str:
        points = [entity(data, "CARTESIAN_POINT", point) for point in mesh.points]
        shell = data.add("CLOSED_SHELL", "''", many([_face(data, each, points) for each in facets]))
        return data.add("FACETED_BREP", text(design.name or f"cam {design.id}"), shell)

    title = (
        f"Spatial cam, faceted: flat faces, {metadata['Surface-Error-Mm']} mm measured to the "
        "true surface; the smooth walls are in flanks.step"
    )
    metadata = {"Body": "faceted", **metadata, "Faces": str(len(facets))}
    kind, meaning = "FACETED_BREP_SHAPE_REPRESENTATION", "points nearer to each other are one"
    return FileContent(shape_file(design, title, kind, write, meaning=meaning), metadata)


def _face(data: Entities, facet: Facet, points: list[str]) -> str:
    axis = entity(data, "DIRECTION", np.round(facet.normal, DIGITS) + 0.0)
    placed = data.add("AXIS2_PLACEMENT_3D", "''", points[facet.loops[0][0]], axis, "$")
    plane = data.add("PLANE", "''", placed)
    bounds = []
    for i, loop in enumerate(facet.loops):
        ring = data.add("POLY_LOOP", "''", many([points[corner] for corner in loop]))
        bounds.append(data.add("FACE_BOUND" if i else "FACE_OUTER_BOUND", "''", ring, ".T."))
    return data.add("FACE_SURFACE", "''", many(bounds), plane, ".T.")


class Facet(NamedTuple):
    """A flat face with its outward unit normal (3,).

    ``loops`` are points of the mesh, the outer boundary first, counter-clockwise seen from outside,
    then holes, clockwise.
    """

    normal: Array
    loops: list[Loop]


def merge_planar_faces(mesh: Mesh) -> list[Facet]:
    """All faces of a mesh without degenerate triangles.

    Only planes perpendicular to the axis are merged, where heights are equal to the bit. A part
    whose boundary touches itself in a point stays in triangles.
    """
    normals = mesh.normals / np.linalg.norm(mesh.normals, axis=1, keepdims=True)
    # Parts: triangles at one height with one orientation, connected by edges.
    flat = np.flatnonzero(np.ptp(mesh.points[mesh.triangles, 2], axis=1) == 0.0)
    owner = {edge: k for k in flat.tolist() for edge in _edges(mesh.triangles[k].tolist())}
    links = [(k, owner[b, a]) for (a, b), k in owner.items() if (b, a) in owner]
    one, other = np.array(links, dtype=int).reshape(-1, 2).T
    same = (normals[one, 2] > 0.0) == (normals[other, 2] > 0.0)
    count = len(mesh.triangles)
    graph = coo_array((np.ones(same.sum()), (one[same], other[same])), shape=(count, count))
    _, part = connected_components(graph, directed=False)
    order = np.argsort(part, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(part[order])) + 1)
    merged, rest = list[Facet](), list[int]()
    for triangles in parts:
        normal = normals[triangles[0]]
        loops = _boundary(mesh, triangles, float(normal[2])) if len(triangles) > 1 else []
        if loops:
            merged.append(Facet(normal, loops))
        else:
            rest += triangles.tolist()
    return merged + [Facet(normals[k], [mesh.triangles[k].tolist()]) for k in sorted(rest)]


def thinnest(mesh: Mesh) -> float:
    """Least height of any triangle [mm]."""
    corners = np.stack(mesh.corners)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=2)
    return float(np.min(np.linalg.norm(mesh.normals, axis=1) / np.max(sides, axis=0)))


def _edges(triangle: Loop) -> list[tuple[int, int]]:
    a, b, c = triangle
    return [(a, b), (b, c), (c, a)]


def _boundary(mesh: Mesh, triangles: Whole, up: float) -> list[Loop]:
    """Boundary loops of coplanar triangles, the outer one first; empty: one touches itself."""
    ends = [edge for triangle in mesh.triangles[triangles].tolist() for edge in _edges(triangle)]
    inside = set(ends)
    free = [(a, b) for a, b in ends if (b, a) not in inside]
    after = dict(free)
    if len(after) < len(free):
        return []
    loops = []
    while after:
        start, b = after.popitem()
        loop = [start]
        while b != start:
            loop.append(b)
            b = after.pop(b)
        loops.append(loop)
    corners = (mesh.points[loop].T for loop in loops)
    areas = [up * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) for x, y, _ in corners]
    outer = int(np.argmax(areas))
    return [loops[outer], *loops[:outer], *loops[outer + 1 :]]


FLANKS = machine_format("spatial", "flanks.step", _flanks, SurfaceOptions)
BODY = machine_format("spatial", "body.step", _body, FacetedOptions)
