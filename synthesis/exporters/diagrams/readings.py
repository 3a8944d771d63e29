"""What a diagram shows: a quantity over the turn, its limits, and where they are broken."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.limits import Claim
from synthesis.catalogue.motion import PlacedSegment
from synthesis.design.design import Design
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.samples.sampling import in_degrees, motion_rows
from synthesis.exporters.samples.turn import Turn
from synthesis.numerics.piecewise import Array

Ends = tuple[float | None, float | None]  # lower and upper
EXACT = 1e-9  # a limit that is reached is not broken


@dataclass(frozen=True)
class Quantity:
    """What a diagram shows: the ``order``-th time derivative of s, and its name for limits."""

    order: int
    name: str
    title: str
    symbol: str


QUANTITIES = (
    Quantity(0, "displacement", "Displacement", "s"),
    Quantity(1, "velocity", "Velocity", "v"),
    Quantity(2, "acceleration", "Acceleration", "a"),
    Quantity(3, "jerk", "Jerk", "j"),
)


@dataclass(frozen=True)
class Bound:
    """A limit on part of the turn [deg], in the diagram's unit; ±∞ where there is none."""

    start: float
    end: float
    lower: float
    upper: float


@dataclass(frozen=True, eq=False)
class Trace:
    """The quantity over the turn.

    Attributes:
        degrees, side: (n,) where, as in ``Rows``. values: (n,) in its unit.
    """

    degrees: Array
    side: NDArray[np.int64]
    values: Array

    def followed_by(self, other: Trace) -> Trace:
        """This trace and then the other."""
        return Trace(
            np.append(self.degrees, other.degrees),
            np.append(self.side, other.side),
            np.append(self.values, other.values),
        )


def trace(turn: Turn, quantity: Quantity, options: MotionOptions) -> Trace:
    """The quantity as a table samples it."""
    rows = motion_rows(turn, options.count)
    values = turn.derivatives(rows.theta, rows.left)[quantity.order]
    return Trace(rows.degrees, rows.side, values * turn.rate(quantity.order))


def impulses(turn: Turn, quantity: Quantity) -> Trace:
    """Where a lower derivative jumps: there the value is infinite, with the jump's sign."""
    theta = turn.joints.breaking(quantity.order - 1)
    order = turn.joints.order[turn.joints.order < quantity.order]
    left = turn.motion.derivatives(theta, 3, "left")
    right = turn.motion.derivatives(theta, 3, "right")
    jump = (right - left)[order, np.arange(len(theta))]
    return Trace(in_degrees(theta), np.zeros(len(theta), dtype=np.int64), np.inf * np.sign(jump))


def bounds(design: Design, quantity: Quantity) -> list[Bound]:
    """What the spec's limits claim of this quantity; neighbours with one bound are joined."""
    return claimed(design, lambda claim: claim.quantity == quantity.name, _on_wire)


def claimed(
    design: Design, wanted: Callable[[Claim], bool], ends: Callable[[Claim], Ends]
) -> list[Bound]:
    """The bounds of those claims that are wanted, with the ends that are made of each."""
    segments, machine = design.resolved_spec.placed_segments(), design.completed_spec.machine()
    found: list[Bound] = []
    for limit in design.completed_spec.all_limits():
        for claim in filter(wanted, limit.claims(segments, machine)):
            for index in claim.segments:
                _join(found, _bound(claim, segments[index], ends(claim)))
    return found


def _on_wire(claim: Claim) -> Ends:
    lower = None if claim.lower is None else claim.to_wire(claim.lower)
    upper = None if claim.upper is None else claim.to_wire(claim.upper)
    return lower, upper


def _bound(claim: Claim, segment: PlacedSegment, between: Ends) -> Bound:
    lower, upper = between
    ends = segment.start + segment.angle * np.array(claim.interval or (0.0, 1.0))
    start, end = in_degrees(ends).tolist()
    return Bound(
        start, end, -math.inf if lower is None else lower, math.inf if upper is None else upper
    )


def _join(found: list[Bound], bound: Bound) -> None:
    """Add a bound, as one with the last if it continues that."""
    if found and replace(found[-1], start=found[-1].end, end=bound.end) == bound:
        bound = replace(bound, start=found.pop().start)
    found.append(bound)


def exceeds(trace: Trace, bound: Bound) -> NDArray[np.bool_]:
    """Rows in which a bound is broken; at its ends only the limits from inside count."""
    angle, side = trace.degrees, trace.side
    inside = ((angle > bound.start) | ((angle == bound.start) & (side >= 0))) & (
        (angle < bound.end) | ((angle == bound.end) & (side <= 0))
    )
    over = trace.values > bound.upper + EXACT * abs(bound.upper)
    under = trace.values < bound.lower - EXACT * abs(bound.lower)
    return np.asarray(inside & (over | under))
