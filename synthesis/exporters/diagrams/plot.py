"""One diagram over the cam angle: curve, limits of the spec, and the numbers at its axis."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.limits import Claim
from synthesis.design.design import Design
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.samples.sampling import in_degrees
from synthesis.numerics.piecewise import Array

EXACT = 1e-9  # relative: a limit that is reached is not broken
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
CROWDED = 0.085  # of an axis: what lies between two numbers at least
FEW = 3  # numbers at an axis, less is too few
ROUNDING = 1e-12
ROUND = (1.0, 2.0, 5.0, 3.0)


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

    @classmethod
    def infinite(cls, degrees: Array, sign: Array) -> Trace:
        """Infinite values with these signs (n,)."""
        side = np.zeros(len(degrees), dtype=np.int64)
        return cls(degrees, side, np.inf * np.sign(sign))

    def followed_by(self, other: Trace) -> Trace:
        """This trace and then the other."""
        return Trace(
            np.append(self.degrees, other.degrees),
            np.append(self.side, other.side),
            np.append(self.values, other.values),
        )


def claimed_bounds(
    design: Design,
    select: Callable[[Claim], bool],
    convert: Callable[[Claim, float], float | None] = lambda claim, value: claim.to_wire(value),
) -> list[Bound]:
    """The bounds of those claims of the spec's limits that are selected.

    ``convert``: a monotone map of a claim's values to the diagram's; bounds change places where it
    falls. Neighbours with the same bounds are joined.
    """
    segments, machine = design.resolved_spec.placed_segments(), design.completed_spec.machine()
    bounds: list[Bound] = []
    for limit in design.completed_spec.all_limits():
        for claim in filter(select, limit.claims(segments, machine)):
            ends = [
                None if end is None else convert(claim, end) for end in (claim.lower, claim.upper)
            ]
            if (convert(claim, 1.0) or 0.0) < (convert(claim, -1.0) or 0.0):
                ends.reverse()
            low, high = ends
            low, high = -math.inf if low is None else low, math.inf if high is None else high
            for segment in (segments[index] for index in claim.segments):
                part = segment.start + segment.angle * np.array(claim.interval or (0.0, 1.0))
                start, end = in_degrees(part).tolist()
                bound = Bound(start, end, low, high)
                last = bounds[-1] if bounds else None
                if last and replace(last, start=last.end, end=bound.end) == bound:
                    bound = replace(bound, start=bounds.pop().start)
                bounds.append(bound)
    return bounds


def exceeds(trace: Trace, bound: Bound) -> NDArray[np.bool_]:
    """Rows in which a bound is broken; at its ends only the limits from inside count."""
    angle, side = trace.degrees, trace.side
    inside = ((angle > bound.start) | ((angle == bound.start) & (side >= 0))) & (
        (angle < bound.end) | ((angle == bound.end) & (side <= 0))
    )
    over = trace.values > bound.upper + EXACT * abs(bound.upper)
    under = trace.values < bound.lower - EXACT * abs(bound.lower)
    return np.asarray(inside & (over | under))


@dataclass(frozen=True)
class Labels:
    """How values are written.

    Attributes:
        ticks: values at the axis and their numbers. factor: stands before the unit.
        format: a value as a number.
    """

    ticks: Sequence[tuple[float, str]]
    factor: str
    format: Callable[[float], str]


def linear(low: float, high: float) -> Labels:
    """Round numbers, a power of ten taken out where they are large or small."""
    size = math.floor(math.log10(max(abs(low), abs(high))))
    exponent = 0 if -2 <= size <= 3 else 3 * (size // 3)
    unit = 10.0**exponent
    factor = f"10{str(exponent).translate(SUPERSCRIPTS)} " if exponent else ""
    ticks = [(value, svg.figure(value / unit, 6)) for value in svg.ticks(low, high, 6)]
    return Labels(ticks, factor, lambda value: svg.figure(value / unit))


def radii(distance: float) -> Callable[[float, float], Labels]:
    """The radius of a curve at a distance from the one whose curvature is the ordinate [1/mm].

    A radius runs over ±∞ where a curve is straight and a curvature does not, so the axis is even in
    curvature and has radii for numbers: ρ = 1/κ − D, negative where the material is hollow, 0 at a
    cusp and negative again where it is undercut.
    """

    def radius(curvature: float) -> str:
        if curvature == 0.0:
            return "∞"
        value = 1.0 / curvature - distance
        return svg.figure(0.0 if abs(value) < ROUNDING * distance else value)

    def labelled(low: float, high: float) -> Labels:
        candidates = [0.0, *([1.0 / distance] if distance > 0.0 else [])]
        size = max(abs(low), abs(high))
        powers = range(math.floor(-math.log10(size)) - 1, math.ceil(-math.log10(size)) + 4)
        sizes = [k * 10.0**power for k in ROUND for power in powers]
        candidates += [1.0 / (sign * r + distance) for r in sizes for sign in (1.0, -1.0)
                   if abs(sign * r + distance) > 1e-9 * r]  # fmt: skip
        taken: list[float] = []
        for value in candidates:
            distant = min((abs(value - other) for other in taken), default=math.inf)
            if low <= value <= high and distant >= CROWDED * (high - low):
                taken.append(value)
        if len(taken) < FEW:  # all radii lie close to −D: far beyond a cusp
            taken = svg.ticks(low, high, 4)
        return Labels([(value, radius(value)) for value in taken], "", radius)

    return labelled


@dataclass(frozen=True, eq=False)
class Plot:
    """One diagram.

    Attributes:
        title: name and symbol. unit: of the numbers.
        curve: as it is drawn. fine: as its extremes are read. infinite: where it is that.
        limits: what it may not exceed. ends: words for its largest (True) and smallest value.
        labels: the numbers, for the values at the lower and the upper edge.
        bad: values, from and to, that no cam has; () where all are possible.
    """

    title: str
    unit: str
    curve: Trace
    fine: Trace
    infinite: Trace
    limits: Sequence[Bound] = ()
    ends: Sequence[tuple[str, bool]] = (("max", True), ("min", False))
    labels: Callable[[float, float], Labels] = linear
    bad: Sequence[float] = ()


NOWHERE = Trace(np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros(0))


def curve_plot(title: str, unit: str, degrees: Array, values: Array) -> Plot:
    """A diagram of one quantity over the turn, (n,) each, without jumps and limits."""
    trace = Trace(degrees, np.zeros(len(degrees), dtype=np.int64), values)
    return Plot(title, unit, trace, trace, NOWHERE)
