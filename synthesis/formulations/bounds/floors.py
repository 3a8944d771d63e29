"""Lower bounds of many quantities at once, over every motion law and size that keep a plan's rows.

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

from synthesis.formulations.bounds.multiplied import in_order
from synthesis.formulations.cone.control import Control
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.cone.rows import Block
from synthesis.formulations.question.ends import Joint, joint_rows
from synthesis.numerics.piecewise import Array

ORDER = 3  # of the derivative that is capped
ROUNDING = 1e-12  # relative allowance for the floating-point sums below


@dataclass(frozen=True, eq=False)
class Wanted:
    """Quantities alpha · (g, g', g'') (x) + size · ζ, in the plan's units.

    Attributes:
        law: (q,) positions of the free laws. x: (q,). alpha: (q, 3). size: (q, n_size).
    """

    law: Array
    x: Array
    alpha: Array
    size: Array

    def costs(self, plan: Plan) -> list[Array]:
        """The same as objectives of the plan's program, but for constants: one (n,) each."""
        found = np.zeros((len(self.x), plan.program.matrix.shape[1]))
        found[:, plan.size] = self.size
        for position in np.unique(self.law):
            mine, rows = self.on(plan, position)
            found[mine, plan.columns[position]] = plan.settled[position].split(rows)[0]
        return list(found)

    def on(self, plan: Plan, position: int) -> tuple[NDArray[np.intp], Array]:
        """Which of them speak of one law, and their factors (k, n) of its coefficients."""
        mine = np.flatnonzero(self.law == position)
        space, alpha = plan.grids[position].space, self.alpha[mine]
        rows = np.zeros((len(mine), space.size))
        for order in np.flatnonzero(np.any(alpha, axis=0)):
            acting = alpha[:, order] != 0.0
            table = space.basis(self.x[mine[acting]], int(order))
            rows[acting] += alpha[acting, order][:, None] * table
        return mine, rows


def floors(
    plan: Plan,
    steering: Sequence[Control],
    sizes: Sequence[tuple[float, float]],
    wanted: Wanted,
    multipliers: Array,
    ends: Array,
) -> Array:
    """A lower bound of every quantity: (q,), −inf where none follows.

    Args:
        plan: rows that hold. steering: caps of every free law's third derivative.
        sizes: ranges of the size variables [mm].
        wanted: the quantities.
        multipliers: (q, m) of the plan's rows without its cones; any, good ones bound well.
        ends: (q, laws, 3) prices of the laws' ends (``solved_prices``); any.
    """
    z = _signed(plan, multipliers)
    total, spent = np.zeros(len(z)), np.zeros(len(z))
    residual = wanted.size.copy()
    for first, block in _said(plan):
        prices = z[:, first : first + len(block.rhs)]
        total -= prices @ block.rhs
        spent += np.abs(prices) @ np.abs(block.rhs)
        if len(block.size):
            size = np.broadcast_to(block.size, (len(block.rhs), residual.shape[1]))
            residual += prices @ size
    total, residual = _fixed(plan, z, total, residual)
    laws, ends = _paid(plan, wanted, z, ends)
    for position, (x, weights) in enumerate(laws):
        price, start = ends[:, position], _starts(x, weights)
        known = plan.settled[position]
        count = min(len(known.end), ORDER)
        given = np.zeros(ORDER)
        given[: min(len(known.start), ORDER)] = known.start[:ORDER]
        total += start @ given - price[:, :count] @ known.end[:count]
        cap = steering[position].cap
        worth = cap * np.sum(integrals(*pieces(x, weights)), axis=1)
        spent += worth + np.abs(price[:, :count]) @ np.abs(known.end[:count])
        spent += cap * np.sum(np.abs(weights), axis=(1, 2))
        total -= worth
        rest = start + _carried(plan, position, ends)
        total -= _unknown(plan, position, cap, rest[:, len(known.start) :])
    bounds = np.array(sizes) / plan.scales.size
    total += np.sum(np.minimum(residual * bounds[:, 0], residual * bounds[:, 1]), axis=1)
    spent += np.sum(np.abs(residual) * np.max(np.abs(bounds), axis=1), axis=1)
    return np.where(np.isfinite(total), total - ROUNDING * spent, -np.inf)


def switchings(
    plan: Plan, wanted: Wanted, multipliers: Array, ends: Array
) -> list[tuple[Array, Array]]:
    """∫ |ψ| of every law, piece by piece: breaks (n+1,) and integrals (q, n)."""
    found = []
    for x, weights in _paid(plan, wanted, _signed(plan, multipliers), ends)[0]:
        breaks, poly = pieces(x, weights)
        found.append((breaks, integrals(breaks, poly)))
    return found


def _signed(plan: Plan, multipliers: Array) -> Array:
    """Those of the rows without cones, none negative where that would mean nothing."""
    z = np.array(multipliers[:, : plan.program.equalities + plan.program.inequalities])
    z[:, plan.program.equalities :] = np.maximum(z[:, plan.program.equalities :], 0.0)
    return z


def _paid(
    plan: Plan, wanted: Wanted, z: Array, ends: Array
) -> tuple[list[tuple[Array, Array]], Array]:
    """All that acts on every law, its end prices among it: points, weights; and these prices."""
    said: list[list[tuple[int, Block]]] = [[] for _ in plan.grids]
    for first, block in _said(plan):
        if block.stretch is not None:
            said[block.stretch].append((first, block))
    laws = [_booked(plan, position, own, wanted, z) for position, own in enumerate(said)]
    starts = np.stack([_starts(x, weights) for x, weights in laws], axis=1)
    ends = _matched(plan, starts, ends)
    paid = [
        (np.append(x, 1.0), np.concatenate([weights, ends[:, k][:, None, :]], axis=1))
        for k, (x, weights) in enumerate(laws)
    ]
    return paid, ends


def solved_prices(plan: Plan, wanted: Wanted, multipliers: Array) -> Array:
    """The solver's prices of g, g' and g'' at the end of every law: (q, laws, 3)."""
    laws = range(len(plan.grids))
    return np.stack([_end_prices(plan, k, wanted, multipliers) for k in laws], axis=1)


def _said(plan: Plan) -> Iterator[tuple[int, Block]]:
    """The blocks that speak of arbitrary laws, with the number of their first row."""
    for at, block in plan.every_block:
        if block.kind != "control" and block.highest < ORDER:
            yield at, block


def _fixed(plan: Plan, z: Array, total: Array, residual: Array) -> tuple[Array, Array]:
    """Size variables that leave no choice: their rows come after those of the joints."""
    at = sum(max(joint.highest - joint.lowest + 1, 0) for joint in plan.joints)
    for j, (low, high) in enumerate(plan.problem.sizing.bounds):
        if low == high:
            total = total - z[:, at] * low / plan.scales.size
            residual[:, j] += z[:, at]
            at += 1
    return total, residual


def _booked(
    plan: Plan,
    position: int,
    said: Sequence[tuple[int, Block]],
    wanted: Wanted,
    z: Array,
) -> tuple[Array, Array]:
    """What its rows and the quantities put on one law: points (p,), weights (q, p, 3)."""
    points, weights = [np.zeros(0)], [np.zeros((len(z), 0, ORDER))]
    for first, block in said:
        prices = z[:, first : first + len(block.rhs)]
        x, alpha = _acting(plan, block)
        points.append(x)
        weights.append(prices[:, :, None] * alpha[None])
    mine = np.flatnonzero(wanted.law == position)
    own = np.zeros((len(z), len(mine), ORDER))
    own[mine, np.arange(len(mine))] = wanted.alpha[mine]
    points.append(wanted.x[mine])
    weights.append(own)
    return np.concatenate(points), np.concatenate(weights, axis=1)


def _acting(plan: Plan, block: Block) -> tuple[Array, Array]:
    """Where rows act on a law: points (r,), alpha (r, 3).

    Coefficients in order act as g' near by.
    """
    if block.kind != "monotone":
        return block.x, np.broadcast_to(block.alpha[:ORDER].T, (len(block.rhs), ORDER))
    return in_order(plan, block, ORDER)


def _end_prices(plan: Plan, position: int, wanted: Wanted, z: Array) -> Array:
    """Prices (q, 3) of g, g', g'' at 1: those that make the last coefficients stationary."""
    end, space = plan.settled[position].end, plan.grids[position].space
    count = len(end)
    last = slice(space.size - count, space.size)
    gradient = np.zeros((len(z), count))
    for at, block in plan.every_block:
        if block.stretch == position and block.laws is not None:
            gradient += z[:, at : at + len(block.rhs)] @ block.laws[:, last]
    mine, rows = wanted.on(plan, position)
    gradient[mine] += rows[:, last]
    prices, at = np.zeros((len(z), max(ORDER, count))), 0
    for joint in plan.joints:
        before, after = joint_rows(joint, plan.problem.free, plan.grids)
        mu = z[:, at : at + len(before.units)]
        at += len(before.units)
        for side in (before, after):
            if side.position == position:
                gradient += mu @ side.dense[:, last]
        if before.position == position:
            prices[:, joint.lowest : joint.highest + 1] = (mu * before.units)[
                :, : prices.shape[1] - joint.lowest
            ]
    prices[:, :count] = space.end_prices(gradient)
    return prices[:, :ORDER]


def _starts(x: Array, weights: Array) -> Array:
    """What weights (q, p, 3) at points come to in g, g', g'' at 0: (q, 3)."""
    powers = [x**n / factorial(n) for n in range(ORDER)]
    return np.stack(
        [sum(weights[:, :, k] @ powers[j - k] for k in range(j + 1)) for j in range(ORDER)], axis=1
    )


def _matched(plan: Plan, starts: Array, near: Array) -> Array:
    """The nearest end prices (q, laws, 3) at which values that nothing settles cancel.

    Initial values that joints share, and those beside a joint that is left out. An end value that
    is neither known nor shared has no price.
    """
    shared = {
        (joint.before, k): ratio for joint in plan.joints for k, ratio in _ratios(plan, joint)
    }
    arriving = {
        (joint.after, k): (joint.before, ratio)
        for joint in plan.joints
        for k, ratio in _ratios(plan, joint)
    }
    matrix, rhs = [], []
    for position, known in enumerate(plan.settled):
        priced = [k < len(known.end) or (position, k) in shared for k in range(ORDER)]
        for k in range(len(known.start), ORDER):
            row = np.zeros((len(plan.grids), ORDER))
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


def _ratios(plan: Plan, joint: Joint) -> Iterator[tuple[int, float]]:
    """Orders that a joint shares, each with what a price before is worth after it."""
    before, after = joint_rows(joint, plan.problem.free, plan.grids)
    for k in range(joint.lowest, min(joint.highest + 1, ORDER)):
        at = k - joint.lowest
        yield k, float(after.units[at] / before.units[at])


def _carried(plan: Plan, position: int, ends: Array) -> Array:
    """What the prices at the end of the law before are worth at this one's start: (q, 3)."""
    carried = np.zeros((len(ends), ORDER))
    for joint in plan.joints:
        if joint.after == position:
            for k, ratio in _ratios(plan, joint):
                carried[:, k] += ratio * ends[:, joint.before, k]
    return carried


def _unknown(plan: Plan, position: int, cap: float, rest: Array) -> Array:
    """What unknown initial values could gain from a residual (q, r) that is not exactly zero.

    Their ranges are those of ``bound``.
    """
    if not rest.shape[1]:
        return np.zeros(len(rest))
    free = plan.problem.free[position].free
    if free is None or free.overshoot:
        return np.where(np.any(rest != 0.0, axis=1), np.inf, 0.0)
    return np.asarray(np.sum(np.abs(rest), axis=1) * 12.0 * (1.0 + 0.5 * cap))


def pieces(x: Array, weights: Array) -> tuple[Array, Array]:
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


def integrals(breaks: Array, poly: Array) -> Array:
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
