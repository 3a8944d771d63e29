"""Half-planes of curved limits on settled laws: there is one at every cam angle.

Only a few of them bind. Those that a size breaks most are found by sampling every piece and
zooming in on each local maximum; the closed form adds them and is asked again (an exchange method).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synthesis.formulations.problem import Problem
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.terms import Curved, Cuts, Vector

Indices = NDArray[np.intp]
DENSITY = 24  # samples of a piece; a law of many pieces needs fewer on each
LEAST_DENSITY = 8
ZOOMS, NARROWER, FAN = 7, 8.0, np.linspace(-1.0, 1.0, 17)
CLEAR = 0.25  # of the size: half-planes that are farther away at every sample bind nowhere
TOPS = 4  # local maxima of a family that are looked at closely


@dataclass(frozen=True, eq=False)
class Planes:
    """Half-planes normals · z ≤ offsets, (k, n_size) and (k,), and by how much z breaks each."""

    normals: Array
    offsets: Array
    excess: Array


def tightest(problem: Problem, z: Vector) -> Planes:
    """Of every curved limit the half-planes that stand out at a size, on settled stretches.

    ``excess`` is left less right side over the normal's length [mm].
    """
    found = [part for stretch in problem.stretches if stretch.law is not None
             for curve in problem.curves_on(stretch)
             for part in _peaks(curve, stretch.placed(), np.array(z))]  # fmt: skip
    if not found:
        return Planes(np.zeros((0, len(z))), np.zeros(0), np.zeros(0))
    return Planes(*(np.concatenate(column) for column in zip(*found, strict=True)))


def _peaks(curve: Curved, placed: Piecewise, z: Array) -> Iterator[tuple[Array, Array, Array]]:
    """Normals, offsets and excess at the local maxima of every family of half-planes."""
    density = max(LEAST_DENSITY, min(DENSITY, 192 // placed.count))
    step = np.linspace(0.0, 1.0, density)
    theta = placed.breaks[:-1, None] + np.diff(placed.breaks)[:, None] * step
    piece = np.repeat(np.arange(placed.count), density)
    families = curve.half_planes(_motion(curve, placed, theta.ravel(), piece))
    for number, cuts in enumerate(families):
        value = _excess(cuts, z).reshape(theta.shape)
        if np.max(value) < -CLEAR * np.linalg.norm(z):
            continue
        padded = np.pad(value, ((0, 0), (1, 1)), constant_values=-np.inf)
        top = (value >= padded[:, :-2]) & (value >= padded[:, 2:])
        on, column = np.nonzero(top & (value >= _threshold(value[top])))

        def at(angle: Array, on: Indices, number: int = number) -> Cuts:
            return curve.half_planes(_motion(curve, placed, angle, on))[number]

        ends = placed.breaks[on], placed.breaks[on + 1]
        theta_top = _zoomed(at, z, theta[on, column], on, ends, density)
        cuts = at(theta_top, on)
        length = np.linalg.norm(cuts.size, axis=0)
        yield cuts.size.T / length[:, None], cuts.upper / length, _excess(cuts, z)


def _threshold(values: Array) -> float:
    """The TOPS-th largest value."""
    return float(np.sort(values)[-min(TOPS, len(values))])


def _zoomed(
    at: Callable[[Array, Indices], Cuts],
    z: Array,
    theta: Array,
    on: Indices,
    ends: tuple[Array, Array],
    density: int,
) -> Array:
    """Angles moved to where their excess is largest between the neighbouring samples."""
    low, high = ends
    reach = (high - low) / (density - 1)
    for _ in range(ZOOMS):
        tried = np.clip(theta[:, None] + reach[:, None] * FAN, low[:, None], high[:, None])
        value = _excess(at(tried.ravel(), np.repeat(on, len(FAN))), z).reshape(tried.shape)
        theta = tried[np.arange(len(theta)), np.argmax(value, axis=1)]
        reach = reach / NARROWER
    return theta


def _motion(curve: Curved, placed: Piecewise, theta: Array, piece: Indices) -> Array:
    """The displacement and its derivatives, as far as the limit asks for them: (4, n)."""
    s = np.zeros((4, len(theta)))
    for order in range(curve.order + 1):
        s[order] = placed.at(theta, piece, order)
    return s


def _excess(cuts: Cuts, z: Array) -> Array:
    """How far z is outside of every half-plane [mm]."""
    return np.asarray((z @ cuts.size - cuts.upper) / np.linalg.norm(cuts.size, axis=0))
