"""What every cam must satisfy besides the limits of its spec.

Of the motion: continuity, the states required at segment ends, tables, no overshoot. Of the
follower: a positive base radius, and a cam that drives it outwards. Of the size: its ranges.

Each check returns lines of the certificate. Rounding allows a share of 1e-9 of the lift throughout.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from math import comb, floor
from typing import Final

import numpy as np

from synthesis.catalogue.fields import ends
from synthesis.catalogue.followers import Follower
from synthesis.catalogue.followers.base import paths, prime_radius
from synthesis.catalogue.followers.kinematics import TracePoint, labelled
from synthesis.catalogue.hub import HUB_RULE, shaft_of_hub
from synthesis.catalogue.limits.base import Machine
from synthesis.certify.piecewise_motion import HIGHEST_ORDER, JUNCTION_TOLERANCE, PiecewiseMotion
from synthesis.certify.quantities import MeasuredCam, Size, TracedPoint, pressure_angle
from synthesis.design.design import Extreme
from synthesis.numerics.box_search import Boxes, BoxSearch, Budget
from synthesis.numerics.piecewise import Array, Indices, Mask
from synthesis.spec.design_spec import DesignSpec
from synthesis.units import DEGREE

DERIVATIVES: Final = ("displacement", "velocity", "acceleration", "jerk", "snap")
REPORTED_ORDER: Final = 2  # jumps of derivatives up to this one are reported even if allowed

BACKWARD_TOLERANCE: Final = 1e-9  # backward travel that counts as none, as a share of the lift
FINE_WIDTH: Final = 1e-2  # width of its enclosure that suffices, as a share of that tolerance
PARTS: Final = 8  # of an interval whose enclosure is too wide
BACKWARD_BUDGET: Final = Budget(levels=8, boxes=50_000)
COEFFICIENT_ROUNDING: Final = 2.0**-46  # relative to a Bernstein coefficient's terms: 128 roundings


def check_motion(
    motion: PiecewiseMotion, machine: Machine, continuity: int | None = None
) -> list[Extreme]:
    """All checks that do not depend on the spec's limits.

    ``continuity``: order up to which all derivatives must be continuous; None: not required.
    """
    return [
        *_continuity(motion, machine, continuity),
        *_end_states(motion, machine),
        *_tables(motion, machine),
        *_overshoot(motion, machine),
    ]


def _deviation(
    limit: str,
    machine: Machine,
    order: int,
    value: float,
    allowed: float,
    angle: float,
    field: str,
    evidence: str,
    width: float = 0.0,  # of its enclosure; without one it is known to rounding
) -> Extreme:
    """The line of a deviation of s^(order), against what is allowed."""
    value, bound, width = (each * machine.wire_factor(order) for each in (value, allowed, width))
    finite = math.isfinite(value)
    return Extreme(
        limit=limit, value=value if finite else None, unit=machine.derivative_unit(order),
        angle_deg=angle / DEGREE, bound=bound, margin=bound - value if finite else None,
        width=width, holds=bound - value >= width, evidence=evidence, field=field,
    )  # fmt: skip


def _continuity(
    motion: PiecewiseMotion, machine: Machine, continuity: int | None
) -> Iterator[Extreme]:
    """Continuity of s everywhere, and of its derivatives where it is required or promised.

    For each order: the worst of the junctions where continuity is required, with a verdict; then
    the largest jump among the others, reported only.
    """
    smooth = np.maximum(_promised_orders(motion), continuity or 0)
    for order in range(min(max(REPORTED_ORDER, int(smooth.max())), HIGHEST_ORDER) + 1):
        promised = (smooth >= order).nonzero()[0]
        if len(promised):
            required = continuity is not None and order <= continuity
            jump = motion.largest_jump(order, promised)
            yield _deviation(
                f"{DERIVATIVES[order]}_join", machine, order, abs(jump.size), jump.allowed,
                jump.angle, "continuity" if required else "program",
                f"one-sided values at {len(promised)} junctions; bound: 1e-9 of lift/β^{order} "
                "plus rounding error",
            )  # fmt: skip
        if order <= REPORTED_ORDER and len(promised) < len(smooth):
            others = motion.discontinuities(order, (smooth < order).nonzero()[0])
            if len(others):
                # a jump that the chosen laws bring with them: reported without a verdict
                jump = motion.largest_jump(order, others)
                yield Extreme(
                    limit=f"{DERIVATIVES[order]}_jump",
                    value=abs(jump.size) * machine.wire_factor(order),
                    unit=machine.derivative_unit(order), angle_deg=jump.angle / DEGREE, bound=None,
                    margin=None, width=0.0, holds=True, field="program",
                    evidence="one-sided values at the junction; the laws on either side do not "
                    "promise continuity there",
                )  # fmt: skip


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


def _end_states(motion: PiecewiseMotion, machine: Machine) -> Iterator[Extreme]:
    """The largest deviation from a velocity, and from an acceleration, required at segment ends."""
    for order in (1, 2):
        # for every required s^(order): deviation, allowed deviation, cam angle, field of the spec
        misses = list[tuple[float, float, float, str]]()
        for segment in (segment for segment in motion.segments if segment.angle > 0.0):
            pieces = motion.pieces_of([segment.index])
            for end, state, side, angle in (
                ("start", segment.start_state, 1, segment.start),
                ("end", segment.end_state, 0, segment.end),
            ):
                wanted = state.known[order - 1]
                if wanted is None:
                    continue
                junction = int(pieces[side - 1]) - side  # before the first piece, after the last
                value = motion.one_sided_values(junction % motion.curve.count)[side][order]
                scale = max(abs(segment.scale) / segment.angle**order, abs(wanted))
                field = f"program/{segment.index}/{end}"
                misses.append((abs(value - wanted), JUNCTION_TOLERANCE * scale, angle, field))
        if misses:
            miss, allowed, angle, field = max(misses, key=lambda each: each[0] / each[1])
            yield _deviation(
                f"{DERIVATIVES[order]}_required", machine, order, miss, allowed, angle, field,
                f"one-sided values at {len(misses)} ends of segments; bound: 1e-9 of "
                f"lift/β^{order}",
            )  # fmt: skip


def _tables(motion: PiecewiseMotion, machine: Machine) -> Iterator[Extreme]:
    """Largest deviation of the motion from the rows of each table that a segment follows."""
    for segment in motion.segments:
        if segment.table is None:
            continue
        theta = segment.start + segment.angle * segment.table.x
        deviation = np.abs(motion.curve(theta) - segment.table.s)
        worst = int(np.argmax(deviation))
        yield _deviation(
            "table_deviation", machine, 0, float(deviation[worst]), segment.table.tolerance,
            float(theta[worst]), f"program/{segment.index}/{segment.table.field}",
            f"all {len(deviation)} rows of the table; the largest deviation is at row {worst}",
        )  # fmt: skip


def _overshoot(motion: PiecewiseMotion, machine: Machine) -> Iterator[Extreme]:
    """Backward travel on segments whose spline law must not overshoot; the worst of them."""
    monotone = [
        s.index for s in motion.segments if s.free is not None and not s.free.overshoot
    ]  # fmt: skip
    if not monotone:
        return
    least, most, count = backward_travel(motion, motion.pieces_of(monotone))
    bounds = [BACKWARD_TOLERANCE * abs(s.lift) for s in motion.segments]
    # in whole multiples of the bound, so that rounding does not decide which one is named
    worst = max(monotone, key=lambda i: floor(most[i] / bounds[i]))
    yield _deviation(
        "overshoot", machine, 0, float(least[worst]), bounds[worst], motion.segments[worst].start,
        f"program/{worst}/law/overshoot",
        f"velocity enclosed on {count} pieces and intervals; bound: 1e-9 of the lift",
        float(most[worst] - least[worst]),
    )  # fmt: skip


def backward_travel(motion: PiecewiseMotion, pieces: Indices) -> tuple[Array, Array, int]:
    """Enclose ∫ max(−v, 0) dθ over each segment, v the velocity in the segment's own sense [mm].

    The ``pieces`` are of spline laws: polynomials, without sinusoids.

    Returns:
        lower and upper ends, one per segment of the motion, and the number of intervals examined.
    """
    search, breaks = _BackwardTravel(motion), motion.curve.breaks
    whole = np.ones(motion.curve.count, dtype=np.intp)
    boxes = Boxes.from_spans(pieces, breaks[pieces], breaks[pieces + 1], whole)
    search.run(boxes, BACKWARD_BUDGET)
    return search.least, search.most, search.intervals


class _BackwardTravel(BoxSearch[Boxes]):
    """Box search that adds up the travel on intervals whose enclosure is narrow enough.

    On an interval of length h the velocity is a polynomial v = Σ b_k B_k in Bernstein's basis,
    whose members are nonnegative and all have the integral h/(n + 1). So

        max(−h · mean(b), 0)  ≤  ∫ max(−v, 0) dθ  ≤  h · mean(max(−b, 0)),

    and both ends agree where all b_k have one sign. The bound of an interval is the width of its
    enclosure less its share of the width that suffices for its segment.
    """

    children = PARTS

    def __init__(self, motion: PiecewiseMotion) -> None:
        self.motion, self.intervals = motion, 0
        lifts = np.array([segment.lift for segment in motion.segments])
        self.forward, self.fine = np.sign(lifts), FINE_WIDTH * BACKWARD_TOLERANCE * np.abs(lifts)
        self.least, self.most = np.zeros((2, len(lifts)))

    def bound(self, boxes: Boxes) -> Array:
        h, owner = boxes.hi - boxes.lo, self.motion.segment_of_piece[boxes.piece]
        # 1. v in powers of x = (θ − lo)/h, from Taylor's series at the interval's left end
        derivatives, errors = self.motion.jets.derivatives(boxes.piece, boxes.lo)
        count = max(self.motion.curve.poly.shape[1] - 1, 1)
        factors = np.cumprod([np.ones_like(h), *(h / k for k in range(1, count))], axis=0)
        terms, rounding = derivatives[1 : count + 1] * factors, errors[1 : count + 1] * factors
        # 2. in Bernstein's basis
        whole = range(count)
        to_bernstein = [[comb(k, j) / comb(count - 1, j) for j in whole] for k in whole]
        back = -self.forward[owner] * (np.array(to_bernstein) @ terms)
        blur = rounding.sum(axis=0) + COEFFICIENT_ROUNDING * np.abs(terms).sum(axis=0)
        # 3. both ends of the travel
        low = np.maximum(h * (back.mean(axis=0) - blur), 0.0)
        high = h * np.maximum(back + blur, 0.0).mean(axis=0)
        self.intervals, self.ends = self.intervals + len(h), (owner, low, high)
        share = self.fine / np.maximum(np.bincount(owner, minlength=len(self.fine)), 1)
        return np.asarray(high - low - share[owner])

    def threshold(self) -> float:
        return 0.0

    def leave(self, upper: Array, which: Mask) -> None:
        """Add up the travel of intervals that are not looked at again."""
        owner, low, high = (each[which] for each in self.ends)
        self.least += np.bincount(owner, low, len(self.least))
        self.most += np.bincount(owner, high, len(self.most))

    def split(self, boxes: Boxes, keep: Mask) -> Boxes:
        return boxes.take(np.flatnonzero(keep)).split(PARTS)


# Rounding error of a dimension computed from the size variables: a share of the prime radius, of
# 180° for an angle, of the dimension itself for one that follows from another part.
DIMENSION_ROUNDING: Final = 1e-12


def check_follower(cam: MeasuredCam) -> list[Extreme]:
    """A positive base radius, and a follower that the cam drives outwards from the prime circle.

    The pressure angle at rest on the prime circle must be below 90°. For a translating follower
    this means that its offset is less than the prime radius, with the roller above the axis; for
    one on an arm, that the arm is not in line with the centres.
    """
    follower, size, stroke = cam.machine.follower, cam.size, cam.motion.stroke
    base = follower.dimensions(size)["base_radius_mm"]
    return [
        Extreme(
            limit="base_radius_positive", value=base, unit="mm", angle_deg=0.0, bound=0.0,
            margin=base, width=0.0, holds=base > 0.0, evidence="computed from the size",
            field="base_radius_mm",
        ),
        *(
            _prime_circle_angle(labelled("prime_circle_angle", path), trace, size, stroke)
            for path, trace in paths(follower).items()
        ),
    ]  # fmt: skip


def _prime_circle_angle(limit: str, trace: TracePoint, size: Size, stroke: float) -> Extreme:
    """The pressure angle at rest where the traced curve is nearest to the axis."""
    at_rest = (trace.nearest_displacement(stroke), 0.0, 0.0, 0.0)
    alpha = abs(float(pressure_angle(TracedPoint(trace, size, at_rest)))) / DEGREE
    return Extreme(
        limit=limit, value=alpha, unit="deg", angle_deg=0.0, bound=90.0,
        margin=90.0 - alpha, width=0.0, holds=alpha < 90.0,
        evidence="pressure angle at rest on the prime circle: below 90° the cam drives the "
        "follower outwards", field="follower",
    )  # fmt: skip


def certify_size(
    spec: DesignSpec, size: tuple[float, ...], final_follower: Follower | None = None
) -> list[Extreme]:
    """Every dimension that the spec names, against its range.

    ``final_follower``: with values chosen after the size; None: the spec's own.
    """
    dimensions = (final_follower or spec.follower).dimensions(size)
    scales = {"mm": prime_radius(spec.follower, size), "deg": 180.0}
    # 1. what is limited: name, range, field of the spec, size to which rounding is relative
    wanted = [
        (name, ends(getattr(owner, name)), prefix + name, scales[name.rpartition("_")[2]])
        for name in dimensions
        for owner, prefix in ((spec, ""), (spec.follower, "follower/"))
        if name in type(owner).model_fields
    ]
    for field, (name, limits) in spec.follower.closure.counter_dimensions().items():
        wanted.append((name, ends(limits), f"follower/{field}", dimensions[name]))
    # 2. the nearer end of each range; no line if both ends are open
    found = []
    for name, (low, high), field, scale in wanted:
        value, rounding = dimensions[name], DIMENSION_ROUNDING * scale
        limit, _, unit = name.rpartition("_")
        margin, bound = min((value - low, low), (high - value, high))
        if not math.isinf(bound):
            found.append(Extreme(
                limit=limit, value=value, unit=unit, angle_deg=0.0, bound=bound,
                margin=margin, width=0.0, holds=margin >= -rounding,
                evidence=f"computed from the size; allowance for rounding {rounding:.3g} {unit}",
                field=field,
            ))  # fmt: skip
    return [*found, *_hub(spec, dimensions["base_radius_mm"], scales["mm"])]


def _hub(spec: DesignSpec, base_radius: float, scale: float) -> Iterator[Extreme]:
    """Room for the hub within the base circle, in terms of what is given: shaft or hub."""
    if spec.hub is None:
        return
    given = spec.hub_diameter_mm
    name, bound = ("hub", given) if given is not None else ("shaft", spec.shaft_diameter_mm)
    assert bound is not None
    value = 2.0 * base_radius if given is not None else shaft_of_hub(2.0 * base_radius)
    by = "" if given is not None else (
        f"; its hub is {spec.hub:.6g} mm across, {HUB_RULE} (cast iron; Cam "
        "Design Handbook, Rothbart, ed., eq. 6.21)"
    )  # fmt: skip
    rounding = 2.0 * DIMENSION_ROUNDING * scale
    yield Extreme(
        limit=f"room_for_{name}", value=value, unit="mm", angle_deg=0.0, bound=bound,
        margin=value - bound, width=0.0, holds=value - bound >= -rounding,
        evidence=f"largest that the base circle has room for{by}; allowance for rounding "
        f"{rounding:.3g} mm",
        field=f"{name}_diameter_mm",
    )  # fmt: skip
