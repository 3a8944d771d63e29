"""What runs of moves leave oscillators ringing with: rows, amplitudes, and the bound's share.

With λ = ν(ζ − i√(1 − ζ²)) the amplitude that a run ending at Θ leaves is

    A = |W| / √(1 − ζ²),   W = ∫ s' e^(−λ(Θ − θ)) dθ:

Duhamel's integral of s'', by parts, so that jumps of s' need no term of their own. It is linear in
the motion: |W| ≤ … is a cone, and W = 0 are two equalities.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from synthesis.formulations.question.grid import Grid
from synthesis.motion import Stretch
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.terms import Ringing

Complex = NDArray[np.complex128]
NODES, SHARES = np.polynomial.legendre.leggauss(12)  # next to exact over 2 rad of a wave
REACH = 2.0  # rad of the swing, or of a law's own waves, in one panel
NATURAL = 1e-3  # of the rows: a radius below it is not divided by
FINE = 0.25  # of a rad of the swing: pieces of ψ, each a polynomial of the fourth degree
CHEBYSHEV = np.cos(np.pi * (2.0 * np.arange(5) + 1.0) / 10.0)
SERIES = 0.5  # |κ| below which Q is summed, as its closed form cancels
TERMS = 14
ROUNDING = 1e-14  # of the largest value of ψ: of closed forms and of their interpolation


@dataclass(frozen=True, eq=False)
class Share:
    """The part of a free law in W: weight ∫ g'(x) e^(−κ(1 − x)) dx."""

    position: int
    weight: complex
    kappa: complex


@dataclass(frozen=True, eq=False)
class Ring:
    """One run's W as a functional of the free laws, over its natural size.

    Attributes:
        shares: of the free laws in it. rows: (2, n) per share, over all coefficients of its law:
            real and imaginary part. shift: (2,) of the given laws. radius: |W| allowed, 0 for none.
        source: as of a row.
    """

    shares: tuple[Share, ...]
    rows: tuple[Array, ...]
    shift: Array
    radius: float
    source: str


def ring(asked: Ringing, stretches: Sequence[Stretch], grids: Sequence[Grid]) -> Ring | None:
    """One run on given grids; None where all of its laws are given.

    Args:
        asked: what may be left. stretches: the whole turn, none of zero angle.
        grids: one per free stretch.
    """
    position = {s.index: k for k, s in enumerate(s for s in stretches if s.law is None)}
    given, shares, rows = 0j, list[Share](), list[Complex]()
    for stretch, weight, kappa in _terms(asked, stretches):
        if stretch.law is not None:
            given += weight * _integral(stretch.law, kappa)
            continue
        share = Share(position[stretch.index], weight, kappa)
        shares.append(share)
        rows.append(weight * on_basis(grids[share.position].space, kappa))
    if not shares:
        return None
    natural = max(float(np.max(np.abs(row))) for row in rows)
    largest = asked.largest * sqrt(1.0 - asked.damping**2)
    scale = max(natural * NATURAL, largest) if largest else natural
    return Ring(
        tuple(Share(one.position, one.weight / scale, one.kappa) for one in shares),
        tuple(np.stack([row.real, row.imag]) / scale for row in rows),
        np.array([given.real, given.imag]) / scale,
        largest / scale,
        asked.source,
    )


def amplitude(asked: Ringing, settled: Sequence[Stretch]) -> float:
    """A of settled laws [mm]."""
    total = 0j
    for stretch, weight, kappa in _terms(asked, settled):
        if stretch.law is not None:
            total += weight * _integral(stretch.law, kappa)
    return abs(total) / sqrt(1.0 - asked.damping**2)


def settles(asked: Ringing, stretches: Sequence[Stretch]) -> bool:
    """Whether all laws of the run are at hand and settled."""
    laws = {s.index for s in stretches if s.law is not None}
    return laws.issuperset(asked.run)


def _terms(asked: Ringing, stretches: Sequence[Stretch]) -> list[tuple[Stretch, complex, complex]]:
    """Stretches of a run, with what ∫ g'(x) e^(−κ(1 − x)) dx is multiplied by, and κ = λβ."""
    by_index = {s.index: s for s in stretches}
    rate = asked.frequency * complex(asked.damping, -sqrt(1.0 - asked.damping**2))
    found, after = [], 0.0
    for index in reversed(asked.run):
        stretch = by_index[index]
        weight = stretch.unit * np.exp(-rate * after)
        found.append((stretch, complex(weight), rate * stretch.angle))
        after += stretch.angle
    return found


