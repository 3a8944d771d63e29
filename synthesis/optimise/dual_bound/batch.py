"""Lower bounds of many quantities at once, over every motion law and size that keep a model's rows.

Each quantity is linear in one law, at a point, and in the size. Multipliers of the rows, one set
for each quantity, add the rows to it; what is left is least for a law that switches with the sign
of ψ and for a size at the ends of its ranges. It is the duality of ``bound``, for capped laws and
without an objective, in a few operations on tables: hundreds of bounds cost what one costs there.

Multipliers of rows at points are spread along the arcs where a limit is met all along
(``MultiplierDensity``). A multiplier of the second derivative at a point makes ψ jump. Where such a
row is met along an arc the true multiplier is a density, and ψ vanishes there: a point's share
between it and a neighbour that has a multiplier too is spread over what lies between them. Where an
arc begins or ends the true one has masses too; so each share is spread only where that makes ψ
smaller. Any masses of any shape give valid bounds, where the rows hold in between too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array, gauss_points
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.bound import ROUNDING, unknown_initial_values
from synthesis.optimise.dual_bound.costates import end_coefficients, end_costates, project_costates
from synthesis.optimise.dual_bound.lagrangian import Lagrangian, sums_at_start
from synthesis.optimise.dual_bound.row_functionals import (
    RowFunctional,
    fixed_size_rows,
    row_functionals,
)
from synthesis.optimise.dual_bound.switching import NODES, mean_absolute
from synthesis.optimise.dual_bound.vibration_terms import vibration_terms


@dataclass(frozen=True, eq=False)
class Quantities:
    """Quantities alpha · (g, g', g'') (x) + size · ζ, in the model's units.

    Attributes:
        law: (q,) positions of the free laws. x: (q,). alpha: (q, 3). size: (q, n_size).
    """

    law: Array
    x: Array
    alpha: Array
    size: Array

    def scaled(self) -> tuple[Quantities, Array]:
        """Every quantity over its largest factor, and these units (q,)."""
        units = np.maximum(np.abs(self.alpha).max(axis=1), np.abs(self.size).max(axis=1))
        alpha, size = self.alpha / units[:, None], self.size / units[:, None]
        return replace(self, alpha=alpha, size=size), units

    def objectives(self, model: ConicModel) -> list[Array]:
        """The same as objectives of the model's program, but for constants: one (n,) each."""
        result = np.zeros((len(self.x), model.program.matrix.shape[1]))
        result[:, model.size] = self.size
        for position in np.unique(self.law):
            mine, rows = self.rows_of_law(model, position)
            result[mine, model.columns[position]] = model.boundary_states[position].split(rows)[0]
        return list(result)

    def rows_of_law(self, model: ConicModel, position: int) -> tuple[NDArray[np.intp], Array]:
        """Which of them speak of one law, and their factors (k, n) of its coefficients."""
        mine = np.flatnonzero(self.law == position)
        space, alpha = model.grids[position].space, self.alpha[mine]
        rows = np.zeros((len(mine), space.size))
        for order in np.flatnonzero(np.any(alpha, axis=0)):
            acting = alpha[:, order] != 0.0
            table = space.basis(self.x[mine[acting]], int(order))
            rows[acting] += alpha[acting, order][:, None] * table
        return mine, rows


def solve_boundary_costates(
    model: ConicModel, quantities: Quantities, multipliers: Array, order: int
) -> Array:
    """The solver's costates of g to g^(m−1) at the end of every law, m the order: (q, laws, m)."""
    gradients = []
    for position in range(len(model.grids)):
        last = end_coefficients(model, position)
        mine, rows = quantities.rows_of_law(model, position)
        gradients.append(np.zeros((len(multipliers), rows[:, last].shape[1])))
        gradients[-1][mine] = rows[:, last]
    return end_costates(model, multipliers, gradients, order)


def dual_bounds(
    model: ConicModel,
    controls: Sequence[Control],
    sizes: Sequence[tuple[float, float]],
    quantities: Quantities,
    multipliers: Array,
    costates: Array,
) -> Array:
    """A lower bound of every quantity: (q,), −inf where none follows.

    Args:
        controls: caps of every free law's control, of one order m, or of one mean square of all.
            sizes: ranges of the size [length].
        multipliers: (q, m) of the model's rows, of its cones those on residual vibration alone;
            any, good ones bound well. Of a mean square the best one is known, and taken.
        costates: (q, laws, m) costates of the laws' ends (``solve_boundary_costates``); any.
    """
    # 1. The quantities and the rows times their multipliers: linear in all unknowns.
    lagrangian = _lagrangian(model, quantities, multipliers, costates)
    total, magnitude = lagrangian.constant, lagrangian.magnitude
    # 2. Least over every law: ∫ ψ w with |w| ≤ cap where w switches with the sign of ψ.
    for k, control in enumerate(controls):
        if control.cap == inf:
            continue
        integral = control.cap * np.sum(_absolute_pieces(lagrangian, k)[1], axis=1)
        total = total - integral - control.cap * lagrangian.psi_error[:, k]
        magnitude = magnitude + integral + control.cap * lagrangian.psi_magnitude[:, k]
    #    Where a mean square of all laws is capped, less what they can make of it together.
    if any(control.cap == inf for control in controls):
        together = _least_under_mean_square(lagrangian)
        total, magnitude = total + together, magnitude - together
    total = total - unknown_initial_values(lagrangian, [largest_integral(c) for c in controls])
    # 3. What is left of the size: linear, so least at an end of each range.
    low, high = np.array(sizes).T / model.scales.size
    total = total + np.sum(np.minimum(lagrangian.size * low, lagrangian.size * high), axis=1)
    magnitude = magnitude + lagrangian.size_magnitude @ np.maximum(np.abs(low), np.abs(high))
    # 4. Less an allowance for rounding, in proportion to all that was added up.
    return np.where(np.isfinite(total), total - ROUNDING * magnitude, -np.inf)


def _lagrangian(
    model: ConicModel, quantities: Quantities, multipliers: Array, costates: Array
) -> Lagrangian:
    """The quantities, and the rows times their multipliers projected on λ ≥ 0."""
    z, first = np.array(multipliers), model.program.equalities
    last = first + model.program.inequalities
    z[:, first:last] = np.maximum(z[:, first:last], 0.0)
    order = costates.shape[2]
    lagrangian = Lagrangian(model, order, len(z))
    lagrangian.size += quantities.size
    lagrangian.size_magnitude += np.abs(quantities.size)
    for k in range(len(model.grids)):
        mine = np.flatnonzero(quantities.law == k)
        weights = np.zeros((len(z), len(mine), order))
        weights[mine, np.arange(len(mine))] = quantities.alpha[mine, :order]
        lagrangian.add_functionals(k, quantities.x[mine], weights)
    for one in row_functionals(model, order):
        own = z[:, one.first_row : one.first_row + one.count]
        lagrangian.add_rows(one.point_rows(), own)
    vibrations, lagrangian.psi_error = vibration_terms(
        model, order, model.vibration_multipliers(z), len(z)
    )
    for rows, mass in (*fixed_size_rows(model, z), *vibrations):
        lagrangian.add_rows(rows, mass)
    lagrangian.reduce()
    lagrangian.add_boundary_costates(project_costates(model, lagrangian.initial_costates, costates))
    return lagrangian


def _least_under_mean_square(lagrangian: Lagrangian) -> Array:
    """The least of Σ ∫ ψ w over all controls with Σ W ∫ w² ≤ room: −√(room Σ ∫ ψ²/W), (q,).

    By Cauchy and Schwarz, with equality where every w is −ψ/W times one number. The multiplier of
    the cap is the best one, whatever the solver's is. What rounding or a vibration adds to ψ adds
    no more than its largest value to √∫ ψ², which is a norm.
    """
    held = ((cone.energy, cone.room) for cone in lagrangian.model.cone_blocks)
    ((weights, room),) = ((energy.weights, room) for energy, room in held if energy is not None)
    squares = np.zeros(lagrangian.count)
    for k, weight in enumerate(weights):
        blur = lagrangian.psi_error[:, k] + ROUNDING * lagrangian.psi_magnitude[:, k]
        squares += (root_mean_squares(lagrangian, k) + blur) ** 2 / weight
    return np.asarray(-np.sqrt(room * squares))


def root_mean_squares(lagrangian: Lagrangian, position: int) -> Array:
    """√∫ ψ² of one law, (q,): Gauss's rule is exact, and a sum of squares loses no digits."""
    breaks, poly = lagrangian.psi_pieces(position)
    s, shares = (each[0] for each in gauss_points(np.array([0.0, 1.0]), NODES))
    value = poly @ s ** np.arange(poly.shape[2])[:, None]
    return np.asarray(np.sqrt(np.einsum("qns,s,n->q", value**2, shares, np.diff(breaks))))


def largest_integral(control: Control) -> float:
    """What |∫ (x − τ)²/2 w dτ| is at most: by the cap, or by Schwarz's inequality."""
    return 0.5 * control.cap if control.cap < inf else sqrt(control.square)


def _absolute_pieces(lagrangian: Lagrangian, position: int) -> tuple[Array, Array]:
    """∫ |ψ| of one law, piece by piece: breaks (n+1,) and integrals (q, n)."""
    breaks, poly = lagrangian.psi_pieces(position)
    flat = poly.reshape(-1, poly.shape[2])
    if poly.shape[2] > 3:
        shares = mean_absolute(flat).reshape(poly.shape[:2])
        return breaks, shares * np.diff(breaks)
    parabolas = np.zeros((len(flat), 3))
    parabolas[:, : flat.shape[1]] = flat
    shares = mean_absolute(parabolas, exact=True).reshape(poly.shape[:2])
    return breaks, shares * np.diff(breaks)


@dataclass(frozen=True, eq=False)
class PointRuns:
    """Points of rows, and points between neighbouring rows, all in ascending order.

    Blocks are made at these points, and the points of a block ascend (``Block.x``).

    Attributes:
        points: (r + each n,) strictly ascending.
        rows: (r,) indices of the rows' own points in ``points``.
        inner: (n, each) indices of the points between two rows in ``points``.
        left: (n,) number of the row before them. right_share, left_share: (n,) shares of the
            multipliers of the rows before and after that belong there.
    """

    points: Array
    rows: NDArray[np.intp]
    inner: NDArray[np.intp]
    left: NDArray[np.intp]
    right_share: Array
    left_share: Array

    @classmethod
    def of(cls, x: Array, parts: Sequence[tuple[float, float]], each: int) -> PointRuns:
        """For rows at x (r,), strictly ascending, on parts of a law.

        ``each``: points between two neighbouring rows of one part.
        """
        part = np.searchsorted([low for low, _ in parts], x, "right")
        together = part[1:] == part[:-1]
        left = np.flatnonzero(together)
        gaps = np.zeros(len(x) + 1)
        gaps[left + 1] = x[left + 1] - x[left]
        reach = np.maximum(gaps[1:] + gaps[:-1], 1e-300)
        ahead, behind = gaps[left + 1] / reach[left], gaps[left + 1] / reach[left + 1]
        # every interval between two rows of one part moves the rows behind it up by ``each``
        rows = np.arange(len(x))
        rows[1:] += each * np.cumsum(together)
        inner = rows[left, None] + 1 + np.arange(each)
        points = np.empty(len(x) + inner.size)
        points[rows] = x
        points[inner] = x[left, None] + gaps[left + 1, None] * (np.arange(each) + 0.5) / each
        return cls(points, rows, inner, left, ahead, behind)

    def distribute(self, z: Array, chosen: NDArray[Any] | float) -> Array:
        """Multipliers (…, r) of the rows as masses at all points; spread where ``chosen`` (n,)."""
        own = z[..., self.left] * self.right_share * chosen
        following = z[..., self.left + 1] * self.left_share * chosen
        kept = np.array(z)
        kept[..., self.left] -= own
        kept[..., self.left + 1] -= following
        each = self.inner.shape[1]
        rising = (np.arange(each) + 0.5) * 2.0 / each**2
        masses = np.empty((*z.shape[:-1], len(self.points)))
        masses[..., self.rows] = kept
        masses[..., self.inner] = own[..., None] * rising[::-1] + following[..., None] * rising
        return masses

    def sum_between(self, breaks: Array, amounts: Array) -> Array:
        """Sums of amounts (…, pieces) over what lies between the rows: (…, n)."""
        sums = np.concatenate([np.zeros((*amounts.shape[:-1], 1)), np.cumsum(amounts, axis=-1)], -1)
        ends = (self.points[self.rows[k]] for k in (self.left, self.left + 1))
        first, last = (np.searchsorted(breaks, end) for end in ends)
        return np.asarray(sums[..., last] - sums[..., first])


@dataclass(frozen=True, eq=False)
class MultiplierDensity:
    """A model with rows between the points of another's, where they hold too.

    Attributes:
        model: for bounds, not to be solved. solved: the other one, whose multipliers are known.
        point_runs: of every block, None where it has no more points.
    """

    model: ConicModel
    solved: ConicModel
    point_runs: tuple[PointRuns | None, ...]

    @classmethod
    def of(
        cls,
        model: ConicModel,
        denser: Sequence[tuple[LinearBlock, PointRuns | None]],
        each: int,
        order: int,
    ) -> MultiplierDensity:
        """For a model whose last blocks are these with fewer points.

        Of the others those that hold all along a law, with the same factors everywhere, too.
        ``order``: of the control; rows of the derivative just below it make ψ jump.
        """
        result = list[tuple[LinearBlock, PointRuns | None]]()
        for block in model.blocks[: len(model.blocks) - len(denser)]:
            runs = None
            uniform = block.alpha.ndim == 1 and block.spans is None
            jumps = uniform and block.highest_order == order - 1 and not block.exact
            if jumps and block.ascending:
                runs = PointRuns.of(block.x, ((0.0, 1.0),), each)
                # the splines' matrix is left out, which bounds do not read
                rhs = np.full(len(runs.points), block.rhs[0])
                block = replace(block, law_matrix=None, x=runs.points, rhs=rhs)
            result.append((block, runs))
        result += denser
        dense = tuple(block for block, _ in result)
        program = replace(model.program, inequalities=sum(len(block.rhs) for block in dense))
        both = replace(model, blocks=dense, program=program), model
        return cls(*both, tuple(runs for _, runs in result))

    def distribute(self, quantities: Quantities, z: Array, costates: Array) -> Array:
        """The other model's multipliers z (q, m) of some quantities as this one's."""
        # ∫ |ψ| between every two rows, with their multipliers at points, and spread between them.
        every = self._masses(z, [1.0] * len(self.point_runs))
        both = [
            _lagrangian(self.solved, quantities, z, costates),
            _lagrangian(self.model, quantities, every, costates),
        ]
        laws = range(len(self.model.grids))
        points, spread = ([_absolute_pieces(one, k) for k in laws] for one in both)
        chosen: list[NDArray[Any] | float] = []
        for runs, block in zip(self.point_runs, self.model.blocks, strict=True):
            if runs is None or block.segment is None:
                chosen.append(0.0)
            else:
                k = block.segment
                chosen.append(runs.sum_between(*spread[k]) < runs.sum_between(*points[k]))
        return self._masses(z, chosen)

    def balance(self, masses: Array, z: Array, order: int) -> Array:
        """Distributed masses (q, m), in total worth as much as the multipliers z (q, m') were.

        Rows between two points differ from those at the points, and the centre of what is spread
        is not where it came from. So ψ gets a polynomial on all that lies before an arc, by far the
        larger part of a law, and the size another factor. Of every block the masses are changed by
        the least, relative to each of them, that makes both what the points made of them. On fine
        knots that is a better bound; on coarse ones it may be a worse one.
        """
        points = self._masses(z, [0.0] * len(self.point_runs))
        result, at = masses.copy(), self.model.program.equalities
        for runs, block in zip(self.point_runs, self.model.blocks, strict=True):
            here, at = slice(at, at + len(block.rhs)), at + len(block.rhs)
            if runs is None or not len(block.rhs):  # no arc: cuts may leave nothing of it
                continue
            # 1. What a unit of each row comes to: the powers of ψ before it, and in the size.
            rows = RowFunctional(self.model, block, here.start, order).point_rows()
            about = 0.5 * (rows.x[0] + rows.x[-1])
            effect = sums_at_start((rows.x - about)[:, None], rows.weights[:, None])
            effect = np.hstack([effect, rows.size])
            effect = effect[:, np.any(effect, axis=0)]
            effect = effect / np.max(np.abs(effect), axis=0)
            # 2. The least squares of relative changes: each is linear in these effects.
            own = masses[:, here]
            missing = (points[:, here] - own) @ effect
            squares = (effect[:, :, None] * effect[:, None]).reshape(len(effect), -1)
            gram = (own @ squares).reshape(len(own), *2 * (effect.shape[1],))
            change = np.einsum("qcd,qd->qc", np.linalg.pinv(gram, hermitian=True), missing)
            result[:, here] = own * np.maximum(1.0 + change @ effect.T, 0.0)
        return result

    def distribute_single(self, z: Array, costates: Array) -> tuple[Array, Array]:
        """The same for one set of multipliers (m,) for the model's own objective; and balanced."""
        none = np.zeros((1, len(self.model.problem.sizing.bounds)))
        nothing = Quantities(np.zeros(1, dtype=int), np.zeros(1), np.zeros((1, 3)), none)
        masses = self.distribute(nothing, z[None], costates)
        return masses[0], self.balance(masses, z[None], costates.shape[2])[0]

    def _masses(self, z: Array, chosen: Sequence[NDArray[Any] | float]) -> Array:
        """Multipliers of all rows, spread where chosen, block by block."""
        at = self.model.program.equalities
        parts = [z[..., :at]]
        for runs, block, here in zip(self.point_runs, self.model.blocks, chosen, strict=True):
            count = len(block.rhs) - (0 if runs is None else runs.inner.size)
            own = z[..., at : at + count]
            parts.append(own if runs is None else runs.distribute(np.maximum(own, 0.0), here))
            at += count
        return np.concatenate([*parts, z[..., at:]], axis=-1)
