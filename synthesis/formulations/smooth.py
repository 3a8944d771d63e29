"""Limits that are not convex, on settled motion: worst violation, and growing out of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from synthesis.formulations.problem import Problem
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array

Vector = tuple[float, ...]
DENSITY = 16  # points on every piece of a law, ends included
WATCHED = -0.7  # points that are slacker than this at first are not looked at while growing


@dataclass(frozen=True, eq=False)
class Samples:
    """One stretch sampled densely and one-sided at breaks: s to s''' (4, n) and θ (n,)."""

    stretch: Stretch
    theta: Array
    s: Array

    def at(self, keep: Array) -> Samples:
        """Only the points marked."""
        return Samples(self.stretch, self.theta[keep], self.s[:, keep])


def sample(problem: Problem) -> list[Samples]:
    """Every stretch of a settled problem."""
    found = []
    for stretch in problem.stretches:
        curve = stretch.placed()
        density = 2 if stretch.kind == "dwell" else max(DENSITY, 192 // curve.count)
        step = np.linspace(0.0, 1.0, density)
        theta = (curve.breaks[:-1, None] + np.diff(curve.breaks)[:, None] * step).ravel()
        piece = np.repeat(np.arange(curve.count), density)
        s = np.stack([curve.at(theta, piece, order) for order in range(4)])
        found.append(Samples(stretch, theta, s))
    return found


def _expressions(problem: Problem, samples: Samples, size: Vector) -> Iterator[Array]:
    for limit in problem.limits:
        for value in limit.smooth(samples.stretch, problem.machine, samples.s, size):
            yield np.broadcast_to(np.asarray(value, dtype=float), samples.theta.shape)


def violation(problem: Problem, samples: list[Samples], size: Vector) -> float:
    """Largest value of the smooth expressions (≤ 0: all hold); −inf where there are none."""
    worst = -np.inf
    for part in samples:
        for value in _expressions(problem, part, size):
            worst = max(worst, float(np.max(np.where(np.isnan(value), np.inf, value))))
    return worst


def grown(problem: Problem, size: Vector, margin: float) -> Vector | None:
    """The size raised as little as needed for the smooth limits to hold by ``margin``.

    Raising enlarges the prime radius and lowers pressure angle and curvature alike; None where
    even the largest size allowed does not do.
    """
    samples = sample(problem)
    follower = problem.machine.follower
    room = follower.room(size, problem.sizing)

    def excess(raised: float) -> float:
        return violation(problem, watched, follower.raised(size, raised)) + margin

    watched = samples
    if excess(0.0) <= 0.0:
        return size
    keep = [
        np.max(np.stack(list(_expressions(problem, part, size))), axis=0) > WATCHED
        for part in samples
    ]
    watched = [p.at(k) for p, k in zip(samples, keep, strict=True) if np.any(k)]
    low, step = 0.0, 1e-6 * problem.length
    while excess(min(step, room)) > 0.0:
        if step >= room:
            return None
        low, step = step, 4.0 * step
    high = _crossing(excess, low, min(step, room))
    watched = samples
    return follower.raised(size, high) if excess(high) <= 0.0 else None


def _crossing(excess: object, low: float, high: float) -> float:
    """A point where ``excess`` is not positive, within 1e-9 relative of where it crosses zero."""
    assert callable(excess)
    f_low, f_high = excess(low), excess(high)
    for _ in range(60):
        if high - low <= 1e-9 * high:
            break
        share = f_low / (f_low - f_high) if np.isfinite(f_low) else 0.5
        middle = low + min(max(share, 0.05), 0.95) * (high - low)
        value = excess(middle)
        if value > 0.0:
            low, f_low = middle, value
        else:
            high, f_high = middle, value
    return high


def reached(problem: Problem, size: Vector) -> tuple[float, float]:
    """Least and largest curvature of the pitch curve on the largest cam with these laws [1/mm]."""
    follower = problem.machine.follower
    largest = follower.raised(size, follower.room(size, problem.sizing))
    values = []
    for part in sample(problem):
        numerator, speed_squared = follower.curvature_terms(part.s, largest)
        values.append(numerator / speed_squared**1.5)
    curvature = np.concatenate(values)
    return float(np.min(curvature)), float(np.max(curvature))
