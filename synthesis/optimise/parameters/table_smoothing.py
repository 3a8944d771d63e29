"""Tables smoothed before anything else: what they are to join, and the motion that comes out."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics import clock
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array
from synthesis.optimise.parameters.table_fit import Fit, Rows, smooth_table
from synthesis.optimise.state.solve_state import Stage


@dataclass(frozen=True, eq=False)
class Tables:
    """The program with its tables smoothed, their splines by index, and what that took."""

    segments: tuple[PlacedSegment, ...]
    splines: dict[int, tuple[SplineSpace, Array]]
    stages: tuple[Stage, ...]


def smooth_tables(segments: Sequence[PlacedSegment], deadline: float = inf) -> Tables:
    """Smooth every table in the order of the program; each joins what is settled beside it.

    Args:
        segments: the program on the cam.
        deadline: ``time.monotonic()`` after which no solve goes on.
    """
    found = list(segments)
    splines, stages = {}, []
    turning = [i for i, segment in enumerate(found) if segment.angle > 0.0]
    for place, i in enumerate(turning):
        free = found[i].free
        if found[i].table is None or free is None:
            continue
        started = time.perf_counter()
        left, right = found[turning[place - 1]], found[turning[(place + 1) % len(turning)]]
        rows = _rows(found[i], left, right)
        left_s = max(deadline - clock.now(), 1e-3)
        fit = smooth_table(rows, free.smoothness + 1, left_s)
        found[i] = found[i].with_law(fit.space.curve(fit.coefficients))
        splines[i] = (fit.space, fit.coefficients)
        stages.append(_stage(i, fit, time.perf_counter() - started))
    return Tables(tuple(found), splines, tuple(stages))


def _rows(segment: PlacedSegment, left: PlacedSegment, right: PlacedSegment) -> Rows:
    readings, unit = segment.table, segment.scale
    assert readings is not None
    assert segment.free is not None
    alone = left is segment
    return Rows(
        readings.x,
        (readings.s - segment.s_start) / unit,
        readings.tolerance / unit,
        _known(segment, left, at_start=True),
        _known(segment, right, at_start=False),
        segment.free.smoothness if alone else 0,
    )


def _known(segment: PlacedSegment, neighbour: PlacedSegment, *, at_start: bool) -> Array:
    """g, g', … at an end: of the settled neighbour, but for what is asked for."""
    assert segment.free is not None
    level = 0.0 if at_start else segment.lift / segment.scale
    state = segment.start_state if at_start else segment.end_state
    asked = state.normalised(segment.angle, segment.scale)
    if neighbour.law is None or neighbour is segment:
        return np.array([level, *(value for value in asked if value is not None)])
    curve = neighbour.placed()
    x = curve.breaks[-1:] if at_start else curve.breaks[:1]
    values = curve.derivatives(x, 2, "left" if at_start else "right")[:, 0]
    scaled = values * segment.angle ** np.arange(3) / segment.scale
    v, a = (own if value is None else value for own, value in zip(scaled[1:], asked, strict=True))
    count = 3 if asked[1] is not None else 1 + min(2, segment.free.continuity_at(at_start=at_start))
    return np.array([level, v, a][:count])


def _stage(index: int, fit: Fit, seconds: float) -> Stage:
    intervals = len(fit.space.breaks) - 1
    return Stage(
        f"table program/{index}", f"QP, {intervals} spline intervals", "Clarabel", fit.unknowns,
        fit.rows, fit.iterations, seconds, fit.stopped.value,
    )  # fmt: skip
