"""Extrema over all contacts of all walls, and the thinnest rib between two of them.

Every quantity is sampled on each patch and refined around the best samples (``patches``).
``enclosure`` proves pressure angle, undercut and radii where rollers are cylindrical.

A rib stands between two consecutive rollers. At a point of the wall that one of them envelops, the
rib is as thick as the least distance to the other roller over half a turn either way. Where the
rollers' swept volumes overlap it is negative: the rib is cut through. The distance is to the roller
as a solid of revolution about its axis; it uses no formula of contacts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import mul

import numpy as np

from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.machines.spatial.machine import LEFT, Seat
from synthesis.machines.spatial.measuring.enclosure import (
    Models,
    Prover,
    prove_convex_radius,
    prove_hollow_radius,
    prove_pressure_angle,
    prove_regular,
)
from synthesis.machines.spatial.measuring.patches import (
    Patch,
    Refinement,
    Sample,
    WallPoints,
    best_samples,
    refine,
    sample_walls,
)
from synthesis.machines.spatial.measuring.quantities import (
    Bound,
    Bounds,
    Extremum,
    Quantity,
    first_jump,
)
from synthesis.numerics.geometry.swept_roller import cross, dot, norm, rotate
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

ANGLES, PLACES = 49, 5  # samples of a patch: cam angles, places
WHOLE = 240  # about so many angles on a wall with many patches
# The last steps are 6e-5 of those between samples.
CLOSER = Refinement(
    2, 11, 8, 0.25, "measured on a grid of every smooth part of a wall, then closer"
)

RIB_ANGLES, RIB_PLACES, RIB_TURNS = 25, 3, 73  # samples; turns: angles of the other roller
RIB_WHOLE = 72  # as WHOLE
RIB_CLOSER = Refinement(
    3, 7, 13, 0.4,
    "measured from points of each wall to the next roller, at every cam angle, then closer",
)  # fmt: skip
RIB = Quantity("rib_thickness", "mm", largest=False, required=Bound(0.0))


@dataclass(frozen=True)
class ContactQuantity:
    """A quantity of contacts.

    Attributes:
        kind: what is measured. of: its values at n angles by m places, (n, m).
        proof: how its extremum is proven; None: it is measured only.
    """

    kind: Quantity
    of: Callable[[WallPoints], Array]
    proof: Prover | None = None


def _sliding(at: WallPoints) -> Array:
    """Sliding per radian, the roller turning so that its middle does not slide across [mm]."""
    swept = at.cam.swept
    middle = np.full((*at.rho.shape[:-1], 1), swept.roller.middle)
    both = replace(at, rho=np.concatenate([at.rho, middle], axis=-1))
    slip, across = both.contacts.slip, _across(both)
    across = across / norm(across)
    spin = dot(across, slip)[:, -1:] / swept.roller.radius
    return norm(slip - spin * swept.roller.profile(both.rho)[0] * across)[:, :-1]


def _spin(at: WallPoints) -> Array:
    """Speed at which the roller turns then, relative to the cam's."""
    roller = at.cam.swept.roller
    middle = replace(at, rho=np.array([roller.middle]))
    across = _across(middle)
    rate = np.abs(dot(across, middle.contacts.slip)) / norm(across) / roller.radius
    return rate + 0.0 * at.rho


def _across(at: WallPoints) -> Array:
    """Directions (3, n, m) across the roller's axis and the wall's normal."""
    swept = at.cam.swept
    u = swept.joint.turn_direction(swept.along.reshape(3, 1, 1), at.state.q)
    return cross(u, at.contacts.normal)


def _radius(curvature: float) -> float:
    """Radius of a negated curvature; infinite where the curvature has the other sign."""
    if np.isinf(curvature):
        return curvature
    return -1.0 / curvature if curvature < 0.0 else np.inf


PRESSURE_ANGLE = ContactQuantity(
    Quantity("pressure_angle", "deg", True, lambda v: v / DEGREE, lambda v: v * DEGREE),
    lambda at: at.contacts.pressure_angle,
    prove_pressure_angle,
)
UNDERCUT = ContactQuantity(
    Quantity("undercut", "1", False, required=Bound(0.0)),
    lambda at: at.contacts.regular,
    prove_regular,
)
# Measured as negated curvatures, which are finite where a wall is flat.
RADII = (
    ContactQuantity(
        Quantity("convex_radius", "mm", False, _radius, lambda radius: -1.0 / radius),
        lambda at: -at.curvatures[0],
        prove_convex_radius,
    ),
    ContactQuantity(
        Quantity("hollow_radius", "mm", False, _radius, lambda radius: -1.0 / radius),
        lambda at: at.curvatures[1],
        prove_hollow_radius,
    ),
)
CORNER = "the velocity jumps there: walls cross on one side and leave a gap on the other"
NO_RADIUS = Extremum(-np.inf, -np.inf, "a wall is undercut: there is no such radius")


def _speeds(omega: float) -> Sequence[ContactQuantity]:
    """Speeds of a cam that turns at ω [rad/s]."""
    per_second, rpm = partial(mul, omega), partial(mul, omega * 60.0 / (2.0 * np.pi))
    return (
        ContactQuantity(
            Quantity("contact_speed", "mm/s", True, per_second), lambda at: norm(at.contacts.slip)
        ),
        ContactQuantity(Quantity("sliding_speed", "mm/s", True, per_second), _sliding),
        ContactQuantity(Quantity("roller_speed", "rpm", True, rpm), _spin),
    )


