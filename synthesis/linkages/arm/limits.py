"""Limits of the joints, and the polygon of arm angles that they leave."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from synthesis.linkages.arm.geometry import Joints
from synthesis.units import FULL_TURN

Span = tuple[float, float]
Corner = tuple[float, float]  # θ2, θ3 [rad]
SAME: Final = 1e-12  # rad: what rounding may take from a limit


@dataclass(frozen=True)
class Limits:
    """From where to where each joint goes, and q = θ2 − θ3 [rad]."""

    base: Span
    upper: Span
    fore: Span
    opening: Span
    tool: Span

    def broken(self, joints: Joints) -> list[tuple[str, float]]:
        """Names of the limits that a posture exceeds, and by how much [rad]."""
        values = {
            "base": joints.base, "upper_arm": joints.upper, "forearm": joints.fore,
            "opening": joints.opening, "tool": joints.tool,
        }  # fmt: skip
        spans = (self.base, self.upper, self.fore, self.opening, self.tool)
        found = []
        for (name, value), (low, high) in zip(values.items(), spans, strict=True):
            beyond = max(low - value, value - high)
            if beyond > SAME:
                found.append((name, beyond))
        return found

    def turns(self, joints: Joints) -> Iterator[Joints]:
        """The same posture by whole turns of its joints, within the limits where it can be.

        An angle that no whole turn brings inside stays as near to its span as can be. Of base and
        tool, which may turn further than once, every one is told.
        """
        upper, fore = _nearest(joints.upper, self.upper), _nearest(joints.fore, self.fore)
        for base in _turned(joints.base, self.base):
            for tool in _turned(joints.tool, self.tool):
                yield Joints(base, upper, fore, tool)

    def polygon(self) -> list[Corner]:
        """Corners of the arm angles that are allowed, counter-clockwise; empty where none are."""
        (a, b), (c, d) = self.upper, self.fore
        corners = [(a, c), (b, c), (b, d), (a, d)]
        low, high = self.opening
        corners = _cut(corners, lambda at: at[0] - at[1] - low)
        return _cut(corners, lambda at: high - at[0] + at[1])

    def within(self, low: float, high: float) -> Limits:
        """The same with q between two angles too."""
        return Limits(
            self.base, self.upper, self.fore,
            (max(self.opening[0], low), min(self.opening[1], high)), self.tool,
        )  # fmt: skip


def _turned(angle: float, span: Span) -> list[float]:
    """The angle by whole turns: all that lie in the span, or the one nearest to it."""
    low, high = span
    first = math.ceil((low - SAME - angle) / FULL_TURN)
    last = math.floor((high + SAME - angle) / FULL_TURN)
    found = [angle + k * FULL_TURN for k in range(first, last + 1)]
    if high - low <= FULL_TURN + SAME:  # both ends of a whole turn are one place
        found = found[-1:]
    return found or [_nearest(angle, span)]


def _nearest(angle: float, span: Span) -> float:
    return min(
        (angle + k * FULL_TURN for k in range(-2, 3)),
        key=lambda each: max(span[0] - each, each - span[1], 0.0),
    )


def _cut(corners: list[Corner], keep: Callable[[Corner], float]) -> list[Corner]:
    """A convex polygon's part where a linear function is not negative (Sutherland, Hodgman)."""
    found: list[Corner] = []
    for here, there in zip(corners, [*corners[1:], *corners[:1]], strict=True):
        first, second = keep(here), keep(there)
        if first >= 0.0:
            found.append(here)
        if (first > 0.0 > second) or (first < 0.0 < second):
            share = first / (first - second)
            found.append(
                (here[0] + share * (there[0] - here[0]), here[1] + share * (there[1] - here[1]))
            )
    return found
