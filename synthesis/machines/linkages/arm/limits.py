"""Joint limits, and the polygon of arm angles (θ2, θ3) that they allow."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from synthesis.machines.linkages.arm.geometry import Joints
from synthesis.units import FULL_TURN

Span = tuple[float, float]
Corner = tuple[float, float]  # θ2, θ3 [rad]
ROUNDING: Final = 1e-12  # rad: by so much a limit may be exceeded


@dataclass(frozen=True)
class Limits:
    """Ranges of the joints and of q = θ2 − θ3 [rad]."""

    base: Span
    upper: Span
    fore: Span
    opening: Span
    tool: Span

    def exceeded(self, joints: Joints) -> list[tuple[str, float]]:
        """Names of the limits that joint angles exceed, and by how much [rad]."""
        values = {
            "base": joints.base, "upper_arm": joints.upper, "forearm": joints.fore,
            "opening": joints.opening, "tool": joints.tool,
        }  # fmt: skip
        spans = (self.base, self.upper, self.fore, self.opening, self.tool)
        found = []
        for (name, value), (low, high) in zip(values.items(), spans, strict=True):
            beyond = max(low - value, value - high)
            if beyond > ROUNDING:
                found.append((name, beyond))
        return found

    def equivalent_angles(self, joints: Joints) -> Iterator[Joints]:
        """The same posture with joints changed by whole turns, within the limits where possible.

        An angle that no whole turn brings inside stays as near to its range as possible. For base
        and tool, whose range may exceed 360°, every equivalent is given.
        """
        upper, fore = _nearest(joints.upper, self.upper), _nearest(joints.fore, self.fore)
        for base in _equivalents(joints.base, self.base):
            for tool in _equivalents(joints.tool, self.tool):
                yield Joints(base, upper, fore, tool)

    def polygon(self) -> list[Corner]:
        """Corners of the allowed arm angles, counter-clockwise; empty where there are none."""
        (a, b), (c, d) = self.upper, self.fore
        corners = [(a, c), (b, c), (b, d), (a, d)]
        low, high = self.opening
        corners = _clip(corners, lambda at: at[0] - at[1] - low)
        return _clip(corners, lambda at: high - at[0] + at[1])

    def within(self, low: float, high: float) -> Limits:
        """The same limits with q restricted to an interval [rad]."""
        return Limits(
            self.base, self.upper, self.fore,
            (max(self.opening[0], low), min(self.opening[1], high)), self.tool,
        )  # fmt: skip


def _equivalents(angle: float, span: Span) -> list[float]:
    """The angle plus whole turns: all that lie in the range, or the one nearest to it."""
    low, high = span
    first = math.ceil((low - ROUNDING - angle) / FULL_TURN)
    last = math.floor((high + ROUNDING - angle) / FULL_TURN)
    found = [angle + k * FULL_TURN for k in range(first, last + 1)]
    if high - low <= FULL_TURN + ROUNDING:  # the ends of a full turn are one place
        found = found[-1:]
    return found or [_nearest(angle, span)]


def _nearest(angle: float, span: Span) -> float:
    return min(
        (angle + k * FULL_TURN for k in range(-2, 3)),
        key=lambda each: max(span[0] - each, each - span[1], 0.0),
    )


def _clip(corners: list[Corner], keep: Callable[[Corner], float]) -> list[Corner]:
    """The part of a convex polygon where a linear function is ≥ 0 (Sutherland and Hodgman)."""
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
