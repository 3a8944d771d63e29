"""A lower bound over every motion law, from the cone program's own multipliers.

The optimum over splines is only the best of its family. Weak duality turns any multipliers
λ ≥ 0 of the rows into a bound for all laws whose m-th derivative is capped (or weighed by the
objective): add λ times the rows to the objective, and minimise over every law pointwise. The
multipliers are used as numbers, not trusted: any λ ≥ 0 gives a valid bound, good ones a tight one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import factorial, inf, sqrt

import numpy as np

from synthesis.formulations.control import Control, controls
from synthesis.formulations.convex import Plan
from synthesis.formulations.ends import boundary_rows, joint_rows
from synthesis.formulations.switching import Switching, switching
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution

ROUNDING = 1e-12  # relative allowance for the floating-point sums below
NAMES = {2: "acceleration", 3: "jerk"}


@dataclass(frozen=True, eq=False)
class Bound:
    """A lower bound of the objective [core units], what it covers, and where ideal laws switch."""

    value: float
    over: str
    switching: tuple[Switching, ...]


@dataclass(eq=False)
class _Ledger:
    """What the multiplied rows add up to.

    Attributes:
        constant: terms free of unknowns. size: (n_size,) factor of ζ. level: factor of π.
        points, weights: per free law, abscissae and (r, m) factors of g, g', … there.
        state: per free law, (m,) factors of unknown initial values g^(j)(0).
        magnitude: sum of the absolute values of what went into ``constant``.
    """

    constant: float
    size: Array
    level: float
    points: list[list[Array]]
    weights: list[list[Array]]
    state: list[Array]
    magnitude: float = field(default=0.0)

    def add(self, amount: float) -> None:
        """Book a constant."""
        self.constant += amount
        self.magnitude += abs(amount)


def bound(plan: Plan, solution: ConeSolution) -> Bound:
    """The bound that these multipliers give: over all laws, else over the splines' family."""
    steering = controls(plan)
    if steering is None:
        return Bound(_in_core_units(plan, _over_family(plan, solution)), _family(plan), ())
    order = steering[0].order if steering else 3
    ledger = _add_up(plan, solution, order)
    psi = tuple(
        switching(np.concatenate(x), np.concatenate(w), order)
        for x, w in zip(ledger.points, ledger.weights, strict=True)
    )
    total = _minimum(plan, solution, ledger, steering, psi)
    over = f"all motion laws with a bounded {NAMES[order]}" if steering else _family(plan)
    return Bound(_in_core_units(plan, total), over, psi)


def _family(plan: Plan) -> str:
    parts = {f"degree {g.space.degree} on {len(g.space.breaks) - 1} intervals" for g in plan.grids}
    return "splines of " + " and ".join(sorted(parts)) if parts else "the given laws"


def _in_core_units(plan: Plan, value: float) -> float:
    """The program's objective as a value of the asked quantity."""
    if plan.energy is not None:
        return sqrt(max(value * plan.energy.unit + plan.energy.constant, 0.0))
    if plan.problem.objective.norm(plan.problem.machine) is not None:
        return value * plan.scales.size
    return value * plan.scales.level


def _over_family(plan: Plan, solution: ConeSolution) -> float:
    """The dual objective, less what its residual could gain with coefficients in a box."""
    program, z = plan.program, solution.multipliers.copy()
    first, count = program.equalities, program.inequalities
    z[first : first + count] = np.maximum(z[first : first + count], 0.0)
    at = first + count
    for size in program.cones:
        z[at] = max(z[at], float(np.linalg.norm(z[at + 1 : at + size])))
        at += size
    x = solution.x
    full = program.quadratic + program.quadratic.T
    full.setdiag(program.quadratic.diagonal())
    curved = full @ x
    residual = curved + program.linear + program.matrix.T @ z
    box = np.maximum(10.0, 10.0 * np.abs(x))
    value = -0.5 * x @ curved - program.rhs @ z - np.abs(residual) @ box
    return float(value) + _fixed_energy(plan)


