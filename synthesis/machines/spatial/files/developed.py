"""Development of a cylindrical cam: curves of its walls on a cylinder about its axis, unrolled.

A point of the cylinder is (φ, z): φ is the cam angle at which it passes the roller's side of the
cam, so that a roller with a radial axis is at φ = θ. Unrolled, the cylinder of radius r is the
plane (r φ, z).

A wall's curve is where its contact lines cross the cylinder: with the roller's axis at an offset y
from the cam's axis, a contact at place ρ has the coordinates ρ and y + r(ρ) m_y across the cam's
axis, so that ρ² + (y + r(ρ) m_y)² = r².

The usual drawing offsets the unrolled path of the roller's axis by the roller's radius instead, and
wraps that: exact in the plane, but the plane's normals are not the roller's. The departure is the
distance by which the true wall lies beyond that curve, in the plane of the cylinder.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.exporter import FileContent, compact_json, machine_format
from synthesis.exporters.options import Options
from synthesis.exporters.samples.columns import Column, concatenate
from synthesis.exporters.tables import csv_table
from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.machine import Seat
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

MAX_ITERATIONS = 40  # of the fixed point; it converges within about ten
CONVERGED = 1e-13  # of the cylinder's radius
MAX_STEPS, LAST_STEP = 12, 1e-8  # Gauss–Newton to the nearest point: steps, and the last one [rad]
DIFFERENCE = 1e-5  # rad: central differences; they only lead to the nearest point
PER_POINT = "theta", "phi", "z", "rho", "departure"  # of a curve
FRAME = (
    "A cylinder about the cam's axis, unrolled. angle_deg is the cam angle at which a point passes "
    "the roller's side of the cam, arc_mm its length on the cylinder; z_mm is along the axis, in "
    "the direction of the follower's motion. departure_mm: distance by which the true wall lies "
    "beyond the unrolled path of the roller's axis, offset by the roller's radius on the cam's "
    "outer cylinder and wrapped to this one; positive where the roller needs more space than that "
    "drawing gives."
)


@dataclass(frozen=True, eq=False)
class WallCurve:
    """A curve on the cylinder.

    Attributes:
        seat: the roller. side: its side; 0: the path of its axis.
        theta: (n,) cam angles of the contacts [rad]. phi, z: (n,) points on the cylinder [rad, mm].
        rho: (n,) places on the roller's axis [mm].
        departure: (n,) from the offset drawn in the plane [mm]; NaN where it is not known.
    """

    seat: Seat
    side: int
    theta: Array
    phi: Array
    z: Array
    rho: Array
    departure: Array

    @property
    def name(self) -> str:
        """Name of the wall, or number of the roller whose axis it is."""
        return f"{self.seat.number}{'L' if self.side < 0 else 'R' if self.side else ''}"

    def plane(self, radius: float) -> Array:
        """(2, n) unrolled [mm]."""
        return np.stack([radius * self.phi, self.z])


def wall_curve(cam: SpatialCam, seat: Seat, side: int, theta: Array, radius: float) -> WallCurve:
    """Where a wall, for side 0 the roller's axis, crosses the cylinder of this radius; else NaN."""
    swept, place = cam.swept, cam.place(seat, theta)
    transverse = np.cross(swept.axis, swept.along)

    def crossing(point: Array) -> tuple[Array, Array, Array]:
        """Offset across the cam's axis, height and ρ where lines along x cross the cylinder."""
        away = point[:, :, 0] - swept.centre[:, None]
        y = transverse @ away
        square = radius**2 - y**2
        return y, swept.axis @ away, np.sqrt(np.where(square > 0.0, square, np.nan))

    y, z, rho = crossing(swept.joint.move_points(swept.origin.reshape(3, 1, 1), place.q))
    # A contact's offset depends on its ρ: a fixed point, by iteration from the axis's.
    for _ in range(MAX_ITERATIONS if side else 0):
        before = rho
        y, z, rho = crossing(swept.contact_points(place, rho[:, None], side)[0])
        if not np.any(np.abs(rho - before) > CONVERGED * radius):
            break
    phi, z = theta - swept.hand * np.arctan2(y, rho), np.where(np.isnan(rho), np.nan, z)
    return WallCurve(seat, side, theta, phi, z, rho, np.full(len(theta), np.nan))


def offset_errors(cam: SpatialCam, line: WallCurve, drawn: float, radius: float) -> Array:
    """Departure (n,) of a wall on the cylinder of ``radius`` from the offset drawn on another [mm].

    Positive where the drawing removes less than the roller; NaN where it has no point near the
    wall's. ``drawn`` is the radius on which the roller's path was unrolled and offset.
    """

    def path(theta: Array) -> Array:
        return wall_curve(cam, line.seat, 0, theta, drawn).plane(drawn)

    def offset(theta: Array) -> Array:
        """The roller's path unrolled and offset at one radius, in the plane of the other."""
        axis = wall_curve(cam, line.seat, 0, theta, drawn)
        roller = cam.swept.roller.profile(axis.rho)[0]
        drawing = axis.plane(drawn) + line.side * roller * _normal(_derivative(path, theta))
        return np.stack([drawing[0] * radius / drawn, drawing[1]])

    # The nearest point of the drawing to each of the wall's, by Gauss–Newton's method.
    point, theta = line.plane(radius), line.theta
    for _ in range(MAX_STEPS):
        slope, away = _derivative(offset, theta), point - offset(theta)
        step = (away * slope).sum(axis=0) / (slope**2).sum(axis=0)
        if not np.any(np.abs(step) > LAST_STEP):
            break
        theta = theta + step
    beyond = line.side * (away * _normal(slope)).sum(axis=0)
    return np.where(np.abs(step) <= LAST_STEP, beyond, np.nan)


