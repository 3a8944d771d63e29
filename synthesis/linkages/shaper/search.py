"""The best shaper of a family, with a proven bound: by cutting planes the one, by boxes the other.

A bound is the least value that is possible on any box of the unit box that was not shown to be
worse; whatever the search leaves out, it leaves out with its own bound.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from synthesis.linkages.shaper.family import EXACT, Family
from synthesis.linkages.shaper.goals import DENSE, SAMPLES, Goal
from synthesis.numerics.affine import Affine
from synthesis.numerics.descent import Found, least
from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import Polytope
from synthesis.units import FULL_TURN

SIZE: Final = 5
TIDY: Final = ((1, 0.0), (2, 0.0), (3, 0.0), (4, 0.5))  # guide, pivots, coupler, ram's line
TRIED: Final = 1024  # points to begin with
STARTS: Final = 4  # of them from which it is descended
ROUNDS: Final = 60
RADIUS: Final = 0.2
AT_ONCE: Final = 1500  # boxes of a round
MOST: Final = 60_000  # boxes in all
NARROW: Final = 1e-6  # the same where slopes may not be known
LOOKED: Final = 32  # boxes of a round whose middles are tried
WIDE: Final = 0.05  # how much the width of a box counts beside its slope


@dataclass(frozen=True, eq=False)
class Best:
    """The best point found and what was proven.

    Attributes:
        u: the point, (5,); None: no point was found. value: of the goal there.
        bound: no shaper of the family has a smaller value; inf: there is none.
        boxes: how many were looked at.
    """

    u: Array | None
    value: float
    bound: float
    boxes: int


def best(family: Family, goal: Goal, tolerance: float, deadline: float | None) -> Best:
    """The best shaper of a family, to within a relative tolerance where time allows."""
    low, high = family.span()
    if low > high:
        return Best(None, np.inf, np.inf, 0)
    with np.errstate(all="ignore"):
        found = _proven(family, goal, _found(family, goal), tolerance, deadline)
        return found if found.u is None else replace(found, u=_tidied(family, goal, found.u))


def _tidied(family: Family, goal: Goal, u: Array) -> Array:
    """The same point, short and in the middle where that costs nothing."""
    value = _values(family, goal, u[None])[0]
    for k, tidy in TIDY:
        other = u.copy()
        other[k] = tidy
        if _values(family, goal, other[None])[0] <= value * (1.0 + EXACT):
            u = other
    return u


def _values(family: Family, goal: Goal, u: Array) -> Array:
    """The goal at points (n, 5), inf where the coupler is too short."""
    one = family.at(list(u.T))
    values = goal.values(one)
    possible = (one.short <= EXACT * np.abs(one.coupler)) & np.isfinite(values)
    return np.asarray(np.where(possible, values, np.inf))


def _found(family: Family, goal: Goal) -> Found | None:
    """The best of some points, descended from."""
    rng = np.random.default_rng(3)
    u = np.vstack([rng.random((TRIED, SIZE)), rng.integers(0, 2, (TRIED // 8, SIZE))])
    values = np.concatenate([_values(family, goal, part) for part in np.array_split(u, 32)])
    order = np.argsort(values)[:STARTS]
    starts = [Found(u[k], float(values[k])) for k in order if np.isfinite(values[k])]
    if not starts:
        return None

    def function(at: Array) -> float | None:
        value = float(_values(family, goal, np.clip(at, 0.0, 1.0)[None])[0])
        return value if np.isfinite(value) else None

    box = Polytope(np.zeros((0, SIZE)), np.zeros(0))
    ends = [least(function, box, start, RADIUS, ROUNDS) for start in starts]
    reached = min(ends, key=lambda one: one.value)
    return Found(np.clip(reached.u, 0.0, 1.0), reached.value)


def _proven(
    family: Family, goal: Goal, found: Found | None, tolerance: float, deadline: float | None
) -> Best:
    """The bound, and what the boxes' middles show of better points."""
    u, value = (None, np.inf) if found is None else (found.u, found.value)
    phi = _angles(goal, family, u)
    waiting = (np.zeros((1, SIZE)), np.ones((1, SIZE)), np.array([-np.inf]))
    left_out, seen = np.inf, 0
    while len(waiting[0]) and seen < MOST and (deadline is None or time.monotonic() < deadline):
        order = np.argsort(waiting[2])[:AT_ONCE]
        rest = np.setdiff1d(np.arange(len(waiting[2])), order)
        lo, hi = waiting[0][order], waiting[1][order]
        seen += len(lo)
        lower, split = _bounds(family, goal, lo, hi, phi)
        lower = np.maximum(lower, waiting[2][order])
        middle = 0.5 * (lo + hi)[np.argsort(lower)[:LOOKED]]
        values = _values(family, goal, middle)
        if values.min() < value:
            u, value = middle[values.argmin()], float(values.min())
        enough = value - tolerance * abs(value) if np.isfinite(value) else np.inf
        done = lower >= enough
        left_out = min(left_out, float(np.min(lower, where=done, initial=np.inf)))
        halves = _halved(lo[~done], hi[~done], split[~done], lower[~done])
        waiting = tuple(np.concatenate([a[rest], b]) for a, b in zip(waiting, halves, strict=True))  # type: ignore[assignment]
    bound = min(left_out, float(np.min(waiting[2], initial=np.inf)))
    return Best(u, value, bound, seen)


