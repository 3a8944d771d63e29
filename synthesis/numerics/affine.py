"""Affine models: what a function of several variables does on a box, with a proven remainder.

On the box u_i = m_i + w_i t_i, t_i in [−1, 1], a model says

    f = c + Σ g_i t_i + something not larger than rem,

for many boxes at once. Sums, products, quotients, roots and maxima of models are models again, so a
formula written for numbers bounds itself; the remainder shrinks with the square of the box (it is
the centred form of interval analysis, Neumaier, Interval Methods for Systems of Equations, 2.3).
Every operation adds an allowance for its roundings, ``ROUNDING`` times the terms that it handled.

Where a model cannot be formed (a divisor that may vanish on the box) its remainder is inf or nan;
evaluate under ``np.errstate(all="ignore")``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, ClassVar, Final

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.numerics.taylor import ARITHMETIC, UfuncDispatch, UfuncRules

ROUNDING: Final = 2.0**-47  # of the terms handled: 64 unit roundoffs
COMPLEX_STEP: Final = 1e-30  # of complex steps: its square vanishes beside any value
FARTHER: Final = 1.2  # of a known range: slopes are worth as much
NARROW: Final = 4e-3  # width of a cell: remainders, some of its square, are small enough then


class Affine(UfuncDispatch):
    """A model on each of n boxes: centres c (n,), slopes g over half the box (d, n), remainders."""

    rules: ClassVar[UfuncRules] = {
        **ARITHMETIC,
        np.sin: lambda f: f._wave(np.sin(f.c), np.cos(f.c)),
        np.cos: lambda f: f._wave(np.cos(f.c), -np.sin(f.c)),
        np.maximum: lambda f, g: _maximum(f, g),
        np.minimum: lambda f, g: -_maximum(-f, -g),
    }

    def __init__(self, c: Array, g: Array, rem: Array) -> None:
        self.c, self.g, self.rem = c, g, rem

    @classmethod
    def variables(cls, lo: Array, hi: Array) -> list[Affine]:
        """The d variables themselves, on boxes from ``lo`` to ``hi``, (…, d) each."""
        centre, half = np.moveaxis(0.5 * (lo + hi), -1, 0), np.moveaxis(0.5 * (hi - lo), -1, 0)
        unit = np.eye(len(half)).reshape(*[len(half)] * 2, *[1] * (half.ndim - 1))
        rem = ROUNDING * (np.abs(centre) + half)
        return [cls(centre[i], unit[i] * half, rem[i]) for i in range(len(half))]

    @cached_property
    def radius(self) -> Array:
        """A bound of |f − c|."""
        return np.asarray(np.abs(self.g).sum(axis=0) + self.rem)

    @property
    def lower(self) -> Array:
        """A lower bound of f on each box."""
        return np.asarray(self.c - self.radius)

    @property
    def upper(self) -> Array:
        """An upper bound of f on each box."""
        return np.asarray(self.c + self.radius)

    def _size(self) -> Array:
        return np.asarray(np.abs(self.c) + self.radius)

    def __add__(self, other: Affine | float) -> Affine:
        if isinstance(other, Affine):
            c = self.c + other.c
            rem = self.rem + other.rem + ROUNDING * (self._size() + other._size())
            return Affine(c, self.g + other.g, rem)
        return Affine(self.c + other, self.g, self.rem + ROUNDING * (self._size() + abs(other)))

    def __neg__(self) -> Affine:
        return Affine(-self.c, -self.g, self.rem)

    def __sub__(self, other: Affine | float) -> Affine:
        return self + (-other)

    def __mul__(self, other: Any) -> Affine:
        if not isinstance(other, Affine):
            rem = self.rem * abs(other) + ROUNDING * self._size() * abs(other)
            return Affine(self.c * other, self.g * other, rem)
        rem = np.abs(self.c) * other.rem + np.abs(other.c) * self.rem + self.radius * other.radius
        rem = rem + ROUNDING * self._size() * other._size()
        return Affine(self.c * other.c, self.c * other.g + other.c * self.g, rem)

    def __truediv__(self, other: Affine | float) -> Affine:
        return self * (other.reciprocal() if isinstance(other, Affine) else 1.0 / other)

    def __rsub__(self, other: float) -> Affine:
        return -self + other

    def __rtruediv__(self, other: float) -> Affine:
        return self.reciprocal() * other

    def reciprocal(self) -> Affine:
        """1/f, for f of one sign on the box: 1/(c + e) = 1/c − e/c² + e²/(c²(c + e))."""
        least = np.abs(self.c) - self.radius
        least = np.where(least > 0.0, least, 0.0)
        inverse = 1.0 / self.c
        rem = inverse**2 * (self.rem + self.radius**2 / least)
        rem = rem + ROUNDING * (np.abs(inverse) + rem)
        return Affine(inverse, -self.g * inverse**2, rem)

    def sqrt(self) -> Affine:
        """√f, for f > 0: √(c + e) = √c + e/(2√c) − (√(c + e) − √c)²/(2√c)."""
        root = np.sqrt(self.c)
        step = self.radius / (root + np.sqrt(self.c - self.radius))
        rem = self.rem / (2.0 * root) + step**2 / (2.0 * root)
        return Affine(root, self.g / (2.0 * root), rem + ROUNDING * (root + self.radius / root))

    def _wave(self, here: Array, slope: Array) -> Affine:
        """w(f) for w'' = −w, of which w(c) and w'(c) are given: w(c + e) = w + w' e − … e²/2."""
        rem = np.abs(slope) * self.rem + 0.5 * self.radius**2 + ROUNDING * (1.0 + self._size())
        return Affine(here, slope * self.g, rem)

    def __abs__(self) -> Affine:
        """|f|: where f may have either sign, the chord over its range, halfway down to the kink."""
        below, above = np.maximum(-self.lower, 0.0), np.maximum(self.upper, 0.0)
        width = np.where(below + above > 0.0, below + above, 1.0)
        slope, sag = (above - below) / width, below * above / width
        rem = np.abs(slope) * self.rem + sag + ROUNDING * (self._size() + sag)
        return Affine(slope * self.c + sag, slope * self.g, rem)

    def restrict(self, low: float, high: float) -> Affine:
        """The same where it is known to lie between two ends: these alone where they say more."""
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        own = np.abs(self.c - middle) + self.radius <= FARTHER * half
        rem = np.where(own, self.rem, half + ROUNDING * (abs(low) + abs(high)))
        return Affine(np.where(own, self.c, middle), np.where(own, self.g, 0.0), rem)


def _maximum(f: Affine, g: Affine) -> Affine:
    """The larger one where that is known, else (f + g + |f − g|)/2."""
    apart = f - g
    either = (f + g + abs(apart)) * 0.5
    for sure, one in ((apart.lower >= 0.0, f), (apart.upper <= 0.0, g)):
        pairs = zip((one.c, one.g, one.rem), (either.c, either.g, either.rem), strict=True)
        either = Affine(*(np.where(sure, mine, other) for mine, other in pairs))
    return either


def positive(value: Any) -> Any:
    """A value that must be positive: a model that may not be so on a box is unknown there."""
    if not isinstance(value, Affine):
        return value
    return Affine(value.c, value.g, np.where(value.lower > 0.0, value.rem, np.inf))


def minorant_plane(
    function: Callable[..., Any], low: Array, high: Array, at: Array, cells: Sequence[int]
) -> tuple[Array, Array] | None:
    """The highest plane below a function that is as steep as it at a place, over n boxes at once.

    What stands above a plane through 0 of these slopes is enclosed on small cells.

    Args:
        function: of k variables: of complex numbers, and of affine models.
        low, high, at: the boxes and the place in each, (k, n).
        cells: into how many parts each variable's range is cut at most: narrow ones into fewer.
            Variables and values are of the order of 1.

    Returns:
        slopes (k, n) and the height at 0 (n,); None where the function cannot be enclosed.
    """
    with np.errstate(all="ignore"):
        # 1. Slopes by complex steps: exact but for rounding, which costs tightness alone.
        steps = 1j * COMPLEX_STEP * np.eye(len(low))
        slopes = np.stack([np.imag(function(*(at + step[:, None]))) for step in steps])
        slopes /= COMPLEX_STEP
        # 2. The function less the plane, on every cell.
        needed = np.ceil(np.max(high - low, axis=1) / NARROW)
        parts = np.clip(needed, 1, cells).astype(int)
        nth = np.moveaxis(np.indices(tuple(parts)), 0, -1).reshape(-1, 1, len(low))
        width = (high - low).T / parts
        variables = Affine.variables(low.T + width * nth, low.T + width * (nth + 1))
        above = function(*variables)
        for variable, slope in zip(variables, slopes, strict=True):
            above = above - variable * slope
        height = np.min(above.lower, axis=0)
    known = np.all(np.isfinite(slopes)) and np.all(np.isfinite(height))
    return (slopes, height) if known else None
