"""The cam's profile at given cam angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.catalogue.constraints import Vector
from synthesis.catalogue.fields import Rotation
from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.kinematics import Flank
from synthesis.catalogue.motion import Motion
from synthesis.numerics.geometry.plane import to_cam
from synthesis.numerics.piecewise import Array, Side


@dataclass(frozen=True, eq=False)
class CamProfile:
    """Points of the cam in its own frame (at cam angle 0 the machine's frame), all (n,).

    Attributes:
        theta: cam angle [rad].
        s: (4, n) displacement and its derivatives per radian [mm].
        pitch_x, pitch_y: roller centre [mm]. x, y: profile (contact point) [mm].
        normal_x, normal_y: unit normal, away from the cam's axis, common to both curves.
        curvature: signed curvature of the pitch curve [1/mm], convex positive.
        radius: signed radius of curvature of the profile [mm], positive where its material is
            convex: ρ_pitch − Rr, of a flank touched from inside −ρ_pitch − Rr; ∞ where straight;
            along a flat face negative where undercut.
        pressure_angle: signed α [rad]; positive where the cam pushes against a rise.
        speed: of the traced curve [mm/rad]; negative where it runs backwards along a face.
    """

    theta: Array
    s: Array
    pitch_x: Array
    pitch_y: Array
    x: Array
    y: Array
    normal_x: Array
    normal_y: Array
    curvature: Array
    radius: Array
    pressure_angle: Array
    speed: Array


def cam_profile(
    motion: Motion,
    follower: Follower,
    size: Vector,
    rotation: Rotation,
    theta: Array,
    side: Side = "right",
    flank: Flank | None = None,
) -> CamProfile:
    """A flank as envelope of the roller: the pitch curve less σ D along its exact normal.

    Args:
        rotation: sense of the cam's turning; clockwise is the mirror image.
        theta: (n,) cam angles [rad].
        side: which one-sided values to give where a derivative jumps.
        flank: which of the cam's flanks; None: the first.
    """
    flank = flank or follower.flanks[0]
    trace, gap = flank.trace, flank.side * flank.distance
    s = motion.derivatives(theta, 3, side)
    (px, py), (dx, dy), (ax, ay), *_ = trace.position(s, size)
    tx, ty = dx + py, dy - px  # tangent D p, D = d/dθ + J
    sx, sy = ax + dy + ty, ay - dx - tx  # D D p
    wx, wy = trace.normal((tx, ty), s, size)  # the curve runs clockwise: outward is left
    length = np.hypot(wx, wy)
    nx, ny = wx / length, wy / length
    # an undercut curve runs backwards along a face: negative speed, negative radius
    speed = np.copysign(np.hypot(tx, ty), tx * ny - ty * nx)
    with np.errstate(divide="ignore", invalid="ignore"):  # a cusp has radius 0
        curvature = np.where(speed == 0.0, np.inf, (ty * sx - tx * sy) / speed**3)
    (gx, gy), _ = trace.drive_direction(s, size)
    alpha = np.arctan2(gx * ny - gy * nx, gx * nx + gy * ny)
    with np.errstate(divide="ignore"):
        radius = 1.0 / (flank.side * curvature) - flank.distance
    mirror = -1.0 if rotation == "cw" else 1.0
    (pitch_x, pitch_y), (normal_x, normal_y) = to_cam(theta, px, py), to_cam(theta, nx, ny)
    x, y = pitch_x - gap * normal_x, pitch_y - gap * normal_y
    return CamProfile(
        theta, s, mirror * pitch_x, pitch_y, mirror * x, y, mirror * normal_x, normal_y,
        curvature, radius, alpha, speed,
    )  # fmt: skip
