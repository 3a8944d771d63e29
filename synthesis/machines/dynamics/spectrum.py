"""Residual spectrum of a motion: vibration left in oscillators of every natural frequency."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np

from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.machines.dynamics.phi import Complex, phi
from synthesis.machines.dynamics.response import Steps
from synthesis.numerics.piecewise import Array


def residual_spectrum(
    motion: Motion, run: Sequence[int], frequencies: Array, damping: float
) -> Array:
    """Residual amplitude at the end of a run of segments, of oscillators at rest before it.

    Exact but for rounding: within every step ∫ s' e^(−λ(Θ − θ)) dθ is a sum of φ-functions.

    Args:
        motion: the motion. run: indices of its segments, in order.
        frequencies: (f,) undamped natural frequencies over the cam's, ω_n/ω.
        damping: damping ratio ζ.

    Returns:
        (f,) amplitudes in the unit of s.
    """
    steps = Steps.of(motion, 1)
    rate: Complex = np.asarray(frequencies * complex(damping, -sqrt(1.0 - damping**2)), complex)
    total, after = np.zeros(len(frequencies), complex), 0.0
    by_index = {s.index: s for s in motion.segments}
    for index in reversed(run):
        segment = by_index[index]
        total += _segment_integral(steps, segment, rate) * np.exp(-rate * after)
        after += segment.angle
    return np.asarray(np.abs(total) / sqrt(1.0 - damping**2))


def _segment_integral(steps: Steps, segment: PlacedSegment, rate: Complex) -> Array:
    """∫ s' e^(−λ(end − θ)) dθ over one segment: (f,)."""
    middle = 0.5 * (steps.theta[1:] + steps.theta[:-1])
    inside = (middle > segment.start) & (middle < segment.end) & (np.diff(steps.theta) > 0.0)
    width, taylor = np.diff(steps.theta)[inside], steps.taylor[:, inside]
    sizes, which = np.unique(width, return_inverse=True)
    functions = phi(np.multiply.outer(-rate, sizes), len(taylor) - 1)
    each = sum(functions[k][:, which] * taylor[k] for k in range(1, len(taylor)))
    left = segment.end - steps.theta[1:][inside]
    return np.asarray(np.sum(each * np.exp(-np.multiply.outer(rate, left)), axis=1))
