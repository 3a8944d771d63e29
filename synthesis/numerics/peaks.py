"""Largest value of a linear combination of a function's derivatives, found in floating point.

Fast and accurate to rounding, but a finding, not a proof: proofs are the certificate's business.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synthesis.numerics.piecewise import Array, Piecewise

SAMPLES = 24


def peak(curve: Piecewise, coefficients: Sequence[float]) -> tuple[float, float]:
    """Largest value of Σ_k coefficients[k] f^(k) over the closed pieces, and where.

    Every piece is sampled; around each sample that is not below its neighbours Newton's method
    finds the stationary point, kept only within the neighbours.

    Returns:
        value and x.
    """
    weights = [(k, c) for k, c in enumerate(coefficients) if c != 0.0]
    if not weights:
        return 0.0, float(curve.breaks[0])
    samples = SAMPLES if curve.waves.shape[1] or curve.poly.shape[1] > 6 else 5
    left, width = curve.breaks[:-1], np.diff(curve.breaks)
    step = np.linspace(0.0, 1.0, samples)
    x: Array = (left[:, None] + width[:, None] * step).ravel()
    piece = np.repeat(np.arange(curve.count), samples)

    def combined(at: Array, on: np.ndarray, raised: int) -> Array:
        total = np.zeros_like(at)
        for k, c in weights:
            total += c * curve.at(at, on, k + raised)
        return total

    value = combined(x, piece, 0)
    best = int(np.argmax(value))
    spread = float(value[best] - value.min())
    # a stationary point between two samples can top its neighbours by no more than their spread
    table = value.reshape(curve.count, samples)
    rough = np.max(np.abs(np.diff(table, axis=1)), axis=1) + 1e-15 * spread
    keep = np.repeat(table.max(axis=1) + rough >= value[best], samples)
    y, on = x[keep], piece[keep]
    half = (width[on] / (samples - 1)) if samples > 1 else width[on]
    low, high = np.maximum(y - half, left[on]), np.minimum(y + half, left[on] + width[on])
    for _ in range(4):
        slope, bend = combined(y, on, 1), combined(y, on, 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            move = np.where(bend < 0.0, -slope / bend, 0.0)
        y = np.clip(y + np.nan_to_num(move), low, high)
    refined = combined(y, on, 0)
    top = int(np.argmax(refined))
    if refined[top] > value[best]:
        return float(refined[top]), float(y[top])
    return float(value[best]), float(x[best])