def _derivative(curve: Callable[[Array], Array], theta: Array) -> Array:
    return (curve(theta + DIFFERENCE) - curve(theta - DIFFERENCE)) / (2.0 * DIFFERENCE)


def _normal(slope: Array) -> Array:
    """Unit normals (2, n) to the left of tangents."""
    return np.asarray(np.stack([-slope[1], slope[0]]) / np.hypot(*slope))


@dataclass(frozen=True, kw_only=True)
class DevelopedOptions(Options):
    """The cylinder and the sampling."""

    radius_mm: Annotated[float | None, Field(gt=0.0, le=1e6)] = None
    """Radius of the cylinder that is unrolled; left out: the cam's."""
    points_per_degree: Annotated[float, Field(gt=0.0, le=20.0)] = 2.0
    """Points per degree of cam angle."""


@dataclass(frozen=True, eq=False)
class Development:
    """The walls and the paths of the rollers' axes on a cylinder [mm], in continuous runs."""

    radius: float
    curves: list[WallCurve]

    @cached_property
    def error(self) -> float | None:
        """Largest departure [mm]; None where the drawing has no point near any wall."""
        values = np.concatenate([np.abs(line.departure) for line in self.curves])
        known = values[~np.isnan(values)]
        return float(known.max()) if len(known) else None

    def file(self, data: bytes) -> FileContent:
        """A file of it with its metadata."""
        known = {} if self.error is None else {"Flat-Offset-Error-Mm": f"{self.error:.3g}"}
        return FileContent(data, {"Radius-Mm": f"{self.radius:.9g}", **known})


def develop(design: SpatialDesign, options: DevelopedOptions) -> Development:
    """Paths of all rollers' axes and all walls.

    Raises:
        InputError: the cam has no such cylinder, or rollers do not reach it, or pass beside it.
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
    if not any(line.side for line in curves):
        raise InputError(
            "/radius_mm", radius, "All rollers pass beside the cylinder of this radius.",
            f"Choose a larger one, up to {outer:.9g}.",
        )  # fmt: skip
    return Development(radius, curves)


def _curves(cam: SpatialCam, radius: float, drawn: float, density: float) -> Iterator[WallCurve]:
    """Walls with their departures, and the rollers' axes, in runs in which they reach the cylinder.

    ``drawn`` is as in ``offset_errors``; ``density``: points per rad.
    """
    pathed = set()
    for wall in cam.walls:
        for start, end in wall.spans:
            theta = np.linspace(start, end, max(2, int(np.ceil((end - start) * density)) + 1))
            lines = []
            if (wall.seat, start) not in pathed:
                pathed.add((wall.seat, start))
                lines.append(wall_curve(cam, wall.seat, 0, theta, radius))
            line = wall_curve(cam, wall.seat, wall.side, theta, radius)
            lines.append(replace(line, departure=offset_errors(cam, line, drawn, radius)))
            for line in lines:
                there = np.flatnonzero(~np.isnan(line.z))
                for run in np.split(there, np.flatnonzero(np.diff(there) > 1) + 1):
                    parts = {name: getattr(line, name)[run] for name in PER_POINT}
                    if len(run) > 1:
                        yield replace(line, **parts)


def _columns(line: WallCurve, radius: float) -> list[Column]:
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
            "departure_mm", "mm",
            "of the true wall from the offset in the plane; 0 where that has no point near it",
            np.nan_to_num(line.departure),
        ),
    ]  # fmt: skip


def _csv(design: SpatialDesign, options: DevelopedOptions) -> FileContent:
    unrolled = develop(design, options)
    columns = [_columns(line, unrolled.radius) for line in unrolled.curves]
    return unrolled.file(csv_table(concatenate(columns)))


def _json(design: SpatialDesign, options: DevelopedOptions) -> FileContent:
    unrolled, curves = develop(design, options), []
    for line in unrolled.curves:
        columns = _columns(line, unrolled.radius)[2 : None if line.side else -1]
        head = {"name": line.name, "roller": line.seat.number, "side": line.side}
        curves.append(head | {column.name: column.values.tolist() for column in columns})
    body = {
        "kind": "development", "frame": FRAME, "design": design.identification,
        "radius_mm": unrolled.radius, "flat_offset_error_mm": unrolled.error, "curves": curves,
    }  # fmt: skip
    return unrolled.file(compact_json(body))


CSV = machine_format("spatial", "developed.csv", _csv, DevelopedOptions)
JSON = machine_format("spatial", "developed.json", _json, DevelopedOptions)
