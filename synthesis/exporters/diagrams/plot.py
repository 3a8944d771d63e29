"""One diagram over the cam angle: curve, limits of the spec, axes; and how it is drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

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
ROUNDING = 1e-12  # relative: a radius smaller than this is a cusp's, 0
ROUND = (1.0, 2.0, 5.0, 3.0)  # first digits of radii at an axis, the preferred ones first


@dataclass(frozen=True)
class Bound:
    """A limit on part of the turn [deg], in the diagram's unit; ±∞ where there is none."""

    start: float
    end: float
    lower: float
    upper: float


@dataclass(frozen=True, eq=False)
class Trace:
    """The quantity over the turn: its values (n,), and where, as in ``Rows``."""

    degrees: Array
    side: NDArray[np.int64]
    values: Array

    @classmethod
    def infinite(cls, degrees: Array, sign: Array) -> Trace:
        """Infinite values with these signs (n,)."""
        return cls.smooth(degrees, np.inf * np.sign(sign))

    @classmethod
    def smooth(cls, degrees: Array, values: Array) -> Trace:
        """Values without jumps."""
        return cls(degrees, np.zeros(len(degrees), dtype=np.int64), values)

    def followed_by(self, other: Trace) -> Trace:
        """This trace and then the other."""
        return Trace(*map(np.append, vars(self).values(), vars(other).values()))

    def over(self, turns: int, advance: float = 0.0) -> Trace:
        """So many turns one after another; ``advance``: how much larger values are in the next."""
        number = np.repeat(np.arange(turns), len(self.degrees))
        degrees, side, values = (np.tile(each, turns) for each in vars(self).values())
        return Trace(degrees + FULL * number, side, values + advance * number)


FULL = 360.0  # degrees in a turn
NOWHERE = Trace.smooth(np.zeros(0), np.zeros(0))


def claimed_bounds(
    design: Design,
    select: Callable[[Claim], bool],
    convert: Callable[[Claim, float], float] = lambda claim, value: claim.to_wire(value) or 0.0,
) -> list[Bound]:
    """The bounds of those claims of the spec's limits that are selected.

    ``convert``: a monotone map of a claim's values to the diagram's; bounds change places where it
    falls. Neighbours with the same bounds are joined.
    """
    segments, machine = design.resolved_spec.placed_segments(), design.completed_spec.machine()
    bounds: list[Bound] = []
    for limit in design.completed_spec.all_limits():
        for claim in filter(select, limit.claims(segments, machine)):
            falls = convert(claim, 1.0) < convert(claim, -1.0)
            lower, upper = (claim.upper, claim.lower) if falls else (claim.lower, claim.upper)
            low = -math.inf if lower is None else convert(claim, lower)
            high = math.inf if upper is None else convert(claim, upper)
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
    """How values are written: those at the axis, any other, and a factor before the unit."""

    ticks: Sequence[tuple[float, str]]
    factor: str
    format: Callable[[float], str]


