"""What one diagram over the cam angle shows, and the numbers at its axis."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from synthesis.exporters.diagrams.readings import Bound, Trace
from synthesis.exporters.drawing import canvas as svg
from synthesis.numerics.piecewise import Array

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
CROWDED = 0.085  # of an axis: what lies between two numbers at least
FEW = 3  # numbers at an axis, less is too few
ROUNDING = 1e-12
ROUND = (1.0, 2.0, 5.0, 3.0)


@dataclass(frozen=True)
class Labels:
    """How values are told.

    Attributes:
        ticks: values at the axis and their numbers. factor: stands before the unit.
        told: a value as a number.
    """

    ticks: Sequence[tuple[float, str]]
    factor: str
    told: Callable[[float], str]


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

    def told(bend: float) -> str:
        if bend == 0.0:
            return "∞"
        radius = 1.0 / bend - distance
        return svg.figure(0.0 if abs(radius) < ROUNDING * distance else radius)

    def labelled(low: float, high: float) -> Labels:
        wanted = [0.0, *([1.0 / distance] if distance > 0.0 else [])]
        size = max(abs(low), abs(high))
        powers = range(math.floor(-math.log10(size)) - 1, math.ceil(-math.log10(size)) + 4)
        sizes = [k * 10.0**power for k in ROUND for power in powers]
        wanted += [1.0 / (sign * r + distance) for r in sizes for sign in (1.0, -1.0)
                   if abs(sign * r + distance) > 1e-9 * r]  # fmt: skip
        taken: list[float] = []
        for bend in wanted:
            apart = min((abs(bend - other) for other in taken), default=math.inf)
            if low <= bend <= high and apart >= CROWDED * (high - low):
                taken.append(bend)
        if len(taken) < FEW:  # all radii lie close to −D: far beyond a cusp
            taken = svg.ticks(low, high, 4)
        return Labels([(bend, told(bend)) for bend in taken], "", told)

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
    bad: Sequence[float] = field(default=())


NOWHERE = Trace(np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros(0))


def curve_plot(title: str, unit: str, degrees: Array, values: Array) -> Plot:
    """A diagram of one quantity over the turn, (n,) each, without jumps and limits."""
    trace = Trace(degrees, np.zeros(len(degrees), dtype=np.int64), values)
    return Plot(title, unit, trace, trace, NOWHERE)
