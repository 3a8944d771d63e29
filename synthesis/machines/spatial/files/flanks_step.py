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
from scipy.interpolate import NdBSpline

from synthesis.errors import InputError
from synthesis.exporters.curves.step import Entities, many, shape_file, text
from synthesis.exporters.exporter import FileContent, FileFormat
from synthesis.exporters.options import Options
from synthesis.machines.spatial.cam import Span, SpatialCam, Wall
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.flanks import Flank, Patch, chosen, patch
from synthesis.machines.spatial.solid.geometry import (
    interpolate_surface,
    spline_surface,
)
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

DEGREES = 5, 3  # of a surface in cam angle and along the roller
FIRST, MAX_LINES = (9, 5), (577, 65)  # grid lines: of the first grid, and at most
MANY = 24  # pieces of a motion: with more, flanks are split at the program's segments only
SHORT = 1e-6  # rad: splits nearer to each other are one


@dataclass(frozen=True, kw_only=True)
class SurfaceOptions(Options):
    """The flanks and their tolerance; an empty ``flank`` stands for all."""

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
        name: the flank's. spline: over cam angle [rad] and place along the roller [mm].
        error: measured distance from the flank [mm].
    """

    name: str
    spline: NdBSpline
    error: float


def _smooth_parts(cam: SpatialCam, span: Span) -> list[Span]:
    """An interval split where the motion's derivatives may jump."""
    cuts = cam.motion.curve.breaks
    if len(cuts) > MANY:
        cuts = np.array([segment.end for segment in cam.motion.segments])
    inside = cuts[(cuts > span[0] + SHORT) & (cuts < span[1] - SHORT)]
    return list(pairwise([span[0], *inside.tolist(), span[1]]))


def _face(cam: SpatialCam, wall: Wall, span: Span, tolerance_um: float) -> Face:
    """A part of a flank, interpolated on finer grids until it is within the tolerance."""
    # Angles are moved inside the part, so that its ends belong to this piece of the motion.
    tiny = 1e-12 * (span[1] - span[0])

    def true(theta: Array, rho: Array) -> Patch:
        return patch(cam, wall, 1, np.clip(theta, span[0] + tiny, span[1] - tiny), rho)

    def distance(spline: NdBSpline, theta: Array, rho: Array) -> float:
        places = np.stack(np.meshgrid(theta, rho, indexing="ij"), axis=-1)
        there = true(theta, rho)
        off = np.moveaxis(spline(places), -1, 0) - there.points
        return float(np.max(np.abs(np.einsum("inm,inm->nm", off, there.normals))))

    (n, m), roller = FIRST, cam.swept.roller
    while True:
        theta, rho = np.linspace(*span, n), np.linspace(roller.inner, roller.outer, m)
        points = np.moveaxis(true(theta, rho).points, 0, -1)
        spline = interpolate_surface(theta, rho, points, DEGREES)
        # The distance from the flank midway between lines of cam angle, and of places.
        along = distance(spline, 0.5 * (theta[1:] + theta[:-1]), rho)
        across = distance(spline, theta, 0.5 * (rho[1:] + rho[:-1]))
        error = max(along, across)
        if error <= 1e-3 * tolerance_um:
            return Face(wall.name, spline, error)
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
    cam = design.cam
    made = [
        _face(cam, wall, part, options.tolerance_um)
        for wall in chosen(cam, options.flank)
        for span in wall.spans
        for part in _smooth_parts(cam, span)
    ]
    error, name = max(face.error for face in made), f"flanks of {design.name or design.id}"

    def write(data: Entities) -> str:
        surfaces = [spline_surface(data, text(face.name), face.spline) for face in made]
        return data.add("GEOMETRIC_SET", text(name), many(surfaces))

    title = f"Flanks of a spatial cam, within {error:.2g} mm of the true ones"
    kind = "GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION"
    metadata = {"Surface-Error-Mm": f"{error:.3g}", "Surfaces": str(len(made))}
    return FileContent(shape_file(design, title, kind, write, error, name=name), metadata)


STEP = FileFormat(
    "flanks.step", "STEP AP242, flanks as surfaces", "model/step", ".step",
    _flanks, SurfaceOptions,
    "Master geometry for CAD: every flank as B-spline surfaces within tolerance_um, named as the "
    "flank and cut where the motion's derivatives jump, to be trimmed and sewn there. Surfaces, "
    "not a solid: for that see body.step.",
)  # fmt: skip
