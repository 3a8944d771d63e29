"""Extremes over all contacts of all walls.

Every quantity is tried on a grid of each patch, and from the best places on between neighbours,
ever closer. What the last steps still gained is told as the width: a measurement, not a proof.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.geometry.swept_roller import cross, dot, norm
from synthesis.numerics.piecewise import Array
from synthesis.spatial.cam import SpatialCam
from synthesis.spatial.measuring import radii
from synthesis.spatial.measuring.enclosing import PRESSURE, UNDERCUT, Proof, proven
from synthesis.spatial.measuring.follower import jump
from synthesis.spatial.measuring.found import Bound, Bounds, Found, Kind, leading
from synthesis.spatial.measuring.patches import Patch, Tried, tried
from synthesis.units import DEGREE

ANGLES, PLACES = 49, 7  # tried on each patch
WHOLE = 480  # angles tried on a wall of many patches
KEPT = 2  # patches that are looked at more closely
CLOSER, ROUNDS, SHRINK = 7, 17, 0.4  # a grid around the best so far, and how it narrows
EVIDENCE = "measured on a grid of every smooth part of a wall, then closer"
Values = Callable[[Patch, Array, Array], Array]
Prover = Callable[[SpatialCam, Sequence[Patch], Found, float | None], Found]


@dataclass(frozen=True)
class Measured:
    """A quantity that contacts have: its values (n, m) at θ (n,) and ρ (m,) of a patch.

    ``proof`` says how its extreme is enclosed; None: it is measured and no more.
    """

    kind: Kind
    of: Values
    proof: Prover | None = None


def _sliding(patch: Patch, theta: Array, rho: Array) -> Array:
    """What slides where the roller turns so that nothing slides across its middle [mm]."""
    swept = patch.cam.swept
    both = np.append(rho, swept.roller.middle)
    found = patch.contacts(theta, both)
    u = swept.joint.turned(swept.along.reshape(3, 1, 1), patch.place(theta).q)
    across = cross(u, found.normal)
    across = across / norm(across)
    radius = swept.roller.profile(both)[0]
    spin = (dot(across, found.slip) / radius)[:, -1:]
    return norm(found.slip - spin * radius * across)[:, :-1]


def _spin(patch: Patch, theta: Array, rho: Array) -> Array:
    """How fast the roller turns for that, against the turn of the cam."""
    swept = patch.cam.swept
    found = patch.contacts(theta, np.array([swept.roller.middle]))
    u = swept.joint.turned(swept.along.reshape(3, 1, 1), patch.place(theta).q)
    across = cross(u, found.normal)
    rate = np.abs(dot(across, found.slip)) / norm(across) / swept.roller.radius
    return rate + 0.0 * rho


def _radius(curvature: float) -> float:
    """Of a curvature with its sign turned; infinite where it is none of this kind."""
    if np.isinf(curvature):
        return curvature
    return -1.0 / curvature if curvature < 0.0 else np.inf


def _enclosed(proof: Proof) -> Prover:
    return lambda cam, parts, found, allowed: proven(cam, parts, proof, found, allowed)


STEEPNESS = Measured(
    Kind("pressure_angle", "deg", True, lambda v: v / DEGREE, lambda v: v * DEGREE),
    lambda p, theta, rho: p.contacts(theta, rho).pressure_angle,
    _enclosed(PRESSURE),
)
AREA = Measured(
    Kind("undercut", "1", False, must=Bound(0.0)),
    lambda p, theta, rho: p.contacts(theta, rho).regular,
    _enclosed(UNDERCUT),
)
RADII = (
    Measured(
        Kind("convex_radius", "mm", False, _radius, lambda radius: -1.0 / radius),
        lambda p, theta, rho: -p.curvatures(theta, rho)[0],
        radii.bulging,
    ),
    Measured(
        Kind("hollow_radius", "mm", False, _radius, lambda radius: -1.0 / radius),
        lambda p, theta, rho: p.curvatures(theta, rho)[1],
        radii.hollow,
    ),
)
CORNER = Found(
    -np.inf, -np.inf, "the velocity jumps there: walls on one side cross, on the other do not meet"
)
NO_RADIUS = Found(-np.inf, -np.inf, "a wall is undercut: there is no such radius")


def _speeds(omega: float) -> Sequence[Measured]:
    """Of a cam that turns at ω [rad/s]."""
    rpm = omega * 60.0 / (2.0 * np.pi)
    return (
        Measured(
            Kind("contact_speed", "mm/s", True, lambda value: value * omega),
            lambda p, theta, rho: norm(p.contacts(theta, rho).slip),
        ),
        Measured(Kind("sliding_speed", "mm/s", True, lambda value: value * omega), _sliding),
        Measured(Kind("roller_speed", "rpm", True, lambda value: value * rpm), _spin),
    )


def extremes(
    cam: SpatialCam, parts: Sequence[Patch], omega: float, bounds: Bounds
) -> Iterator[tuple[Kind, Found]]:
    """Every quantity's extreme over all patches."""
    if not parts:
        return
    rho = np.linspace(cam.swept.roller.inner, cam.swept.roller.outer, PLACES)
    grids = list(tried(parts, ANGLES, WHOLE))

    def over(quantity: Measured) -> Found:
        bound = bounds.get(quantity.kind.name, quantity.kind.must)
        allowed = None if bound is None else quantity.kind.core(bound.value)
        return _extreme(quantity, parts, grids, rho, allowed)

    yield STEEPNESS.kind, over(STEEPNESS)
    corner = jump(cam.motion.curve, 1)
    area = over(AREA) if corner is None else replace(CORNER, theta=corner)
    yield AREA.kind, area
    for radius in RADII:
        yield radius.kind, over(radius) if area.value > 0.0 else NO_RADIUS
    for speed in _speeds(omega):
        yield speed.kind, over(speed)


