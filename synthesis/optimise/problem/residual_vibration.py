"""Residual vibration after runs of moves: rows, amplitudes, and its share of ψ.

With λ = ν(ζ − i√(1 − ζ²)) the amplitude that a run ending at Θ leaves is

    A = |W| / √(1 − ζ²),   W = ∫ s' e^(−λ(Θ − θ)) dθ:

Duhamel's integral of s'', by parts, so that jumps of s' need no term of their own. It is linear in
the motion: |W| ≤ … is a cone, and W = 0 are two equalities.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.constraints import VibrationBound
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.optimise.problem.grid import Grid

Complex = NDArray[np.complex128]
NODES, SHARES = np.polynomial.legendre.leggauss(12)  # next to exact over 2 rad of a wave
REACH = 2.0  # rad of the swing, or of a law's own waves, in one panel
NATURAL = 1e-3  # of the rows: a radius below it is not divided by
FINE = 0.25  # of a rad of the swing: pieces of ψ, each a polynomial of the fourth degree
CHEBYSHEV = np.cos(np.pi * (2.0 * np.arange(5) + 1.0) / 10.0)
SERIES = 0.5  # |κ| below which Q is summed, as its closed form cancels
TERMS = 14  # of the power series of a sinusoid on one piece
ROUNDING = 1e-14  # of the largest value of ψ: of closed forms and of their interpolation


@dataclass(frozen=True, eq=False)
class LawTerm:
    """The part of a free law in W: weight ∫ g'(x) e^(−κ(1 − x)) dx."""

    position: int
    weight: complex
    kappa: complex


@dataclass(frozen=True, eq=False)
class VibrationTerm:
    """One run's W as a functional of the free laws, over its natural size.

    Attributes:
        law_terms: of the free laws in it. rows: (2, n) per share, over all coefficients of its law:
            real and imaginary part. shift: (2,) of the given laws. radius: |W| allowed, 0 for none.
        source: as of a row.
    """

    law_terms: tuple[LawTerm, ...]
    rows: tuple[Array, ...]
    shift: Array
    radius: float
    source: str

    def of_laws(self, number: Mapping[int, int]) -> VibrationTerm | None:
        """The same where laws are numbered anew; None where it speaks of others, too."""
        if any(share.position not in number for share in self.law_terms):
            return None
        shares = (replace(one, position=number[one.position]) for one in self.law_terms)
        return replace(self, law_terms=tuple(shares))


def vibration_term(
    limit: VibrationBound, segments: Sequence[PlacedSegment], grids: Sequence[Grid]
) -> VibrationTerm | None:
    """One run on given grids; None where all of its laws are given."""
    position = {s.index: k for k, s in enumerate(s for s in segments if s.law is None)}
    given, shares, rows = 0j, list[LawTerm](), list[Complex]()
    for segment, weight, kappa in _terms(limit, segments):
        if segment.law is not None:
            given += weight * _integral(segment.law, kappa)
            continue
        share = LawTerm(position[segment.index], weight, kappa)
        shares.append(share)
        rows.append(weight * basis_integrals(grids[share.position].space, kappa))
    if not shares:
        return None
    natural = max(float(np.max(np.abs(row))) for row in rows)
    largest = limit.max_amplitude * sqrt(1.0 - limit.damping**2)
    scale = max(natural * NATURAL, largest) if largest else natural
    return VibrationTerm(
        tuple(LawTerm(one.position, one.weight / scale, one.kappa) for one in shares),
        tuple(np.stack([row.real, row.imag]) / scale for row in rows),
        np.array([given.real, given.imag]) / scale,
        largest / scale,
        limit.source,
    )


def amplitude(limit: VibrationBound, settled: Sequence[PlacedSegment]) -> float:
    """A of given laws [length]."""
    terms = (
        weight * _integral(s.law, kappa) for s, weight, kappa in _terms(limit, settled) if s.law
    )
    return abs(sum(terms)) / sqrt(1.0 - limit.damping**2)


def _terms(
    limit: VibrationBound, segments: Sequence[PlacedSegment]
) -> list[tuple[PlacedSegment, complex, complex]]:
    """Segments of a run, with what ∫ g'(x) e^(−κ(1 − x)) dx is multiplied by, and κ = λβ."""
    by_index = {s.index: s for s in segments}
    rate = limit.frequency * complex(limit.damping, -sqrt(1.0 - limit.damping**2))
    result, after = [], 0.0
    for index in reversed(limit.run):
        segment = by_index[index]
        weight = segment.scale * np.exp(-rate * after)
        result.append((segment, complex(weight), rate * segment.angle))
        after += segment.angle
    return result


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
def basis_integrals(space: SplineSpace, kappa: complex) -> Complex:
    """∫ B_j'(x) e^(−κ(1 − x)) dx of every basis function: (size,)."""
    x, share, _ = _panels(space.breaks, np.full(len(space.breaks) - 1, abs(kappa)))
    # no product of matrices: how those add up depends on the number of threads
    result: Complex = np.einsum("i,ij->j", share * np.exp(-kappa * (1.0 - x)), space.basis(x, 1))
    return result


def _integral(law: Piecewise, kappa: complex) -> complex:
    """The same of a given law."""
    speed = np.full(law.count, abs(kappa))
    if law.waves.shape[1]:
        speed += np.max(np.abs(law.waves[..., 1]), axis=1)
    x, share, piece = _panels(law.breaks, speed)
    return complex((share * np.exp(-kappa * (1.0 - x))) @ law.at(x, piece, 1))


@dataclass(frozen=True, eq=False)
class SwitchingContribution:
    """What multipliers (y0, y1) of a ring's two rows come to on one law, as a functional of g.

    y · (Re W, Im W) = Σ state[j] g^(j)(0) + ∫ ψ g^(m) dx for every law g.

    Attributes:
        initial: (m,). spans: (n, 2) and poly: (n, 5): ψ, in s from 0 to 1 along each span.
        error: what ψ differs from these polynomials at most.
    """

    initial: Array
    spans: Array
    poly: Array
    error: float


def switching_contribution(share: LawTerm, y: Array, order: int) -> SwitchingContribution:
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
    return SwitchingContribution(
        state, np.stack([breaks[:-1], breaks[1:]], axis=1), values @ inverse.T, missed
    )


def _kernel(tau: Array, kappa: complex, order: int) -> Complex:
    """P (order 2) or Q (order 3) at τ."""
    t: Complex = (1.0 - tau).astype(complex)
    if abs(kappa) < SERIES:
        result = np.zeros_like(t)
        term: Complex = t ** (order - 1) / (order - 1)
        for k in range(TERMS):
            result = result + term
            term = term * (-kappa * t) / (order + k)
        return result
    whole = -np.expm1(-kappa * t) / kappa
    return whole if order == 2 else np.asarray((t - whole) / kappa)
