"""Half-planes of nonconvex limits on given laws: a semi-infinite system, one for every cam angle.

Only a few of them bind. Those that a size breaks most are found by sampling every piece and
zooming in on each local maximum; the closed form adds them in turn (an exchange method).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from synthesis.catalogue.constraints import NonconvexConstraint, Vector
from synthesis.numerics.piecewise import Array, Indices, Piecewise
from synthesis.optimise.problem.problem import Problem

DENSITY = 24  # samples of a piece; a law of many pieces needs fewer on each
LEAST_DENSITY = 8  # points of a piece, so that none is missed on short ones
FAN, NARROWER = np.linspace(-1.0, 1.0, 33), 16.0
"""Places about the highest sample, in steps between samples: a zoom narrows these as much."""
ZOOMS = 2  # to 1/256 of such a step; then a parabola is exact to its square, the value to rounding
NEAR = 1e-6  # of the size: half-planes satisfied by more than this are left out
TOPS = 4  # local maxima of a family that are looked at closely


class HalfPlanes(NamedTuple):
    """Half-planes normals · z ≤ offsets, (k, n_size) and (k,), and by how much z breaks each."""

    normals: Array
    offsets: Array
    excess: Array


def join(parts: Iterable[HalfPlanes], sizes: int) -> HalfPlanes:
    """All of several sets, of so many size variables each; there may be none."""
    nothing = HalfPlanes(np.zeros((0, sizes)), np.zeros(0), np.zeros(0))
    return HalfPlanes(*map(np.concatenate, zip(nothing, *parts, strict=True)))


def most_violated(problem: Problem, z: Vector) -> HalfPlanes:
    """Of every curved limit the half-planes that stand out at a size, on given segments.

    Those that are clearly kept are left out. ``excess`` is left less right side over the normal's
    length [length].
    """
    near = -NEAR * max(problem.length, *map(abs, z))
    placed = {s.index: s.placed() for s in problem.segments if s.law is not None}
    each = (
        local_maxima(curve, placed[segment.index], np.array(z), near)
        for segment in problem.segments
        if segment.law is not None
        for curve in problem.curved_limits_on(segment)
    )
    return join(each, len(z))


def local_maxima(
    curve: NonconvexConstraint, placed: Piecewise, z: Array, above: float = -np.inf
) -> HalfPlanes:
    """Half-planes at the few highest local maxima of every family of them.

    ``above``: excess [length] that a maximum has to come to, or may, to be looked at: between two
    samples there is none that tops them by more than they differ from the next.
    """
    density = max(LEAST_DENSITY, min(DENSITY, 192 // placed.count))
    step = np.linspace(0.0, 1.0, density)
    theta = placed.breaks[:-1, None] + np.diff(placed.breaks)[:, None] * step
    piece = np.repeat(np.arange(placed.count), density)
    planes = _planes(curve, placed, theta.ravel(), piece, z)
    if not len(planes.excess):
        return planes  # a limit that is checked on finished sizes alone
    value = planes.excess.reshape(-1, *theta.shape)
    padded = np.pad(value, ((0, 0), (0, 0), (1, 1)), mode="reflect")
    before, after = padded[..., :-2], padded[..., 2:]
    top = (value >= before) & (value >= after)
    steps = value - np.minimum(before, after)
    # of every family the few highest
    tops = np.where(top, value, -np.inf).reshape(len(value), -1)
    threshold = np.sort(tops, axis=1)[:, -min(TOPS, tops.shape[1])]
    family, on, column = np.nonzero(
        top & (value >= threshold[:, None, None]) & (value + steps > above)
    )
    if not len(family):
        return HalfPlanes(*(part[:0] for part in planes))
    at, reach = theta[on, column], (np.diff(placed.breaks) / (density - 1))[on]
    low, high = placed.breaks[on], placed.breaks[on + 1]
    each, wide = np.arange(len(at)), np.repeat(on, len(FAN))
    for _ in range(ZOOMS):
        tried = np.clip(at[:, None] + reach[:, None] * FAN, low[:, None], high[:, None])
        planes = _planes(curve, placed, tried.ravel(), wide, z)
        value = planes.excess.reshape(-1, *tried.shape)[family, each]
        best = value.argmax(axis=1)
        at, reach = tried[each, best], reach / NARROWER
    # The vertex of the parabola through the highest and its neighbours, where that is higher still.
    middle = np.clip(best, 1, len(FAN) - 2)
    before, here, after = (value[each, middle + k] for k in (-1, 0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = np.clip(0.5 * (after - before) / (2.0 * here - before - after), -1.0, 1.0)
    vertex = np.clip(tried[each, middle] + np.nan_to_num(shift) * reach, low, high)
    result = _planes(curve, placed, np.append(at, vertex), np.append(on, on), z)
    mine = 2 * family * len(at) + each
    mine = np.where(result.excess[mine + len(at)] > result.excess[mine], mine + len(at), mine)
    return HalfPlanes(*(part[mine] for part in result))


def _planes(
    curve: NonconvexConstraint, placed: Piecewise, theta: Array, piece: Indices, z: Array
) -> HalfPlanes:
    """All families at given angles, one family after the other."""
    s = np.zeros((4, len(theta)))
    s[: curve.order + 1] = placed.jet(theta, piece, curve.order)
    families = curve.half_planes(s)
    normals = np.concatenate([np.zeros((0, len(z))), *(cuts.size.T for cuts in families)])
    offsets = np.concatenate([np.zeros(0), *(cuts.upper for cuts in families)])
    length = np.linalg.norm(normals, axis=1)
    normals, offsets = normals / length[:, None], offsets / length
    return HalfPlanes(normals, offsets, normals @ z - offsets)
