"""What every motion must satisfy: continuity, end states, tables, and no overshoot where promised.

Each check returns lines of the certificate. Rounding allows a share of 1e-9 of the lift throughout.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from math import comb, floor
from typing import Final

import numpy as np

from synthesis.catalogue.limits.base import Machine
from synthesis.certify.piecewise_motion import (
    HIGHEST_ORDER,
    JUNCTION_TOLERANCE,
    Indices,
    Intervals,
    Jump,
    PiecewiseMotion,
)
from synthesis.design.design import Extreme
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

DERIVATIVES: Final = ("displacement", "velocity", "acceleration", "jerk", "snap")
REPORTED_ORDER: Final = 2  # jumps of derivatives up to this one are reported even if allowed

BACKWARD_TOLERANCE: Final = 1e-9  # backward travel that counts as none, as a share of the lift
FINE_WIDTH: Final = 1e-2  # width of its enclosure that suffices, as a share of that tolerance
DISTINCT: Final = 1000  # two segments are equally bad if they differ by less than 1/1000 of it
FIRST_PARTS: Final = 2  # intervals into which a piece is first divided
NEXT_PARTS: Final = 8  # parts of an interval in each later round
MAX_ROUNDS: Final = 7
MAX_INTERVALS: Final = 50_000
COEFFICIENT_ROUNDING: Final = 2.0**-46  # relative to a Bernstein coefficient's terms: 128 roundings
LENGTH_ROUNDING: Final = 1e-12  # relative: a few roundings of speed times length


def check_motion(
    motion: PiecewiseMotion, machine: Machine, continuity: int | None = None
) -> list[Extreme]:
    """All checks that do not depend on the spec's limits.

    Args:
        motion: the finished motion. machine: gives the cam speed and the units.
        continuity: order up to which all derivatives must be continuous; None: not required.
    """
    return [
        *_continuity(motion, machine, continuity),
        *_end_states(motion, machine),
        *_tables(motion, machine),
        *_overshoot(motion, machine),
    ]


# -- continuity ------------------------------------------------------------------------------


def _continuity(
    motion: PiecewiseMotion, machine: Machine, continuity: int | None
) -> Iterator[Extreme]:
    """Continuity of s everywhere, and of its derivatives where it is required or promised.

    For each order: the worst of the junctions where continuity is required (judged), then the
    largest jump among the others (reported only).
    """
    smooth = np.maximum(_promised_orders(motion), continuity or 0)
    for order in range(min(max(REPORTED_ORDER, int(smooth.max())), HIGHEST_ORDER) + 1):
        promised = (smooth >= order).nonzero()[0]
        if len(promised):
            required = continuity is not None and order <= continuity
            jump = motion.largest_jump(order, promised)
            yield _junction(machine, jump, len(promised), required=required)
        if order <= REPORTED_ORDER and len(promised) < len(smooth):
            others = motion.discontinuities(order, (smooth < order).nonzero()[0])
            if len(others):
                yield _allowed_jump(machine, motion.largest_jump(order, others))


def _promised_orders(motion: PiecewiseMotion) -> Array:
    """Order up to which the derivatives are continuous at each junction by the laws' promise (n,).

    Inside a spline law it is the law's class. Between two laws it is what the rougher promises at
    its end; a law with a fixed formula promises nothing.
    """
    free = [segment.free for segment in motion.segments]
    inner = np.array([math.inf if law is None else law.smoothness for law in free])
    start, end = (
        np.array([math.inf if law is None else law.continuity_at(at_start=first) for law in free])
        for first in (True, False)
    )
    here, there = motion.segment_of_piece, motion.segment_of_piece[motion.next_piece]
    # the last junction lies between two ends even if one segment makes up the whole turn
    inside = (here == there) & (motion.next_piece > 0)
    found = np.where(inside, inner[here], np.minimum(end[here], start[there]))
    return np.where(np.isinf(found), 0.0, found)


def _junction(machine: Machine, jump: Jump, count: int, *, required: bool) -> Extreme:
    """The worst of the junctions where continuity is promised or required."""
    to_wire = machine.wire_factor(jump.order)
    value, bound = abs(jump.size) * to_wire, jump.allowed * to_wire
    finite = math.isfinite(value)
    return Extreme(
        limit=f"{DERIVATIVES[jump.order]}_join", value=value if finite else None,
        unit=machine.derivative_unit(jump.order), angle_deg=jump.angle / DEGREE, bound=bound,
        margin=bound - value if finite else None, width=0.0, holds=value <= bound,
        evidence=f"one-sided values at {count} junctions; bound: 1e-9 of lift/β^{jump.order} "
        "plus rounding error",
        field="continuity" if required else "program",
    )  # fmt: skip


def _allowed_jump(machine: Machine, jump: Jump) -> Extreme:
    """A jump that the chosen laws bring with them: reported, not judged."""
    return Extreme(
        limit=f"{DERIVATIVES[jump.order]}_jump",
        value=abs(jump.size) * machine.wire_factor(jump.order),
        unit=machine.derivative_unit(jump.order), angle_deg=jump.angle / DEGREE, bound=None,
        margin=None, width=0.0, holds=True,
        evidence="one-sided values at the junction; the laws on either side do not promise "
        "continuity there",
        field="program",
    )  # fmt: skip


# -- end states ------------------------------------------------------------------------------


def _end_states(motion: PiecewiseMotion, machine: Machine) -> Iterator[Extreme]:
    """The required velocity, and the required acceleration, that is missed most at segment ends."""
    for order in (1, 2):
        misses = list(_end_state_misses(motion, order))
        if misses:
            miss, allowed, angle, field = max(misses, key=lambda each: each[0] / each[1])
            to_wire = machine.wire_factor(order)
            value, bound = miss * to_wire, allowed * to_wire
            yield Extreme(
                limit=f"{DERIVATIVES[order]}_asked", value=value,
                unit=machine.derivative_unit(order), angle_deg=angle / DEGREE, bound=bound,
                margin=bound - value, width=0.0, holds=value <= bound,
                evidence=f"one-sided values at {len(misses)} ends of segments; bound: 1e-9 of "
                f"lift/β^{order}",
                field=field,
            )  # fmt: skip


def _end_state_misses(
    motion: PiecewiseMotion, order: int
) -> Iterator[tuple[float, float, float, str]]:
    """For every required s^(order): deviation, allowed deviation, cam angle, field of the spec."""
    for segment in motion.segments:
        required = segment.start_state.known[order - 1], segment.end_state.known[order - 1]
        if segment.angle <= 0.0 or required == (None, None):
            continue
        pieces = motion.pieces_of([segment.index])
        for end, wanted, junction, angle in (
            ("start", required[0], int(pieces[0]) - 1, segment.start),
            ("end", required[1], int(pieces[-1]), segment.end),
        ):
            if wanted is None:
                continue
            before, after = motion.one_sided_values(junction % motion.curve.count)
            value = after[order] if end == "start" else before[order]
            allowed = JUNCTION_TOLERANCE * max(
                abs(segment.scale) / segment.angle**order, abs(wanted)
            )
            yield abs(value - wanted), allowed, angle, f"program/{segment.index}/{end}"


# -- tables ----------------------------------------------------------------------------------


def _tables(motion: PiecewiseMotion, machine: Machine) -> Iterator[Extreme]:
    """Largest deviation of the motion from the rows of each table that a segment follows."""
    for segment in motion.segments:
        if segment.table is None:
            continue
        theta = segment.start + segment.angle * segment.table.x
        deviation = np.abs(motion.curve(theta) - segment.table.s)
        worst, to_wire = int(np.argmax(deviation)), machine.wire_factor(0)
        value, bound = float(deviation[worst]) * to_wire, segment.table.tolerance * to_wire
        yield Extreme(
            limit="table_deviation", value=value, unit=machine.derivative_unit(0),
            angle_deg=theta[worst] / DEGREE, bound=bound, margin=bound - value, width=0.0,
            holds=value <= bound,
            evidence=f"all {len(deviation)} rows of the table; the largest deviation is at row "
            f"{worst}",
            field=f"program/{segment.index}/{segment.table.field}",
        )  # fmt: skip


# -- overshoot -------------------------------------------------------------------------------


def _overshoot(motion: PiecewiseMotion, machine: Machine) -> Iterator[Extreme]:
    """Backward travel on segments whose spline law must not overshoot; the worst of them."""
    monotone = [
        s.index
        for s in motion.segments
        if s.free is not None and not s.free.overshoot and s.angle > 0.0
    ]
    if not monotone:
        return
    least, most, count = backward_travel(motion, motion.pieces_of(monotone))
    bounds = [BACKWARD_TOLERANCE * abs(s.lift) for s in motion.segments]
    # counted in coarse steps of the bound, so that rounding does not decide which one is named
    worst = max(monotone, key=lambda i: floor(DISTINCT * most[i] / bounds[i]))
    value, bound, width = (
        float(length) * machine.wire_factor(0)
        for length in (least[worst], bounds[worst], most[worst] - least[worst])
    )
    margin = bound - value
    yield Extreme(
        limit="overshoot", value=value, unit=machine.derivative_unit(0),
        angle_deg=motion.segments[worst].start / DEGREE, bound=bound, margin=margin,
        width=width, holds=margin >= width, field=f"program/{worst}/law/overshoot",
        evidence=f"velocity enclosed on {count} pieces and intervals; bound: 1e-9 of the lift",
    )  # fmt: skip


def backward_travel(motion: PiecewiseMotion, pieces: Indices) -> tuple[Array, Array, int]:
    """Enclose ∫ max(−v, 0) dθ over each segment, v the velocity in the segment's own sense [mm].

    Returns:
        lower and upper ends, one per segment of the motion (0 where no piece is asked about), and
        the number of pieces and intervals examined.
    """
    segments = motion.segments
    least, most = np.zeros(len(segments)), np.zeros(len(segments))
    fine = FINE_WIDTH * BACKWARD_TOLERANCE * np.abs([s.lift for s in segments])
    breaks, count, owner = motion.curve.breaks, len(pieces), motion.segment_of_piece[pieces]
    # 1. Bernstein enclosure of whole pieces: enough where the velocity clearly has one sign
    whole = backward_travel_bound(motion, pieces)
    coarse = ~(whole <= fine[owner] / np.bincount(owner)[owner])
    most += np.bincount(owner[~coarse], whole[~coarse], len(segments))
    if not coarse.any():
        return least, most, count
    # 2. Subdivision with Taylor models: intervals whose enclosure is narrow enough for their share
    # of the segment are added up, the others are divided, until the limits on effort are reached
    intervals = Intervals(pieces, breaks[pieces], breaks[pieces + 1]).take(coarse)
    intervals = intervals.split(FIRST_PARTS)
    for round_ in range(MAX_ROUNDS):
        low, high = _backward_travel_on(motion, intervals)
        count += len(low)
        owner = motion.segment_of_piece[intervals.piece]
        crowd = np.bincount(owner, minlength=len(segments))[owner]
        coarse = high - low > fine[owner] / crowd
        last = round_ == MAX_ROUNDS - 1
        if last or count + NEXT_PARTS * np.count_nonzero(coarse) > MAX_INTERVALS:
            coarse[:] = False
        least += np.bincount(owner[~coarse], low[~coarse], len(segments))
        most += np.bincount(owner[~coarse], high[~coarse], len(segments))
        if not coarse.any():
            break
        intervals = intervals.take(coarse).split(NEXT_PARTS)
    return least, most, count


def backward_travel_bound(motion: PiecewiseMotion, pieces: Indices) -> Array:
    """Upper bound of the backward travel on whole pieces; ∞ where a piece is no plain polynomial.

    A polynomial on [0, 1] is nowhere above its largest Bernstein coefficient, so the travel is at
    most that of −v times the piece's length.
    """
    curve = motion.curve
    start, poly = curve.breaks[pieces], curve.poly[pieces, 1:].T
    if curve.waves[pieces, :, 0].any() or not np.array_equal(curve.origins[pieces], start):
        return np.full(len(pieces), np.inf)
    length, power = curve.breaks[pieces + 1] - start, np.arange(len(poly))[:, None]
    terms = poly * (power + 1.0) * length**power  # of v in powers of (θ − start) / length
    back = -_forward(motion, pieces) * (_to_bernstein(len(poly)) @ terms)
    speed: Array = back.max(axis=0) + COEFFICIENT_ROUNDING * np.abs(terms).sum(axis=0)
    return (1.0 + LENGTH_ROUNDING) * length * np.maximum(speed, 0.0)


@cache
def _to_bernstein(count: int) -> Array:
    """Matrix (count, count) from coefficients of powers to those of Bernstein polynomials."""
    degree = count - 1
    return np.array(
        [[comb(k, j) / comb(degree, j) for j in range(count)] for k in range(count)], dtype=float
    )


def _forward(motion: PiecewiseMotion, pieces: Indices) -> Array:
    """Sign of the lift of each piece's segment."""
    lifts = np.array([segment.lift for segment in motion.segments])
    return np.asarray(np.sign(lifts)[motion.segment_of_piece[pieces]])


def _backward_travel_on(motion: PiecewiseMotion, intervals: Intervals) -> tuple[Array, Array]:
    """Lower and upper end of the backward travel on each interval, from Taylor models of s and v.

    It is at least the net loss of displacement, and at most the largest backward velocity times
    the length.
    """
    s, v = motion.jets.models(intervals.piece, intervals.lo, intervals.hi, 1)
    forward = _forward(motion, intervals.piece)
    high, low, *_ = v.extremes()
    back = np.where(forward > 0.0, -low, high) + v.rem
    length = (intervals.hi - intervals.lo) * (1.0 + LENGTH_ROUNDING)
    most = length * np.maximum(back, 0.0)
    # s = c0 + c1 t + c2 t² ± rem on t in [−1, 1]: the ends differ by 2 c1, to within 2 rem
    least = np.maximum(-2.0 * forward * s.c1 - 2.0 * s.rem, 0.0)
    return np.minimum(least, most), most
