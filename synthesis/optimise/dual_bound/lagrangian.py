"""The Lagrangian: multiplied rows added up as a functional of arbitrary laws.

By Taylor's formula every term λ alpha_k g^(k)(x) is a sum over the initial values g^(j)(0) and an
integral of the control w = g^(m). So the Lagrangian is

    constant + Σ initial_costates · (unknown g^(j)(0)) + size · ζ + level π + Σ ∫ ψ w dx,

with a switching function ψ for every free law. Next to each sum stands the sum of the absolute
values of its terms: rounding errors are a small share of that.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.row_functionals import WeightedRows
from synthesis.optimise.dual_bound.switching import Switching, switching
from synthesis.optimise.problem.boundary import Junction, junction_rows


@dataclass(eq=False)
class Lagrangian:
    """A Lagrangian to which terms are added one after the other.

    Attributes:
        model: whose rows. order: m, the order of the control.
        size: (n_size,) factor of ζ. level: factor of π.
        size_magnitude: sum of the absolute values of what went into ``size``.
        psi_error: (laws,) bound of |true ψ − its polynomials|, from residual vibration.
    """

    model: ConicModel
    order: int
    size: Array = field(init=False)
    level: float = 0.0
    size_magnitude: Array = field(init=False)
    psi_error: Array = field(init=False)
    _constant: float = field(default=0.0, init=False)
    _magnitude: float = field(default=0.0, init=False)
    _initial_costates: list[Array] = field(init=False)
    _psi_magnitude: Array = field(init=False)
    _points: list[list[Array]] = field(init=False)
    _weights: list[list[Array]] = field(init=False)
    _spans: list[list[Array]] = field(init=False)
    _polys: list[list[Array]] = field(init=False)
    _reduced: list[int] = field(init=False)

    def __post_init__(self) -> None:
        laws = range(len(self.model.grids))
        self.size = np.zeros(len(self.model.problem.sizing.bounds))
        self.size_magnitude, self._psi_magnitude = np.zeros_like(self.size), np.zeros(len(laws))
        self.psi_error = np.zeros(len(laws))
        self._initial_costates = [np.zeros(self.order) for _ in laws]
        self._points, self._weights = [[] for _ in laws], [[] for _ in laws]
        self._spans, self._polys = [[] for _ in laws], [[] for _ in laws]
        self._reduced = [0 for _ in laws]

    @property
    def constant(self) -> float:
        """The constant term."""
        self._reduce_to_initial_values()
        return self._constant

    @property
    def magnitude(self) -> float:
        """Sum of the absolute values of what went into ``constant``."""
        self._reduce_to_initial_values()
        return self._magnitude

    @property
    def initial_costates(self) -> list[Array]:
        """Per free law, (m,) factors of unknown initial values g^(j)(0)."""
        self._reduce_to_initial_values()
        return self._initial_costates

    @property
    def psi_magnitude(self) -> Array:
        """Sum of the absolute values of what went into every law's ψ."""
        self._reduce_to_initial_values()
        return self._psi_magnitude

    def add_constant(self, amount: float) -> None:
        """Add a constant."""
        self._constant += amount
        self._magnitude += abs(amount)

    def add_rows(self, rows: WeightedRows, mass: Array) -> None:
        """Add rows times their multipliers (n,)."""
        if np.count_nonzero(mass) < len(mass):
            nonzero = mass != 0.0
            rows, mass = rows.select(nonzero), mass[nonzero]
        if not len(mass):
            return
        self.add_constant(-float(mass @ rows.rhs))
        self.size += mass @ rows.size
        self.size_magnitude += np.abs(mass) @ np.abs(rows.size)
        if rows.level:
            self.level += rows.level * float(np.sum(mass))
        if rows.position is None:
            return
        self.add_functionals(rows.position, rows.x, mass[:, None] * rows.weights)
        if rows.spans is not None and rows.poly is not None:
            self._spans[rows.position].append(rows.spans)
            self._polys[rows.position].append(mass[:, None] * rows.poly)
            self._psi_magnitude[rows.position] += float(np.abs(mass) @ np.abs(rows.poly[:, 0]))

    def add_functionals(self, position: int, x: Array, weights: Array) -> None:
        """Add Σ weights[i, k] g^(k)(x_i) of one law: x (n,), weights (n, m)."""
        self._points[position].append(x)
        self._weights[position].append(weights)

    def _reduce_to_initial_values(self) -> None:
        """Add the initial values' share of the functionals that were added since the last time."""
        for position, arrays in enumerate(self._weights):
            first = self._reduced[position]
            if first == len(arrays):
                continue
            self._reduced[position] = len(arrays)
            weights = np.concatenate(arrays[first:])
            size = float(np.abs(weights).sum())
            self._psi_magnitude[position] += size
            start = self.model.boundary_states[position].start[: self.order]
            shares = _sums_at_start(np.concatenate(self._points[position][first:]), weights)
            known = len(start)
            for share, value in zip(shares[:known].tolist(), start.tolist(), strict=True):
                self._constant += share * value
                self._magnitude += size * abs(value)  # shares are sums that may cancel
            self._initial_costates[position][known:] += shares[known:]

    def add_boundary_costates(self, costates: Sequence[Array]) -> None:
        """Add the end conditions of all laws, times their costates (m,).

        A derivative that two laws share has one costate; it acts on the start of the law after the
        junction as well.
        """
        for position, nu in enumerate(costates):
            known = self.model.boundary_states[position].end[: len(nu)]
            self.add_constant(-float(nu[: len(known)] @ known))
            self.add_functionals(position, np.ones(1), nu[None, :])
        for junction in self.model.junctions:
            for k, ratio in propagate_state(self.model, junction, self.order):
                self.initial_costates[junction.after][k] += ratio * costates[junction.before][k]

    def psi(self) -> tuple[Switching, ...]:
        """The switching function of every law."""
        return tuple(self._psi(position) for position in range(len(self._points)))

    def _psi(self, position: int) -> Switching:
        points = np.concatenate([np.zeros(0), *self._points[position]])
        weights = np.concatenate([np.zeros((0, self.order)), *self._weights[position]])
        result = switching(points, weights, self.order)
        if not self._spans[position]:
            return result
        poly = np.concatenate(self._polys[position])
        used = np.flatnonzero(poly.any(axis=0))
        poly = poly[:, : used[-1] + 1] if len(used) else poly[:, :1]
        return result.with_densities(np.concatenate(self._spans[position]), poly)