def _extreme(
    quantity: Measured,
    parts: Sequence[Patch],
    walls: Sequence[Tried],
    rho: Array,
    allowed: float | None,
) -> Found:
    """The extreme over all patches, which are tried wall by wall; proven where it can be.

    ``allowed``: what it may come to [core units].
    """
    sign = 1.0 if quantity.kind.largest else -1.0
    seen = [
        (part, theta, values)
        for wall in walls
        for part, theta, values in zip(
            parts[wall.first :],
            wall.theta,
            wall.apart(sign * _values(quantity, wall.together, wall.theta.ravel(), rho)),
            strict=False,
        )
    ]
    best = sorted(seen, key=lambda each: -leading(each[2].max()))[:KEPT]
    found = [_closer(quantity, sign, *each, rho) for each in best]
    most = max(found, key=lambda each: leading(sign * each.value))
    if quantity.proof is None or not np.isfinite(most.value):
        return most
    return quantity.proof(parts[0].cam, parts, most, allowed)


def _values(quantity: Measured, patch: Patch, theta: Array, rho: Array) -> Array:
    """Values (n, m), and of what lies beyond the end faces nothing that could count."""
    values = quantity.of(patch, theta, rho)
    cam = patch.cam
    if np.all(np.isinf(cam.faces)):
        return values
    inside = cam.between_faces(patch.points(theta, rho))
    return np.where(inside, values, -np.inf if quantity.kind.largest else np.inf)


def _closer(
    quantity: Measured, sign: float, patch: Patch, angles: Array, values: Array, rho: Array
) -> Found:
    """The best near the best of a grid."""
    n, m = np.unravel_index(int(np.argmax(values)), values.shape)
    theta, place, value = float(angles[n]), float(rho[m]), float(values[n, m])
    wide = (patch.high - patch.low) / max(len(angles) - 1, 1)
    long = (rho[-1] - rho[0]) / (len(rho) - 1)
    before = value
    for _ in range(ROUNDS):
        around = np.clip(theta + wide * np.linspace(-1.0, 1.0, CLOSER), patch.low, patch.high)
        along = np.clip(place + long * np.linspace(-1.0, 1.0, CLOSER), rho[0], rho[-1])
        values = sign * _values(quantity, patch, around, along)
        n, m = np.unravel_index(int(np.argmax(values)), values.shape)
        before = value
        if values[n, m] > value:
            value, theta, place = float(values[n, m]), float(around[n]), float(along[m])
        wide, long = SHRINK * wide, SHRINK * long
    limit = value + 2.0 * (value - before)
    return Found(sign * value, sign * limit, EVIDENCE, theta, patch.wall, place)
