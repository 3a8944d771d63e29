"""Functions that are, piece by piece, a polynomial plus sinusoids.

Every motion law of VDI 2143, Norton and Rothbart has this form, and so has every spline, so one
representation serves evaluation, derivatives (exact, term by term) and proven ranges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import zip_longest
from math import factorial
from typing import Literal

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]
Side = Literal["left", "right"]


def sorted_unique(values: Array) -> Array:
    """Sorted, without repetition: what ``np.unique`` does, in a third of its time for a few."""
    found = np.sort(values, axis=None)
    new = np.empty(len(found), dtype=bool)
    new[:1] = True
    np.not_equal(found[1:], found[:-1], out=new[1:])
    return np.asarray(found[new])


def horner(falling: Array, t: Array, highest: int) -> Array:
    """Polynomials and their derivatives up to this one at t (…), in one run of Horner's scheme.

    From coefficients (d+1, …), highest power first, to (highest + 1, …) within 3 d + 2 roundings of
    the terms, that of t included.
    """
    first, *others = falling
    rows = [first]  # f^(k) / k! of what the scheme has come to
    for coefficient in others:
        pairs = zip(rows, (coefficient, *rows), strict=False)
        rows = [*[row * t + below for row, below in pairs], rows[-1]][: highest + 1]
    value = np.zeros((highest + 1, *first.shape))
    for order, row in enumerate(rows):
        np.multiply(row, float(factorial(order)), out=value[order])
    return value


def gauss_points(breaks: Array, count: int) -> tuple[Array, Array]:
    """Points and weights of Gauss's rule on each of n pieces: (n, count) both.

    Exact for polynomials up to degree 2 count − 1.
    """
    nodes, weights = _leggauss(count)
    half = 0.5 * np.diff(breaks)[:, None]
    return 0.5 * (breaks[1:] + breaks[:-1])[:, None] + half * nodes, half * weights


_leggauss = lru_cache(maxsize=64)(leggauss)


@dataclass(frozen=True, eq=False)
class Piecewise:
    """f(x) = Σ_j poly[i,j] (x − origin[i])^j + Σ_m A sin(w (x − origin[i]) + φ) on piece i.

    Attributes:
        breaks: (n+1,) increasing ends of the pieces; piece i is [breaks[i], breaks[i+1]].
        origins: (n,) point about which piece i is written (either end, whichever cancels less).
        poly: (n, d+1) coefficients, constant first.
        waves: (n, m, 3) amplitude A, angular frequency w, phase φ; m may be 0.
    """

    breaks: Array
    origins: Array
    poly: Array
    waves: Array

    @classmethod
    def of(
        cls,
        breaks: ArrayLike,
        poly: Sequence[ArrayLike],
        waves: Sequence[Sequence[tuple[float, float, float]]] | None = None,
        origins: ArrayLike | None = None,
    ) -> Piecewise:
        """Build from ragged rows: ``poly[i]`` and ``waves[i]`` of any length per piece."""
        ends = np.asarray(breaks, dtype=float)
        rows = [np.atleast_1d(np.asarray(row, dtype=float)) for row in poly]
        table = np.array(list(zip_longest(*rows, fillvalue=0.0)), dtype=float).T.copy()
        wave_table = np.zeros((len(rows), max(map(len, waves or ()), default=0), 3))
        for i, wave_row in enumerate(waves or ()):
            wave_table[i, : len(wave_row)] = wave_row or 0.0
        start = ends[:-1].copy() if origins is None else np.asarray(origins, dtype=float)
        return cls(ends, start, table, wave_table)

    @property
    def count(self) -> int:
        """Number of pieces."""
        return len(self.origins)

    @property
    def is_constant(self) -> bool:
        """Whether no piece moves."""
        return self.poly.shape[1] == 1 and not self.waves.shape[1]

    def piece_of(self, x: Array, side: Side = "right") -> Indices:
        """Index of the piece that holds each x; at a break the piece on the given side."""
        found = np.searchsorted(self.breaks, x, side=side) - 1
        return np.clip(found, 0, self.count - 1)

    def at(self, x: Array, piece: Indices, order: int) -> Array:
        """The ``order``-th derivative at x (k,), by the formulas of the given pieces: (k,)."""
        return np.asarray(self.jet(x, piece, order)[order])

    def __call__(self, x: ArrayLike, order: int = 0, side: Side = "right") -> Array:
        """The ``order``-th derivative at x (any shape), one-sided at breaks."""
        points = np.asarray(x, dtype=float)
        flat = points.ravel()
        return self.at(flat, self.piece_of(flat, side), order).reshape(points.shape)

    def derivatives(self, x: ArrayLike, highest: int = 3, side: Side = "right") -> Array:
        """f, f', …, f^(highest) at x: (highest+1, k)."""
        points = np.asarray(x, dtype=float).ravel()
        return self.jet(points, self.piece_of(points, side), highest)

    def jet(self, x: Array, piece: Indices, highest: int) -> Array:
        """f, f', …, f^(highest) at x (k,) by the formulas of the given pieces: (highest+1, k)."""
        if self.is_constant:
            value = np.zeros((highest + 1, len(x)))
            value[0] = self.poly[piece, 0]
            return value
        t = x - self.origins[piece]
        value = horner(self.descending.take(piece, axis=-1), t, highest)
        if self.waves.shape[1]:
            amplitude, frequency, phase = np.moveaxis(self.waves[piece], -1, 0)
            angle = frequency * t[:, None] + phase
            sine, cosine = np.sin(angle), np.cos(angle)
            for order in range(highest + 1):
                # sin differentiated: without π/2 added to the phase, so that exact zeros stay
                wave = (sine, cosine, -sine, -cosine)[order % 4]
                value[order] += np.sum(amplitude * frequency**order * wave, axis=1)
        return value

    @cached_property
    def descending(self) -> Array:
        """Coefficients, highest power first: (d+1, n)."""
        return np.ascontiguousarray(self.poly.T[::-1])

    @cached_property
    def _derivatives(self) -> tuple[Array, ...]:
        """Coefficients of the polynomials and of their derivatives, constant first."""
        tables = [self.poly]
        while tables[-1].shape[1] > 1:
            tables.append(tables[-1][:, 1:] * np.arange(1.0, tables[-1].shape[1]))
        return tuple(tables)

    def combine_derivatives(self, coefficients: Sequence[float]) -> Piecewise:
        """Σ_k coefficients[k] f^(k) as a function of its own; of polynomials alone."""
        mixed = np.zeros_like(self.poly)
        for c, rows in zip(coefficients, self._derivatives, strict=False):
            if c != 0.0:
                mixed[:, : rows.shape[1]] += c * rows
        return Piecewise(self.breaks, self.origins, mixed, self.waves)

    def bound_derivative(self, piece: Indices, width: Array, order: int) -> Array:
        """Crude bound of |f^(order)| within ``width`` of the origin of each piece: (k,)."""
        falling = np.abs(self.descending).take(piece, axis=-1)
        value = horner(falling, width, order)[order]
        if self.waves.shape[1]:
            amplitude, frequency, _ = np.moveaxis(self.waves[piece], -1, 0)
            value = value + np.sum(np.abs(amplitude * frequency**order), axis=1)
        return np.asarray(value)

    def restrict(self, low: float, high: float) -> Piecewise:
        """The same function on [low, high] alone, a part of its interval that is no point."""
        first = int(np.searchsorted(self.breaks, low, side="right")) - 1
        last = int(np.searchsorted(self.breaks, high, side="left"))
        kept = slice(max(first, 0), max(last, 1))
        breaks = self.breaks[kept.start : kept.stop + 1].copy()
        breaks[0], breaks[-1] = low, high
        return Piecewise(breaks, self.origins[kept], self.poly[kept], self.waves[kept])

    def split_at(self, at: ArrayLike) -> tuple[Piecewise, Indices]:
        """The same function with further breaks, and of which piece each new one is a part.

        A break less than 1e-12 of the interval from another one is left out.
        """
        given = np.asarray(at, dtype=float)
        if not given.size:
            return self, np.arange(self.count)
        wanted = sorted_unique(given)
        far = 1e-12 * (self.breaks[-1] - self.breaks[0])
        apart = np.abs(wanted[:, None] - self.breaks).min(axis=1, initial=np.inf)
        inside = (wanted > self.breaks[0]) & (wanted < self.breaks[-1]) & (apart > far)
        breaks = np.union1d(self.breaks, wanted[inside])
        owner = self.piece_of(0.5 * (breaks[1:] + breaks[:-1]))
        parts = Piecewise(breaks, self.origins[owner], self.poly[owner], self.waves[owner])
        return parts, owner

    def rescale(self, start: float, width: float, shift: float, scale: float) -> Piecewise:
        """x ↦ shift + scale · f((x − start)/width), on [start, start + width · span]."""
        powers = scale / width ** np.arange(self.poly.shape[1])
        poly = self.poly * powers
        poly[:, 0] += shift
        waves = self.waves
        if waves.shape[1]:
            waves = waves * np.array([scale, 1.0 / width, 1.0])
        return Piecewise(start + width * self.breaks, start + width * self.origins, poly, waves)

    def mirror(self) -> Piecewise:
        """x ↦ f(a + b − x) on the same interval [a, b]."""
        both = self.breaks[0] + self.breaks[-1]
        signs = (-1.0) ** np.arange(self.poly.shape[1])
        waves = self.waves[::-1] * np.array([1.0, -1.0, 1.0])
        return Piecewise(
            (both - self.breaks)[::-1], (both - self.origins)[::-1], self.poly[::-1] * signs, waves
        )


def concatenate(parts: Sequence[Piecewise]) -> Piecewise:
    """One function out of neighbours, each beginning where the one before ends."""
    degree = max(part.poly.shape[1] for part in parts)
    waves = max(part.waves.shape[1] for part in parts)
    count = sum(part.count for part in parts)
    poly, wave, at = np.zeros((count, degree)), np.zeros((count, waves, 3)), 0
    for part in parts:
        here = slice(at, at + part.count)
        poly[here, : part.poly.shape[1]] = part.poly
        wave[here, : part.waves.shape[1]] = part.waves
        at = here.stop
    breaks = [part.breaks[:-1] for part in parts] + [parts[-1].breaks[-1:]]
    return Piecewise(
        np.concatenate(breaks), np.concatenate([part.origins for part in parts]), poly, wave
    )