def initial_terms(x: Array, weights: Array) -> Array:
    """What weights (n, m) on g, g', … at x (n,) come to in them at 0, by Taylor: (n, m)."""
    order = weights.shape[1]
    powers = _powers(x, order)
    return np.stack(
        [
            np.sum([weights[:, k] * powers[j - k] for k in range(j + 1)], axis=0)
            for j in range(order)
        ],
        axis=1,
    )


def _sums_at_start(x: Array, weights: Array) -> Array:
    """The sums over all x of what ``initial_terms`` says of each: (m,)."""
    order = weights.shape[1]
    moments = (_powers(x, order) @ weights).tolist()
    return np.array([sum(moments[j - k][k] for k in range(j + 1)) for j in range(order)])


def _powers(x: Array, count: int) -> Array:
    """x^n/n! for n < count: (count, n)."""
    result = np.ones((count, len(x)))
    result[1:2] = x
    for n in range(2, count):
        np.multiply(result[n - 1], x / n, out=result[n])
    return result


def propagate_state(
    model: ConicModel, junction: Junction, order: int
) -> Iterator[tuple[int, float]]:
    """Orders below ``order`` shared at a junction, and the factor of the costate after it."""
    before, after = junction_rows(junction, model.problem.free, model.grids)
    for k in range(junction.lowest, min(junction.highest + 1, order)):
        at = k - junction.lowest
        yield k, float(after.units[at] / before.units[at])
