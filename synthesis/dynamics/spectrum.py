"""The residual spectrum of a motion: what every natural frequency would be left swinging with."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np

from synthesis.dynamics.phi import Complex, phi
from synthesis.dynamics.response import Steps
from synthesis.limits.residual_vibration import runs
from synthesis.motion import Motion, Stretch
from synthesis.numerics.piecewise import Array


def residuals(motion: Motion, run: Sequence[int], frequencies: Array, damping: float) -> Array:
    """Amplitude where a run of stretches ends, of an oscillator at rest before it.

    Exact but for rounding: over every step ∫ s' e^(−λ(Θ − θ)) dθ is a sum of φ-functions.

    Args:
        motion: the settled motion. run: indices of its stretches, in order.
        frequencies: (f,) undamped, in swings per radian of the cam times 2π, ω_n/ω.
        damping: ζ.

    Returns:
        (f,) amplitudes in the unit of s.
    """
    steps = Steps.of(motion, 1)
    rate: Complex = np.asarray(frequencies * complex(damping, -sqrt(1.0 - damping**2)), complex)
    total, after = np.zeros(len(frequencies), complex), 0.0
    by_index = {s.index: s for s in motion.stretches}
    for index in reversed(run):
        stretch = by_index[index]
        total += _moved(steps, stretch, rate) * np.exp(-rate * after)
        after += stretch.angle
    return np.asarray(np.abs(total) / sqrt(1.0 - damping**2))


def _moved(steps: Steps, stretch: Stretch, rate: Complex) -> Array:
    """∫ s' e^(−λ(end − θ)) dθ over one stretch: (f,)."""
    middle = 0.5 * (steps.theta[1:] + steps.theta[:-1])
    inside = (middle > stretch.start) & (middle < stretch.end) & (np.diff(steps.theta) > 0.0)
    width, taylor = np.diff(steps.theta)[inside], steps.taylor[:, inside]
    sizes, which = np.unique(width, return_inverse=True)
    functions = phi(np.multiply.outer(-rate, sizes), len(taylor) - 1)
    each = sum(functions[k][:, which] * taylor[k] for k in range(1, len(taylor)))
    left = stretch.end - steps.theta[1:][inside]
    return np.asarray(np.sum(each * np.exp(-np.multiply.outer(rate, left)), axis=1))


def moves(motion: Motion) -> tuple[tuple[int, ...], ...]:
    """The runs between the dwells of a motion."""
    return runs(motion.stretches)
