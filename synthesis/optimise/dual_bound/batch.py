"""Lower bounds of many quantities at once, over every motion law and size that keep a model's rows.

Each quantity is linear in one law, at a point, and in the size. Multipliers of the rows, one set
for each quantity, add the rows to it; what is left is least for a law that switches with the sign
of ψ and for a size at the ends of its ranges. It is the duality of ``bound``, for capped laws and
without an objective, in a few operations on tables: hundreds of bounds cost what one costs there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import factorial

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.bound import INITIAL_VALUE_BOUND, ROUNDING
from synthesis.optimise.dual_bound.lagrangian import propagate_state
from synthesis.optimise.dual_bound.row_functionals import sort_by_place
from synthesis.optimise.problem.boundary import junction_rows

ORDER = 3
"""Of the control: only capped jerks are handled here."""


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
        model: rows that hold. controls: caps of every free law's third derivative.
        sizes: ranges of the size variables [length].
        quantities: the quantities.
        multipliers: (q, m) of the model's rows without its cones; any, good ones bound well.
        costates: (q, laws, 3) costates of the laws' ends (``solve_boundary_costates``); any.
    """
    # 1. Multipliers of the right sign: by weak duality any of these give a valid bound.
    z = _feasible_multipliers(model, multipliers)
    # 2. The rows times them, added to the quantity: a constant, and what is left of the size.
    total, magnitude = np.zeros(len(z)), np.zeros(len(z))
    residual = quantities.size.copy()
    for first, block in _law_blocks(model):
        row_multipliers = z[:, first : first + len(block.rhs)]
        total -= row_multipliers @ block.rhs
        magnitude += np.abs(row_multipliers) @ np.abs(block.rhs)
        if len(block.size):
            size = np.broadcast_to(block.size, (len(block.rhs), residual.shape[1]))
            residual += row_multipliers @ size
    total, residual = _add_fixed_sizes(model, z, total, residual)
    # 3. What is left of every law, as ∫ψw with the control |w| ≤ cap and its initial values
    #    (Taylor's formula): least where w switches with the sign of ψ, that is −cap ∫|ψ|.
    laws, costates = _functionals(model, quantities, z, costates)
    for position, (x, weights) in enumerate(laws):
        price, start = costates[:, position], _initial_terms(x, weights)
        boundary = model.boundary_states[position]
        count = min(len(boundary.end), ORDER)
        given = np.zeros(ORDER)
        given[: min(len(boundary.start), ORDER)] = boundary.start[:ORDER]
        total += start @ given - price[:, :count] @ boundary.end[:count]
        cap = controls[position].cap
        integral = cap * np.sum(absolute_piece_integrals(*switching_pieces(x, weights)), axis=1)
        magnitude += integral + np.abs(price[:, :count]) @ np.abs(boundary.end[:count])
        magnitude += cap * np.sum(np.abs(weights), axis=(1, 2))
        total -= integral
        rest = start + _costates_carried(model, position, costates)
        total -= _unknown_initial_values(model, position, cap, rest[:, len(boundary.start) :])
    # 4. What is left of the size: linear, so least at an end of each range.
    bounds = np.array(sizes) / model.scales.size
    total += np.sum(np.minimum(residual * bounds[:, 0], residual * bounds[:, 1]), axis=1)
    magnitude += np.sum(np.abs(residual) * np.max(np.abs(bounds), axis=1), axis=1)
    # 5. Less an allowance for rounding, in proportion to all that was added up.
    return np.where(np.isfinite(total), total - ROUNDING * magnitude, -np.inf)


def switching_functions(
    model: ConicModel, quantities: Quantities, multipliers: Array, costates: Array
) -> list[tuple[Array, Array]]:
    """∫ |ψ| of every law, piece by piece: breaks (n+1,) and integrals (q, n)."""
    result = []
    for x, weights in _functionals(
        model, quantities, _feasible_multipliers(model, multipliers), costates
    )[0]:
        breaks, poly = switching_pieces(x, weights)
        result.append((breaks, absolute_piece_integrals(breaks, poly)))
    return result


def _feasible_multipliers(model: ConicModel, multipliers: Array) -> Array:
    """Those of the rows without cones, none negative where that would mean nothing."""
    z = np.array(multipliers[:, : model.program.equalities + model.program.inequalities])
    z[:, model.program.equalities :] = np.maximum(z[:, model.program.equalities :], 0.0)
    return z


