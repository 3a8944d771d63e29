"""What a cutter or a grinding wheel of a given size reaches of a cam.

A cutter that touches the profile at c, where the normal m points out of the material, has its
centre at c + R m. It leaves another point q of the cam alone where q is no nearer than R:

    R ≤ |q − c|² / (2 m·(q − c))    for all q with m·(q − c) > 0,

whose limit for q → c is the radius of a hollow. So the largest cutter that reaches all of the
profile is the least of these, over all pairs of points; it also counts narrow places whose sides
lie far apart along the profile, and the other wall of a groove.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.catalogue.profile import CamProfile
from synthesis.design.design import Design
from synthesis.exporters.options import PlacedCurve
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import in_degrees
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

LOCAL = 3600  # angles at which the radius of hollows is looked at
PAIRED = 720  # angles at which all pairs are
CHUNK = 90  # points whose pairs are looked at together: bounds the memory
NEAR = 1e-4  # of the cam's size: nearer pairs are the hollow's radius and rounding
ROOM = 1e-9  # relative: a cutter that just fits, fits


@dataclass(frozen=True)
class Fit:
    """The largest cutter: its radius [mm], infinite where any fits, and where it touches."""

    radius: float
    angle_deg: float
    x: float
    y: float


def checked_cam(design: Design, options: PlacedCurve) -> Cam:
    """The cam and the curve that the options ask for.

    InputError: as ``Cam.of``; or its cutter does not reach all of the flank.
    """
    cam = Cam.of(design, options)
    cutter_diameter = options.cutter_diameter_mm
    if cutter_diameter is None:
        return cam
    fit = largest_cutter(cam)
    if 0.5 * cutter_diameter > fit.radius * (1.0 + ROOM):
        raise options.refusal(
            "cutter_diameter_mm",
            f"At cam angle {fit.angle_deg:.6g}°, x = {fit.x:.6g}, y = {fit.y:.6g} mm, no cutter "
            f"larger than {2.0 * fit.radius:.6g} mm in diameter reaches the profile.",
            "Take a smaller one, or ask for the design with the limit cutter_radius.",
        )
    return cam


def largest_cutter(cam: Cam) -> Fit:
    """The largest cutter that reaches all of the cam's flank."""
    # the least radius of its hollows
    hollow = cam.at(np.union1d(FULL_TURN * np.arange(LOCAL) / LOCAL, cam.joints.theta))
    radius = np.where(hollow.radius < 0.0, -hollow.radius, np.inf)
    # circles that touch one point and go through another, over all pairs
    theta = FULL_TURN * np.arange(PAIRED) / PAIRED
    at = cam.at(theta)
    c, m = np.stack([at.x, at.y]), cam.flank.side * np.stack([at.normal_x, at.normal_y])
    q = walls(cam, theta)
    least = np.concatenate(
        [_tangent(c[:, i : i + CHUNK], m[:, i : i + CHUNK], q) for i in range(0, PAIRED, CHUNK)]
    )
    return min(_fit(at, least), _fit(hollow, radius), key=lambda fit: fit.radius)


def walls(cam: Cam, theta: Array) -> Array:
    """Points (2, k n) at angles (n,) of the k flanks along the cam's traced curve [mm]."""
    flanks = [each.at(theta) for each in cam.flanks() if each.flank.path == cam.flank.path]
    return np.hstack([np.stack([flank.x, flank.y]) for flank in flanks])


def _tangent(c: Array, m: Array, q: Array) -> Array:
    """(k,) largest radius of circles that touch at c (2, k) with no q (2, n) inside."""
    dx, dy = (q[i][None, :] - c[i][:, None] for i in (0, 1))
    ahead = m[0][:, None] * dx + m[1][:, None] * dy
    square = dx * dx + dy * dy
    other = (ahead > 0.0) & (square > (NEAR * np.max(np.abs(c))) ** 2)
    radius = np.where(other, square, np.inf) / np.where(other, 2.0 * ahead, 1.0)
    return np.asarray(np.min(radius, axis=1))


def _fit(at: CamProfile, radii: Array) -> Fit:
    """Where the least of radii (n,) is."""
    k = int(np.argmin(radii))
    return Fit(float(radii[k]), float(in_degrees(at.theta[k])), float(at.x[k]), float(at.y[k]))
