"""STEP AP242: every flank as B-spline surfaces within a tolerance, in mm; no geometry kernel.

A surface interpolates contacts on a grid that is refined until the surface is within the tolerance
midway between the grid lines too. Flanks are split where the motion's derivatives jump.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field
from scipy.interpolate import NdBSpline, make_interp_spline

from synthesis.errors import InputError
from synthesis.exporters.curves.part21 import Entities, exchange_file, many, real, text
from synthesis.exporters.curves.step_curve import FINEST, SCHEMA, axes, context, product
from synthesis.exporters.exporter import FileFormat, Made
from synthesis.exporters.options import Options
from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.flanks import chosen, patch
from synthesis.machines.spatial.files.options import Flank
from synthesis.machines.spatial.meshing import Span
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

DEGREES = 5, 3  # of a surface in cam angle and along the roller
FIRST, MAX_LINES = (9, 5), (577, 65)  # grid lines: of the first grid, and at most
MANY = 24  # pieces of a motion: with more, flanks are split at the program's segments only
SHORT = 1e-6  # rad: splits nearer to each other are one


@dataclass(frozen=True, kw_only=True)
class SurfaceOptions(Options):
    """The flanks and their tolerance.

    Attributes:
        flank: a wall's name; "": all.
        tolerance_um: largest distance of a surface from its flank [µm].
    """

    flank: Flank = ""
    tolerance_um: Annotated[
        float,
        Field(
            ge=0.01,
            le=1e3,
            description="Largest distance of the surfaces from the flanks, along the normal [µm]. "
            "The header Camwright-Surface-Error-Mm gives the one reached.",
        ),
    ] = 1.0


@dataclass(frozen=True, eq=False)
class Face:
    """A part of a flank.

    Attributes:
        name: the flank's. knots: in cam angle [rad] and along the roller [mm], repeated ones too.
        points: (n, m, 3) control points [mm]. error: measured distance from the flank [mm].
    """

    name: str
    knots: tuple[Array, Array]
    points: Array
    error: float


def faces(design: SpatialDesign, options: SurfaceOptions) -> list[Face]:
    """The selected flanks, in smooth parts.

    Raises:
        InputError: there is no such flank, or the tolerance is not reached.
    """
    cam = design.cam
    return [
        _face(cam, wall, part, options.tolerance_um)
        for wall in chosen(cam, options.flank)
        for span in wall.spans
        for part in _relaxables(cam, span)
    ]


def _relaxables(cam: SpatialCam, span: Span) -> list[Span]:
    """An interval split where the motion's derivatives may jump."""
    cuts = cam.motion.curve.breaks
    if len(cuts) > MANY:
        cuts = np.array([segment.end for segment in cam.motion.segments])
    inside = cuts[(cuts > span[0] + SHORT) & (cuts < span[1] - SHORT)]
    return list(pairwise([span[0], *inside.tolist(), span[1]]))


def _face(cam: SpatialCam, wall: Wall, span: Span, tolerance_um: float) -> Face:
    n, m = FIRST
    roller = cam.swept.roller
    while True:
        theta, rho = np.linspace(*span, n), np.linspace(roller.inner, roller.outer, m)
        spline = _interpolated(theta, rho, _points(cam, wall, span, theta, rho))
        errors = _errors(cam, wall, span, spline, theta, rho)
        if max(errors) <= 1e-3 * tolerance_um:
            return Face(wall.name, (spline.t[0], spline.t[1]), spline.c, max(errors))
        # Refine the direction with the larger error.
        finer = (2 * n - 1, m) if errors[0] >= errors[1] else (n, 2 * m - 1)
        if finer[0] > MAX_LINES[0] or finer[1] > MAX_LINES[1]:
            raise InputError(
                "/tolerance_um",
                tolerance_um,
                f"Flank {wall.name} from {span[0] / DEGREE:.6g}° to {span[1] / DEGREE:.6g}° comes "
                f"within {1e3 * max(errors):.3g} µm with {n} by {m} points, the most allowed.",
                "Increase tolerance_um, or use files of points.",
            )
        n, m = finer


