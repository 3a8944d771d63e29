"""What is made small where a spec names no objective."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from synthesis.catalogue.limits import Limit
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.catalogue.objectives import SMALL_AND_SMOOTH, AnyObjective, BaseRadius

ORDER = 2  # the acceleration: where it jumps, jerk is infinite
EQUAL = 1e-9  # of lift/β², or 1 mm per rad²: accelerations that differ by less do not jump


def assumed_objectives(segments: Segments, limits: Sequence[Limit]) -> tuple[AnyObjective, ...]:
    """The objectives of a spec that names none.

    The base radius alone where laws are all given, or where a limit speaks of acceleration or jerk.
    A free law bends ever more sharply for a smaller cam; so where no limit says how far it may, the
    cam is the smallest whose rms jerk is near the least. That needs a motion of finite jerk.
    """
    free = any(segment.law_is_free for segment in segments)
    limited = any(limit.limits_acceleration for limit in limits)
    if free and not limited and _jerk_is_finite(segments):
        return SMALL_AND_SMOOTH
    return (BaseRadius(),)


def _jerk_is_finite(segments: Segments) -> bool:
    """Whether the acceleration jumps nowhere: free laws are C2, and given ones have no jump."""
    turning = [segment for segment in segments if segment.angle > 0.0]
    pairs = zip(turning, [*turning[1:], turning[0]], strict=True)
    return not any(jumps for pair in pairs for jumps in _jumps(*pair))


def _jumps(segment: PlacedSegment, after: PlacedSegment) -> Iterator[bool]:
    """Whether the acceleration jumps inside a segment, and where the next one begins."""
    scale = EQUAL * max(abs(segment.lift) / segment.angle**ORDER, 1.0)
    if segment.free is not None:
        yield min(segment.free.smoothness, *segment.free.end_continuity) < ORDER
    elif segment.law is not None:
        curve = segment.placed()
        at = curve.breaks[1:-1]
        left, right = (curve.derivatives(at, ORDER, side)[ORDER] for side in ("left", "right"))
        yield bool(np.any(np.abs(left - right) > scale))
        if after.law is not None:
            end = segment.end_derivatives(ORDER, at_start=False)[ORDER]
            yield abs(end - after.end_derivatives(ORDER, at_start=True)[ORDER]) > scale
