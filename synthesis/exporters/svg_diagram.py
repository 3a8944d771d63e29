"""One diagram of the motion: axes, curve, jumps, limits and where they are broken."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from synthesis.design import Design
from synthesis.exporters import svg_canvas as svg
from synthesis.exporters.cam import Cam
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.readings import (
    EXACT,
    Bound,
    Quantity,
    Trace,
    bounds,
    exceeds,
    impulses,
    trace,
)
from synthesis.numerics.piecewise import Array

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MEASURED_PER_DEGREE = 20.0  # at which the extremes are read
PLATEAU = 1e-13  # values that differ by less are one plateau
FAR = 1.6  # a limit further out than this many times the peak is told, not drawn


@dataclass(frozen=True)
class Frame:
    """Where a diagram lies on the sheet [mm], and the values at its lower and upper edge."""

    left: float
    top: float
    width: float
    height: float
    low: float = 0.0
    high: float = 1.0

    def x(self, degrees: Array) -> Array:
        """Abscissae of cam angles."""
        return self.left + self.width * degrees / 360.0

    def y(self, value: Array) -> Array:
        """Ordinates of values."""
        return self.top + self.height * (self.high - value) / (self.high - self.low)


def diagram(
    design: Design, cam: Cam, quantity: Quantity, frame: Frame, options: MotionOptions
) -> list[str]:
    """The elements of one diagram, its title line above the frame."""
    curve, infinite = trace(cam, quantity, options), impulses(cam, quantity)
    fine = trace(cam, quantity, MotionOptions(MEASURED_PER_DEGREE))
    limits, unit = bounds(design, quantity), svg.unit(cam.travel.told(quantity.order))
    frame = _ranged(frame, fine.values, limits)
    return [
        *_axes(frame, _exponent(frame)),
        *_limit_lines(frame, limits),
        *_curve(frame, curve),
        *_arrows(frame, infinite, bool(limits)),
        *_broken(frame, fine, limits),
        *_title(frame, quantity, unit, fine.followed_by(infinite), limits),
    ]


def _ranged(frame: Frame, values: Array, limits: list[Bound]) -> Frame:
    """The frame with a range that holds zero, the curve, and the limits that are not far away."""
    peak = float(np.max(np.abs(values)))
    ends = [end for bound in limits for end in (bound.lower, bound.upper)]
    shown = [0.0, float(values.min()), float(values.max())]
    shown += [end for end in ends if abs(end) <= FAR * peak]
    if max(shown) == min(shown):
        shown = [-1.0, 1.0]
    pad = 0.06 * (max(shown) - min(shown))
    low = min(shown) - pad if min(shown) < -EXACT * max(shown) else 0.0
    return Frame(frame.left, frame.top, frame.width, frame.height, low, max(shown) + pad)


def _exponent(frame: Frame) -> int:
    """Power of ten taken out of the numbers at the axis: 0 or a multiple of three."""
    size = math.floor(math.log10(max(abs(frame.low), abs(frame.high))))
    return 0 if -2 <= size <= 3 else 3 * (size // 3)


def _axes(frame: Frame, exponent: int) -> list[str]:
    right, bottom = frame.left + frame.width, frame.top + frame.height
    across = frame.x(np.arange(30.0, 360.0, 30.0)).tolist()
    body = [svg.line("grid", x, frame.top, x, bottom) for x in across]
    for value in svg.ticks(frame.low, frame.high, 6):
        y = float(frame.y(np.array(value)))
        body.append(svg.line("axis" if value == 0.0 else "grid", frame.left, y, right, y))
        shown = svg.figure(value / 10.0**exponent, 6)
        body.append(svg.text("tick", frame.left - 1.6, y + 0.9, shown, "end"))
    body.append(svg.line("axis", frame.left, frame.top, frame.left, bottom))
    return [*body, svg.line("axis", frame.left, bottom, right, bottom)]


def _limit_lines(frame: Frame, limits: list[Bound]) -> list[str]:
    body = []
    for bound in limits:
        x1, x2 = frame.x(np.array([bound.start, bound.end])).tolist()
        for end in (bound.lower, bound.upper):
            if frame.low <= end <= frame.high:
                y = float(frame.y(np.array(end)))
                body.append(svg.line("limit", x1, y, x2, y))
    return body


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
    zero = float(frame.y(np.array(0.0)))
    for x, value in zip(frame.x(infinite.degrees).tolist(), infinite.values, strict=True):
        y = frame.top if value > 0.0 else frame.top + frame.height
        body.append(svg.line("limit" if limited else "jump", x, zero, x, y))
        away = math.copysign(0.5 * math.pi, -value)
        body.append(svg.arrow_head("alarm" if limited else "solid", x, y, away, 2.2))
    return body


def _broken(frame: Frame, curve: Trace, limits: list[Bound]) -> list[str]:
    """The curve once more, where it breaks a limit."""
    body = []
    x, y = frame.x(curve.degrees), frame.y(curve.values)
    for bound in limits:
        wrong = np.flatnonzero(exceeds(curve, bound))
        runs = np.split(wrong, np.flatnonzero(np.diff(wrong) > 1) + 1)
        body += [svg.path("line broken", svg.steps(x[r], y[r], 3)) for r in runs if len(r)]
    return body


def _title(
    frame: Frame, quantity: Quantity, unit: str, curve: Trace, limits: list[Bound]
) -> list[str]:
    """Name and unit on the left; extremes and limits on the right, in alarm if broken."""
    exponent = _exponent(frame)
    factor = f"10{str(exponent).translate(SUPERSCRIPTS)} " if exponent else ""
    ends = [("max", curve.values.max())]
    ends += [("min", curve.values.min())] if quantity.order else []
    told = []
    for word, value in ends:  # on a plateau, its beginning
        first = np.argmax(np.isclose(curve.values, value, rtol=PLATEAU, atol=0.0))
        angle = svg.figure(curve.degrees[first], 5)
        told.append(f"{word} {svg.figure(value / 10.0**exponent)} at {angle}°")
    told += sorted({_limit_text(bound, exponent) for bound in limits})
    broken = any(exceeds(curve, bound).any() for bound in limits)
    title = f"{quantity.title} {quantity.symbol}, {factor}{unit}"
    right, y = frame.left + frame.width, frame.top - 2.2
    return [
        svg.text("label", frame.left, y, title),
        svg.text("alarm" if broken else "quiet", right, y, " · ".join(told), "end"),
    ]


def _limit_text(bound: Bound, exponent: int) -> str:
    ends = [svg.figure(end / 10.0**exponent) for end in (bound.lower, bound.upper)]
    if bound.lower == -bound.upper:
        return f"limit ±{ends[1]}"
    if ends[0] == ends[1]:  # a window that asks for one value
        return f"limit {ends[0]}"
    if math.isinf(bound.lower) or math.isinf(bound.upper):
        return f"limit {ends[1] if math.isinf(bound.lower) else ends[0]}"
    return f"limits {ends[0]} and {ends[1]}"
