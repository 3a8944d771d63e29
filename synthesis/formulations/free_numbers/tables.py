"""Tables smoothed before anything else: what they are to join, and the motion that comes out."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from synthesis import clock
from synthesis.formulations.free_numbers.table_fit import Fit, Rows, smoothed
from synthesis.formulations.rounds.search import Stage
from synthesis.motion import Stretch
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array


@dataclass(frozen=True, eq=False)
class Tables:
    """The program with its tables smoothed, their splines by index, and what that took."""

    stretches: tuple[Stretch, ...]
    splines: dict[int, tuple[SplineSpace, Array]]
    stages: tuple[Stage, ...]


def smooth_tables(stretches: Sequence[Stretch], deadline: float = inf) -> Tables:
    """Smooth every table in the order of the program; each joins what is settled beside it.

    Args:
        stretches: the program on the cam.
        deadline: ``time.monotonic()`` after which no solve goes on.
    """
    found = list(stretches)
    splines, stages = {}, []
    turning = [i for i, stretch in enumerate(found) if stretch.angle > 0.0]
    for place, i in enumerate(turning):
        free = found[i].free
        if found[i].readings is None or free is None:
            continue
        started = time.perf_counter()
        left, right = found[turning[place - 1]], found[turning[(place + 1) % len(turning)]]
        rows = _rows(found[i], left, right)
        left_s = max(deadline - clock.now(), 1e-3)
        fit = smoothed(rows, free.smoothness + 1, left_s)
        found[i] = found[i].with_law(fit.space.curve(fit.coefficients))
        splines[i] = (fit.space, fit.coefficients)
        stages.append(_stage(i, fit, time.perf_counter() - started))
    return Tables(tuple(found), splines, tuple(stages))


def _rows(stretch: Stretch, left: Stretch, right: Stretch) -> Rows:
    readings, unit = stretch.readings, stretch.unit
    assert readings is not None
    assert stretch.free is not None
    alone = left is stretch
    return Rows(
        readings.x,
        (readings.s - stretch.s_start) / unit,
        readings.tolerance / unit,
        _known(stretch, left, at_start=True),
        _known(stretch, right, at_start=False),
        stretch.free.smoothness if alone else 0,
    )


def _known(stretch: Stretch, neighbour: Stretch, *, at_start: bool) -> Array:
    """g, g', … at an end: of the settled neighbour, but for what is asked for."""
    assert stretch.free is not None
    level = 0.0 if at_start else stretch.lift / stretch.unit
    state = stretch.at_start if at_start else stretch.at_end
    asked = state.normalised(stretch.angle, stretch.unit)
    if neighbour.law is None or neighbour is stretch:
        return np.array([level, *(value for value in asked if value is not None)])
    curve = neighbour.placed()
    x = curve.breaks[-1:] if at_start else curve.breaks[:1]
    values = curve.derivatives(x, 2, "left" if at_start else "right")[:, 0]
    scaled = values * stretch.angle ** np.arange(3) / stretch.unit
    v, a = (own if value is None else value for own, value in zip(scaled[1:], asked, strict=True))
    count = 3 if asked[1] is not None else 1 + min(2, stretch.free.promised(at_start=at_start))
    return np.array([level, v, a][:count])


def _stage(index: int, fit: Fit, seconds: float) -> Stage:
    intervals = len(fit.space.breaks) - 1
    return Stage(
        f"table program/{index}", f"QP, {intervals} spline intervals", "Clarabel", fit.unknowns,
        fit.rows, fit.iterations, seconds, fit.stopped.value,
    )  # fmt: skip
