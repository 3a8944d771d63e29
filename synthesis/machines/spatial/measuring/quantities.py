"""Quantities, their extrema and bounds; the extrema of the motion, and contacts that hold it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from operator import mul

import numpy as np

from synthesis.catalogue.limits.motion import EXACT, TRAVEL, SegmentBound
from synthesis.catalogue.motion import PlacedSegment
from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.machines.spatial.design import SpatialExtreme
from synthesis.machines.spatial.machine import LEFT, RIGHT
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics.maxima import maximise
from synthesis.numerics.piecewise import Piecewise
from synthesis.units import DEGREE, FULL_TURN, Travel

NAMES = ("velocity", "acceleration", "jerk")
STATIONARY = "stationary points of every piece"
JUMP = 1e-9  # of a derivative's largest value: smaller jumps are rounding
SHORT = 1e-9  # rad: shorter intervals between ends of walls are rounding


@dataclass(frozen=True)
class Bound:
    """An allowed value.

    Attributes:
        value: in the quantity's unit on the wire. field: of the spec, that sets it; "": none.
    """

    value: float
    field: str = ""


Bounds = Mapping[str, Bound]


@dataclass(frozen=True)
class Quantity:
    """A quantity and which of its extremes is measured.

    Attributes:
        name, unit: on the wire. largest: whether its maximum is measured, otherwise its minimum.
        to_wire: from the core's value to the wire's. from_wire: the inverse.
        required: bound that every cam must keep, whatever the spec says.
    """

    name: str
    unit: str
    largest: bool
    to_wire: Callable[[float], float] = float
    from_wire: Callable[[float], float] = float
    required: Bound | None = None


@dataclass(frozen=True)
class Extremum:
    """An extreme value [core units].

    Attributes:
        value: infinite where there is none.
        limit: the true extreme does not lie beyond it, as far as the evidence goes.
        evidence: how that is known.
        theta: where [rad]. wall, rho: on which wall, and where on the roller's axis [mm]; None: the
            quantity does not belong to a wall.
    """

    value: float
    limit: float
    evidence: str
    theta: float | None = None
    wall: Wall | None = None
    rho: float | None = None


def rounded(value: float) -> float:
    """A value to twelve digits: of two that differ by rounding only, the first one is chosen."""
    return float(f"{value:.11e}")


def to_wire(quantity: Quantity, extremum: Extremum, bounds: Bounds) -> SpatialExtreme:
    """An extremum on the wire, against its bound."""
    value, limit = quantity.to_wire(extremum.value), quantity.to_wire(extremum.limit)
    finite = math.isfinite(value)
    width = abs(limit - value) if finite and math.isfinite(limit) else 0.0
    bound = bounds.get(quantity.name, quantity.required)
    margin = None
    if bound is not None and finite:
        margin = bound.value - value if quantity.largest else value - bound.value
    if bound is None:
        holds = True
    elif margin is None:  # the minimum of nothing is +∞ and keeps every bound, the maximum −∞
        holds = value == (-math.inf if quantity.largest else math.inf)
    else:
        holds = margin >= width
    wall = extremum.wall
    return SpatialExtreme(
        quantity=quantity.name,
        value=value if finite else None,
        unit=quantity.unit,
        angle_deg=None if extremum.theta is None else extremum.theta / DEGREE,
        roller=None if wall is None else wall.seat.number,
        side=None if wall is None else wall.letter,
        rho_mm=extremum.rho,
        bound=None if bound is None else bound.value,
        margin=margin,
        width=width,
        holds=holds,
        evidence=extremum.evidence,
        field="" if bound is None else bound.field,
    )


def follower_peaks(
    cam: SpatialCam, travel: Travel, omega: float
) -> Iterator[tuple[Quantity, Extremum]]:
    """Largest |velocity|, |acceleration| and |jerk| of the follower [units per rad^k]."""
    curve = cam.motion.curve
    for order, name in enumerate(NAMES, start=1):
        unit, rate = travel.derivative_unit(order), travel.wire_factor(order, omega)
        quantity = Quantity(name, unit, True, partial(mul, rate))
        if order > 1 and (at := first_jump(curve, order - 1)) is not None:
            yield quantity, Extremum(np.inf, np.inf, f"{NAMES[order - 2]} jumps there", at)
            continue
        both = [maximise(curve, [0.0] * order + [sign]) for sign in (1.0, -1.0)]
        value, theta = max(both, key=lambda each: rounded(each[0]))
        yield quantity, Extremum(value, value, STATIONARY, theta)


def first_jump(curve: Piecewise, order: int) -> float | None:
    """The first cam angle where a derivative jumps, the end of the turn included [rad]."""
    ends, pieces = curve.breaks, np.arange(curve.count)
    after = curve.at(ends[:-1], pieces, order)
    before = np.roll(curve.at(ends[1:], pieces, order), 1)
    size = max(float(np.abs(after).max()), float(np.abs(before).max()))
    jumps = np.flatnonzero(np.abs(after - before) > JUMP * size)
    return float(ends[jumps[0]]) if len(jumps) else None


def contact_counts(cam: SpatialCam) -> Iterator[tuple[Quantity, Extremum]]:
    """Fewest simultaneous contacts on either side of the rollers, and their mean number.

    A form-closed follower needs one contact on each side at every cam angle.
    """
    marks = np.unique([0.0, FULL_TURN, *(t for w in cam.walls for span in w.spans for t in span)])
    middles = 0.5 * (marks[1:] + marks[:-1])
    wide = np.diff(marks)
    counted = wide > SHORT
    counts = {
        side: sum(
            ((middles > a) & (middles < b)).astype(int)
            for wall in cam.walls if wall.side == side for a, b in wall.spans
        ) + np.zeros(len(middles), dtype=int)
        for side in (LEFT, RIGHT)
    }  # fmt: skip
    evidence = "counted between the angles where walls begin and end"
    for name, side in (("contacts_left", LEFT), ("contacts_right", RIGHT)):
        least = int(np.argmin(np.where(counted, counts[side], 1 << 30)))
        value = float(counts[side][least])
        quantity = Quantity(name, "1", largest=False, required=Bound(1.0))
        yield quantity, Extremum(value, value, evidence, float(middles[least]))
    mean = float(((counts[LEFT] + counts[RIGHT]) * wide).sum() / FULL_TURN)
    yield Quantity("contacts_mean", "1", largest=False), Extremum(mean, mean, evidence)


def segment_bound_extremes(
    spec: SpatialCamSpec, cam: SpatialCam
) -> Iterator[tuple[Quantity, Extremum]]:
    """The extremes that windows and points of the program bound, each side if it is bounded."""
    travel = spec.machine.travel
    for placed, segment in zip(cam.motion.segments, spec.program, strict=True):
        for limit in segment.segment_bounds(placed.index):
            rate = travel.wire_factor(limit.order, spec.omega)
            unit = travel.derivative_unit(limit.order)
            size = abs(placed.lift) / placed.angle**limit.order * rate
            rounding = EXACT * size if limit.equality else 0.0
            for bound, largest in ((limit.max, True), (limit.min, False)):
                if bound is None:
                    continue
                end = "max" if largest else "min"
                name = limit.name if limit.name.endswith(end) else f"{limit.name}_{end}"
                allowed = Bound(bound + (rounding if largest else -rounding), limit.field)
                value, theta = _extreme(limit, placed, rate, largest)
                yield (
                    Quantity(name, unit, largest, required=allowed),
                    Extremum(value, value, STATIONARY, theta),
                )


def _extreme(
    limit: SegmentBound, segment: PlacedSegment, rate: float, largest: bool
) -> tuple[float, float]:
    """The extreme on the wire, and where [rad].

    A travel is measured from the start of its segment, in the segment's direction.
    """
    order = limit.order
    back = order == TRAVEL and segment.lift < 0.0
    factor = -rate if back else rate
    start = factor * segment.s_start if order == TRAVEL else 0.0
    low, high = (segment.start + x * segment.angle for x in limit.interval)
    curve = segment.placed()
    sign = 1.0 if largest == (factor > 0.0) else -1.0
    if low == high:
        at = np.array([low])
        both = [float(curve(at, order, side)[0]) for side in ("left", "right")]
        value = max(both, key=lambda each: sign * each)
        return factor * value - start, low
    most, theta = maximise(curve.restrict(low, high), [0.0] * order + [sign])
    return factor * sign * most - start, theta