def _functionals(
    model: ConicModel, quantities: Quantities, z: Array, costates: Array
) -> tuple[list[tuple[Array, Array]], Array]:
    """All that acts on every law, its end costates among it: points, weights; and these prices."""
    blocks_by_law: list[list[tuple[int, LinearBlock]]] = [[] for _ in model.grids]
    for first, block in _law_blocks(model):
        if block.segment is not None:
            blocks_by_law[block.segment].append((first, block))
    laws = [
        _law_functional(model, position, own, quantities, z)
        for position, own in enumerate(blocks_by_law)
    ]
    starts = np.stack([_initial_terms(x, weights) for x, weights in laws], axis=1)
    costates = _project_costates(model, starts, costates)
    paid = [
        (np.append(x, 1.0), np.concatenate([weights, costates[:, k][:, None, :]], axis=1))
        for k, (x, weights) in enumerate(laws)
    ]
    return paid, costates


def solve_boundary_costates(model: ConicModel, quantities: Quantities, multipliers: Array) -> Array:
    """The solver's costates of g, g' and g'' at the end of every law: (q, laws, 3)."""
    laws = range(len(model.grids))
    return np.stack([_boundary_costates(model, k, quantities, multipliers) for k in laws], axis=1)


def _law_blocks(model: ConicModel) -> Iterator[tuple[int, LinearBlock]]:
    """The blocks that speak of arbitrary laws, with the number of their first row."""
    for at, block in model.numbered_blocks:
        if block.kind != "control" and block.highest_order < ORDER:
            yield at, block


def _add_fixed_sizes(
    model: ConicModel, z: Array, total: Array, residual: Array
) -> tuple[Array, Array]:
    """Size variables that leave no choice: their rows come after those of the joints."""
    at = sum(max(junction.highest - junction.lowest + 1, 0) for junction in model.junctions)
    for j, (low, high) in enumerate(model.problem.sizing.bounds):
        if low == high:
            total = total - z[:, at] * low / model.scales.size
            residual[:, j] += z[:, at]
            at += 1
    return total, residual


def _law_functional(
    model: ConicModel,
    position: int,
    blocks_by_law: Sequence[tuple[int, LinearBlock]],
    quantities: Quantities,
    z: Array,
) -> tuple[Array, Array]:
    """What its rows and the quantities put on one law: points (p,), weights (q, p, 3)."""
    points, weights = [np.zeros(0)], [np.zeros((len(z), 0, ORDER))]
    for first, block in blocks_by_law:
        multipliers = z[:, first : first + len(block.rhs)]
        x, alpha = _point_functional(model, block)
        points.append(x)
        weights.append(multipliers[:, :, None] * alpha[None])
    mine = np.flatnonzero(quantities.law == position)
    own = np.zeros((len(z), len(mine), ORDER))
    own[mine, np.arange(len(mine))] = quantities.alpha[mine]
    points.append(quantities.x[mine])
    weights.append(own)
    return np.concatenate(points), np.concatenate(weights, axis=1)


def _point_functional(model: ConicModel, block: LinearBlock) -> tuple[Array, Array]:
    """Where rows act on a law: points (r,), alpha (r, 3).

    Coefficients in order act as g' near by.
    """
    if block.kind != "monotone":
        return block.x, np.broadcast_to(block.alpha[:ORDER].T, (len(block.rhs), ORDER))
    return sort_by_place(model, block, ORDER)


def _boundary_costates(model: ConicModel, position: int, quantities: Quantities, z: Array) -> Array:
    """Prices (q, 3) of g, g', g'' at 1: those that make the last coefficients stationary."""
    end, space = model.boundary_states[position].end, model.grids[position].space
    count = len(end)
    last = slice(space.size - count, space.size)
    gradient = np.zeros((len(z), count))
    for at, block in model.numbered_blocks:
        if block.segment == position and block.law_matrix is not None:
            gradient += z[:, at : at + len(block.rhs)] @ block.law_matrix[:, last]
    mine, rows = quantities.rows_of_law(model, position)
    gradient[mine] += rows[:, last]
    multipliers, at = np.zeros((len(z), max(ORDER, count))), 0
    for junction in model.junctions:
        before, after = junction_rows(junction, model.problem.free, model.grids)
        mu = z[:, at : at + len(before.units)]
        at += len(before.units)
        for side in (before, after):
            if side.position == position:
                gradient += mu @ side.dense[:, last]
        if before.position == position:
            multipliers[:, junction.lowest : junction.highest + 1] = (mu * before.units)[
                :, : multipliers.shape[1] - junction.lowest
            ]
    multipliers[:, :count] = space.end_multipliers(gradient)
    return multipliers[:, :ORDER]


def _initial_terms(x: Array, weights: Array) -> Array:
    """What weights (q, p, 3) at points come to in g, g', g'' at 0: (q, 3)."""
    powers = [x**n / factorial(n) for n in range(ORDER)]
    return np.stack(
        [sum(weights[:, :, k] @ powers[j - k] for k in range(j + 1)) for j in range(ORDER)], axis=1
    )


