"""Rows implied by a norm of the size that may not be too small, over a box of sizes.

‖y‖ ≥ least is not convex, but over a box every y_k² lies below its chord, so that the chords
together are no less than least²: a row that is exact at the corners, the tighter the narrower the
box.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from synthesis.catalogue.constraints import AffineNorm
from synthesis.optimise.conic.linear_rows import LinearBlock, Scales
from synthesis.optimise.problem.problem import Problem


def reverse_convex_rows(
    problem: Problem, sizes: Sequence[tuple[float, float]], scales: Scales
) -> Iterator[LinearBlock]:
    """What least norms of the problem's cones imply within ranges of the size [length]."""
    for cone in problem.norm_bounds:
        if cone.lower > 0.0:
            yield from outside_ball_rows(cone.norm, cone.lower, sizes, scales)
    if problem.sizing.min_norm > 0.0:
        yield from outside_ball_rows(
            problem.machine.follower.radius_norm(), problem.sizing.min_norm, sizes, scales
        )


def outside_ball_rows(
    norm: AffineNorm, least: float, sizes: Sequence[tuple[float, float]], scales: Scales
) -> Iterator[LinearBlock]:
    """What a norm of the size from ``least`` on implies within ranges [length].

    −Σ (low + high) y ≤ −least² − Σ low · high, y = matrix · z + shift; none where all is far.
    """
    matrix, shift = np.array(norm.matrix), np.array(norm.shift)
    middle, half = np.array(sizes).mean(axis=1), 0.5 * np.ptp(np.array(sizes), axis=1)
    centre, reach = matrix @ middle + shift, np.abs(matrix) @ half
    low, high = centre - reach, centre + reach
    nearest = np.where((low < 0.0) & (high > 0.0), 0.0, np.minimum(np.abs(low), np.abs(high)))
    if np.sum(nearest**2) >= least**2 or not np.all(np.isfinite(reach)):
        return
    size = -(low + high) @ matrix * scales.size
    upper = -(least**2) - float(low @ high) + float((low + high) @ shift)
    unit = max(float(np.max(np.abs(size))), 1e-300)
    yield LinearBlock.of_size(size / unit, np.array([upper / unit]), "farther")
