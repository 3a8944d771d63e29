"""The follower's motion: peaks in time, windows and points, contacts that hold it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from synthesis.catalogue.limits.segment_bound import EXACT, TRAVEL, SegmentBound
from synthesis.catalogue.motion import PlacedSegment
from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.machine import LEFT, RIGHT
from synthesis.machines.spatial.measuring.extremum import Bound, Extremum, Quantity, rounded
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics.maxima import maximise
from synthesis.numerics.piecewise import Piecewise
from synthesis.units import FULL_TURN, Travel

NAMES = ("velocity", "acceleration", "jerk")
STATIONARY = "stationary points of every piece"
JUMP = 1e-9  # of a derivative's largest value: smaller jumps are rounding
SHORT = 1e-9  # rad: shorter intervals between ends of walls are rounding


def follower_peaks(
    cam: SpatialCam, travel: Travel, omega: float
) -> Iterator[tuple[Quantity, Extremum]]:
    """Largest |velocity|, |acceleration| and |jerk| of the follower [units per rad^k]."""
    curve = cam.motion.curve
    for order, name in enumerate(NAMES, start=1):
        quantity = Quantity(
            name, travel.derivative_unit(order), True, _multiply(travel.wire_factor(order, omega))
        )
        if order > 1 and (at := first_jump(curve, order - 1)) is not None:
            yield quantity, Extremum(np.inf, np.inf, f"{NAMES[order - 2]} jumps there", at)
            continue
        both = [maximise(curve, [0.0] * order + [sign]) for sign in (1.0, -1.0)]
        value, theta = max(both, key=lambda each: rounded(each[0]))
        yield quantity, Extremum(value, value, STATIONARY, theta)


def _multiply(rate: float) -> Callable[[float], float]:
    return lambda value: value * rate


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


def demand_extremes(spec: SpatialCamSpec, cam: SpatialCam) -> Iterator[tuple[Quantity, Extremum]]:
    """The extremes that windows and points of the program bound."""
    for placed, segment in zip(cam.motion.segments, spec.program, strict=True):
        for demand in segment.segment_bounds(placed.index):
            yield from _bounded_sides(demand, placed, spec)


def _bounded_sides(
    demand: SegmentBound, segment: PlacedSegment, spec: SpatialCamSpec
) -> Iterator[tuple[Quantity, Extremum]]:
    """The largest and the least value over a window or at a point, each if it is bounded."""
    travel = spec.machine.travel
    rate = travel.wire_factor(demand.order, spec.omega)
    size = abs(segment.lift) / segment.angle**demand.order * rate
    rounding = EXACT * size if demand.equality else 0.0
    for bound, largest in ((demand.max, True), (demand.min, False)):
        if bound is None:
            continue
        end = "max" if largest else "min"
        name = demand.name if demand.name.endswith(end) else f"{demand.name}_{end}"
        required = Bound(bound + (rounding if largest else -rounding), demand.field)
        unit = travel.derivative_unit(demand.order)
        value, theta = _extreme(demand, segment, rate, largest)
        yield (
            Quantity(name, unit, largest, required=required),
            Extremum(value, value, STATIONARY, theta),
        )


def _extreme(
    demand: SegmentBound, segment: PlacedSegment, rate: float, largest: bool
) -> tuple[float, float]:
    """The extreme on the wire, and where [rad].

    A travel is measured from the start of its segment, in the segment's direction.
    """
    order = demand.order
    back = order == TRAVEL and segment.lift < 0.0
    factor = -rate if back else rate
    start = factor * segment.s_start if order == TRAVEL else 0.0
    low, high = (segment.start + x * segment.angle for x in demand.interval)
    curve = segment.placed()
    sign = 1.0 if largest == (factor > 0.0) else -1.0
    if low == high:
        at = np.array([low])
        both = [float(curve(at, order, side)[0]) for side in ("left", "right")]
        value = max(both, key=lambda each: sign * each)
        return factor * value - start, low
    most, theta = maximise(curve.restrict(low, high), [0.0] * order + [sign])
    return factor * sign * most - start, theta
