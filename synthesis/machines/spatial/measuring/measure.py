"""Measuring a finished cam: the extremum of every quantity, on the wire, against its bound.

``enclosure`` proves what samples of contacts (``patches``) find where rollers are cylindrical.

A rib stands between two consecutive rollers. At a point of the wall that one of them envelops, the
rib is as thick as the least distance to the other roller over half a turn to either side. Where the
rollers' swept volumes overlap it is negative: the rib is cut through. The distance is to the roller
as a solid of revolution about its axis; it uses no formula of contacts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from operator import mul

import numpy as np

from synthesis.catalogue.limits.motion import EXACT, NAMES, TRAVEL
from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.machines.spatial.design import SpatialExtreme
from synthesis.machines.spatial.machine import LEFT, RIGHT, Seat
from synthesis.machines.spatial.measuring.enclosure import (
    Models,
    Prover,
    prove_convex_radius,
    prove_hollow_radius,
    prove_pressure_angle,
    prove_regular,
)
from synthesis.machines.spatial.measuring.patches import (
    Bound,
    Bounds,
    Extremum,
    Patch,
    Quantity,
    Sampling,
    WallPoints,
    find_extremum,
    patches,
    rounded,
)
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics import clock
from synthesis.numerics.geometry.swept_roller import cross, dot, norm, rotate
from synthesis.numerics.maxima import maximise
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.units import DEGREE, FULL_TURN, Travel

# The last steps are 6e-5 of those between samples.
CONTACTS = Sampling(
    49, 240, 2, 11, 8, 0.25, "measured on a grid of every smooth part of a wall, then closer"
)
RIBS = Sampling(
    25, 72, 3, 7, 13, 0.4,
    "measured from points of each wall to the next roller, at every cam angle, then closer",
)  # fmt: skip
PLACES, RIB_PLACES, RIB_TURNS = 5, 3, 73  # samples on the roller; of the other roller's cam angle
RIB = Quantity("rib_thickness", "mm", largest=False, required=Bound(0.0))
JUMP = 1e-9  # of a derivative's largest value: smaller jumps are rounding
STATIONARY = "stationary points of every piece"
SHORT = 1e-9  # rad: shorter intervals between ends of walls are rounding


def measure(spec: SpatialCamSpec, cam: SpatialCam) -> list[SpatialExtreme]:
    """Measure every quantity of a cam against what its spec allows.

    Raises:
        Cancelled: the caller has gone.
    """
    # The tightest bound of every limited quantity.
    bounds: dict[str, Bound] = {}
    for position, limit in enumerate(spec.limits):
        known = bounds.get(limit.quantity)
        if known is None or (limit.bound < known.value) is limit.upper:
            bounds[limit.quantity] = Bound(limit.bound, f"limits/{position}/{limit.field}")
    parts = list(patches(cam))

    def measured() -> Iterator[tuple[Quantity, Extremum]]:
        yield from contact_extrema(cam, parts, spec.omega, bounds)
        thinnest = thinnest_rib(cam, parts, spec.machine.seats())
        if thinnest is not None:
            yield RIB, thinnest
        for name, clearance in spec.machine.clearances(cam.sizes).items():
            positive = Quantity(name, "mm", largest=False, required=Bound(0.0))
            yield positive, Extremum(clearance, clearance, "closed form")
        yield from contact_counts(cam)
        yield from follower_peaks(cam, spec.machine.travel, spec.omega)
        yield from segment_bound_extremes(spec, cam)

    extremes = []
    for quantity, extremum in measured():
        extremes.append(to_wire(quantity, extremum, bounds))
        clock.now()  # raises Cancelled between two quantities
    return extremes


def to_wire(quantity: Quantity, extremum: Extremum, bounds: Bounds) -> SpatialExtreme:
    """An extremum on the wire, against its bound."""
    value, limit = quantity.to_wire(extremum.value), quantity.to_wire(extremum.limit)
    width = abs(limit - value) if math.isfinite(value) and math.isfinite(limit) else 0.0
    bound, margin = bounds.get(quantity.name, quantity.required), math.inf
    if bound is not None:  # the minimum of nothing is +∞ and keeps every bound, the maximum −∞
        margin = bound.value - value if quantity.largest else value - bound.value
    wall = extremum.wall
    return SpatialExtreme(
        quantity=quantity.name,
        value=value if math.isfinite(value) else None,
        unit=quantity.unit,
        angle_deg=None if extremum.theta is None else extremum.theta / DEGREE,
        roller=None if wall is None else wall.seat.number,
        side=None if wall is None else wall.letter,
        rho_mm=extremum.rho,
        bound=None if bound is None else bound.value,
        margin=margin if math.isfinite(margin) else None,
        width=width,
        holds=margin >= width,
        evidence=extremum.evidence,
        field="" if bound is None else bound.field,
    )


def follower_peaks(
    cam: SpatialCam, travel: Travel, omega: float
) -> Iterator[tuple[Quantity, Extremum]]:
    """Largest |velocity|, |acceleration| and |jerk| of the follower [units per rad^k]."""
    curve = cam.motion.curve
    for order, name in enumerate(NAMES[1:], start=1):
        unit, rate = travel.derivative_unit(order), travel.wire_factor(order, omega)
        quantity = Quantity(name, unit, True, partial(mul, rate))
        if order > 1 and (at := first_jump(curve, order - 1)) is not None:
            yield quantity, Extremum(np.inf, np.inf, f"{NAMES[order - 1]} jumps there", at)
            continue
        both = [maximise(curve, [0.0] * order + [sign]) for sign in (1.0, -1.0)]
        value, theta = max(both, key=lambda each: rounded(each[0]))
        yield quantity, Extremum(value, value, STATIONARY, theta)


def contact_counts(cam: SpatialCam) -> Iterator[tuple[Quantity, Extremum]]:
    """Fewest simultaneous contacts on either side of the rollers, and their mean number.

    A form-closed follower needs one contact on each side at every cam angle.
    """
    spans = [(wall.side, *span) for wall in cam.walls for span in wall.spans]
    marks = np.unique([0.0, FULL_TURN, *(end for _, *both in spans for end in both)])
    middles, wide = 0.5 * (marks[1:] + marks[:-1]), np.diff(marks)
    evidence = "counted between the angles where walls begin and end"
    total = np.zeros(len(middles))
    for name, side in (("contacts_left", LEFT), ("contacts_right", RIGHT)):
        met = [(middles > a) & (middles < b) for each, a, b in spans if each == side]
        count = np.sum([0.0 * wide, *met], axis=0)
        total += count
        least = int(np.argmin(np.where(wide > SHORT, count, np.inf)))
        value = float(count[least])
        quantity = Quantity(name, "1", largest=False, required=Bound(1.0))
        yield quantity, Extremum(value, value, evidence, float(middles[least]))
    mean = float((total * wide).sum() / FULL_TURN)
    yield Quantity("contacts_mean", "1", largest=False), Extremum(mean, mean, evidence)


def segment_bound_extremes(
    spec: SpatialCamSpec, cam: SpatialCam
) -> Iterator[tuple[Quantity, Extremum]]:
    """The extremes that windows and points of the program bound, each side if it is bounded."""
    travel = spec.machine.travel
    for placed, segment in zip(cam.motion.segments, spec.program, strict=True):
        for limit in segment.segment_bounds(placed.index):
            order, rate = limit.order, travel.wire_factor(limit.order, spec.omega)
            size = abs(placed.lift) / placed.angle**order * rate
            rounding = EXACT * size if limit.equality else 0.0
            # A travel is measured from the start of its segment, in the segment's direction.
            factor = -rate if order == TRAVEL and placed.lift < 0.0 else rate
            start = factor * placed.s_start if order == TRAVEL else 0.0
            low, high = (placed.start + x * placed.angle for x in limit.interval)
            curve = placed.placed()
            for bound, largest in ((limit.max, True), (limit.min, False)):
                if bound is None:
                    continue
                sign = 1.0 if largest == (factor > 0.0) else -1.0
                if low < high:
                    most, theta = maximise(curve.restrict(low, high), [0.0] * order + [sign])
                else:  # a point; a derivative may jump there
                    both = (curve(np.array([low]), order, side) for side in ("left", "right"))
                    most, theta = max(sign * float(each[0]) for each in both), low
                value, end = factor * sign * most - start, "max" if largest else "min"
                name = limit.name if limit.name.endswith(end) else f"{limit.name}_{end}"
                allowed = Bound(bound + (rounding if largest else -rounding), limit.field)
                yield (
                    Quantity(name, travel.derivative_unit(order), largest, required=allowed),
                    Extremum(value, value, STATIONARY, theta),
                )


@dataclass(frozen=True)
class ContactQuantity(Quantity):
    """A quantity ``of`` contacts, (n, m) values, and how its extremum is proven, if it is."""

    of: Callable[[WallPoints], Array] = field(kw_only=True)
    proof: Prover | None = None

    def extremum(self, walls: Sequence[WallPoints], how: Sampling) -> Extremum:
        """The extremum over all walls by samples."""
        sign = 1.0 if self.largest else -1.0

        def values(at: WallPoints) -> Array:
            """To be maximised; −∞ beyond the end faces."""
            return at.between_faces(sign * self.of(at), -np.inf)

        return find_extremum(values, walls, how, sign)


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
    "pressure_angle", "deg", True, lambda v: v / DEGREE, lambda v: v * DEGREE,
    of=lambda at: at.contacts.pressure_angle, proof=prove_pressure_angle,
)  # fmt: skip
UNDERCUT = ContactQuantity(
    "undercut", "1", False, required=Bound(0.0),
    of=lambda at: at.contacts.regular, proof=prove_regular,
)  # fmt: skip
# Measured as negated curvatures, which are finite where a wall is flat.
_RADIUS = partial(
    ContactQuantity, unit="mm", largest=False, to_wire=_radius, from_wire=lambda r: -1.0 / r
)
RADII = (
    _RADIUS("convex_radius", of=lambda at: -at.curvatures[0], proof=prove_convex_radius),
    _RADIUS("hollow_radius", of=lambda at: at.curvatures[1], proof=prove_hollow_radius),
)
CORNER = "the velocity jumps there: walls cross on one side and leave a gap on the other"
NO_RADIUS = Extremum(-np.inf, -np.inf, "a wall is undercut: there is no such radius")


def contact_extrema(
    cam: SpatialCam, parts: Sequence[Patch], omega: float, bounds: Bounds
) -> Iterator[tuple[Quantity, Extremum]]:
    """The extremum of every quantity of contacts over all patches; ω of the cam [rad/s]."""
    if not parts:
        return
    walls = list(CONTACTS.walls(parts, cam.swept.roller.places(PLACES)))
    # The proof is for ruled surfaces: the contacts of a crowned roller are not offsets of one.
    models = None if cam.swept.roller.crown > 0.0 else Models(cam, parts)

    def over(quantity: ContactQuantity) -> Extremum:
        bound = bounds.get(quantity.name, quantity.required)
        allowed = None if bound is None else quantity.from_wire(bound.value)
        sampled = quantity.extremum(walls, CONTACTS)
        if models is None or quantity.proof is None or not np.isfinite(sampled.value):
            return sampled
        return quantity.proof(models, sampled, allowed)

    yield PRESSURE_ANGLE, over(PRESSURE_ANGLE)
    corner = first_jump(cam.motion.curve, 1)
    area = over(UNDERCUT) if corner is None else Extremum(-np.inf, -np.inf, CORNER, corner)
    yield UNDERCUT, area
    for radius in RADII:
        yield radius, over(radius) if area.value > 0.0 else NO_RADIUS
    per_second, rpm = partial(mul, omega), partial(mul, omega * 60.0 / FULL_TURN)
    for name, unit, to_wire, of in (
        ("contact_speed", "mm/s", per_second, lambda at: norm(at.contacts.slip)),
        ("sliding_speed", "mm/s", per_second, _sliding),
        ("roller_speed", "rpm", rpm, _spin),
    ):
        speed = ContactQuantity(name, unit, True, to_wire, of=of)
        yield speed, over(speed)


def first_jump(curve: Piecewise, order: int) -> float | None:
    """The first cam angle where a derivative jumps, the end of the turn included [rad]."""
    ends, pieces = curve.breaks, np.arange(curve.count)
    after = curve.at(ends[:-1], pieces, order)
    before = np.roll(curve.at(ends[1:], pieces, order), 1)
    size = max(float(np.abs(after).max()), float(np.abs(before).max()))
    jumps = np.flatnonzero(np.abs(after - before) > JUMP * size)
    return float(ends[jumps[0]]) if len(jumps) else None


def thinnest_rib(cam: SpatialCam, parts: Sequence[Patch], seats: Sequence[Seat]) -> Extremum | None:
    """The least rib thickness; None where the cam has no ribs."""
    others = {wall: _behind(wall, seats, cam.period) for wall in cam.walls}
    bounded = [part for part in parts if others[part.wall] is not None]
    if not bounded:
        return None

    def thickness(points: WallPoints, offset: Array) -> Array:
        start = points.repeat([others[patch.wall] or 0.0 for patch in points.patches])
        return -_rib_thickness(points, start, offset)

    walls = RIBS.walls(bounded, cam.swept.roller.places(RIB_PLACES))
    offset = np.linspace(-0.5 * FULL_TURN, 0.5 * FULL_TURN, RIB_TURNS)
    return find_extremum(thickness, walls, RIBS, -1.0, offset)


def _behind(wall: Wall, seats: Sequence[Seat], period: float) -> float | None:
    """Position at q = 0 of the roller beyond the rib behind a wall; None where there is none."""
    ordered = sorted(seats, key=lambda seat: seat.start)
    step = -1 if wall.side == LEFT else 1
    periods, at = divmod(ordered.index(wall.seat) + step, len(ordered))
    if len(ordered) < 2 or (periods and np.isinf(period)):
        return None
    return ordered[at].start + (periods * period if periods else 0.0)


def _rib_thickness(wall: WallPoints, start: Array, offset: Array) -> Array:
    """Distance of a wall's points from rollers ``start`` (k n,) at q = 0: (j, k n, m) [mm].

    It is taken ``offset``, (j, 1) or (j, k n), later in the turn. Negative inside the roller;
    infinite where the wall is beyond the end faces.
    """
    cam, swept, points = wall.cam, wall.cam.swept, wall.points
    centre, shape = swept.centre.reshape(3, 1, 1), (len(offset), *points.shape[1:])
    turned = np.broadcast_to(offset, shape[:2]).ravel()
    # The wall's points as the cam carries them on, seen along the other roller's axis.
    away = np.broadcast_to((points - centre)[:, None], (3, *shape)).reshape(3, -1, shape[2])
    moved = rotate(away, swept.hand * turned, swept.axis) + centre
    theta = np.tile(wall.theta.ravel(), shape[0]) + turned
    q = np.tile(start, shape[0]) + cam.motion.derivatives(theta, 0)[0]
    q = q + cam.gain * np.floor(theta / FULL_TURN)
    u = swept.joint.turn_direction(swept.along.reshape(3, 1, 1), q)
    foot = moved - swept.joint.move_points(swept.origin.reshape(3, 1, 1), q)
    roller, along = swept.roller, dot(u, foot)
    within = np.clip(along, roller.inner, roller.outer)
    beyond = np.abs(along - within)
    over = norm(foot - along * u) - roller.profile(within)[0]
    distance = np.where(beyond > 0.0, np.hypot(beyond, np.maximum(over, 0.0)), over)
    return wall.between_faces(distance.reshape(shape), np.inf)
