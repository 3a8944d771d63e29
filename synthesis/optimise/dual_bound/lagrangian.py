"""The Lagrangian: multiplied rows added up as a functional of arbitrary laws.

By Taylor's formula every term λ alpha_k g^(k)(x) is a sum over the initial values g^(j)(0) and an
integral of the control w = g^(m). So the Lagrangian is

    constant + Σ initial_costates · (unknown g^(j)(0)) + size · ζ + level π + Σ ∫ ψ w dx,

with a switching function ψ for every free law. Next to each sum stands the sum of the absolute
values of its terms: rounding errors are a small share of that. There are q sums at once, one for
each of q sets of multipliers: one for the bound of an objective, hundreds for bound tightening.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.row_functionals import WeightedRows
from synthesis.optimise.dual_bound.switching import Switching, add_densities, switching_pieces
from synthesis.optimise.problem.boundary import junction_rows


class Lagrangian:
    """q Lagrangians, to which terms are added one after the other; complete after ``reduce``.

    Attributes:
        model: whose rows. order: m, the order of the control. count: q.
        constant: (q,). magnitude: (q,) sum of the absolute values of what went into it.
        initial_costates: (q, laws, m) factors of unknown initial values g^(j)(0).
        size: (q, n_size) factor of ζ. level: (q,) factor of π.
        size_magnitude, psi_magnitude: (q, n_size) and (q, laws), sums of the absolute values of
            what went into ``size`` and into every ψ.
        psi_error: (q, laws) bounds of |true ψ − its polynomials|, from residual vibration.
    """

    def __init__(self, model: ConicModel, order: int, count: int = 1) -> None:
        self.model, self.order, self.count = model, order, count
        laws, sizes = len(model.grids), len(model.problem.sizing.bounds)
        self.constant, self.magnitude, self.level = np.zeros((3, count))
        self.size, self.size_magnitude = np.zeros((2, count, sizes))
        self.initial_costates = np.zeros((count, laws, order))
        self.psi_magnitude, self.psi_error = np.zeros((2, count, laws))
        self._functionals: list[list[tuple[Array, Array]]] = [[] for _ in range(laws)]
        self._densities: list[list[tuple[Array, Array]]] = [[] for _ in range(laws)]
        self._reduced = [0] * laws

    def add_constant(self, amount: float | Array, magnitude: float | Array | None = None) -> None:
        """Add a constant; ``magnitude``: of the terms that it is the sum of."""
        self.constant += amount
        self.magnitude += np.abs(amount) if magnitude is None else magnitude

    def add_rows(self, rows: WeightedRows, mass: Array) -> None:
        """Add rows times their multipliers, (n,) or (q, n)."""
        mass = mass.reshape(self.count, -1)
        if not mass.shape[1]:
            return
        absolute = np.abs(mass)
        self.add_constant(-(mass @ rows.rhs), absolute @ np.abs(rows.rhs))
        self.size += mass @ rows.size
        self.size_magnitude += absolute @ np.abs(rows.size)
        if rows.level:
            self.level += rows.level * mass.sum(axis=1)
        if rows.position is None:
            return
        self.add_functionals(rows.position, rows.x, mass[:, :, None] * rows.weights)
        if rows.spans is not None and rows.poly is not None:
            self._densities[rows.position].append((rows.spans, mass[:, :, None] * rows.poly))
            self.psi_magnitude[:, rows.position] += absolute @ np.abs(rows.poly).max(axis=1)

    def add_functionals(self, position: int, x: Array, weights: Array) -> None:
        """Add Σ weights[…, i, k] g^(k)(x_i) of one law: x (n,), weights (q, n, m)."""
        self._functionals[position].append((x, weights))

    def add_breaks(self, position: int, x: Array) -> None:
        """Let ψ of one law have breaks at x (n,), where nothing acts."""
        self.add_functionals(position, x, np.zeros((self.count, len(x), self.order)))

    def reduce(self) -> None:
        """Add the initial values' share of the functionals that were added since the last time."""
        for position, functionals in enumerate(self._functionals):
            new, self._reduced[position] = functionals[self._reduced[position] :], len(functionals)
            if not new:
                continue
            weights = np.concatenate([each for _, each in new], axis=1)
            magnitude = np.abs(weights).sum(axis=(1, 2))
            self.psi_magnitude[:, position] += magnitude
            start = self.model.boundary_states[position].start[: self.order]
            shares, known = sums_at_start(np.concatenate([x for x, _ in new]), weights), len(start)
            # shares are sums that may cancel: their terms are as large as the weights
            self.add_constant(shares[:, :known] @ start, magnitude * np.abs(start).sum())
            self.initial_costates[:, position, known:] += shares[:, known:]

    def add_boundary_costates(self, costates: Array) -> None:
        """Add the end conditions of all laws, times their costates (q, laws, m).

        A derivative that two laws share has one costate; it acts on the start of the law after the
        junction as well.
        """
        for position, boundary in enumerate(self.model.boundary_states):
            nu, known = costates[:, position], boundary.end[: self.order]
            own = nu[:, : len(known)]
            self.add_constant(-(own @ known), np.abs(own) @ np.abs(known))
            self.add_functionals(position, np.ones(1), nu[:, None, :])
        self.reduce()
        for before, after, k, ratio in shared_derivatives(self.model, self.order):
            self.initial_costates[:, after, k] += ratio * costates[:, before, k]

    def functionals(self, position: int) -> tuple[Array, Array]:
        """All of one law: x (n,), weights (q, n, m). Densities act so on what lies before them."""
        each = self._functionals[position]
        points = np.concatenate([np.zeros(0), *(x for x, _ in each)])
        nothing = np.zeros((self.count, 0, self.order))
        return points, np.concatenate([nothing, *(w for _, w in each)], axis=1)

    def has_densities(self, position: int) -> bool:
        """Whether any multipliers of one law are densities."""
        return bool(self._densities[position])

    def psi_pieces(self, position: int) -> tuple[Array, Array]:
        """ψ of one law: breaks (n+1,), polynomials (q, n, d)."""
        breaks, poly = switching_pieces(*self.functionals(position))
        densities = self._densities[position]
        if not densities:
            return breaks, poly
        more = np.concatenate([each for _, each in densities], axis=1)
        used = np.flatnonzero(more.any(axis=(0, 1)))
        more = more[..., : used[-1] + 1] if len(used) else more[..., :1]
        return add_densities(breaks, poly, np.concatenate([spans for spans, _ in densities]), more)

    def psi(self) -> tuple[Switching, ...]:
        """The switching function of every law; of the first set of multipliers."""
        pieces = (self.psi_pieces(position) for position in range(len(self._densities)))
        return tuple(Switching(breaks, poly[0]) for breaks, poly in pieces)


def sums_at_start(x: Array, weights: Array) -> Array:
    """What weights (…, n, m) on g, g', … at x (…, n) come to in them at 0, by Taylor: (…, m)."""
    order = weights.shape[-1]
    # x^n/n!
    powers = np.ones((*x.shape[:-1], order, x.shape[-1]))
    for n in range(1, order):
        powers[..., n, :] = powers[..., n - 1, :] * (x / n if n > 1 else x)
    moments = powers @ weights
    result = moments[..., 0, :].copy()
    for n in range(1, order):
        result[..., n:] += moments[..., n, :-n]
    return np.asarray(result)


def shared_derivatives(model: ConicModel, order: int) -> Iterator[tuple[int, int, int, float]]:
    """Derivatives below ``order`` that two laws share: the positions of the laws before and after
    the junction, k, and the factor with which the costate of g^(k)(1) acts on g^(k)(0) after it.
    """
    for junction in model.junctions:
        before, after = junction_rows(junction, model.problem.free, model.grids)
        for k in range(junction.lowest, min(junction.highest + 1, order)):
            at = k - junction.lowest
            ratio = float(after.units[at] / before.units[at])
            yield junction.before, junction.after, k, ratio
