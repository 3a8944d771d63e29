"""STEP AP242: the whole cam as a solid bounded by its true surfaces, in mm. No kernel is needed.

No difference of solids: kernels make no sound one where walls run out of the blank at a grazing
angle. Tops and floors are the turned surfaces themselves, walls are B-splines whose own edges are
the faces' edges, and every edge is made once, for both of its faces.
"""

from __future__ import annotations

from dataclasses import dataclass

from synthesis.exporters.curves.part21 import Entities, exchange_file, many, real, text
from synthesis.exporters.curves.step_curve import FINEST, SCHEMA, axes, context, product
from synthesis.exporters.exporter import Made
from synthesis.spatial.blank import Blank, BlankOptions
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.grooves import Cuts
from synthesis.spatial.smooth.build import Builder
from synthesis.spatial.smooth.patches import crowded
from synthesis.spatial.smooth.sheets import Seen, Sheets, TooCoarse
from synthesis.spatial.smooth.shell import Shell
from synthesis.spatial.smooth.told import told_shell

DEPTHS = 65  # from the ribs' tops to the floor
STRIDES = (4, 2, 1)  # every so many of them are looked at, the fewer the better


@dataclass(frozen=True, eq=False)
class Solid:
    """A body's shell, and how far its walls are from the true ones [mm]."""

    shell: Shell
    error: float


def solid_of(design: SpatialDesign, options: BlankOptions, tolerance: float) -> Solid:
    """The body with its walls within a tolerance [mm].

    Raises:
        NotSmooth: there is none of this kind.
        InputError: there is no body.
    """
    cuts = Cuts.of(design.cam, design.spec.machine, straight=True)
    blank = Blank.of(cuts, options, DEPTHS, crowded)
    sheets = Sheets(cuts, blank, Seen.of(cuts, blank))
    for stride in STRIDES:
        builder = Builder(sheets, tolerance, stride)
        try:
            return Solid(builder.built(), max(builder.errors))
        except TooCoarse:
            if stride == STRIDES[-1]:
                raise
    raise AssertionError


def smooth(design: SpatialDesign, options: BlankOptions, tolerance: float) -> Made:
    """The file.

    Raises:
        NotSmooth, InputError: as ``solid_of``.
    """
    solid = solid_of(design, options, tolerance)
    data = Entities()
    shared = context(data, max(solid.error, FINEST))
    name = text(design.name or f"cam {design.id}")
    origin = data.add("CARTESIAN_POINT", "''", many(map(real, (0.0, 0.0, 0.0))))
    placed = data.add("AXIS2_PLACEMENT_3D", "''", origin, *axes(data))
    body = data.add("MANIFOLD_SOLID_BREP", name, told_shell(data, solid.shell))
    shape = data.add("ADVANCED_BREP_SHAPE_REPRESENTATION", name, many([placed, body]), shared)
    data.add("SHAPE_DEFINITION_REPRESENTATION", product(data, design), shape)
    error = f"{solid.error:.3g}"
    title = f"Spatial cam, a solid of its true surfaces, walls within {error} mm"
    told = {"Body": "smooth", "Surface-Error-Mm": error, "Faces": str(len(solid.shell.faces))}
    return Made(exchange_file(design, title, SCHEMA, data.lines()), told)
