"""Multipliers of a value that is held along a window: of all that are as good, the quietest.

Where a derivative is held, the ideal law has nothing to decide, so ψ should vanish there. The
multipliers of a spline's rows only make it small on average over the splines; between them it
swings, and the bound pays for every swing. Any other measure on the window is as valid, and one
with the same moments changes nothing outside of it.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from synthesis.formulations.bounds.switching import Switching
from synthesis.numerics.piecewise import Array

NODES = 33
SAMPLES = 3  # between two nodes


def quietening(
    psi: Switching, x: Array, part: tuple[float, float], factor: float, degree: int
) -> tuple[Array, Array]:
    """Masses to add to a held derivative's multipliers that make ψ small on its window.

    Args:
        psi: ψ as it stands. x: (r,) points of the present multipliers. part: the window.
        factor: of the derivative in its rows.
        degree: a mass at x contributes factor (x − τ)^degree / degree! to ψ, for τ < x.

    Returns:
        (n,) points and (n,) masses, whose moments up to that degree vanish.
    """
    low, high = part
    chebyshev = 0.5 - 0.5 * np.cos(np.pi * np.arange(NODES) / (NODES - 1))
    nodes = np.unique(np.clip(np.append(x, low + (high - low) * chebyshev), low, high))
    width = np.diff(nodes)
    shares = (np.arange(SAMPLES) + 0.5) / SAMPLES
    tau = (nodes[:-1, None] + width[:, None] * shares).ravel()
    weight = np.sqrt(np.repeat(width / (high - low), SAMPLES))
    unit = (high - low) ** degree / factorial(degree)
    reach = np.maximum(nodes - tau[:, None], 0.0) / (high - low)
    effect = weight[:, None] * (reach**degree if degree else (nodes > tau[:, None]))
    scaled = (nodes - low) / (high - low)
    moments = np.vander(scaled, degree + 1, increasing=True).T
    *_, directions = np.linalg.svd(moments)
    free = directions[degree + 1 :].T  # masses without moments
    found, *_ = np.linalg.lstsq(effect @ free, -weight * psi(tau), rcond=1e-10)
    return nodes, (free @ found) / (factor * unit)