def _angles(goal: Goal, family: Family, u: Array | None) -> list[float]:
    """Crank angles for the bound: all round, and more where the best point has its peaks."""
    if not goal.angles:
        return []
    phi = FULL_TURN * np.arange(SAMPLES) / SAMPLES
    if u is not None:
        over = goal.over_turn(family.at([np.array([x]) for x in u]))[:, 0]
        for part in over:
            phi = np.append(phi, DENSE[np.argmax(part)] + 0.05 * np.arange(-3, 4))
    return [float(each) for each in phi]


def _bounds(
    family: Family, goal: Goal, lo: Array, hi: Array, phi: list[float]
) -> tuple[Array, Array]:
    """A lower bound of the goal on every box, inf where nothing fits, and which way to split."""
    one = family.bounded(Affine.variables(lo, hi))
    parts = goal.least(one, phi or [0.0], family.lengths["ram_line_mm"])
    lows = np.stack([part.lower for part in parts])
    lows = np.where(np.isfinite(lows), lows, -np.inf)
    which = np.argmax(lows, axis=0)
    lower, rows = np.max(lows, axis=0), np.arange(len(lo))
    slopes = np.abs(np.stack([part.g for part in parts]))[which, :, rows]
    rem = np.stack([part.rem for part in parts])[which, rows]
    # where nothing is known yet, what makes the coupler's angle uncertain is split
    steep = np.abs(one.level.g.T) + np.abs(one.level_at_ends.g.T) + NARROW * (hi - lo)
    known = np.isfinite(lower)[:, None]
    slopes, rem = np.where(known, slopes, steep), np.where(known[:, 0], rem, 0.0)
    spread = (rem + np.sum(slopes, axis=1))[:, None]
    split = np.argmax(slopes + WIDE * spread * (hi - lo), axis=1)
    # goals are sizes: none is negative
    return np.where(one.short.lower > 0.0, np.inf, np.maximum(lower, 0.0)), split


def _halved(lo: Array, hi: Array, split: Array, lower: Array) -> tuple[Array, Array, Array]:
    """Every box as two."""
    rows = np.arange(len(lo))
    middle = 0.5 * (lo + hi)[rows, split]
    left, right = hi.copy(), lo.copy()
    left[rows, split], right[rows, split] = middle, middle
    return np.concatenate([lo, right]), np.concatenate([left, hi]), np.concatenate([lower, lower])
