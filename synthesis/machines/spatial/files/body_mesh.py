"""The whole cam as a mesh: STL for viewing, printing and measuring, JSON for an animated 3D view.

The JSON holds the cam's body as a grid, its rollers, and their motion. Points are integers in units
of a small length, little-endian 16-bit in base64: three for a point, column by column, row by row.
The grid's rows go once around the cam; the last row coincides with the first, but with its columns
shifted (a turret has advanced by some rollers).
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.exporter import FileContent, compact_json, machine_format
from synthesis.machines.spatial.body import (
    Blank,
    BlankOptions,
    Body,
    Mesh,
    build_body,
    flank_error,
    triangulate,
)
from synthesis.machines.spatial.cam import FRAME
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.grooves import GrooveSections
from synthesis.machines.spatial.machine import Seat
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

MAX_TRIANGLES = 1_000_000  # of an STL file
HEADER = 80  # bytes
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])
DEPTHS, PARTS = 4, 5  # rows of points on a wall; parts of the arc across a face
LARGEST = 32767  # signed 16 bits
MOTION_ROWS = 361  # of the table of the motion
PLACES = 6  # decimals of lengths and directions
Rows = Annotated[float, Field(ge=0.1, le=20.0)]
Levels = Annotated[int, Field(ge=2, le=100)]


@dataclass(frozen=True, kw_only=True)
class MeshOptions(BlankOptions):
    """As ``BlankOptions``, and how fine the mesh is."""

    points_per_degree: Rows = 1.0
    """Rows of points per degree of cam angle."""
    depths: Levels = 7
    """Rows of points from a rib's top to the floor."""


def mesh_body(
    design: SpatialDesign, options: MeshOptions, most: int
) -> tuple[Mesh, Mapping[str, str]]:
    """The cam's surface with at most so many triangles, and metadata of its files.

    Raises:
        InputError: there may be more (checked before anything is computed), or there is no body.
    """
    parts = design.spec.machine.chart(design.cam.sizes).parts
    grooves = len(design.walls) // 2 + 2
    columns = (grooves + 1) * 2 * (options.depths - 1 + parts)
    count = 2 * columns * 360.0 * options.points_per_degree
    if count > most:
        fewer = options.points_per_degree * most / count
        raise InputError(
            "/points_per_degree",
            options.points_per_degree,
            f"This may make {count:.2g} triangles; a file has at most {most}.",
            f"Request at most {fewer:.3g}, or fewer depths.",
        )
    cuts = GrooveSections(design.cam, design.spec.machine)
    blank = Blank.of(cuts, options, options.depths)
    body = build_body(cuts, blank, round(360.0 * options.points_per_degree))
    mesh = triangulate(body)
    return mesh, {
        "Surface-Error-Mm": f"{flank_error(cuts, body):.3g}",
        "Volume-Mm3": f"{mesh.volume:.10g}",
        "Triangles": str(len(mesh.triangles)),
    }


def _stl(design: SpatialDesign, options: MeshOptions) -> FileContent:
    mesh, metadata = mesh_body(design, options, MAX_TRIANGLES)
    records, normal = np.zeros(len(mesh.triangles), dtype=RECORD), mesh.normals
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    records["normal"] = normal / np.where(length > 0.0, length, 1.0)
    records["corners"] = np.stack(mesh.corners, axis=1)
    title = f"Camwright {design.engine_version}, {design.id}"
    head = title.encode("ascii", "replace")[:HEADER].ljust(HEADER)
    return FileContent(head + np.uint32(len(records)).tobytes() + records.tobytes(), metadata)


STL = machine_format("spatial", "body.stl", _stl, MeshOptions)


@dataclass(frozen=True, kw_only=True)
class SurfaceOptions(BlankOptions):
    """As ``BlankOptions``, and how fine the grid is."""

    points_per_degree: Annotated[float, Field(ge=0.1, le=1.0)] = 0.75
    """Rows of points per degree of cam angle."""


def _surfaces(design: SpatialDesign, options: SurfaceOptions) -> bytes:
    cuts = GrooveSections(design.cam, design.spec.machine)
    blank = Blank.of(cuts, options, DEPTHS)
    parts = min(PARTS, blank.chart.parts)
    body = build_body(cuts, blank, round(360.0 * options.points_per_degree), parts)
    head = {"kind": "surfaces", "frame": FRAME, "design": design.identification}
    return compact_json({**head, "body": _grid(body), "follower": _follower(design)})


def _grid(body: Body) -> dict[str, Any]:
    points = np.moveaxis(body.points, 0, -1)
    unit = float(np.max(np.abs(points))) / LARGEST
    whole = np.round(points / unit).astype("<i2")
    return {
        "rows": points.shape[0],
        "columns": points.shape[1],
        "unit_mm": unit,
        "points": base64.b64encode(whole.tobytes()).decode("ascii"),
        "strips": [
            {"kind": strip.kind, "first": strip.first, "last": strip.last} for strip in body.strips
        ],
        "bore_mm": 2.0 * body.blank.bore,
    }


def _follower(design: SpatialDesign) -> dict[str, Any]:
    """The rollers and their motion, in the frame of the cam at θ = 0.

    A point or direction is a + b cos q + c sin q + d q: rows a, b, c, d.
    """
    cam, machine = design.cam, design.spec.machine
    swept, axes = cam.swept, cam.axes
    theta = np.linspace(0.0, FULL_TURN, MOTION_ROWS)
    place = swept.joint.harmonics(swept.origin)
    place[0] -= swept.centre
    return {
        "cam_turns": swept.hand,
        "seats": [{"number": seat.number, "start": seat.start} for seat in machine.seats()],
        "radius_mm": swept.roller.radius,
        "inner_mm": swept.roller.inner,
        "outer_mm": swept.roller.outer,
        "origin_mm": _rounded(place @ axes.T),
        "along": _rounded(swept.joint.harmonics(swept.along, turning=True) @ axes.T),
        "unit": "rad" if machine.travel.unit == "deg" else "mm",
        "theta_deg": (theta / DEGREE).round(PLACES).tolist(),
        "q": _rounded(cam.place(Seat(0, 0.0), theta).q),
    }


def _rounded(values: Array) -> list[Any]:
    return (np.round(values, PLACES) + 0.0).tolist()  # type: ignore[no-any-return]


SURFACES = machine_format("spatial", "surfaces.json", _surfaces, SurfaceOptions)
