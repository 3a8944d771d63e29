"""Cutter paths: poses of a cutter that machines the rollers' walls, and their file.

A cutter of the roller's size moves as the roller does and machines both walls. One of radius Rc <
Rr has to keep the distance Rc from the wall: its axis would have to lie on the curve c = p − Rc n
through all contacts p, n the normal into the cam. The normal rotates along the roller's width (the
wall is twisted), so that c is not straight and no such cutter machines the wall exactly. With the
roller's axis direction u, the normal n in the middle, t = u × n, and τ from −1 to 1 over the width,
a line

    c(0) + a n + h τ (u + (b n + d t)/h)

deviates by e(τ) = (a + b τ) n·n(τ) + d τ t·n(τ) − (c(τ) − c(0) − h τ u)·n(τ), to first order; a, b,
d minimise the sum of squares of e. The tilt d, half of the twist, removes the error that grows with
the square of the twist. The rest is measured: the deviation of the cutter's envelope from the wall,
as the least distance of the wall's points from the moving axis, minus Rc.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.exporter import FileContent, machine_format
from synthesis.exporters.options import Options
from synthesis.exporters.samples.columns import Column, concatenate
from synthesis.exporters.tables import csv_table
from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.flanks import Density, Flank, sample_angles, select_walls
from synthesis.numerics.geometry.swept_roller import cross, dot, norm
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

PLACES = 9  # on the roller's axis
STEP = 2e-3  # rad: to the neighbouring poses, between which the cutter is nearest (by a parabola)
RANK = 1e-9  # of the largest singular value: smaller ones count as 0 in the least squares
BOTH = 0  # side of a path that machines both walls


class CutterPoses(NamedTuple):
    """Poses of a cutter at cam angles ``theta`` (n,) [rad], in the machine's frame, (3, n) each.

    ``centre`` lies on its axis at the middle of the roller's width [mm], ``direction`` points away
    from the roller's ρ = 0.
    """

    theta: Array
    centre: Array
    direction: Array


def roller_poses(cam: SpatialCam, which: Wall, theta: Array) -> CutterPoses:
    """Poses of a cutter of the roller's own form, at cam angles (n,) [rad]."""
    swept, q = cam.swept, cam.place(which.seat, theta).q
    middle = swept.origin + swept.roller.middle * swept.along
    centre = swept.joint.move_points(middle.reshape(3, 1, 1), q)[:, :, 0]
    direction = swept.joint.turn_direction(swept.along.reshape(3, 1, 1), q)[:, :, 0]
    return CutterPoses(theta, centre, direction)


def flank_poses(cam: SpatialCam, which: Wall, theta: Array, radius: float) -> CutterPoses:
    """Poses of a cylindrical cutter of this radius [mm] on one wall, at cam angles (n,) [rad]."""
    roller = cam.swept.roller
    tau = np.linspace(-1.0, 1.0, PLACES)
    half = 0.5 * (roller.outer - roller.inner)
    contacts = cam.contacts(which, theta, roller.middle + half * tau)
    wanted = contacts.point - radius * contacts.normal
    middle = PLACES // 2
    u = roller_poses(cam, which, theta).direction
    n = contacts.normal[:, :, middle]
    n = n - dot(n, u) * u
    n = n / norm(n)
    t = cross(u, n)
    on_n, on_t = (dot(each[:, :, None], contacts.normal) for each in (n, t))
    columns = np.stack([on_n, tau * on_n, tau * on_t], axis=-1)
    line = wanted[:, :, middle, None] + half * tau * u[:, :, None]
    missed = dot(wanted - line, contacts.normal)
    a, b, d = np.moveaxis(np.linalg.pinv(columns, rcond=RANK) @ missed[:, :, None], 1, 0)[..., 0]
    direction = half * u + b * n + d * t
    return CutterPoses(theta, wanted[:, :, middle] + a * n, direction / norm(direction))


def envelope_error(
    cam: SpatialCam, which: Wall, poses: tuple[CutterPoses, CutterPoses, CutterPoses], radius: float
) -> Array:
    """Deviation of the cutter's envelope from the wall: (n, m), positive where material is left.

    ``poses`` are those ``STEP`` before, at, and ``STEP`` after the same cam angles (n,).
    """
    swept, theta = cam.swept, poses[1].theta
    point = swept.on_cam(theta, cam.contacts(which, theta, swept.roller.places(PLACES)).point)

    def distance(pose: CutterPoses) -> Array:
        """Of the wall's points from the cutter's axis."""
        centre = swept.on_cam(pose.theta, pose.centre[:, :, None])
        far = swept.on_cam(pose.theta, (pose.centre + pose.direction)[:, :, None])
        return norm(cross(point - centre, far - centre))

    before, at, after = map(distance, poses)
    bend = before + after - 2.0 * at
    least = at - np.where(bend > 0.0, (after - before) ** 2 / (8.0 * np.abs(bend)), 0.0)
    return np.asarray(least - radius)


