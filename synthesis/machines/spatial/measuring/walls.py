"""Extrema over all contacts of all walls.

Every quantity is sampled on a grid of each patch, and refined around the best samples. What the
last refinement gained is reported as the width: a measurement, not a proof. ``enclosure`` proves
pressure angle, undercut and radii where rollers are cylindrical.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.measuring import enclosure
from synthesis.machines.spatial.measuring.enclosure import (
    PRESSURE,
    Models,
    Proof,
    prove_extremum,
    undercut,
)
from synthesis.machines.spatial.measuring.extremum import Bound, Bounds, Extremum, Quantity, rounded
from synthesis.machines.spatial.measuring.motion import first_jump
from synthesis.machines.spatial.measuring.patches import (
    ContactPlaces,
    Patch,
    PatchSet,
    WallSamples,
    sample_walls,
)
from synthesis.numerics.geometry.swept_roller import cross, dot, norm
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

ANGLES, PLACES = 49, 5  # samples of a patch: cam angles, places
WHOLE = 240  # about so many angles on a wall with many patches
REFINED = 2  # patches that are refined
GRID, ROUNDS, SHRINK = 11, 8, 0.25  # refinement: points a direction, rounds, shrinkage a round
EVIDENCE = "measured on a grid of every smooth part of a wall, then closer"
Values = Callable[[ContactPlaces, Array, Array], Array]
Prover = Callable[[Models, Extremum, float | None], Extremum]


@dataclass(frozen=True)
class ContactQuantity:
    """A quantity of contacts.

    Attributes:
        kind: what is measured. of: its values (n, m) at θ (n,) and ρ, (m,) or (n, m).
        proof: how its extremum is proven; None: it is measured only.
    """

    kind: Quantity
    of: Values
    proof: Prover | None = None


def _sliding(patch: ContactPlaces, theta: Array, rho: Array) -> Array:
    """Sliding per radian, the roller turning so that its middle does not slide across [mm]."""
    swept = patch.cam.swept
    middle = np.full((*rho.shape[:-1], 1), swept.roller.middle)
    both = np.concatenate([rho, middle], axis=-1)
    found = patch.contacts(theta, both)
    u = swept.joint.turn_direction(swept.along.reshape(3, 1, 1), patch.place(theta).q)
    across = cross(u, found.normal)
    across = across / norm(across)
    radius = swept.roller.profile(both)[0]
    spin = dot(across, found.slip)[:, -1:] / swept.roller.radius
    return norm(found.slip - spin * radius * across)[:, :-1]


def _spin(patch: ContactPlaces, theta: Array, rho: Array) -> Array:
    """Speed at which the roller turns then, relative to the cam's."""
    swept = patch.cam.swept
    found = patch.contacts(theta, np.array([swept.roller.middle]))
    u = swept.joint.turn_direction(swept.along.reshape(3, 1, 1), patch.place(theta).q)
    across = cross(u, found.normal)
    rate = np.abs(dot(across, found.slip)) / norm(across) / swept.roller.radius
    return rate + 0.0 * rho


def _radius(curvature: float) -> float:
    """Radius of a negated curvature; infinite where the curvature has the other sign."""
    if np.isinf(curvature):
        return curvature
    return -1.0 / curvature if curvature < 0.0 else np.inf


def _prove_pressure_angle(models: Models, found: Extremum, allowed: float | None) -> Extremum:
    return prove_extremum(models, PRESSURE, found, allowed)


def _prove_regular(models: Models, found: Extremum, allowed: float | None) -> Extremum:
    return prove_extremum(
        models, Proof(undercut(models.cam.swept.roller.radius), -1.0), found, allowed
    )


PRESSURE_ANGLE = ContactQuantity(
    Quantity("pressure_angle", "deg", True, lambda v: v / DEGREE, lambda v: v * DEGREE),
    lambda p, theta, rho: p.contacts(theta, rho).pressure_angle,
    _prove_pressure_angle,
)
UNDERCUT = ContactQuantity(
    Quantity("undercut", "1", False, required=Bound(0.0)),
    lambda p, theta, rho: p.contacts(theta, rho).regular,
    _prove_regular,
)
RADII = (
    ContactQuantity(
        Quantity("convex_radius", "mm", False, _radius, lambda radius: -1.0 / radius),
        lambda p, theta, rho: -p.curvatures(theta, rho)[0],
        enclosure.prove_convex_radius,
    ),
    ContactQuantity(
        Quantity("hollow_radius", "mm", False, _radius, lambda radius: -1.0 / radius),
        lambda p, theta, rho: p.curvatures(theta, rho)[1],
        enclosure.prove_hollow_radius,
    ),
)
CORNER = Extremum(
    -np.inf,
    -np.inf,
    "the velocity jumps there: walls cross on one side and leave a gap on the other",
)
NO_RADIUS = Extremum(-np.inf, -np.inf, "a wall is undercut: there is no such radius")


