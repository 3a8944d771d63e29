"""Peak values of a law's normalised curve, by which laws are compared and cams are sized."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from pydantic import Field

from synthesis.catalogue.fields import AnswerModel
from synthesis.catalogue.laws.base import MotionLaw
from synthesis.numerics.piecewise import Array, Piecewise

SAMPLES = 65  # of a piece: two turning points of a named law are farther apart
BISECTIONS = 60  # to the last bit; Newton would converge slowly on flat tops
JUMP_TOLERANCE = 1e-9  # of the peak: rounding leaves 1e-14, the smallest real jump is above 1


class Characteristics(AnswerModel):
    """Peak values for unit lift and unit angle; null where infinite.

    On a segment of lift h and angle β at cam speed ω, the peaks are Cv·hω/β, Ca·hω²/β² and
    Cj·hω³/β³. At the ends the law meets a dwell, or its own mirror image where it turns.
    """

    Cv: float = Field(description="Largest velocity.")
    Ca_max: float | None = Field(description="Largest acceleration.")
    Ca_min: float | None = Field(description="Largest deceleration, negative.")
    Cj_max: float | None = Field(description="Largest jerk.")
    Cj_min: float | None = Field(description="Most negative jerk.")


@lru_cache(maxsize=256)
def characteristics(law: MotionLaw) -> Characteristics:
    """Peak values of a rise by ``law``."""
    curve = law.curve("rise")
    peak_v, peak_a, peak_j = (extremes(curve, order) for order in (1, 2, 3))
    start, end = law.ends.split("-")
    v_jumps = jumps(curve, 1, True, True)
    a_jumps = jumps(curve, 2, start == "R", end == "R")
    jerks = peak_j if len(v_jumps) == 0 else (None, None)
    return Characteristics(
        Cv=max(abs(value) for value in peak_v),
        Ca_max=None if np.any(v_jumps > 0.0) else peak_a[0],
        Ca_min=None if np.any(v_jumps < 0.0) else peak_a[1],
        Cj_max=None if np.any(a_jumps > 0.0) else jerks[0],
        Cj_min=None if np.any(a_jumps < 0.0) else jerks[1],
    )


def extremes(curve: Piecewise, order: int) -> tuple[float, float]:
    """Largest and smallest value of the ``order``-th derivative, one-sided at breaks.

    They lie at ends of pieces or where the next derivative changes sign, found by bisection.
    """
    grid = np.linspace(curve.breaks[:-1], curve.breaks[1:], SAMPLES, axis=1)
    piece = np.repeat(np.arange(curve.count), SAMPLES).reshape(grid.shape)
    slope = curve.at(grid.ravel(), piece.ravel(), order + 1).reshape(grid.shape)
    turning = slope[:, :-1] * slope[:, 1:] < 0.0
    low, high, rising = grid[:, :-1][turning], grid[:, 1:][turning], slope[:, :-1][turning] > 0.0
    where = piece[:, 1:][turning]
    for _ in range(BISECTIONS):
        middle = (low + high) / 2.0
        before = (curve.at(middle, where, order + 1) > 0.0) == rising
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    x, at = np.concatenate([grid.ravel(), low]), np.concatenate([piece.ravel(), where])
    values = curve.at(x, at, order)
    return float(values.max()), float(values.min())


def jumps(curve: Piecewise, order: int, from_rest: bool, to_rest: bool) -> Array:
    """Jumps of the ``order``-th derivative: at breaks, and against rest at the ends."""
    before = curve(curve.breaks, order, "left")
    after = curve(curve.breaks, order, "right")
    before[0] = 0.0 if from_rest else after[0]
    after[-1] = 0.0 if to_rest else before[-1]
    step = after - before
    scale = max(np.abs(before).max(), np.abs(after).max(), 1.0)
    return np.asarray(step[np.abs(step) > JUMP_TOLERANCE * scale])