def _fixed_energy(plan: Plan) -> float:
    """The settled coefficients' share of the mean square, which the program leaves out."""
    if plan.energy is None:
        return 0.0
    shares = [
        float(np.sum(known.split(factor)[1] ** 2))
        for known, factor in zip(plan.settled, plan.energy.factors, strict=True)
    ]
    return sum(shares) / plan.energy.unit


def _add_up(plan: Plan, solution: ConeSolution, order: int) -> _Ledger:
    """All rows times their multipliers, as functionals of arbitrary laws."""
    laws = len(plan.grids)
    ledger = _Ledger(
        0.0, np.zeros(len(plan.problem.sizing.bounds)), 0.0,
        [[] for _ in range(laws)], [[] for _ in range(laws)], [np.zeros(order) for _ in range(laws)],
    )  # fmt: skip
    _book_blocks(plan, solution, ledger, order)
    _book_balls(plan, solution, ledger)
    _book_joints_and_fixed(plan, solution, ledger, order)
    for position in range(laws):
        _book_end(plan, solution, ledger, position, order)
    return ledger


def _book_point(
    plan: Plan, ledger: _Ledger, position: int, x: Array, weights: Array, order: int
) -> None:
    """Σ weights[i, k] g^(k)(x_i), split into initial values and an integral over g^(m)."""
    ledger.points[position].append(x)
    ledger.weights[position].append(weights)
    start = plan.settled[position].start
    for j in range(order):
        powers = np.stack([x ** (j - k) / factorial(j - k) for k in range(j + 1)], axis=1)
        share = float(np.sum(weights[:, : j + 1] * powers))
        if j < len(start):
            ledger.add(share * float(start[j]))
        else:
            ledger.state[position][j] += share


def _book_blocks(plan: Plan, solution: ConeSolution, ledger: _Ledger, order: int) -> None:
    for block, z in zip(plan.blocks, plan.multipliers(solution.multipliers), strict=True):
        if block.kind in ("control", "monotone") or np.any(block.alpha[order:]):
            continue  # says nothing of arbitrary laws, or is the steering itself
        ledger.add(-float(z @ block.rhs))
        ledger.level += block.level * float(np.sum(z))
        if len(block.size):
            ledger.size += block.size * float(np.sum(z))
        if block.stretch is not None:
            weights = z[:, None] * block.alpha[:order]
            _book_point(plan, ledger, block.stretch, block.x, weights, order)


def _book_balls(plan: Plan, solution: ConeSolution, ledger: _Ledger) -> None:
    """Cones on the size with a fixed radius; the objective's own is minimised over later."""
    at = plan.program.equalities + plan.program.inequalities
    for ball in plan.balls:
        v = solution.multipliers[at + 1 : at + 1 + len(ball.shift)]
        at += 1 + len(ball.shift)
        if ball.head is None:
            ledger.add(-float(np.linalg.norm(v)) * ball.radius - float(v @ ball.shift))
            ledger.size -= (ball.matrix.T @ v)[plan.size]


def _book_joints_and_fixed(plan: Plan, solution: ConeSolution, ledger: _Ledger, order: int) -> None:
    at = 0
    for joint in plan.joints:
        before, after = joint_rows(joint, plan.problem.free, plan.grids)
        mu = solution.multipliers[at : at + len(before.units)]
        at += len(mu)
        for k, price in enumerate(mu, start=joint.lowest):
            if k < order:
                unit = np.zeros((1, order))
                unit[0, k] = price * before.units[k - joint.lowest]
                _book_point(plan, ledger, joint.before, np.ones(1), unit, order)
                ledger.state[joint.after][k] += price * after.units[k - joint.lowest]
    for j, (low, high) in enumerate(plan.problem.sizing.bounds):
        if low == high:
            mu = float(solution.multipliers[at])
            at += 1
            ledger.size[j] += mu
            ledger.add(-mu * low / plan.scales.size)