def contact_extrema(
    cam: SpatialCam, parts: Sequence[Patch], omega: float, bounds: Bounds
) -> Iterator[tuple[Quantity, Extremum]]:
    """The extremum of every quantity of contacts over all patches."""
    if not parts:
        return
    rho = np.linspace(cam.swept.roller.inner, cam.swept.roller.outer, PLACES)
    walls = list(sample_walls(parts, rho, ANGLES, WHOLE))
    # The proof is for ruled surfaces: the contacts of a crowned roller are not offsets of one.
    models = None if cam.swept.roller.crown > 0.0 else Models(cam, parts)

    def over(quantity: ContactQuantity) -> Extremum:
        bound = bounds.get(quantity.kind.name, quantity.kind.required)
        allowed = None if bound is None else quantity.kind.from_wire(bound.value)
        sampled = _extremum(quantity, walls, rho)
        if models is None or quantity.proof is None or not np.isfinite(sampled.value):
            return sampled
        return quantity.proof(models, sampled, allowed)

    yield PRESSURE_ANGLE.kind, over(PRESSURE_ANGLE)
    corner = first_jump(cam.motion.curve, 1)
    area = over(UNDERCUT) if corner is None else Extremum(-np.inf, -np.inf, CORNER, corner)
    yield UNDERCUT.kind, area
    for radius in RADII:
        yield radius.kind, over(radius) if area.value > 0.0 else NO_RADIUS
    for speed in _speeds(omega):
        yield speed.kind, over(speed)


def _extremum(quantity: ContactQuantity, walls: Sequence[WallPoints], rho: Array) -> Extremum:
    """The extremum over all patches, sampled wall by wall."""
    sign = 1.0 if quantity.kind.largest else -1.0

    def values(at: WallPoints) -> Array:
        """To be maximised; −∞ beyond the end faces."""
        return at.between_faces(sign * quantity.of(at), -np.inf)

    def on_grids(parts: Sequence[Patch], at: Array) -> Array:
        return values(WallPoints(parts, at[:, 0], np.repeat(at[:, 1], at.shape[2], axis=0)))

    samples = (sample for wall in walls for sample in best_samples(wall, values(wall)))
    return refine(on_grids, samples, rho, CLOSER, sign)


def thinnest_rib(cam: SpatialCam, parts: Sequence[Patch], seats: Sequence[Seat]) -> Extremum | None:
    """The least rib thickness; None where the cam has no ribs."""
    rho = np.linspace(cam.swept.roller.inner, cam.swept.roller.outer, RIB_PLACES)
    offset = np.linspace(-0.5 * FULL_TURN, 0.5 * FULL_TURN, RIB_TURNS)
    others = {wall: _behind(wall, seats, cam.period) for wall in cam.walls}
    samples: list[Sample] = []
    for wall in sample_walls(parts, rho, RIB_ANGLES, RIB_WHOLE):
        other = others[wall.patches[0].wall]
        if other is not None:
            samples += best_samples(wall, -_rib_thickness(wall, other, offset), offset)

    def on_grids(parts: Sequence[Patch], at: Array) -> Array:
        return np.stack(
            [
                -_rib_thickness(part.at(theta, rho), other, offset)
                for part, (offset, theta, rho) in zip(parts, at, strict=True)
                if (other := others[part.wall]) is not None
            ]
        )

    return refine(on_grids, samples, rho, RIB_CLOSER, -1.0) if samples else None


def _behind(wall: Wall, seats: Sequence[Seat], period: float) -> Seat | None:
    """The roller on the other side of the rib behind a wall; None where no roller bounds it."""
    ordered = sorted(seats, key=lambda seat: seat.start)
    step = -1 if wall.side == LEFT else 1
    periods, at = divmod(ordered.index(wall.seat) + step, len(ordered))
    if len(ordered) < 2 or (periods and np.isinf(period)):
        return None
    lag = periods * period if periods else 0.0
    return replace(ordered[at], start=ordered[at].start + lag)


def _rib_thickness(wall: WallPoints, other: Seat, offset: Array) -> Array:
    """Distance of a wall's points from another roller, ``offset`` (k,) later: (k, n, m) [mm].

    Negative inside the roller; infinite where the wall is beyond the end faces.
    """
    cam, swept, points = wall.cam, wall.cam.swept, wall.points
    centre = swept.centre.reshape(3, 1, 1)
    # The wall's points as the cam carries them on, seen along the other roller's axis.
    away = points.reshape(3, 1, -1) - centre
    moved = rotate(away, swept.hand * offset, swept.axis) + centre
    theta = (np.repeat(wall.theta.ravel(), points.shape[2]) + offset[:, None]).ravel()
    turns = np.floor(theta / FULL_TURN)
    q = other.start + cam.motion.derivatives(theta, 0)[0] + cam.gain * turns
    u = swept.joint.turn_direction(swept.along.reshape(3, 1, 1), q)
    foot = moved.reshape(3, -1, 1) - swept.joint.move_points(swept.origin.reshape(3, 1, 1), q)
    roller, along = swept.roller, dot(u, foot)
    within = np.clip(along, roller.inner, roller.outer)
    beyond = np.abs(along - within)
    over = norm(foot - along * u) - roller.profile(within)[0]
    distance = np.where(beyond > 0.0, np.hypot(beyond, np.maximum(over, 0.0)), over)
    return wall.between_faces(distance.reshape(-1, *points.shape[1:]), np.inf)
