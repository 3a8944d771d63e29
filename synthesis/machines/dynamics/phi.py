"""φ-functions of complex numbers: exact responses of linear systems to polynomial inputs.

φ_0(z) = e^z and φ_k(z) = ∫_0^1 e^((1−u) z) u^(k−1)/(k−1)! du, so that ξ' = λξ + Σ f_k t^k/k! over
a step h gives ξ(h) = e^(λh) ξ(0) + Σ f_k h^(k+1) φ_(k+1)(λh) (Hochbruck & Ostermann, Exponential
integrators, Acta Numerica 19, 2010).
"""

from __future__ import annotations

from math import factorial

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
TERMS = 22  # of the series in the unit disc, where the last is below rounding


def phi(z: Complex, highest: int) -> Complex:
    """φ_0 to φ_highest: (highest + 1, *z.shape).

    By their series in the unit disc, and outside by doubling the argument, φ_k(2z) = 2^(−k)
    [e^z φ_k(z) + Σ_j φ_j(z)/(k−j)!], which is stable where the real part is not positive.
    """
    size = np.abs(z)
    halvings = np.ceil(np.log2(np.maximum(size, 1.0))).astype(int)
    small = z / 2.0**halvings
    found = np.stack([_series(small, k) for k in range(highest + 1)])
    shares = np.array(
        [[1.0 / factorial(k - j) if 1 <= j <= k else 0.0 for j in range(highest + 1)]
         for k in range(highest + 1)]
    )  # fmt: skip
    scale = 0.5 ** np.arange(highest + 1)
    for done in range(int(halvings.max(initial=0))):
        going = halvings > done
        part = found[:, going]
        before = np.exp(small[going] * 2.0**done)
        found[:, going] = scale[:, None] * (before * part + shares @ part)
    found[0] = np.exp(z)
    return found


def _series(z: Complex, k: int) -> Complex:
    term = np.full(z.shape, 1.0 / factorial(k), dtype=complex)
    total = term.copy()
    for j in range(1, TERMS):
        term = term * z / (j + k)
        total += term
    return total