@dataclass(frozen=True, kw_only=True)
class CutterOptions(Options):
    """The cutter and the sampling of its path; an empty ``flank`` stands for all."""

    cutter_diameter_mm: Annotated[float | None, Field(gt=0.0, le=1e6)] = None
    """Diameter of a cylindrical cutter. Left out: a cutter of the roller's own form, which machines
    both walls at once, exactly; a thinner one machines each flank separately."""
    flank: Flank = ""
    frame: Literal["cam", "machine"] = "cam"
    """`cam`: positions and directions in the cam's frame, for a five-axis part program. `machine`:
    the same with the cam rotated by c_deg."""
    points_per_degree: Density = 1.0


def _csv(design: SpatialDesign, options: CutterOptions) -> FileContent:
    cam = design.cam
    walls, radius = select_walls(cam, options.flank), _radius(cam, options)
    if radius is None:
        walls = list({wall.seat.number: wall for wall in walls}.values())
    columns, errors = [], [0.0]
    for wall, _, theta in sample_angles(walls, options.points_per_degree):
        if radius is None:
            columns.append(_columns(cam, wall, BOTH, roller_poses(cam, wall, theta), options))
            continue
        before, at, after = (
            flank_poses(cam, wall, theta + step, radius) for step in (-STEP, 0.0, STEP)
        )
        columns.append(_columns(cam, wall, wall.side, at, options))
        error = envelope_error(cam, wall, (before, at, after), radius)
        errors.append(float(np.max(np.abs(error))))
    return FileContent(csv_table(concatenate(columns)), {"Wall-Error-Mm": f"{max(errors):.3g}"})


def _radius(cam: SpatialCam, options: CutterOptions) -> float | None:
    """Radius of a cutter thinner than the roller [mm]; None: a cutter of the roller's form."""
    roller = cam.swept.roller
    if options.cutter_diameter_mm is None:
        return None
    radius = 0.5 * options.cutter_diameter_mm
    thinnest = float(np.min(roller.profile(roller.places(2))[0]))
    if radius > roller.radius or (roller.crown and radius >= thinnest):
        most = 2.0 * (thinnest if roller.crown else roller.radius)
        raise InputError(
            "/cutter_diameter_mm",
            options.cutter_diameter_mm,
            f"A cylindrical cutter must be thinner than the roller, {most:.9g} mm at its "
            "thinnest, or it removes too much material.",
            "Choose a thinner one, or leave it out for a cutter of the roller's form.",
        )
    return None if radius == roller.radius else radius


def _columns(
    cam: SpatialCam, wall: Wall, side: int, poses: CutterPoses, options: CutterOptions
) -> Sequence[Column]:
    swept = cam.swept
    # The tool axis points to the spindle, away from the cam's axis.
    outwards = math.copysign(1.0, float(cam.axes[0] @ swept.along))
    tool = outwards * poses.direction
    tip = poses.centre - 0.5 * (swept.roller.outer - swept.roller.inner) * tool
    if options.frame == "cam":
        tip = cam.frame_points(poses.theta, tip[:, :, None])[:, :, 0]
        tool = cam.frame_directions(poses.theta, tool[:, :, None])[:, :, 0]
    else:
        tip, tool = cam.axes @ (tip - swept.centre[:, None]), cam.axes @ tool
    count = len(poses.theta)
    return [
        Column("roller", "1", "number of the roller", np.full(count, wall.seat.number)),
        Column("side", "1", "R: 1, L: -1, both flanks at once: 0", np.full(count, side)),
        Column("theta_deg", "deg", "cam angle", poses.theta / DEGREE),
        Column("c_deg", "deg", "rotation of the cam about z", swept.hand * poses.theta / DEGREE),
        *(Column(f"{name}_mm", "mm", "tip of the cutter, at the roller's end", values)
          for name, values in zip("xyz", tip, strict=True)),
        *(Column(name, "1", "axis of the cutter, from its tip to the spindle", values)
          for name, values in zip("ijk", tool, strict=True)),
    ]  # fmt: skip


CSV = machine_format("spatial", "cutter.csv", _csv, CutterOptions)
