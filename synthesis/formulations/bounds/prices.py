"""Prices of the end values, for a mean square: those that make the bound largest.

The bound is concave in the prices of g^(k)(1), k < m, law by law, and its gradient is by how much
the ideal law's end misses what it has to be; so Newton's method finds them, in one step where
nothing caps the law. The solver's own prices come from the last few coefficients of the spline,
and what is uncertain there grows with the third power of the knots.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial

import numpy as np

from synthesis.formulations.bounds.switching import NODES, SHARES, Switching
from synthesis.formulations.cone.control import Control
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.question.ends import joint_rows
from synthesis.numerics.piecewise import Array

STEPS = 30
SETTLED = 1e-14


@dataclass(frozen=True, eq=False)
class _Law:
    """One free law as the prices of its end see it.

    Attributes:
        shares: (n,) weights of the integral over [0, 1] at Gauss points.
        psi: (n,) ψ there, from rows alone. reach: (m, n) what the price of g^(k)(1) adds to it.
        constant: (m,) what that price is worth without any integral.
    """

    control: Control
    shares: Array
    psi: Array
    reach: Array
    constant: Array

    def worth(self, prices: Array) -> tuple[float, Array, Array]:
        """The bound's share, its gradient and its Hessian."""
        weight, cap = self.control.weight, self.control.cap
        psi = self.psi + prices @ self.reach
        w = np.clip(-psi / (2.0 * weight), -cap, cap)
        free = self.shares * (np.abs(w) < cap) / (2.0 * weight)
        value = self.constant @ prices + np.sum(self.shares * (weight * w**2 + psi * w))
        gradient = self.constant + self.reach @ (self.shares * w)
        return float(value), gradient, -(self.reach * free) @ self.reach.T


def end_prices(
    plan: Plan,
    steering: Sequence[Control],
    psi: Sequence[Switching],
    state: Sequence[Array],
    guess: Sequence[Array],
) -> list[Array]:
    """Prices (m,) of g^(k)(1) for every free law, at which unknown initial values are worthless.

    Args:
        plan: the plan.
        steering: of every law, each with a weight.
        psi: of every law, from its rows alone; not needed where no mean square is weighed.
        state: per law, (m,) factors of unknown initial values that its rows leave.
        guess: the solver's prices, good enough where no mean square is weighed.
    """
    if not plan.grids:
        return []
    matrix, rhs = _shared(plan, steering[0].order, state)
    near = np.concatenate(guess)
    prices = near + _least(matrix, rhs - matrix @ near) if len(rhs) else near
    if not all(control.weight for control in steering):
        return list(prices.reshape(len(steering), -1))
    laws = [_law(plan, k, *both) for k, both in enumerate(zip(steering, psi, strict=True))]
    prices = _least(matrix, rhs)
    value, gradient, bend = _sum(laws, prices)
    for _ in range(STEPS):
        step = _newton(gradient, bend, matrix)
        share, before = 1.0, value
        while share > 1e-6 and (found := _sum(laws, prices + share * step))[0] <= before:
            share *= 0.5
        if share <= 1e-6:
            break
        prices = prices + share * step
        value, gradient, bend = found
        if value - before <= SETTLED * abs(value):
            break
    return list(prices.reshape(len(laws), -1))


def _law(plan: Plan, position: int, control: Control, psi: Switching) -> _Law:
    order, known = control.order, plan.settled[position]
    cuts = np.union1d(psi.breaks, np.linspace(0.0, 1.0, 65))
    width = np.diff(cuts)[:, None]
    tau = (cuts[:-1, None] + width * (NODES + 1.0) / 2.0).ravel()
    powers = [(1.0 - tau) ** (order - 1 - k) / factorial(order - 1 - k) for k in range(order)]
    constant = np.zeros(order)
    for k in range(order):
        for j in range(k, min(len(known.start), order)):
            constant[k] += known.start[j] / factorial(j - k)
    count = min(len(known.end), order)
    constant[:count] -= known.end[:count]
    return _Law(control, (width * SHARES / 2.0).ravel(), psi(tau), np.stack(powers), constant)


def _shared(plan: Plan, order: int, state: Sequence[Array]) -> tuple[Array, Array]:
    """matrix · prices = rhs: unknown initial values are worth nothing, joint by joint."""
    rows, rhs = [np.zeros((0, len(plan.grids) * order))], []
    for joint in plan.joints:
        before, after = joint_rows(joint, plan.problem.free, plan.grids)
        for k in range(joint.lowest, min(joint.highest + 1, order)):
            row = np.zeros((len(plan.grids), order))
            for j in range(k + 1):
                row[joint.after, j] = 1.0 / factorial(k - j)
            at = k - joint.lowest
            row[joint.before, k] += after.units[at] / before.units[at]
            rows.append(row.reshape(1, -1))
            rhs.append(-float(state[joint.after][k]))
    return np.vstack(rows), np.array(rhs)


def _sum(laws: Sequence[_Law], prices: Array) -> tuple[float, Array, Array]:
    """Value, gradient and Hessian of all laws together."""
    table = prices.reshape(len(laws), -1)
    parts = [law.worth(row) for law, row in zip(laws, table, strict=True)]
    order = table.shape[1]
    bend = np.zeros((len(prices), len(prices)))
    for k, (_, _, block) in enumerate(parts):
        bend[k * order : (k + 1) * order, k * order : (k + 1) * order] = block
    return sum(p[0] for p in parts), np.concatenate([p[1] for p in parts]), bend


def _newton(gradient: Array, bend: Array, matrix: Array) -> Array:
    """The step to the top of the quadratic model that keeps matrix · prices."""
    n, rows = len(gradient), len(matrix)
    system = np.zeros((n + rows, n + rows))
    system[:n, :n] = bend - 1e-14 * np.trace(np.abs(bend)) * np.eye(n)
    system[:n, n:], system[n:, :n] = matrix.T, matrix
    return _least(system, np.concatenate([-gradient, np.zeros(rows)]))[:n]


def _least(matrix: Array, rhs: Array) -> Array:
    """The shortest of the solutions."""
    return np.asarray(np.linalg.lstsq(matrix, rhs, rcond=None)[0], dtype=float)