def _panels(breaks: Array, speed: Array) -> tuple[Array, Array, NDArray[np.intp]]:
    """Gauss points, weights and intervals, for a wave of ``speed`` [rad] on every interval."""
    width = np.diff(breaks)
    count = np.maximum(np.ceil(speed * width / REACH), 1.0).astype(int)
    own = np.repeat(np.arange(len(width)), count)
    step = (width / count)[own]
    first = np.arange(len(own)) - np.repeat(np.cumsum(count) - count, count)
    left = breaks[own] + first * step
    x = left[:, None] + step[:, None] * (NODES + 1.0) / 2.0
    return x.ravel(), (step[:, None] * SHARES / 2.0).ravel(), np.repeat(own, len(NODES))


@lru_cache(maxsize=256)
def on_basis(space: SplineSpace, kappa: complex) -> Complex:
    """∫ B_j'(x) e^(−κ(1 − x)) dx of every basis function: (size,)."""
    x, share, _ = _panels(space.breaks, np.full(len(space.breaks) - 1, abs(kappa)))
    # no product of matrices: how those add up depends on the number of threads
    found: Complex = np.einsum("i,ij->j", share * np.exp(-kappa * (1.0 - x)), space.basis(x, 1))
    return found


def _integral(law: Piecewise, kappa: complex) -> complex:
    """The same of a given law."""
    speed = np.full(law.count, abs(kappa))
    if law.waves.shape[1]:
        speed += np.max(np.abs(law.waves[..., 1]), axis=1)
    x, share, piece = _panels(law.breaks, speed)
    return complex((share * np.exp(-kappa * (1.0 - x))) @ law.at(x, piece, 1))


@dataclass(frozen=True, eq=False)
class Swing:
    """What multipliers (y0, y1) of a ring's two rows come to on one law, as a functional of g.

    y · (Re W, Im W) = Σ state[j] g^(j)(0) + ∫ ψ g^(m) dx for every law g.

    Attributes:
        state: (m,). spans: (n, 2) and poly: (n, 5): ψ, in s from 0 to 1 along each span.
        missed: what ψ differs from these polynomials at most.
    """

    state: Array
    spans: Array
    poly: Array
    missed: float


def swing(share: Share, y: Array, order: int) -> Swing:
    """That functional, from closed forms: P = ∫ e^(−κ(1 − u)) du from τ to 1, Q = ∫ P du."""
    kappa, factor = share.kappa, complex(y[0], -y[1]) * share.weight
    start = _kernel(np.zeros(1), kappa, 2)[0], _kernel(np.zeros(1), kappa, 3)[0]
    state = np.zeros(order)
    for k in range(1, order):
        state[k] = float((factor * start[k - 1]).real)
    count = max(int(np.ceil(abs(kappa) / FINE)), 1)
    breaks = np.linspace(0.0, 1.0, count + 1)
    tau = breaks[:-1, None] + (CHEBYSHEV + 1.0) / (2.0 * count)
    values = (factor * _kernel(tau, kappa, order)).real
    inverse = np.linalg.inv(np.vander((CHEBYSHEV + 1.0) / 2.0, 5, increasing=True))
    fifth = abs(factor) * abs(kappa) ** (6 - order)
    missed = fifth * (0.5 / count) ** 5 / 1920.0 + ROUNDING * float(np.max(np.abs(values)))
    return Swing(state, np.stack([breaks[:-1], breaks[1:]], axis=1), values @ inverse.T, missed)


def _kernel(tau: Array, kappa: complex, order: int) -> Complex:
    """P (order 2) or Q (order 3) at τ."""
    t: Complex = (1.0 - tau).astype(complex)
    if abs(kappa) < SERIES:
        found = np.zeros_like(t)
        term: Complex = t ** (order - 1) / (order - 1)
        for k in range(TERMS):
            found = found + term
            term = term * (-kappa * t) / (order + k)
        return found
    whole = -np.expm1(-kappa * t) / kappa
    return whole if order == 2 else np.asarray((t - whole) / kappa)
