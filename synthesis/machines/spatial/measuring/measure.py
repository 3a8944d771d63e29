"""Measuring a finished cam: the extremum of every quantity, on the wire, against its bound."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from operator import mul

import numpy as np

from synthesis.catalogue.limits.motion import EXACT, NAMES, TRAVEL
from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.design import SpatialExtreme
from synthesis.machines.spatial.machine import LEFT, RIGHT
from synthesis.machines.spatial.measuring.patches import (
    Bound,
    Bounds,
    Extremum,
    Quantity,
    patches,
    rounded,
)
from synthesis.machines.spatial.measuring.walls import (
    RIB,
    contact_extrema,
    first_jump,
    thinnest_rib,
)
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics import clock
from synthesis.numerics.maxima import maximise
from synthesis.units import DEGREE, FULL_TURN, Travel

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
