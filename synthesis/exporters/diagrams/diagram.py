"""One diagram of the motion: axes, curve, jumps, limits and where they are broken."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.exporters.diagrams.plot import EXACT, Bound, Labels, Plot, Trace, exceeds
from synthesis.exporters.drawing import canvas as svg
from synthesis.numerics.piecewise import Array

PLATEAU = 1e-13  # values that differ by less are one plateau
FAR = 1.6  # a limit further out than this many times the peak is written, not drawn
HATCH = 1.1  # [mm] between the lines that fill what exceeds a limit
LEGIBLE = 4.0  # [mm], height of a strip in which a word fits


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
        right = frame.left + frame.width - 1.5
        body.append(svg.text("tick", right, 0.5 * (top + bottom) + 0.9, "undercut", "end"))
    return body


def _axes(frame: Frame, labels: Labels) -> list[str]:
    right, bottom = frame.left + frame.width, frame.top + frame.height
    across = frame.x(np.arange(30.0, 360.0, 30.0)).tolist()
    body = [svg.line("grid", x, frame.top, x, bottom) for x in across]
    for value, text in labels.ticks:
        y = float(frame.y(np.array(value)))
        body.append(svg.line("axis" if value == 0.0 else "grid", frame.left, y, right, y))
        body.append(svg.text("tick", frame.left - 1.6, y + 0.9, text, "end"))
    body.append(svg.line("axis", frame.left, frame.top, frame.left, bottom))
    return [*body, svg.line("axis", frame.left, bottom, right, bottom)]


def _limit_lines(frame: Frame, limits: Sequence[Bound]) -> list[str]:
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


def _broken(frame: Frame, curve: Trace, limits: Sequence[Bound]) -> list[str]:
    """The curve once more where it breaks a limit, and what lies between the two hatched."""
    body = []
    x, y = frame.x(curve.degrees), frame.y(curve.values)
    for bound in limits:
        wrong = np.flatnonzero(exceeds(curve, bound))
        runs = np.split(wrong, np.flatnonzero(np.diff(wrong) > 1) + 1)
        for run in (run for run in runs if len(run)):
            over = curve.values[run[0]] > bound.upper
            level = float(frame.y(np.array(bound.upper if over else bound.lower)))
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
    right, y = frame.left + frame.width, frame.top - 2.2
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
