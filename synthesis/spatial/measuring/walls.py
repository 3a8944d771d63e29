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
from synthesis.spatial.measuring.enclosing import PRESSURE, Models, Proof, proven, undercut
from synthesis.spatial.measuring.follower import jump
from synthesis.spatial.measuring.found import Bound, Bounds, Found, Kind, leading
from synthesis.spatial.measuring.patches import Patch, Spots, Touching, Tried, tried
from synthesis.units import DEGREE

ANGLES, PLACES = 49, 5  # tried on each patch
WHOLE = 240  # angles tried on a wall of many patches
KEPT = 2  # patches that are looked at more closely
CLOSER, ROUNDS, SHRINK = 11, 8, 0.25  # a grid around the best so far, and how it narrows
EVIDENCE = "measured on a grid of every smooth part of a wall, then closer"
Values = Callable[[Touching, Array, Array], Array]
Prover = Callable[[Models, Found, float | None], Found]


@dataclass(frozen=True)
class Measured:
    """A quantity that contacts have: its values (n, m) at θ (n,) and ρ, (m,) or (n, m).

    ``proof`` says how its extreme is enclosed; None: it is measured and no more.
    """

    kind: Kind
    of: Values
    proof: Prover | None = None


def _sliding(patch: Touching, theta: Array, rho: Array) -> Array:
    """What slides where the roller turns so that nothing slides across its middle [mm]."""
    swept = patch.cam.swept
    middle = np.full((*rho.shape[:-1], 1), swept.roller.middle)
    both = np.concatenate([rho, middle], axis=-1)
    found = patch.contacts(theta, both)
    u = swept.joint.turned(swept.along.reshape(3, 1, 1), patch.place(theta).q)
    across = cross(u, found.normal)
    across = across / norm(across)
    radius = swept.roller.profile(both)[0]
    spin = dot(across, found.slip)[:, -1:] / swept.roller.radius
    return norm(found.slip - spin * radius * across)[:, :-1]


def _spin(patch: Touching, theta: Array, rho: Array) -> Array:
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


def _steepness(models: Models, found: Found, allowed: float | None) -> Found:
    return proven(models, PRESSURE, found, allowed)


def _area(models: Models, found: Found, allowed: float | None) -> Found:
    return proven(models, Proof(undercut(models.cam.swept.roller.radius), -1.0), found, allowed)


STEEPNESS = Measured(
    Kind("pressure_angle", "deg", True, lambda v: v / DEGREE, lambda v: v * DEGREE),
    lambda p, theta, rho: p.contacts(theta, rho).pressure_angle,
    _steepness,
)
AREA = Measured(
    Kind("undercut", "1", False, must=Bound(0.0)),
    lambda p, theta, rho: p.contacts(theta, rho).regular,
    _area,
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
    # crowned rollers sweep something else than a ruled surface
    models = None if cam.swept.roller.crown > 0.0 else Models(cam, parts)

    def over(quantity: Measured) -> Found:
        bound = bounds.get(quantity.kind.name, quantity.kind.must)
        allowed = None if bound is None else quantity.kind.core(bound.value)
        found = _extreme(quantity, parts, grids, rho)
        if models is None or quantity.proof is None or not np.isfinite(found.value):
            return found
        return quantity.proof(models, found, allowed)

    yield STEEPNESS.kind, over(STEEPNESS)
    corner = jump(cam.motion.curve, 1)
    area = over(AREA) if corner is None else replace(CORNER, theta=corner)
    yield AREA.kind, area
    for radius in RADII:
        yield radius.kind, over(radius) if area.value > 0.0 else NO_RADIUS
    for speed in _speeds(omega):
        yield speed.kind, over(speed)


def _extreme(
    quantity: Measured, parts: Sequence[Patch], walls: Sequence[Tried], rho: Array
) -> Found:
    """The extreme over all patches, which are tried wall by wall."""
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
    return max(_closer(quantity, sign, best, rho), key=lambda each: leading(sign * each.value))


def _values(quantity: Measured, patch: Touching, theta: Array, rho: Array) -> Array:
    """Values (n, m), and of what lies beyond the end faces nothing that could count."""
    values = quantity.of(patch, theta, rho)
    cam = patch.cam
    if np.all(np.isinf(cam.faces)):
        return values
    inside = cam.between_faces(patch.points(theta, rho))
    return np.where(inside, values, -np.inf if quantity.kind.largest else np.inf)


def _closer(
    quantity: Measured, sign: float, best: Sequence[tuple[Patch, Array, Array]], rho: Array
) -> Sequence[Found]:
    """The best near the best of grids, each on its own patch; all of them in one go."""
    parts, spots = [part for part, *_ in best], np.arange(len(best))
    n, m = np.array([np.unravel_index(np.argmax(values), values.shape) for *_, values in best]).T
    theta, value = np.array([(a[i], v[i, j]) for (_, a, v), i, j in zip(best, n, m, strict=True)]).T
    place, long = rho[m], (rho[-1] - rho[0]) / (len(rho) - 1)
    low, high = np.array([(part.low, part.high) for part in parts]).T[:, :, None]
    wide = (high - low) / np.array([[max(len(angles) - 1, 1)] for _, angles, _ in best])
    grid, before = np.linspace(-1.0, 1.0, CLOSER), value
    together = Spots(parts[0].cam, parts, CLOSER)
    for _ in range(ROUNDS):
        around = np.clip(theta[:, None] + wide * grid, low, high)
        along = np.clip(place[:, None] + long * grid, rho[0], rho[-1])
        each = np.repeat(along, CLOSER, axis=0)
        found = sign * _values(quantity, together, around.ravel(), each)
        found = found.reshape(len(best), -1)
        at = np.argmax(found, axis=1)
        n, m = np.divmod(at, CLOSER)
        before, better = value, found[spots, at] > value
        value = np.where(better, found[spots, at], value)
        theta = np.where(better, around[spots, n], theta)
        place = np.where(better, along[spots, m], place)
        wide, long = SHRINK * wide, SHRINK * long
    limit = value + 2.0 * (value - before)
    told = zip(parts, *np.stack([sign * value, sign * limit, theta, place]).tolist(), strict=True)
    return [Found(v, l, EVIDENCE, t, part.wall, r) for part, v, l, t, r in told]
