"""What the finished motion leaves an oscillator ringing with, proven from its equation of motion.

The output z of a train on a spring and a damper obeys z'' + 2ζν z' + ν² z = ν² s + 2ζν s'. On a
short step its Taylor coefficients follow from those of s by a recurrence, and what is left out
is bounded by a geometric series. Steps are joined by the state (z, z'), seen from the cam's end of
the train. Nothing here is an integral against a kernel, which the formulations use.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, hypot, sqrt
from typing import Final

import numpy as np

from synthesis.certify.course import Course, Indices
from synthesis.numerics.enclosure import Enclosed
from synthesis.numerics.piecewise import Array
from synthesis.terms import Ringing
from synthesis.units import FULL_TURN

STEP: Final = 0.5  # rad of the swing, or of a law's own waves, at most
TERMS: Final = 18  # of a Taylor series
UNIT: Final = 2.0**-53
ROUNDINGS: Final = 64.0  # of the largest term of a step, in its sum


@dataclass(frozen=True, eq=False)
class _Steps:
    """The run cut into steps: θ where each begins (n,), its piece, its length."""

    theta: Array
    piece: Indices
    length: Array


def left_ringing(course: Course, ring: Ringing) -> Enclosed:
    """The amplitude where a run ends, and the cam angle of that."""
    steps = _steps(course, ring)
    forced, missed, scale = _series(course, ring, steps)
    nu, zeta = ring.frequency, ring.damping
    state, error = np.zeros(2), 0.0  # z − s and z'
    for k, length in enumerate(steps.length):
        state = _free(ring, float(length)) @ state + forced[:, k]
        # the energy of a free swing never grows, so errors of earlier steps do not either
        error += missed[k] + ROUNDINGS * UNIT * (scale[k] + nu * abs(state[0]) + abs(state[1]))
    damped = nu * sqrt(1.0 - zeta**2)
    value = hypot(state[0], (state[1] + zeta * nu * state[0]) / damped)
    blur = float(2.0 * error / damped + 8.0 * UNIT * value)
    angle = (steps.theta[-1] + steps.length[-1]) % FULL_TURN
    return Enclosed(value, max(value - blur, 0.0), value + blur, float(angle))


def _steps(course: Course, ring: Ringing) -> _Steps:
    theta, piece, length = [], [], []
    for index in ring.run:
        for k in course.pieces([index]).tolist():
            low, high = course.curve.breaks[k], course.curve.breaks[k + 1]
            waves = float(np.max(np.abs(course.curve.waves[k, :, 1]), initial=0.0))
            fastest = max(ring.frequency, waves)
            count = max(int(np.ceil(fastest * (high - low) / STEP)), 1)
            ends = np.linspace(low, high, count + 1)
            theta.append(ends[:-1])
            length.append(np.diff(ends))
            piece.append(np.full(count, k))
    return _Steps(np.concatenate(theta), np.concatenate(piece), np.concatenate(length))


def _series(course: Course, ring: Ringing, steps: _Steps) -> tuple[Array, Array, Array]:
    """What every step adds to the state at its end, from rest at its beginning.

    Rest is z = s and z' = 0, so that y = z − s(start) is what the series is of.

    Returns:
        (2, n) additions to z − s and z'; (n,) what they miss; (n,) size of the largest terms, both
        as ν |z| + |z'|.
    """
    nu, zeta, h = ring.frequency, ring.damping, steps.length
    derivatives = course.curve.jet(steps.theta, steps.piece, TERMS + 1)
    s = np.zeros_like(derivatives)  # Taylor coefficients times h^k, s(start) left out
    factor = np.ones_like(h)
    for k in range(1, TERMS + 2):
        factor = factor * h / k
        s[k] = derivatives[k] * factor
    y = np.zeros((TERMS + 1, len(h)))
    for k in range(TERMS - 1):
        force = (nu * h) ** 2 * s[k] + 2.0 * zeta * nu * h * (k + 1) * s[k + 1]
        swing = 2.0 * zeta * nu * h * (k + 1) * y[k + 1] + (nu * h) ** 2 * y[k]
        y[k + 2] = (force - swing) / ((k + 1) * (k + 2))
    rates = np.arange(TERMS + 1)[:, None] * y / h
    forced = np.stack([np.sum(y - s[:-1], axis=0), np.sum(rates, axis=0)])
    tail = np.maximum(np.abs(y[-1]), np.abs(y[-2])) + np.abs(s[TERMS + 1]) + np.abs(s[TERMS])
    missed = tail * (nu + TERMS / h)
    scale = np.max(nu * (np.abs(y) + np.abs(s[:-1])) + np.abs(rates), axis=0)
    return forced, missed, scale + _cancelled(course, steps, nu)


def _cancelled(course: Course, steps: _Steps, nu: float) -> Array:
    """Size of the terms from which the coefficients of s were summed: (n,) as ν |z| + |z'|."""
    away = np.abs(steps.theta - course.curve.origins[steps.piece]) + steps.length
    found, factor = np.zeros_like(steps.length), np.ones_like(steps.length)
    for k in range(1, TERMS):
        factor = factor * steps.length / k
        found += course.curve.bound(steps.piece, away, k) * factor * (nu + k / steps.length)
    return found


def _free(ring: Ringing, length: float) -> Array:
    """The state (z, z') of a free swing after ``length``, from that before: (2, 2)."""
    nu, zeta = ring.frequency, ring.damping
    damped = nu * sqrt(1.0 - zeta**2)
    decay, sine = exp(-zeta * nu * length), np.sin(damped * length)
    cosine, share = np.cos(damped * length), zeta * nu / damped * sine
    return np.asarray(
        decay * np.array([[cosine + share, sine / damped],
                          [-(nu**2) / damped * sine, cosine - share]])
    )  # fmt: skip
