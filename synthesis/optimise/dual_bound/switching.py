"""The switching function ψ of a free law: what its highest bounded derivative is worth.

By weak duality every law pays ∫ ψ w dx with w = g^(m); a row with multiplier λ at x_i that reads
alpha · (g, g', …) contributes λ alpha_k (x_i − τ)^(m−1−k) / (m−1−k)! for τ < x_i. So ψ is a
polynomial of degree m − 1 between the points, of a higher one where multipliers are densities; and
where it changes sign the ideal law switches.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import accumulate, pairwise
from math import comb

import numpy as np

from synthesis.numerics.maxima import quadratic_roots
from synthesis.numerics.piecewise import Array, gauss_points, sorted_unique

NODES = 5  # of Gauss's rule, exact to degree 9 between the cuts
TINY = 1e-14  # of the largest coefficient: a leading one below it has no root near by


@dataclass(frozen=True, eq=False)
class Switching:
    """ψ(τ) = Σ_j poly[i, j] s^j with s = (τ − breaks[i]) / (breaks[i+1] − breaks[i]) in [0, 1]."""

    breaks: Array
    poly: Array

    def __call__(self, tau: Array) -> Array:
        """ψ at τ, of the piece on the right."""
        piece = np.clip(np.searchsorted(self.breaks, tau, "right") - 1, 0, len(self.poly) - 1)
        s = (tau - self.breaks[piece]) / (self.breaks[piece + 1] - self.breaks[piece])
        return np.asarray(sum(self.poly[piece, j] * s**j for j in range(self.poly.shape[1])))

    @property
    def magnitude_bound(self) -> float:
        """What |ψ| is nowhere above."""
        return float(np.max(np.abs(self.poly @ _bernstein(self.poly.shape[1]))))

    def sign_changes(self, noise: float = 0.0) -> Array:
        """Points inside (0, 1) where ψ changes sign, at jumps as well.

        Also where it goes from next to nothing (``noise``, of the largest |ψ|) to more, or back.
        """
        cuts = self._breaks_and_roots((0.0,))
        value = self(gauss_points(cuts, NODES)[0])
        size = np.max(np.abs(value), axis=1)
        sense = np.where(size > noise * np.max(size), np.sign(value[:, NODES // 2]), 0.0)
        return np.asarray(cuts[1:-1][sense[1:] != sense[:-1]], dtype=float)

    def least_integral(self, cap: float, weight: float) -> float:
        """∫ min over |w| ≤ cap of (weight w² + ψ w): never positive.

        Exact but for rounding; without a weight never above the true value. With one the cap may
        be infinite.
        """
        if weight == 0.0:
            return -cap * absolute_integrals([self])[0]
        edge = 2.0 * weight * cap
        cuts = self._breaks_and_roots((0.0, edge, -edge) if np.isfinite(edge) else (0.0,))
        tau, shares = gauss_points(cuts, NODES)
        psi = np.abs(self(tau))
        inner = -(psi**2) / (4.0 * weight)
        outer = -cap * psi + weight * cap**2 if np.isfinite(cap) else inner
        value = np.where(psi <= edge, inner, outer)
        return float(np.sum(value * shares))

    def losses(
        self, knots: Array, law: Callable[[Array], Array], cap: float, weight: float
    ) -> Array:
        """What a law (its control) pays more than the ideal one between knots: (n,) ≥ 0."""
        cuts = np.union1d(self._breaks_and_roots((0.0,)), knots)
        tau, shares = gauss_points(cuts, NODES)
        psi, w = self(tau), law(tau)
        paid = weight * w**2 + psi * w
        ideal = -cap * np.abs(psi) if weight == 0.0 else -(psi**2) / (4.0 * weight)
        loss = np.sum((paid - ideal) * shares, axis=1)
        # the middle between the last two cuts may round to the end itself
        interval = np.searchsorted(knots[:-1], 0.5 * (cuts[:-1] + cuts[1:]), "right") - 1
        sums = np.bincount(interval, np.maximum(loss, 0.0), minlength=len(knots) - 1)
        return np.asarray(sums, dtype=float)

    def _breaks_and_roots(self, values: tuple[float, ...]) -> Array:
        """The breaks and the roots of ψ − value, sorted."""
        result, width = [self.breaks], self.breaks[1:] - self.breaks[:-1]
        for value in values:
            shifted = self.poly
            if value:
                shifted = shifted.copy()
                shifted[:, 0] -= value
            for root in _roots(shifted):
                inside = (root > 0.0) & (root < 1.0)
                result.append((self.breaks[:-1] + width * root)[inside])
        return sorted_unique(np.concatenate(result))


def add_densities(breaks: Array, psi: Array, spans: Array, poly: Array) -> tuple[Array, Array]:
    """q functions ψ with a polynomial more on each span.

    Args:
        breaks, psi: (n+1,) and (q, n, m), in s from 0 to 1 along each piece. spans: (r, 2).
        poly: (q, r, d) in s from 0 to 1 along each span.

    Returns:
        finer breaks, and the sums.
    """
    finer = np.unique(np.concatenate([breaks, spans.ravel()]))
    table = np.zeros((len(psi), len(finer) - 1, max(poly.shape[2], psi.shape[2])))
    # its own polynomials between the finer breaks
    left, right = finer[:-1], finer[1:]
    piece = np.searchsorted(breaks[1:-1], 0.5 * (left + right), "right")
    start, width = breaks[piece], np.diff(breaks)[piece]
    shares = [np.tile((end - start) / width, len(psi)) for end in (left, right)]
    own = psi[:, piece].reshape(-1, psi.shape[2])
    table[..., : psi.shape[2]] = restrict_polynomials(own, *shares).reshape(len(psi), len(left), -1)
    first, last = np.searchsorted(finer, spans).T
    each = np.repeat(np.arange(len(spans)), last - first)
    piece = np.arange(len(each)) - np.repeat(np.cumsum(last - first) - last, last - first)
    low, high = spans[each].T
    shares = [np.tile((finer[piece + side] - low) / (high - low), len(psi)) for side in (0, 1)]
    more = restrict_polynomials(poly[:, each].reshape(-1, poly.shape[2]), *shares)
    more = more.reshape(len(psi), len(each), -1)
    np.add.at(table.swapaxes(0, 1)[..., : poly.shape[2]], piece, more.swapaxes(0, 1))
    return finer, table


def absolute_integrals(each: Sequence[Switching]) -> list[float]:
    """∫ |ψ| of every law, never below the true value; all of them are worked out together."""
    if not each:
        return []
    degree = max(psi.poly.shape[1] for psi in each)
    poly = np.zeros((sum(len(psi.poly) for psi in each), degree))
    ends = list(accumulate((len(psi.poly) for psi in each), initial=0))
    for psi, first, last in zip(each, ends[:-1], ends[1:], strict=True):
        poly[first:last, : psi.poly.shape[1]] = psi.poly
    width = np.concatenate([psi.breaks[1:] - psi.breaks[:-1] for psi in each])
    result: list[float] = np.add.reduceat(mean_absolute(poly) * width, ends[:-1]).tolist()
    return result


def mean_absolute(poly: Array, *, exact: bool = False) -> Array:
    """∫ |p(s)| ds over [0, 1] of polynomials (n, d): (n,), but for rounding never too small.

    Every one is cut at its roots. On a part |p| is at most the mean of its Bernstein coefficients'
    sizes, and is that where they have one sign; roots need not be exact for that. ``exact``: |∫ p|
    on every part instead, for parabolas, whose roots are exact.
    """
    roots = [np.fmin(np.fmax(root, 0.0), 1.0) for root in _roots(poly)]  # of none, an end
    if exact:
        c, b, a = poly.T
        ends = [np.minimum(*roots), np.maximum(*roots), np.ones(1)]
        values = [0.0 * c, *(t * (c + t * (0.5 * b + t * (a / 3.0))) for t in ends)]
        return np.asarray(sum(np.abs(y - x) for x, y in pairwise(values)))
    cuts = np.zeros((len(roots) + 2, len(poly)))
    cuts[1:-1], cuts[-1] = np.sort(np.array(roots).reshape(-1, len(poly)), axis=0), 1.0
    bernstein = restrict_polynomials(poly, cuts[:-1], cuts[1:]) @ _bernstein(poly.shape[1])
    sizes = np.abs(bernstein).sum(axis=2) / poly.shape[1]
    return np.asarray((np.diff(cuts, axis=0) * sizes).sum(axis=0))


def restrict_polynomials(poly: Array, low: Array, high: Array) -> Array:
    """Polynomials (n, d) in s on parts low to high (…, n) of [0, 1], from 0 to 1 along the part."""
    degree, width = poly.shape[1], high - low
    columns = [poly[:, j] for j in range(degree)]
    result = np.empty((*low.shape, degree))
    if degree <= 3:
        c, b, a = columns + [np.zeros(1)] * (3 - degree)
        rising = low * a
        parts = c + low * (b + rising), width * (b + 2.0 * rising), width * width * a
        for j in range(degree):
            result[..., j] = parts[j]
        return result
    powers = [low**i for i in range(degree)]
    for j in range(degree):
        shares = (comb(i, j) * columns[i] * powers[i - j] for i in range(j, degree))
        result[..., j] = width**j * sum(shares)
    return result


@cache
def _bernstein(count: int) -> Array:
    """(count, count): coefficients of s^j to those of Bernstein."""
    degree = count - 1
    return np.array(
        [[comb(i, j) / comb(degree, j) for i in range(count)] for j in range(count)], dtype=float
    )


def _roots(poly: Array) -> Sequence[Array]:
    """Roots of polynomials (n, d), as many arrays as there may be; NaN or far off where none."""
    if poly.shape[1] <= 3:
        columns = [poly[:, j] for j in range(poly.shape[1])]
        c, b, a = columns + [np.zeros(1)] * (3 - len(columns))
        return quadratic_roots(a, b, c)
    signs = np.sign(poly @ _bernstein(poly.shape[1]))
    mixed = np.any(signs != signs[:, :1], axis=1)  # others have none
    result = np.full((poly.shape[1] - 1, len(poly)), np.nan)
    chosen = poly[mixed]
    largest = np.max(np.abs(chosen), axis=1)
    lead = chosen[:, -1]
    lead = np.where(np.abs(lead) > TINY * largest, lead, TINY * largest)
    companion = np.zeros((len(chosen), *2 * (poly.shape[1] - 1,)))
    companion[:, 1:, :-1] = np.eye(poly.shape[1] - 2)
    companion[:, :, -1] = -chosen[:, :-1] / lead[:, None]
    roots = np.linalg.eigvals(companion)
    result[:, mixed] = np.where(np.abs(roots.imag) <= 1e-7, roots.real, np.nan).T
    return list(result)


def switching_pieces(points: Array, weights: Array) -> tuple[Array, Array]:
    """ψ from point rows at (r,) of q sets of multipliers: breaks (n+1,), polynomials (q, n, m).

    ``weights``: (q, r, m) λ_i alpha_k for k < m; m is 2 or 3. The polynomials are in s from 0 to 1
    along each piece.
    """
    sorting = points.argsort(kind="stable")
    x, w, order = points[sorting], weights[:, sorting], weights.shape[2]
    breaks = np.zeros(len(x) + 2)
    breaks[1:-1], breaks[-1] = x, 1.0
    new = np.ones(len(breaks), dtype=bool)
    np.not_equal(breaks[1:], breaks[:-1], out=new[1:])  # they are in order
    breaks = breaks[new]
    # Σ w (x − τ)^n/n! of all rows with x ≥ breaks[i+1], in powers of τ and then about breaks[i]
    w2, w1, w0 = w[..., -1], w[..., -2], w[..., -3] if order > 2 else np.zeros(len(x))
    table = np.zeros((3, len(w), len(x) + 1))
    table[0, :, :-1], table[1, :, :-1] = w2 + x * (w1 + 0.5 * x * w0), -w1 - x * w0
    table[2, :, :-1] = 0.5 * w0
    suffix = table[..., ::-1].cumsum(axis=2)[..., ::-1]
    c, b, a = suffix[..., x.searchsorted(breaks[1:], side="left")]
    first, width = breaks[:-1], breaks[1:] - breaks[:-1]
    parts = c + first * (b + first * a), width * (b + 2.0 * a * first), width**2 * a
    poly = np.empty((*c.shape, order))
    for j in range(order):
        poly[..., j] = parts[j]
    return breaks, poly