def _inside(span: Span, theta: Array) -> Array:
    """Cam angles moved inside the part, so that its ends belong to this piece of the motion."""
    tiny = 1e-12 * (span[1] - span[0])
    return np.clip(theta, span[0] + tiny, span[1] - tiny)


def _points(cam: SpatialCam, wall: Wall, span: Span, theta: Array, rho: Array) -> Array:
    """Points of the flank (n, m, 3) [mm]."""
    return np.moveaxis(patch(cam, wall, 1, _inside(span, theta), rho).points, 0, -1)


def _interpolated(theta: Array, rho: Array, points: Array) -> NdBSpline:
    by_theta = make_interp_spline(theta, points, k=DEGREES[0], axis=0)
    by_rho = make_interp_spline(rho, by_theta.c, k=DEGREES[1], axis=1)
    return NdBSpline((by_theta.t, by_rho.t), np.moveaxis(by_rho.c, 0, 1), DEGREES)


def _errors(
    cam: SpatialCam, wall: Wall, span: Span, spline: NdBSpline, theta: Array, rho: Array
) -> tuple[float, float]:
    """Largest distances midway between lines of cam angle, and between places on the roller."""
    between = 0.5 * (theta[1:] + theta[:-1]), 0.5 * (rho[1:] + rho[:-1])
    return (
        _away(cam, wall, spline, between[0], rho),
        _away(cam, wall, spline, _inside(span, theta), between[1]),
    )


def _away(cam: SpatialCam, wall: Wall, spline: NdBSpline, theta: Array, rho: Array) -> float:
    true = patch(cam, wall, 1, theta, rho)
    places = np.stack(np.meshgrid(theta, rho, indexing="ij"), axis=-1)
    off = np.moveaxis(spline(places), -1, 0) - true.points
    return float(np.max(np.abs(np.einsum("inm,inm->nm", off, true.normals))))


def _flanks(design: SpatialDesign, options: SurfaceOptions) -> Made:
    made = faces(design, options)
    error = max(face.error for face in made)
    data = Entities()
    shared = context(data, max(error, FINEST))
    name = text(f"flanks of {design.name or design.id}")
    origin = data.add("CARTESIAN_POINT", "''", many(map(real, (0.0, 0.0, 0.0))))
    placed = data.add("AXIS2_PLACEMENT_3D", "''", origin, *axes(data))
    drawn = data.add("GEOMETRIC_SET", name, many([_surface(data, face) for face in made]))
    shape = data.add(
        "GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION", name, many([placed, drawn]), shared
    )
    data.add("SHAPE_DEFINITION_REPRESENTATION", product(data, design), shape)
    title = f"Flanks of a spatial cam, within {error:.2g} mm of the true ones"
    told = {"Surface-Error-Mm": f"{error:.3g}", "Surfaces": str(len(made))}
    return Made(exchange_file(design, title, SCHEMA, data.lines()), told)


def _surface(data: Entities, face: Face) -> str:
    rows = [
        many([data.add("CARTESIAN_POINT", "''", many(map(real, point))) for point in row])
        for row in face.points.tolist()
    ]
    each = [np.unique(knots, return_counts=True) for knots in face.knots]
    return data.add(
        "B_SPLINE_SURFACE_WITH_KNOTS", text(face.name), *map(str, DEGREES), many(rows),
        ".UNSPECIFIED.", ".F.", ".F.", ".F.",
        *(many(map(str, times.tolist())) for _, times in each),
        *(many(map(real, knots.tolist())) for knots, _ in each), ".UNSPECIFIED.",
    )  # fmt: skip


STEP = FileFormat(
    "flanks.step", "STEP AP242, flanks as surfaces", "model/step", ".step",
    _flanks, SurfaceOptions,
    "Master geometry for CAD: every flank as B-spline surfaces within tolerance_um, named as the "
    "flank and cut where the motion's derivatives jump, to be trimmed and sewn there. Surfaces, "
    "not a solid: for that see body.step.",
)  # fmt: skip