def linear(low: float, high: float, most: int = 6) -> Labels:
    """Round numbers, ``most`` + 1 or fewer; a power of ten taken out where large or small."""
    size = math.floor(math.log10(max(abs(low), abs(high))))
    exponent = 0 if -2 <= size <= 3 else 3 * (size // 3)
    unit = 10.0**exponent
    factor = f"10{str(exponent).translate(SUPERSCRIPTS)} " if exponent else ""
    ticks = [(value, svg.figure(value / unit, 6)) for value in svg.ticks(low, high, most)]
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
    infinite: Trace = NOWHERE
    limits: Sequence[Bound] = ()
    ends: Sequence[tuple[str, bool]] = (("max", True), ("min", False))
    labels: Callable[[float, float], Labels] = linear
    bad: Sequence[float] = ()


def curve_plot(title: str, unit: str, degrees: Array, values: Array) -> Plot:
    """A diagram of one quantity over the turn, (n,) each, without jumps and limits."""
    trace = Trace.smooth(degrees, values)
    return Plot(title, unit, trace, trace)


def over_turns(plot: Plot, turns: int, advance: float = 0.0) -> Plot:
    """A turn's diagram over so many; ``advance``: of the quantity from turn to turn."""
    if turns == 1:
        return plot
    return replace(
        plot,
        curve=plot.curve.over(turns, advance),
        fine=plot.fine.over(turns, advance),
        infinite=plot.infinite.over(turns),
        limits=[
            replace(each, start=each.start + FULL * k, end=each.end + FULL * k)
            for k in range(turns)
            for each in plot.limits
        ],
    )


Numbers = TypeVar("Numbers", float, Array)
PLATEAU = 1e-13  # values that differ by less are one plateau
FAR = 1.6  # a limit further out than this many times the peak is written, not drawn
HATCH = 1.1  # [mm] between the lines that fill what exceeds a limit
LEGIBLE = 4.0  # [mm], height of a strip in which a word fits


@dataclass(frozen=True)
class Frame:
    """Where a diagram lies on the sheet [mm], and the values at its four edges."""

    left: float
    top: float
    width: float
    height: float
    low: float = 0.0
    high: float = 1.0
    start: float = 0.0
    end: float = 360.0

    @property
    def angles(self) -> list[int]:
        """Round cam angles from edge to edge, of one turn every 30° [deg]."""
        turns = (self.end - self.start) / FULL
        step = next((each for each in (30, 60, 90, 180) if each >= 30.0 * turns), 0)
        step = step or int(FULL) * math.ceil(turns / 12.0)
        return list(range(int(self.start), int(self.end) + 1, step))

    @property
    def right(self) -> float:
        """Its right edge."""
        return self.left + self.width

    @property
    def bottom(self) -> float:
        """Its lower edge."""
        return self.top + self.height

    def x(self, value: Numbers) -> Numbers:
        """Abscissae of values, of cam angles [deg] where nothing else is said."""
        return self.left + self.width * (value - self.start) / (self.end - self.start)

    def y(self, value: Numbers) -> Numbers:
        """Ordinates of values."""
        return self.top + self.height * (self.high - value) / (self.high - self.low)


def diagram(plot: Plot, frame: Frame) -> list[str]:
    """The elements of one diagram, its title line above the frame."""
    frame = with_range(frame, plot)
    labels = plot.labels(frame.low, frame.high)
    return [
        *_bad(frame, plot.bad),
        *_axes(frame, labels),
        *_limit_lines(frame, plot.limits),
        *_curve(frame, plot.curve),
        *_arrows(frame, plot.infinite, bool(plot.limits)),
        *_broken(frame, plot.fine, plot.limits),
        *_title(frame, plot, labels),
    ]


def with_range(frame: Frame, plot: Plot) -> Frame:
    """The frame with a range that holds zero, the curve, and the limits that are not far away."""
    values = plot.fine.values
    peak = float(np.max(np.abs(values)))
    ends = [end for bound in plot.limits for end in (bound.lower, bound.upper)]
    shown = [0.0, float(values.min()), float(values.max())]
    shown += [end for end in ends if abs(end) <= FAR * peak]
    if max(shown) == min(shown):
        shown = [-1.0, 1.0]
    pad = 0.06 * (max(shown) - min(shown))
    low = min(shown) - pad if min(shown) < -EXACT * max(shown) else 0.0
    return replace(frame, low=low, high=max(shown) + pad)


def _bad(frame: Frame, ends: Sequence[float]) -> list[str]:
    """A ground for values that no cam has."""
    if not ends or max(ends) <= frame.low or min(ends) >= frame.high:
        return []
    top, bottom = frame.y(np.clip([max(ends), min(ends)], frame.low, frame.high)).tolist()
    body = [svg.box("undercut", frame.left, top, frame.width, bottom - top)]
    if bottom - top >= LEGIBLE:
        x, y = frame.right - 1.5, 0.5 * (top + bottom) + 0.9
        body.append(svg.text("tick", x, y, "undercut", "end"))
    return body


def _axes(frame: Frame, labels: Labels) -> list[str]:
    right, bottom = frame.right, frame.bottom
    across = [frame.x(float(each)) for each in frame.angles if frame.start < each < frame.end]
    body = [svg.line("grid", x, frame.top, x, bottom) for x in across]
    for value, text in labels.ticks:
        y = frame.y(value)
        body.append(svg.line("axis" if value == 0.0 else "grid", frame.left, y, right, y))
        body.append(svg.text("tick", frame.left - 1.6, y + 0.9, text, "end"))
    body.append(svg.line("axis", frame.left, frame.top, frame.left, bottom))
    return [*body, svg.line("axis", frame.left, bottom, right, bottom)]


def _limit_lines(frame: Frame, limits: Sequence[Bound]) -> list[str]:
    return [
        svg.line("limit", frame.x(bound.start), frame.y(end), frame.x(bound.end), frame.y(end))
        for bound in limits
        for end in (bound.lower, bound.upper)
        if frame.low <= end <= frame.high
    ]


def _curve(frame: Frame, curve: Trace) -> list[str]:
    """The curve in unbroken runs, and a dotted line across every jump."""
    x, y = frame.x(curve.degrees), frame.y(curve.values)
    starts = np.flatnonzero((np.diff(x) == 0.0) & (np.abs(np.diff(y)) > 1e-3)) + 1
    runs = zip(np.split(x, starts), np.split(y, starts), strict=True)
    body = [svg.line("jump", x[i], y[i - 1], x[i], y[i]) for i in starts.tolist()]
    return [*body, *(svg.path("line curve", svg.steps(a, b, 3)) for a, b in runs)]


def _arrows(frame: Frame, infinite: Trace, limited: bool) -> list[str]:
    """An arrow to the frame's edge where the value is infinite."""
    body = []
    zero = frame.y(0.0)
    for x, value in zip(frame.x(infinite.degrees).tolist(), infinite.values, strict=True):
        y = frame.top if value > 0.0 else frame.bottom
        body.append(svg.line("limit" if limited else "jump", x, zero, x, y))
        away = math.copysign(0.5 * math.pi, -value)
        body.append(svg.arrow_head("alarm" if limited else "solid", x, y, away, 2.2))
    return body


def _broken(frame: Frame, curve: Trace, limits: Sequence[Bound]) -> list[str]:
    """The curve once more where it breaks a limit, and what lies between the two hatched."""
    body = []
    x, y = frame.x(curve.degrees), frame.y(curve.values)
    for bound in limits:
        wrong = np.flatnonzero(exceeds(curve, bound))
        runs = np.split(wrong, np.flatnonzero(np.diff(wrong) > 1) + 1)
        for run in (run for run in runs if len(run)):
            over = curve.values[run[0]] > bound.upper
            level = frame.y(bound.upper if over else bound.lower)
            body += _hatched(x[run], y[run], level)
            body.append(svg.path("line broken", svg.steps(x[run], y[run], 3)))
    return body


def _hatched(x: Array, y: Array, level: float) -> list[str]:
    """Upright lines from a curve to a level."""
    at = np.arange(math.ceil(x[0] / HATCH), math.floor(x[-1] / HATCH) + 1) * HATCH
    feet = np.interp(at, x, y)
    return [svg.line("hatch", a, b, a, level) for a, b in zip(at.tolist(), feet, strict=True)]


def _title(frame: Frame, plot: Plot, labels: Labels) -> list[str]:
    """Name and unit on the left; extremes and limits on the right, in alarm if broken."""
    curve, text = plot.fine.followed_by(plot.infinite), []
    for word, largest in plot.ends:  # on a plateau, its beginning
        value = curve.values.max() if largest else curve.values.min()
        first = np.argmax(np.isclose(curve.values, value, rtol=PLATEAU, atol=0.0))
        text.append(f"{word} {labels.format(value)} at {svg.figure(curve.degrees[first], 5)}°")
    text += sorted({_limit_text(bound, labels) for bound in plot.limits})
    broken = any(exceeds(curve, bound).any() for bound in plot.limits)
    right, y = frame.right, frame.top - 2.2
    title = svg.text("label", frame.left, y, f"{plot.title}, {labels.factor}{plot.unit}")
    kind = "alarm" if broken else "quiet"
    return [title, *([svg.text(kind, right, y, " · ".join(text), "end")] if text else [])]


def _limit_text(bound: Bound, labels: Labels) -> str:
    lower, upper = labels.format(bound.lower), labels.format(bound.upper)
    if bound.lower == -bound.upper:
        return f"limit ±{upper}"
    if lower == upper:  # a window that asks for one value
        return f"limit {lower}"
    if math.isinf(bound.lower) or math.isinf(bound.upper):
        return f"limit {upper if math.isinf(bound.lower) else lower}"
    return f"limits {lower} and {upper}"
