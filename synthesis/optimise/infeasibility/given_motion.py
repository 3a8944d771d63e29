"""Limits that a given law breaks by itself, whatever the cam's size."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.catalogue.motion import PlacedSegment
from synthesis.optimise.infeasibility.relaxable import Relaxable, RelaxableRange
from synthesis.optimise.problem.problem import Problem
from synthesis.units import DEGREE

JUMP = 1e-9  # of lift/β^k: what rounding may leave between two sides


@dataclass(frozen=True)
class GivenMotionConflict:
    """What the given laws need of a limit [wire], None where no value is enough, and why."""

    value: float | None
    note: str


def given_motion_conflicts(
    parts: Sequence[Relaxable], problem: Problem
) -> dict[int, GivenMotionConflict]:
    """The parts, by position, that a given law breaks."""
    found: dict[int, GivenMotionConflict] = {}
    for position, part in enumerate(parts):
        if isinstance(part, RelaxableRange):
            continue
        jump = next(_jumps(problem, part.order(problem)), None)
        if jump is not None:
            found[position] = GivenMotionConflict(None, jump)
            continue
        each = [((s,), f"program/{s.index} has a given law that needs this much by itself")
                for s in problem.segments]  # fmt: skip
        for segments, note in [*each, (problem.segments, "given laws together leave this much")]:
            value = part.least(replace(problem, segments=segments), None)
            if value is None or part.tighter(part.requested, value):
                if part.fixed(problem):
                    note = "the follower needs this much by itself, whatever law and size"
                worst = found[position].value if position in found else part.requested
                if value is None or worst is None or part.tighter(worst, value):
                    found[position] = GivenMotionConflict(value, note)
    return found


def _jumps(problem: Problem, order: int) -> Iterator[str]:
    """Where a derivative below ``order`` jumps on or between given laws: there it is infinite."""
    segments = problem.segments
    for before, after in zip(segments, (*segments[1:], segments[0]), strict=True):
        if before.law is None:
            continue
        curve = before.placed()
        for k in range(1, order):
            size = JUMP * max(abs(before.scale), 1e-300) / before.angle**k
            inner = curve.breaks[1:-1]
            apart = np.abs(curve(inner, k, "left") - curve(inner, k, "right"))
            if np.any(apart > size):
                yield _note(k, before, float(inner[np.argmax(apart)]))
            if after.law is None:
                continue
            size = max(size, JUMP * abs(after.scale) / after.angle**k)
            ends = curve(curve.breaks[-1:], k, "left") - after.placed()(
                after.placed().breaks[:1], k, "right"
            )
            if abs(ends[0]) > size:
                yield _note(k, before, before.end)


def _note(order: int, segment: PlacedSegment, angle: float) -> str:
    what = ("displacement", "velocity", "acceleration")[order]
    return (
        f"the {what} of given laws jumps at {angle / DEGREE:.6g}° (program/{segment.index}): "
        "no value is enough; choose a smoother law"
    )