def _book_end(
    plan: Plan, solution: ConeSolution, ledger: _Ledger, position: int, order: int
) -> None:
    """Known end values: their multipliers ν make the eliminated last coefficients stationary."""
    end, space = plan.settled[position].end, plan.grids[position].space
    gradient = np.zeros(space.size)
    for block, z in zip(plan.blocks, plan.multipliers(solution.multipliers), strict=True):
        if block.stretch == position and block.laws is not None:
            gradient += block.laws.T @ z
    at = 0
    for joint in plan.joints:
        for side in joint_rows(joint, plan.problem.free, plan.grids):
            if side.position == position:
                mu = solution.multipliers[at : at + len(side.units)]
                gradient += side.dense.T @ mu
        at += max(joint.highest - joint.lowest + 1, 0)
    if plan.energy is not None:
        factor = plan.energy.factors[position]
        laws, _ = plan.recover(solution.x)
        gradient += 2.0 / plan.energy.unit * factor.T @ (factor @ laws[position].coefficients)
    count = len(end)
    rows = boundary_rows(space, 1.0, count)[:, space.size - count :]
    nu = np.linalg.solve(rows.T, -gradient[space.size - count :])[:order]
    known = min(count, order)
    unit = np.zeros((1, order))
    unit[0, :known] = nu[:known]
    ledger.add(-float(nu[:known] @ end[:known]))
    _book_point(plan, ledger, position, np.ones(1), unit, order)


def _minimum(
    plan: Plan,
    solution: ConeSolution,
    ledger: _Ledger,
    steering: Sequence[Control],
    psi: Sequence[Switching],
) -> float:
    """The least value of objective plus multiplied rows, after scaling λ to be dual feasible."""
    capped = sum(p.least(c.cap, c.weight) for p, c in zip(psi, steering, strict=True))
    paid = ledger.constant + capped - ROUNDING * (ledger.magnitude + abs(capped))
    paid -= _unknown_states(plan, solution, ledger, steering)
    norm = plan.problem.objective.norm(plan.problem.machine)
    if norm is not None:
        # ‖Mζ + m‖ ≥ y·(Mζ + m) for ‖y‖ ≤ 1: y takes up what the rows leave of ζ
        y = np.linalg.solve(np.array(norm.matrix).T, -ledger.size)
        shrink = 1.0 / max(1.0, float(np.linalg.norm(y)))
        return shrink * (paid + float(y @ np.array(norm.shift)) / plan.scales.size)
    bounds = np.array(plan.problem.sizing.bounds) / plan.scales.size
    paid += float(np.sum(np.min(ledger.size[:, None] * bounds, axis=1)))
    if plan.energy is not None:
        return paid
    rates = sum(-c.rate * p.least(1.0, 0.0) for p, c in zip(psi, steering, strict=True))
    price = rates - ledger.level
    return paid / price if price > 0.0 else 0.0


def _unknown_states(
    plan: Plan, solution: ConeSolution, ledger: _Ledger, steering: Sequence[Control]
) -> float:
    """What unknown initial values could gain from a residual that is not exactly zero.

    For g in [0, 1] with |∫ (x−τ)²/2 w dτ| ≤ R: |g'(0)| ≤ 7 + 7R and |g''(0)| ≤ 12 + 12R (from
    Taylor's formula at 1/2 and 1). The level and the energy are at most twice what was found.
    """
    lost = 0.0
    for position, (state, control) in enumerate(zip(ledger.state, steering, strict=True)):
        if not np.any(state):
            continue
        free = plan.problem.free[position].free
        if free is None or free.overshoot:
            return inf
        reach = control.cap / 2.0 if control.cap < inf else 0.0
        if control.rate and plan.extra is not None:
            reach += control.rate * abs(float(solution.x[plan.extra]))
        if control.weight:
            laws, _ = plan.recover(solution.x)
            assert plan.energy is not None
            values = plan.energy.factors[position] @ laws[position].coefficients
            reach += sqrt(2.0 * float(np.sum(values**2)) / plan.energy.weights[position])
        lost += float(np.abs(state[1:]).sum()) * 12.0 * (1.0 + reach)
    return lost
