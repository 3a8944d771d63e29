"""Development of a cylindrical cam's walls as tables."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.exporter import FileContent, FileFormat
from synthesis.exporters.options import Options
from synthesis.exporters.samples.columns import Column, joined
from synthesis.exporters.tables.formats import csv_table
from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.development import WallCurve, axis_path, offset_errors, wall_curve
from synthesis.machines.spatial.files.identification import json_file
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

FRAME = (
    "A cylinder about the cam's axis, unrolled. angle_deg is the cam angle at which a point passes "
    "the roller's side of the cam, arc_mm its length on the cylinder; z_mm is along the axis, in "
    "the direction of the follower's motion. departure_mm: distance by which the true wall lies "
    "beyond the unrolled path of the roller's axis, offset by the roller's radius on the cam's "
    "outer cylinder and wrapped to this one; positive where the roller needs more space than that "
    "drawing gives."
)


@dataclass(frozen=True, kw_only=True)
class DevelopedOptions(Options):
    """The cylinder and the sampling."""

    radius_mm: Annotated[
        float | None,
        Field(
            gt=0.0,
            le=1e6,
            description="Radius of the cylinder that is unrolled; left out: the cam's.",
        ),
    ] = None
    points_per_degree: Annotated[
        float, Field(gt=0.0, le=20.0, description="Points per degree of cam angle.")
    ] = 2.0


@dataclass(frozen=True, eq=False)
class Development:
    """The walls and the paths of the rollers' axes on a cylinder, in continuous runs.

    Attributes:
        radius: of the cylinder [mm].
        curves: each with its departure (n,) from the offset drawn in the plane [mm], NaN on the
            path of a roller's axis.
    """

    radius: float
    curves: list[tuple[WallCurve, Array]]

    @cached_property
    def error(self) -> float | None:
        """Largest departure [mm]; None where the drawing has no point near any wall."""
        values = np.concatenate([np.abs(departure) for _, departure in self.curves])
        known = values[~np.isnan(values)]
        return float(known.max()) if len(known) else None

    def file(self, data: bytes) -> FileContent:
        """A file of it with its metadata."""
        known = {} if self.error is None else {"Flat-Offset-Error-Mm": f"{self.error:.3g}"}
        return FileContent(data, {"Radius-Mm": f"{self.radius:.9g}", **known})


def develop(design: SpatialDesign, options: DevelopedOptions) -> Development:
    """Paths of all rollers' axes and all walls.

    Raises:
        InputError: the cam has no such cylinder, the roller does not reach it, or all rollers pass
            beside it.
    """
    span = design.spec.machine.wall_radii(design.dimensions)
    if span is None:
        raise InputError(
            "/radius_mm", options.radius_mm,
            f"The cam of a {design.spec.machine.title} has no development on a cylinder.",
            "Request files of its flanks.",
        )  # fmt: skip
    inner, outer = span
    radius = outer if options.radius_mm is None else options.radius_mm
    if not inner <= radius <= outer:
        raise InputError(
            "/radius_mm", radius,
            f"The roller reaches into the cam from {outer:.9g} to {inner:.9g} mm of its axis.",
            "Choose a radius between these.",
        )  # fmt: skip
    curves = list(_curves(design.cam, radius, outer, options.points_per_degree / DEGREE))
    if not any(line.side for line, _ in curves):
        raise InputError(
            "/radius_mm", radius, "All rollers pass beside the cylinder of this radius.",
            f"Choose a larger one, up to {outer:.9g}.",
        )  # fmt: skip
    return Development(radius, curves)


def _curves(
    cam: SpatialCam, radius: float, drawn: float, density: float
) -> Iterator[tuple[WallCurve, Array]]:
    pathed = set()
    for wall in cam.walls:
        for start, end in wall.spans:
            theta = np.linspace(start, end, max(2, int(np.ceil((end - start) * density)) + 1))
            if (wall.seat, start) not in pathed:
                pathed.add((wall.seat, start))
                axis = axis_path(cam, wall.seat, theta, radius)
                yield from _runs(axis, np.full(len(theta), np.nan))
            line = wall_curve(cam, wall, theta, radius)
            yield from _runs(line, offset_errors(cam, line, drawn, radius))


def _runs(line: WallCurve, departure: Array) -> Iterator[tuple[WallCurve, Array]]:
    """The continuous runs in which the roller reaches the cylinder."""
    there = np.flatnonzero(~np.isnan(line.z))
    for run in np.split(there, np.flatnonzero(np.diff(there) > 1) + 1):
        if len(run) > 1:
            parts = {name: getattr(line, name)[run] for name in ("theta", "phi", "z", "rho")}
            yield replace(line, **parts), departure[run]


def _columns(line: WallCurve, departure: Array, radius: float) -> list[Column]:
    count = len(line.theta)
    return [
        Column("roller", "1", "number of the roller", np.full(count, line.seat.number)),
        Column("side", "1", "R: 1, L: -1, path of its axis: 0", np.full(count, line.side)),
        Column("theta_deg", "deg", "cam angle of the contact", line.theta / DEGREE),
        Column("angle_deg", "deg", "place around the cylinder", line.phi / DEGREE),
        Column("arc_mm", "mm", "the same as a length", radius * line.phi),
        Column("z_mm", "mm", "place along the cam's axis", line.z),
        Column("rho_mm", "mm", "place on the roller's axis", line.rho),
        Column(
            "departure_mm",
            "mm",
            "of the true wall from the offset in the plane; 0 where that has no point near it",
            np.where(np.isnan(departure), 0.0, departure),
        ),
    ]


def _csv(design: SpatialDesign, options: DevelopedOptions) -> FileContent:
    found = develop(design, options)
    return found.file(csv_table(joined([_columns(*each, found.radius) for each in found.curves])))


def _json(design: SpatialDesign, options: DevelopedOptions) -> FileContent:
    found = develop(design, options)
    body = {
        "radius_mm": found.radius,
        "flat_offset_error_mm": found.error,
        "curves": [_curve(*each, found.radius) for each in found.curves],
    }
    return found.file(json_file(design, "development", FRAME, body))


def _curve(line: WallCurve, departure: Array, radius: float) -> dict[str, Any]:
    columns = _columns(line, departure, radius)[2 : None if line.side else -1]
    values = {column.name: column.values.tolist() for column in columns}
    return {"name": line.name, "roller": line.seat.number, "side": line.side, **values}


PURPOSE = (
    "A cylindrical cam's walls and the paths of its rollers' axes on a cylinder about its axis, "
    "unrolled. The header Camwright-Flat-Offset-Error-Mm says by how much the true walls differ "
    "from the path offset by the roller's radius in the plane and wrapped."
)
CSV = FileFormat(
    "developed.csv", "Unrolled walls, comma separated", "text/csv; charset=utf-8; header=present",
    ".csv", _csv, DevelopedOptions, PURPOSE,
)  # fmt: skip
JSON = FileFormat(
    "developed.json", "Unrolled walls", "application/json", ".json", _json, DevelopedOptions,
    PURPOSE,
)  # fmt: skip
