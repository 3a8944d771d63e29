"""Rows on the size from limits on a traced curve where the motion is given: dwells, given laws.

There only the size is open, so that a box of sizes is all that has to be known.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from synthesis.formulations.problem import Problem
from synthesis.formulations.rows import Block, Scales
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.terms import Cuts, Moving, Seen

SAMPLES = 48  # of a stretch
NEAR = -0.15  # a smooth limit above this, relative, is near to binding

Sizes = Sequence[tuple[float, float]]


def binding(problem: Problem, size: tuple[float, ...]) -> bool:
    """Whether a traced limit is near to binding on a given stretch at a size, or broken."""
    for stretch in problem.stretches:
        theta = _angles(problem, stretch)
        s = None if stretch.law is None else stretch.placed().derivatives(theta)
        for limit in () if s is None else problem.limits:
            if limit.traced(stretch, problem.machine):
                found = limit.smooth(stretch, problem.machine, theta, s, size)
                if any(np.max(value) > NEAR for value in found):
                    return True
    return False


def resting(problem: Problem, sizes: Sizes, scales: Scales) -> Iterator[Block]:
    """What traced limits imply on given stretches within a box of sizes [mm].

    Rows that all of the box keeps are left out.
    """
    for stretch in problem.stretches:
        if stretch.law is None:
            continue
        theta = _angles(problem, stretch)
        s = np.asarray(stretch.placed().derivatives(theta)[:3])
        for limit in problem.limits:
            for implied in limit.traced(stretch, problem.machine):
                low, high = _box(implied.seen, s, sizes)
                found = implied.cuts(low, high, None, Moving(theta, s, s))
                if found is not None:
                    yield from _block(found, s, sizes, scales, implied.source)


def _angles(problem: Problem, stretch: Stretch) -> Array:
    """Cam angles of a stretch at which its rows are written."""
    load = problem.machine.load
    bends = np.zeros(0) if load is None else load.process.breaks
    inner = bends[(bends > stretch.start) & (bends < stretch.end)]
    return np.union1d(np.linspace(stretch.start, stretch.end, SAMPLES + 1), inner)


def _box(seen: Seen, s: Array, sizes: Sizes) -> tuple[Array, Array]:
    """Bounds of X, u and e, (3, n), from those of the size: they are linear in it."""
    middle = np.mean(np.array(sizes), axis=1)
    half = 0.5 * np.ptp(np.array(sizes), axis=1)
    at = np.stack(seen.of(s, middle.tolist()))
    reach = (np.abs(np.array(seen.by)) @ half)[:, None]
    return at - reach, at + reach


def _block(cuts: Cuts, s: Array, sizes: Sizes, scales: Scales, source: str) -> Iterator[Block]:
    """The rows that a size of the box breaks, with the motion put in."""
    upper = cuts.upper - np.sum(cuts.coefficients[:3] * s, axis=0)
    ends = np.array(sizes)
    most = np.sum(np.maximum(cuts.size * ends[:, :1], cuts.size * ends[:, 1:]), axis=0)
    broken = most > upper
    if not np.any(broken):
        return
    rows = cuts.size[:, broken].T * scales.size
    unit = np.maximum(np.max(np.abs(rows), axis=1), 1e-300)
    yield Block(
        "size", None, None, np.zeros(len(rows)), np.zeros(4), rows / unit[:, None], 0.0,
        upper[broken] / unit, source,
    )  # fmt: skip
