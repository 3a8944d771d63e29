"""Spline stretches that promise never to move backwards."""

from __future__ import annotations

from functools import cache
from math import comb, floor
from typing import Final

import numpy as np

from synthesis.certify.course import Course, Indices
from synthesis.certify.path import Boxes
from synthesis.design import Extreme
from synthesis.limits.base import Machine
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

BACKWARD: Final = 1e-9  # of the lift: travel backwards that counts as none
FINE: Final = 1e-2  # of that bound: width of the enclosure that is good enough
FIRST: Final = 2
PARTS: Final = 1000  # of the bound: less of it apart, two stretches are equally bad
SPLIT: Final = 8
ROUNDS: Final = 7
MOST_BOXES: Final = 50_000
ROUNDING: Final = 2.0**-46  # of the terms of a coefficient: more than 64 roundings


def overshoot(course: Course, machine: Machine) -> list[Extreme]:
    """Travel backwards on stretches that may not overshoot: the worst of them, if there is one."""
    kept = [
        s.index
        for s in course.motion.stretches
        if s.free is not None and not s.free.overshoot and s.angle > 0.0
    ]
    if not kept:
        return []
    least, most, count = _travel(course, course.pieces(kept))
    bounds = [BACKWARD * abs(s.lift) for s in course.motion.stretches]
    # in parts of the bound: of roundings none is the worst
    worst = max(kept, key=lambda i: floor(PARTS * most[i] / bounds[i]))
    value, bound, width = (
        float(length) * machine.rate(0)
        for length in (least[worst], bounds[worst], most[worst] - least[worst])
    )
    margin = bound - value
    return [
        Extreme(
            limit="overshoot", value=value, unit=machine.told(0),
            angle_deg=course.motion.stretches[worst].start / DEGREE, bound=bound, margin=margin,
            width=width, holds=margin >= width, field=f"program/{worst}/law/overshoot",
            evidence=f"velocity enclosed on {count} pieces and boxes; bound: 1e-9 of the lift",
        )
    ]  # fmt: skip


def _travel(course: Course, pieces: Indices) -> tuple[Array, Array, int]:
    """∫ of the backward velocity over each stretch [mm]: proven lower and upper end.

    Pieces on which Bernstein's coefficients leave no doubt are settled at once, others in boxes.

    Returns:
        lower and upper ends, one per stretch of the motion, and the number of boxes.
    """
    stretches = course.motion.stretches
    least, most = np.zeros(len(stretches)), np.zeros(len(stretches))
    fine = FINE * BACKWARD * np.abs([s.lift for s in stretches])
    breaks, count, owner = course.curve.breaks, len(pieces), course.stretch[pieces]
    whole = _on_pieces(course, pieces)
    coarse = ~(whole <= fine[owner] / np.bincount(owner)[owner])
    most += np.bincount(owner[~coarse], whole[~coarse], len(stretches))
    if not coarse.any():
        return least, most, count
    boxes = Boxes(pieces, breaks[pieces], breaks[pieces + 1]).take(coarse).split(FIRST)
    for round_ in range(ROUNDS):
        low, high = _on_boxes(course, boxes)
        count += len(low)
        owner = course.stretch[boxes.piece]
        crowd = np.bincount(owner, minlength=len(stretches))[owner]
        coarse = high - low > fine[owner] / crowd
        if round_ == ROUNDS - 1 or count + SPLIT * np.count_nonzero(coarse) > MOST_BOXES:
            coarse[:] = False
        least += np.bincount(owner[~coarse], low[~coarse], len(stretches))
        most += np.bincount(owner[~coarse], high[~coarse], len(stretches))
        if not coarse.any():
            break
        boxes = boxes.take(coarse).split(SPLIT)
    return least, most, count


def _on_pieces(course: Course, pieces: Indices) -> Array:
    """The most on whole pieces: the backward velocity is nowhere above its largest coefficient."""
    curve = course.curve
    start, poly = curve.breaks[pieces], curve.poly[pieces, 1:].T
    if curve.waves[pieces, :, 0].any() or not np.array_equal(curve.origins[pieces], start):
        return np.full(len(pieces), np.inf)
    length, power = curve.breaks[pieces + 1] - start, np.arange(len(poly))[:, None]
    terms = poly * (power + 1.0) * length**power  # of v in (x − start) / length
    back = -_forward(course, pieces) * (_to_bernstein(len(poly)) @ terms)
    speed: Array = back.max(axis=0) + ROUNDING * np.abs(terms).sum(axis=0)
    return (1.0 + 1e-12) * length * np.maximum(speed, 0.0)


@cache
def _to_bernstein(count: int) -> Array:
    """(count, count): from coefficients of powers to those of Bernstein's polynomials."""
    degree = count - 1
    return np.array(
        [[comb(k, j) / comb(degree, j) for j in range(count)] for k in range(count)], dtype=float
    )


def _forward(course: Course, pieces: Indices) -> Array:
    """The sense in which each piece's stretch moves."""
    lifts = np.array([stretch.lift for stretch in course.motion.stretches])
    return np.asarray(np.sign(lifts)[course.stretch[pieces]])


def _on_boxes(course: Course, boxes: Boxes) -> tuple[Array, Array]:
    """The same on each box: it is no less than the net fall, no more than what the speed allows."""
    s, v = course.jets.models(boxes.piece, boxes.lo, boxes.hi, 1)
    forward = _forward(course, boxes.piece)
    high, low, *_ = v.extremes()
    back = np.where(forward > 0.0, -low, high) + v.rem
    most = (boxes.hi - boxes.lo) * (1.0 + 1e-12) * np.maximum(back, 0.0)
    least = np.maximum(-2.0 * forward * s.c1 - 2.0 * s.rem, 0.0)
    return np.minimum(least, most), most
