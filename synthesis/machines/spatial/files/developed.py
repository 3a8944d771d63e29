"""Development of a cylindrical cam's walls as tables."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.exporter import FileFormat, Made
from synthesis.exporters.options import Options
from synthesis.exporters.samples.columns import Column, joined
from synthesis.exporters.tables.csv_table import table
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
    """The cylinder and the sampling.

    Attributes:
        radius_mm: of the cylinder; None: the cam's. points_per_degree: over the cam angle.
    """

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
class Unrolled:
    """A curve and its departure from the offset drawn in the plane.

    Attributes:
        line: the curve. departure: (n,) [mm]; NaN on the path of a roller's axis.
    """

    line: WallCurve
    departure: Array

    @property
    def name(self) -> str:
        """Name of the wall, or number of the roller whose axis it is."""
        letter = {1: "R", 0: "", -1: "L"}[self.line.side]
        return f"{self.line.seat.number}{letter}"


def radius_of(design: SpatialDesign, options: DevelopedOptions) -> float:
    """Radius of the cylinder that is unrolled [mm].

    Raises:
        InputError: the cam has none, or the roller does not reach this one.
    """
    span = design.spec.machine.wall_radii(design.dimensions)
    if span is None:
        raise InputError(
            "/radius_mm", options.radius_mm,
            f"The cam of a {design.spec.machine.title} has no development on a cylinder.",
            "Request files of its flanks.",
        )  # fmt: skip
    radius = span[1] if options.radius_mm is None else options.radius_mm
    if not span[0] <= radius <= span[1]:
        raise InputError(
            "/radius_mm", radius,
            f"The roller reaches into the cam from {span[1]:.9g} to {span[0]:.9g} mm of its axis.",
            "Choose a radius between these.",
        )  # fmt: skip
    return radius


def unrolled(design: SpatialDesign, options: DevelopedOptions) -> list[Unrolled]:
    """Paths of all rollers' axes and all walls, in continuous runs.

    Raises:
        InputError: as ``radius_of``, and where rollers pass beside the cylinder.
    """
    cam, radius = design.cam, radius_of(design, options)
    span = design.spec.machine.wall_radii(design.dimensions)
    assert span is not None  # or radius_of had refused
    found = list(_lines(cam, radius, span[1], options.points_per_degree / DEGREE))
    if not any(each.line.side for each in found):
        raise InputError(
            "/radius_mm", radius, "All rollers pass beside the cylinder of this radius.",
            f"Choose a larger one, up to {span[1]:.9g}.",
        )  # fmt: skip
    return found


def _lines(cam: SpatialCam, radius: float, drawn: float, density: float) -> Iterator[Unrolled]:
    pathed = set()
    for each in cam.walls:
        for start, end in each.spans:
            theta = np.linspace(start, end, max(2, int(np.ceil((end - start) * density)) + 1))
            if (each.seat, start) not in pathed:
                pathed.add((each.seat, start))
                axis = axis_path(cam, each.seat, theta, radius)
                yield from _runs(axis, np.full(len(theta), np.nan))
            line = wall_curve(cam, each, theta, radius)
            yield from _runs(line, offset_errors(cam, line, drawn, radius))


def _runs(line: WallCurve, departure: Array) -> Iterator[Unrolled]:
    """The continuous runs in which the roller reaches the cylinder."""
    there = np.flatnonzero(~np.isnan(line.z))
    for run in np.split(there, np.flatnonzero(np.diff(there) > 1) + 1):
        if len(run) > 1:
            part = WallCurve(
                line.seat, line.side, line.theta[run], line.phi[run], line.z[run], line.rho[run]
            )
            yield Unrolled(part, departure[run])


def error(found: list[Unrolled]) -> float | None:
    """Largest departure [mm]; None where the drawing has no point near any wall."""
    values = np.concatenate([np.abs(each.departure) for each in found])
    known = values[~np.isnan(values)]
    return float(known.max()) if len(known) else None


def _columns(each: Unrolled, radius: float) -> list[Column]:
    line = each.line
    count = len(line.theta)
    departure = np.where(np.isnan(each.departure), 0.0, each.departure)
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
            departure,
        ),
    ]


def metadata(found: list[Unrolled], radius: float) -> dict[str, str]:
    """Metadata of a file."""
    worst = error(found)
    known = {} if worst is None else {"Flat-Offset-Error-Mm": f"{worst:.3g}"}
    return {"Radius-Mm": f"{radius:.9g}", **known}


def _csv(design: SpatialDesign, options: DevelopedOptions) -> Made:
    found, radius = unrolled(design, options), radius_of(design, options)
    columns = joined([_columns(each, radius) for each in found])
    return Made(table(columns), metadata(found, radius))


def _json(design: SpatialDesign, options: DevelopedOptions) -> Made:
    found, radius = unrolled(design, options), radius_of(design, options)
    body = {
        "radius_mm": radius,
        "flat_offset_error_mm": error(found),
        "curves": [_curve(each, radius) for each in found],
    }
    data = json_file(design, "development", FRAME, body)
    return Made(data, metadata(found, radius))


def _curve(each: Unrolled, radius: float) -> dict[str, Any]:
    columns = {column.name: column.values.tolist() for column in _columns(each, radius)[2:]}
    if each.line.side == 0:
        del columns["departure_mm"]
    return {"name": each.name, "roller": each.line.seat.number, "side": each.line.side, **columns}


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
