"""Amplitude of the free vibration that a run leaves behind, from the oscillator's equation.

The output z of a follower train on a spring and a damper obeys z'' + 2ζν z' + ν² z = ν² s + 2ζν s'.
On a short step the Taylor coefficients of z follow from those of s by a recurrence, and the
remainder is bounded by a geometric series. Steps are chained by the exact free response of the
state (z − s, z'). The optimiser integrates against a kernel instead; neither formula is shared.
"""

from __future__ import annotations

from math import exp, hypot, sqrt
from typing import Final

import numpy as np

from synthesis.catalogue.constraints import VibrationBound
from synthesis.certify.piecewise_motion import PiecewiseMotion
from synthesis.numerics.box_search import Boxes
from synthesis.numerics.enclosure import Enclosure
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

STEP: Final = 0.5  # largest phase of the oscillator, or of a law's sinusoid, in one step [rad]
ORDER: Final = 18  # of the Taylor series on a step: 0.5^18/18! is below a rounding error
UNIT_ROUNDOFF: Final = 2.0**-53  # of double precision, relative
ROUNDINGS: Final = 64.0  # of the largest term of a step, in the sum of its series


def residual_amplitude(motion: PiecewiseMotion, run: VibrationBound) -> Enclosure:
    """The amplitude at the end of a run, and the cam angle there."""
    nu, zeta = run.frequency, run.damping
    damped = nu * sqrt(1.0 - zeta**2)
    steps = _steps(motion, run)
    forced, missed, scale = _step_responses(motion, run, steps)
    state, error = np.zeros(2), 0.0  # z − s and z'; error of ν |z − s| + |z'|
    for k, length in enumerate(steps.hi - steps.lo):
        state = _free_response(run, float(length)) @ state + forced[:, k]
        # the energy of a free vibration never grows, so neither do errors of earlier steps
        rounding = scale[k] + nu * abs(state[0]) + abs(state[1])
        error += missed[k] + ROUNDINGS * UNIT_ROUNDOFF * rounding
    value = hypot(state[0], (state[1] + zeta * nu * state[0]) / damped)
    # √2 of the norm suffices for the amplitude; the rest covers the roundings of its formula
    blur = float(2.0 * error / damped)
    angle = float(steps.hi[-1]) % FULL_TURN
    return Enclosure(value, max(value - blur, 0.0), value + blur, angle)


def _steps(motion: PiecewiseMotion, run: VibrationBound) -> Boxes:
    """Equal steps of each piece, none longer than ``STEP`` of the fastest oscillation on it."""
    breaks, waves = motion.curve.breaks, np.abs(motion.curve.waves[:, :, 1])
    fastest = np.maximum(run.frequency, waves.max(axis=1, initial=0.0))
    counts = np.maximum(np.ceil(fastest * np.diff(breaks) / STEP), 1.0).astype(np.intp)
    pieces = np.concatenate([motion.pieces_of([index]) for index in run.run])
    return Boxes.from_spans(pieces, breaks[pieces], breaks[pieces + 1], counts)


def _step_responses(
    motion: PiecewiseMotion, run: VibrationBound, steps: Boxes
) -> tuple[Array, Array, Array]:
    """State at the end of every step that starts at rest on the motion, z = s and z' = 0.

    Returns:
        (2, n) z − s and z' there; (n,) bounds of the remainder; (n,) size of the largest terms.
        The last two are norms ν |z − s| + |z'|.
    """
    nu, zeta, h = run.frequency, run.damping, steps.hi - steps.lo
    # Taylor coefficients of s times h^k, without s at the start of the step
    s, factor = motion.curve.jet(steps.lo, steps.piece, ORDER + 1), np.ones_like(h)
    s[0] = 0.0
    for k in range(1, ORDER + 2):
        factor = factor * h / k
        s[k] *= factor
    # those of z by the recurrence: coefficient k + 2 of z'' from the coefficients k of the rest
    z = np.zeros((ORDER + 1, len(h)))
    for k in range(ORDER - 1):
        force = (nu * h) ** 2 * s[k] + 2.0 * zeta * nu * h * (k + 1) * s[k + 1]
        inner = 2.0 * zeta * nu * h * (k + 1) * z[k + 1] + (nu * h) ** 2 * z[k]
        z[k + 2] = (force - inner) / ((k + 1) * (k + 2))
    rates = np.arange(ORDER + 1)[:, None] * z / h
    forced = np.stack([np.sum(z - s[:-1], axis=0), np.sum(rates, axis=0)])
    # coefficients at least halve from one to the next (νh ≤ 1/2), so the rest is below the last
    tail = np.maximum(np.abs(z[-1]), np.abs(z[-2])) + np.abs(s[ORDER + 1]) + np.abs(s[ORDER])
    missed = tail * (nu + ORDER / h)
    scale = np.max(nu * (np.abs(z) + np.abs(s[:-1])) + np.abs(rates), axis=0)
    return forced, missed, scale + _cancellation(motion, steps, nu)


def _cancellation(motion: PiecewiseMotion, steps: Boxes, nu: float) -> Array:
    """Size of the terms whose sums are the coefficients of s (n,), as ν |z| + |z'|."""
    h = steps.hi - steps.lo
    away = np.abs(steps.lo - motion.curve.origins[steps.piece]) + h
    found, factor = np.zeros_like(h), np.ones_like(h)
    for k in range(1, ORDER):
        factor = factor * h / k
        found += motion.curve.bound_derivative(steps.piece, away, k) * factor * (nu + k / h)
    return found


def _free_response(run: VibrationBound, length: float) -> Array:
    """The state (z, z') of a free vibration after ``length``, from that before: (2, 2)."""
    nu, zeta = run.frequency, run.damping
    damped = nu * sqrt(1.0 - zeta**2)
    decay, sine = exp(-zeta * nu * length), np.sin(damped * length)
    cosine, share = np.cos(damped * length), zeta * nu / damped * sine
    free = [[cosine + share, sine / damped], [-(nu**2) / damped * sine, cosine - share]]
    return np.asarray(decay * np.array(free))
