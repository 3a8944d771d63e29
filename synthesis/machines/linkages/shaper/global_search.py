"""Global minimum over a design space: descent for the point, branch and bound for the bound.

The bound is the least lower bound of all boxes that are pruned or left open. The boxes are taken
best first, 1500 at a time, until time or boxes run out: ``numerics.box_search`` goes level by
level, which here would need many times the boxes, as bounds of affine models improve slowly in five
dimensions.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from synthesis.machines.linkages.shaper.design_space import (
    DENSE,
    EXACT,
    DesignSpace,
    ShaperObjective,
)
from synthesis.numerics.affine import Affine
from synthesis.numerics.bundle_method import BundlePoint, minimise
from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import Polytope
from synthesis.units import FULL_TURN

SIZE: Final = 5  # dimensions of the unit box
SAMPLES: Final = 24  # crank angles of a turn at which a bound takes the acceleration
# Preferred coordinates where the objective does not decide: guide, pivots and coupler short, the
# ram's line in the middle.
PREFERRED: Final = ((1, 0.0), (2, 0.0), (3, 0.0), (4, 0.5))
SAMPLES_OF_BOX: Final = 1024  # random points before the descent
STARTS: Final = 4  # of these points, starts of a descent
ROUNDS: Final = 60  # of a descent
RADIUS: Final = 0.2  # of its first trust region, in the unit box
BATCH: Final = 1500  # boxes of a round
MAX_BOXES: Final = 60_000  # in all
MIDDLES: Final = 32  # boxes of a round whose middles are evaluated
WIDE: Final = 0.05  # weight of a box's width beside its slopes in the choice of the split


@dataclass(frozen=True, eq=False)
class SearchResult:
    """The best point and the bound.

    Attributes:
        u: the point, (5,); None: none was found. value: of the objective there.
        bound: no feasible shaper has a smaller value; inf: there is no feasible shaper.
    """

    u: Array | None
    value: float
    bound: float


def global_minimum(
    space: DesignSpace, objective: ShaperObjective, tolerance: float, deadline: float | None
) -> SearchResult:
    """The best shaper, to a relative gap where time allows (``deadline``: ``time.monotonic()``)."""
    low, high = space.span()
    if low > high:
        return SearchResult(None, np.inf, np.inf)
    with np.errstate(all="ignore"):
        found = _branch_and_bound(space, objective, _descend(space, objective), tolerance, deadline)
        if found.u is None:
            return found
        # Preferred coordinates wherever they do not cost anything.
        u, value = found.u, _values(space, objective, found.u[None])[0]
        for k, preferred in PREFERRED:
            other = u.copy()
            other[k] = preferred
            if _values(space, objective, other[None])[0] <= value * (1.0 + EXACT):
                u = other
        return replace(found, u=u)


def _values(space: DesignSpace, objective: ShaperObjective, u: Array) -> Array:
    """The objective at points (n, 5); inf where the coupler is too short."""
    one = space.at(list(u.T))
    values = objective.values(one)
    possible = (one.short <= EXACT * np.abs(one.coupler)) & np.isfinite(values)
    return np.asarray(np.where(possible, values, np.inf))


def _descend(space: DesignSpace, objective: ShaperObjective) -> BundlePoint | None:
    """The best of some random points, improved by a bundle method (``numerics.bundle_method``)."""
    rng = np.random.default_rng(3)
    u = np.vstack(
        [rng.random((SAMPLES_OF_BOX, SIZE)), rng.integers(0, 2, (SAMPLES_OF_BOX // 8, SIZE))]
    )
    values = np.concatenate([_values(space, objective, part) for part in np.array_split(u, 32)])
    order = np.argsort(values)[:STARTS]
    starts = [BundlePoint(u[k], float(values[k])) for k in order if np.isfinite(values[k])]
    if not starts:
        return None

    def function(at: Array) -> float | None:
        value = float(_values(space, objective, np.clip(at, 0.0, 1.0)[None])[0])
        return value if np.isfinite(value) else None

    box = Polytope(np.zeros((0, SIZE)), np.zeros(0))
    ends = [minimise(function, box, start, RADIUS, ROUNDS) for start in starts]
    reached = min(ends, key=lambda one: one.value)
    return BundlePoint(np.clip(reached.u, 0.0, 1.0), reached.value)


def _branch_and_bound(
    space: DesignSpace,
    objective: ShaperObjective,
    found: BundlePoint | None,
    tolerance: float,
    deadline: float | None,
) -> SearchResult:
    """The bound, and better points at the middles of boxes."""
    u, value = (None, np.inf) if found is None else (found.u, found.value)
    phi = _angles(objective, space, u)
    # Lower and upper corners of open boxes, and their bounds so far; least bound of pruned boxes.
    waiting = (np.zeros((1, SIZE)), np.ones((1, SIZE)), np.array([-np.inf]))
    left_out, count = np.inf, 0
    while (
        len(waiting[0]) and count < MAX_BOXES and (deadline is None or time.monotonic() < deadline)
    ):
        # Best first: the boxes with the least bounds.
        order = np.argsort(waiting[2])[:BATCH]
        rest = np.setdiff1d(np.arange(len(waiting[2])), order)
        lo, hi = waiting[0][order], waiting[1][order]
        count += len(lo)
        lower, split = _bounds(space, objective, lo, hi, phi)
        lower = np.maximum(lower, waiting[2][order])
        # Incumbent: the middles of the most promising boxes.
        middle = 0.5 * (lo + hi)[np.argsort(lower)[:MIDDLES]]
        values = _values(space, objective, middle)
        if values.min() < value:
            u, value = middle[values.argmin()], float(values.min())
        # Prune boxes that cannot improve the incumbent by more than the tolerance; their bound
        # counts.
        enough = value - tolerance * abs(value) if np.isfinite(value) else np.inf
        done = lower >= enough
        left_out = min(left_out, float(np.min(lower, where=done, initial=np.inf)))
        halves = _bisect(lo[~done], hi[~done], split[~done], lower[~done])
        waiting = tuple(np.concatenate([a[rest], b]) for a, b in zip(waiting, halves, strict=True))  # type: ignore[assignment]
    bound = min(left_out, float(np.min(waiting[2], initial=np.inf)))
    return SearchResult(u, value, bound)


def _angles(objective: ShaperObjective, space: DesignSpace, u: Array | None) -> list[float]:
    """Crank angles for the bound: evenly over the turn, more where the best point has peaks."""
    if not objective.angles:
        return []
    phi = FULL_TURN * np.arange(SAMPLES) / SAMPLES
    if u is not None:
        over = objective.over_turn(space.at([np.array([x]) for x in u]))[:, 0]
        for part in over:
            phi = np.append(phi, DENSE[np.argmax(part)] + 0.05 * np.arange(-3, 4))
    return [float(each) for each in phi]


def _bounds(
    space: DesignSpace, objective: ShaperObjective, lo: Array, hi: Array, phi: list[float]
) -> tuple[Array, Array]:
    """A lower bound on every box, inf where nothing is feasible, and the coordinate to split."""
    # Affine models of the shapers on the boxes; |sin γ| ≤ k narrows them.
    k = space.steep
    one = replace(space.at(Affine.variables(lo, hi)), narrow=lambda sine: sine.restrict(-k, k))
    parts = objective.lower_bounds(one, phi or [0.0], space.lengths["ram_line_mm"])
    lows = np.stack([part.lower for part in parts])
    lows = np.where(np.isfinite(lows), lows, -np.inf)
    which = np.argmax(lows, axis=0)
    lower, rows = np.max(lows, axis=0), np.arange(len(lo))
    slopes = np.abs(np.stack([part.g for part in parts]))[which, :, rows]
    rem = np.stack([part.rem for part in parts])[which, rows]
    # Where nothing is known yet, split what makes the coupler's angle uncertain.
    steep = np.abs(one.level.g.T) + np.abs(one.level_at_ends.g.T)
    known = np.isfinite(lower)[:, None]
    slopes, rem = np.where(known, slopes, steep), np.where(known[:, 0], rem, 0.0)
    spread = (rem + np.sum(slopes, axis=1))[:, None]
    split = np.argmax(slopes + WIDE * spread * (hi - lo), axis=1)
    # Objectives are not negative.
    return np.where(one.short.lower > 0.0, np.inf, np.maximum(lower, 0.0)), split


def _bisect(lo: Array, hi: Array, split: Array, lower: Array) -> tuple[Array, Array, Array]:
    """Every box cut in half at its coordinate."""
    rows = np.arange(len(lo))
    middle = 0.5 * (lo + hi)[rows, split]
    left, right = hi.copy(), lo.copy()
    left[rows, split], right[rows, split] = middle, middle
    return np.concatenate([lo, right]), np.concatenate([left, hi]), np.concatenate([lower, lower])