def _project_costates(model: ConicModel, starts: Array, near: Array) -> Array:
    """The nearest end costates (q, laws, 3) at which the factors of unknown values vanish.

    Initial values that joints share, and those beside a joint that is left out. An end value that
    is neither known nor shared has no price.
    """
    shared = {
        (junction.before, k): ratio
        for junction in model.junctions
        for k, ratio in propagate_state(model, junction, ORDER)
    }
    arriving = {
        (junction.after, k): (junction.before, ratio)
        for junction in model.junctions
        for k, ratio in propagate_state(model, junction, ORDER)
    }
    matrix, rhs = [], []
    for position, boundary in enumerate(model.boundary_states):
        priced = [k < len(boundary.end) or (position, k) in shared for k in range(ORDER)]
        for k in range(len(boundary.start), ORDER):
            row = np.zeros((len(model.grids), ORDER))
            row[position, : k + 1] = [priced[j] / factorial(k - j) for j in range(k + 1)]
            if (position, k) in arriving:
                before, ratio = arriving[position, k]
                row[before, k] += ratio
            matrix.append(row.ravel())
            rhs.append(-starts[:, position, k])
    if not matrix:
        return near
    table, flat = np.array(matrix), near.reshape(len(near), -1)
    missed = np.array(rhs) - table @ flat.T
    moved = flat + np.linalg.lstsq(table, missed, rcond=None)[0].T
    return np.asarray(moved.reshape(near.shape))


def _costates_carried(model: ConicModel, position: int, costates: Array) -> Array:
    """The costates at the end of the law before, as they act on this one's start: (q, 3)."""
    carried = np.zeros((len(costates), ORDER))
    for junction in model.junctions:
        if junction.after == position:
            for k, ratio in propagate_state(model, junction, ORDER):
                carried[:, k] += ratio * costates[:, junction.before, k]
    return carried


def _unknown_initial_values(model: ConicModel, position: int, cap: float, rest: Array) -> Array:
    """What unknown initial values could gain from a residual (q, r) that is not exactly zero.

    Their ranges are those of ``bound``.
    """
    if not rest.shape[1]:
        return np.zeros(len(rest))
    free = model.problem.free[position].free
    if free is None or free.overshoot:
        return np.where(np.any(rest != 0.0, axis=1), np.inf, 0.0)
    return np.asarray(np.sum(np.abs(rest), axis=1) * INITIAL_VALUE_BOUND * (1.0 + 0.5 * cap))


def switching_pieces(x: Array, weights: Array) -> tuple[Array, Array]:
    """ψ of weights (q, p, 3) on g, g', g'' at x (p,): breaks (n+1,), polynomials (q, n, 3).

    ψ(τ) = Σ w0 (x − τ)²/2 + w1 (x − τ) + w2 over the points behind τ; each piece is a polynomial
    in τ less its own first break.
    """
    sorting = np.argsort(x, kind="stable")
    x, weights = x[sorting], weights[:, sorting]
    breaks = np.unique(np.concatenate([[0.0, 1.0], x]))
    w0, w1, w2 = np.moveaxis(weights, 2, 0)
    table = np.stack([0.5 * w0 * x * x + w1 * x + w2, -w0 * x - w1, 0.5 * w0], axis=2)
    suffix = np.cumsum(table[:, ::-1], axis=1)[:, ::-1]
    suffix = np.concatenate([suffix, np.zeros((len(table), 1, 3))], axis=1)
    c, b, a = np.moveaxis(suffix[:, np.searchsorted(x, breaks[1:], side="left")], 2, 0)
    first = breaks[:-1]
    return breaks, np.stack([c + first * (b + first * a), b + 2.0 * a * first, a], axis=2)


def absolute_piece_integrals(breaks: Array, poly: Array) -> Array:
    """∫ |ψ| over every piece, exact: (q, n)."""
    width = np.diff(breaks)
    c, b, a = np.moveaxis(poly, 2, 0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        half = -0.5 * (b + np.where(b < 0.0, -1.0, 1.0) * np.sqrt(b * b - 4.0 * a * c))
        roots = np.stack([half / a, c / half])
    roots = np.where((roots > 0.0) & (roots < width), roots, 0.0)  # none: an empty part
    cuts = [np.zeros_like(c), roots.min(axis=0), roots.max(axis=0), np.broadcast_to(width, c.shape)]
    values = [t * (c + t * (b / 2.0 + t * a / 3.0)) for t in cuts]
    return np.asarray(sum(np.abs(high - low) for low, high in pairwise(values)))