def _speeds(omega: float) -> Sequence[ContactQuantity]:
    """Speeds of a cam that turns at ω [rad/s]."""
    rpm = omega * 60.0 / (2.0 * np.pi)
    return (
        ContactQuantity(
            Quantity("contact_speed", "mm/s", True, lambda value: value * omega),
            lambda p, theta, rho: norm(p.contacts(theta, rho).slip),
        ),
        ContactQuantity(
            Quantity("sliding_speed", "mm/s", True, lambda value: value * omega), _sliding
        ),
        ContactQuantity(Quantity("roller_speed", "rpm", True, lambda value: value * rpm), _spin),
    )


def extrema(
    cam: SpatialCam, parts: Sequence[Patch], omega: float, bounds: Bounds
) -> Iterator[tuple[Quantity, Extremum]]:
    """The extremum of every quantity over all patches."""
    if not parts:
        return
    rho = np.linspace(cam.swept.roller.inner, cam.swept.roller.outer, PLACES)
    grids = list(sample_walls(parts, ANGLES, WHOLE))
    # The proof is for ruled surfaces: the contacts of a crowned roller are not offsets of one.
    models = None if cam.swept.roller.crown > 0.0 else Models(cam, parts)

    def over(quantity: ContactQuantity) -> Extremum:
        bound = bounds.get(quantity.kind.name, quantity.kind.required)
        allowed = None if bound is None else quantity.kind.from_wire(bound.value)
        found = _extreme(quantity, parts, grids, rho)
        if models is None or quantity.proof is None or not np.isfinite(found.value):
            return found
        return quantity.proof(models, found, allowed)

    yield PRESSURE_ANGLE.kind, over(PRESSURE_ANGLE)
    corner = first_jump(cam.motion.curve, 1)
    area = over(UNDERCUT) if corner is None else replace(CORNER, theta=corner)
    yield UNDERCUT.kind, area
    for radius in RADII:
        yield radius.kind, over(radius) if area.value > 0.0 else NO_RADIUS
    for speed in _speeds(omega):
        yield speed.kind, over(speed)


def _extreme(
    quantity: ContactQuantity, parts: Sequence[Patch], walls: Sequence[WallSamples], rho: Array
) -> Extremum:
    """The extremum over all patches, sampled wall by wall."""
    sign = 1.0 if quantity.kind.largest else -1.0
    seen = [
        (part, theta, values)
        for wall in walls
        for part, theta, values in zip(
            parts[wall.first :],
            wall.theta,
            wall.by_patch(sign * _values(quantity, wall.together, wall.theta.ravel(), rho)),
            strict=False,
        )
    ]
    best = sorted(seen, key=lambda each: -rounded(each[2].max()))[:REFINED]
    return max(_refine(quantity, sign, best, rho), key=lambda each: rounded(sign * each.value))


def _values(quantity: ContactQuantity, patch: ContactPlaces, theta: Array, rho: Array) -> Array:
    """Values (n, m); beyond the end faces the worst value, which is no extremum."""
    values = quantity.of(patch, theta, rho)
    cam = patch.cam
    if np.all(np.isinf(cam.faces)):
        return values
    inside = cam.between_faces(patch.points(theta, rho))
    return np.where(inside, values, -np.inf if quantity.kind.largest else np.inf)


def _refine(
    quantity: ContactQuantity, sign: float, best: Sequence[tuple[Patch, Array, Array]], rho: Array
) -> Sequence[Extremum]:
    """Refine the best samples, each on its own patch; all of them in one vectorised call."""
    parts, spots = [part for part, *_ in best], np.arange(len(best))
    n, m = np.array([np.unravel_index(np.argmax(values), values.shape) for *_, values in best]).T
    theta, value = np.array([(a[i], v[i, j]) for (_, a, v), i, j in zip(best, n, m, strict=True)]).T
    place, long = rho[m], (rho[-1] - rho[0]) / (len(rho) - 1)
    low, high = np.array([(part.low, part.high) for part in parts]).T[:, :, None]
    wide = (high - low) / np.array([[max(len(angles) - 1, 1)] for _, angles, _ in best])
    grid, before = np.linspace(-1.0, 1.0, GRID), value
    together = PatchSet(parts[0].cam, parts, GRID)
    for _ in range(ROUNDS):
        around = np.clip(theta[:, None] + wide * grid, low, high)
        along = np.clip(place[:, None] + long * grid, rho[0], rho[-1])
        each = np.repeat(along, GRID, axis=0)
        found = sign * _values(quantity, together, around.ravel(), each)
        found = found.reshape(len(best), -1)
        at = np.argmax(found, axis=1)
        n, m = np.divmod(at, GRID)
        before, better = value, found[spots, at] > value
        value = np.where(better, found[spots, at], value)
        theta = np.where(better, around[spots, n], theta)
        place = np.where(better, along[spots, m], place)
        wide, long = SHRINK * wide, SHRINK * long
    limit = value + 2.0 * (value - before)
    told = zip(parts, *np.stack([sign * value, sign * limit, theta, place]).tolist(), strict=True)
    return [Extremum(v, l, EVIDENCE, t, part.wall, r) for part, v, l, t, r in told]
