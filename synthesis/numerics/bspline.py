"""Clamped B-splines on [0, 1]: basis matrices, pieces, knots."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline

from synthesis.numerics.double_double import (
    DoubleDouble,
    difference,
    neighbour_differences,
    quotient,
)
from synthesis.numerics.piecewise import Array, Piecewise


@dataclass(frozen=True, eq=False)
class SplineSpace:
    """Splines of degree p, of class C^(p−1), clamped at 0 and 1 (de Boor).

    ``breaks``: (n+1,) knots without repetition, from 0 to 1.
    """

    degree: int
    breaks: Array

    @cached_property
    def knots(self) -> Array:
        """Knot vector with clamped ends: (n + 1 + 2p,)."""
        p = self.degree
        return np.concatenate([np.zeros(p), self.breaks, np.ones(p)])

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return len(self.breaks) - 1 + self.degree

    def basis(self, x: Array, order: int = 0) -> Array:
        """The ``order``-th derivative of every basis function at x: (len(x), size).

        At an inner knot the piece on the right counts, at 1 the last piece.
        """
        return np.asarray(self._basis(x, nu=order), dtype=float)

    @cached_property
    def greville(self) -> Array:
        """Abscissae at which interpolation by this space is well posed: (size,)."""
        return np.array([self.knots[i + 1 : i + 1 + self.degree].mean() for i in range(self.size)])

    @cached_property
    def _basis(self) -> BSpline:
        """All basis functions at once."""
        return BSpline.construct_fast(self.knots, np.eye(self.size), self.degree)

    def end_derivatives(self, x: float, count: int) -> Array:
        """Derivatives 0 to count − 1 of every basis function at an end of [0, 1]: (count, size)."""
        return self._ends[0 if x <= 0.0 else 1, :count]

    @cached_property
    def _ends(self) -> Array:
        """Derivatives at both ends of [0, 1], as many as there are and some zeros more."""
        both, orders = np.array([0.0, 1.0]), range(max(self.degree, 5) + 1)
        return _kept(np.stack([self.basis(both, order) for order in orders], axis=1))

    @cached_property
    def control_matrices(self) -> tuple[Array, ...]:
        """Matrices to the B-spline coefficients of each derivative: (size − order, size).

        A spline lies in the hull of its coefficients, so a bound on these bounds the
        derivative everywhere.
        """
        found, knots = [_kept(np.eye(self.size))], self.knots
        for k in range(self.degree):
            p = self.degree - k
            rise = knots[k + p + 1 : len(knots) - k - 1] - knots[k + 1 : len(knots) - k - p - 1]
            found.append(_kept(p * np.diff(found[-1], axis=0) / rise[:, None]))
        return tuple(found)

    @cached_property
    def step_matrix(self) -> Array:
        """Matrix to what each coefficient is more than the next one: (size − 1, size)."""
        return _kept(-np.diff(np.eye(self.size), axis=0))

    @cached_property
    def step_slopes(self) -> tuple[Array, Array]:
        """What a coefficient's step stands for: c_i − c_(i+1) = factor · a coefficient of g'.

        First where on [0, 1] that coefficient of g' stands, then factors ≤ 0: (size − 1,) each.
        """
        p, knots, count = self.degree, self.knots, self.size - 1
        x = np.mean([knots[2 + j : 2 + j + count] for j in range(p - 1)], axis=0)
        return _kept(x), _kept(-(knots[p + 1 : p + 1 + count] - knots[1 : 1 + count]) / p)

    def end_multipliers(self, gradient: Array) -> Array:
        """Prices of g to g^(q−1) at 1 that pay for a gradient (…, q) over the last q coefficients.

        Of a function that is made stationary in these by multiplying the known values at the end.
        """
        count = gradient.shape[-1]
        if count not in self._end_inverses:
            rows = self.end_derivatives(1.0, count)[:, self.size - count :]
            self._end_inverses[count] = np.asarray(np.linalg.inv(rows), dtype=float)
        return np.asarray(-gradient @ self._end_inverses[count])

    @cached_property
    def _end_inverses(self) -> dict[int, Array]:
        return {}

    def curve(self, coefficients: Array) -> Piecewise:
        """The spline as polynomial pieces about their left ends, right to the last digits."""
        return self.curves(coefficients[None, :])[0]

    def curves(self, coefficients: Array) -> list[Piecewise]:
        """The same of several splines: (k, size), in little more time than of one.

        Differences of neighbouring coefficients over close knots lose digits, most in the highest
        derivative; so they are taken in doubled precision, and rounded once.
        """
        table: DoubleDouble = (coefficients, np.zeros_like(coefficients))
        columns, share = list[Array](), 1.0
        for order in range(self.degree + 1):
            if order:
                table = quotient(neighbour_differences(table), self._gaps[order - 1])
                share *= (self.degree - order + 1) / order
            # values where each interval begins, of the derivative that has these coefficients
            inner = self.knots[order : len(self.knots) - order]
            derivative = BSpline.construct_fast(inner, table[0].T, self.degree - order)
            columns.append(share * derivative(self.breaks[:-1]).T)
        left = self.breaks[:-1]
        waves = np.zeros((len(left), 0, 3))
        tables = np.stack(columns, axis=-1)
        return [Piecewise(self.breaks, left, poly, waves) for poly in tables]

    @cached_property
    def _gaps(self) -> tuple[DoubleDouble, ...]:
        """By what differences are divided for the derivatives from the first to the highest."""
        found, t = [], self.knots
        for order in range(1, self.degree + 1):
            inner, p = t[order : len(t) - order], self.degree - order + 1
            found.append(difference(inner[p:], inner[:-p]))
        return tuple(found)


def _kept(table: Array) -> Array:
    """The table, to be read only: it is handed out again and again."""
    table.setflags(write=False)
    return table
