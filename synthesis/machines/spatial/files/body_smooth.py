"""STEP AP242: the whole cam as a solid bounded by its true surfaces, in mm.

Written without a geometry kernel: Boolean differences fail where walls leave the blank at a grazing
angle. Tops and floors are the turned surfaces themselves, walls are B-splines whose boundary curves
are the faces' edges, and every edge is made once for both of its faces.
"""

from __future__ import annotations

from dataclasses import dataclass

from synthesis.exporters.curves.part21 import Entities, exchange_file, many, real, text
from synthesis.exporters.curves.step_curve import FINEST, SCHEMA, axes, context, product
from synthesis.exporters.exporter import Made
from synthesis.machines.spatial.blank import Blank, BlankOptions
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.grooves import GrooveSections
from synthesis.machines.spatial.solid.build import Builder
from synthesis.machines.spatial.solid.geometry import point
from synthesis.machines.spatial.solid.patches import cluster_at_ends
from synthesis.machines.spatial.solid.sheets import TooFewDepths, WallSheets, WallStates
from synthesis.machines.spatial.solid.shell import Face, Key, Shell

DEPTHS = 65  # from the ribs' tops to the floor
STRIDES = (4, 2, 1)  # every so many depths are used: coarse first, for small files


@dataclass(frozen=True, eq=False)
class Solid:
    """A body's shell, and the largest distance of its walls from the true ones [mm]."""

    shell: Shell
    error: float


def build_solid(design: SpatialDesign, options: BlankOptions, tolerance: float) -> Solid:
    """The body with its walls within a tolerance [mm].

    Raises:
        NotSmooth: the body has no smooth boundary.
        InputError: there is no body.
    """
    cuts = GrooveSections.of(design.cam, design.spec.machine, straight=True)
    blank = Blank.of(cuts, options, DEPTHS, cluster_at_ends)
    sheets = WallSheets(cuts, blank, WallStates.of(cuts, blank))
    for stride in STRIDES:
        builder = Builder(sheets, tolerance, stride)
        try:
            return Solid(builder.build(), max(builder.errors))
        except TooFewDepths:
            if stride == STRIDES[-1]:
                raise
    raise AssertionError


def smooth(design: SpatialDesign, options: BlankOptions, tolerance: float) -> Made:
    """The file.

    Raises:
        NotSmooth, InputError: as ``build_solid``.
    """
    solid = build_solid(design, options, tolerance)
    data = Entities()
    shared = context(data, max(solid.error, FINEST))
    name = text(design.name or f"cam {design.id}")
    origin = data.add("CARTESIAN_POINT", "''", many(map(real, (0.0, 0.0, 0.0))))
    placed = data.add("AXIS2_PLACEMENT_3D", "''", origin, *axes(data))
    body = data.add("MANIFOLD_SOLID_BREP", name, write_shell(data, solid.shell))
    shape = data.add("ADVANCED_BREP_SHAPE_REPRESENTATION", name, many([placed, body]), shared)
    data.add("SHAPE_DEFINITION_REPRESENTATION", product(data, design), shape)
    error = f"{solid.error:.3g}"
    title = f"Spatial cam, a solid of its true surfaces, walls within {error} mm"
    told = {"Body": "smooth", "Surface-Error-Mm": error, "Faces": str(len(solid.shell.faces))}
    return Made(exchange_file(design, title, SCHEMA, data.lines()), told)


def write_shell(data: Entities, shell: Shell) -> str:
    """Write the CLOSED_SHELL with all its entities; returns the reference."""
    corners = {
        key: data.add("VERTEX_POINT", "''", point(data, place))
        for key, place in shell.vertices.items()
    }
    edges = {
        key: data.add(
            "EDGE_CURVE",
            "''",
            corners[edge.first],
            corners[edge.last],
            edge.curve.to_step(data),
            ".T.",
        )
        for key, edge in shell.edges.items()
    }
    return data.add("CLOSED_SHELL", "''", many([_face(data, face, edges) for face in shell.faces]))


def _face(data: Entities, face: Face, edges: dict[Key, str]) -> str:
    bounds = []
    for i, loop in enumerate(face.loops):
        runs = [
            data.add("ORIENTED_EDGE", "''", "*", "*", edges[key], _flag(along))
            for key, along in loop
        ]
        way = data.add("EDGE_LOOP", "''", many(runs))
        bounds.append(data.add("FACE_BOUND" if i else "FACE_OUTER_BOUND", "''", way, ".T."))
    surface = face.surface.to_step(data)
    return data.add("ADVANCED_FACE", "''", many(bounds), surface, _flag(face.outwards))


def _flag(value: bool) -> str:
    return ".T." if value else ".F."
