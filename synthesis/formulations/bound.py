"""A lower bound over every motion law, from the cone program's own multipliers.

The optimum over splines is only the best of its family. Weak duality turns any multipliers
λ ≥ 0 of the rows into a bound for all laws whose m-th derivative is capped (or weighed by the
objective): add λ times the rows to the objective, and minimise over every law pointwise. The
multipliers are used as numbers, not trusted: any λ ≥ 0 gives a valid bound, good ones a tight one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import factorial, inf, sqrt

import numpy as np

from synthesis.formulations.control import Control, controls
from synthesis.formulations.convex import Plan
from synthesis.formulations.ends import joint_rows
from synthesis.formulations.family import over_family
from synthesis.formulations.held import quietening
from synthesis.formulations.multipliers import ends_priced, heard
from synthesis.formulations.prices import end_prices
from synthesis.formulations.switching import Switching, spread, switching
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution

ROUNDING = 1e-12  # relative allowance for the floating-point sums below
NAMES = {2: "acceleration", 3: "jerk"}


@dataclass(frozen=True, eq=False)
class Bound:
    """A lower bound of the objective [core units], and what it covers.

    Attributes:
        switching: ψ of every free law; empty where the bound covers a spline family only.
        order: m, the derivative that steers.
        steering: how every free law is steered, caps at the level found.
    """

    value: float
    over: str
    switching: tuple[Switching, ...] = ()
    steering: tuple[Control, ...] = ()

    @property
    def order(self) -> int:
        """m, the derivative that steers."""
        return self.steering[0].order if self.steering else 3


@dataclass(eq=False)
class _Ledger:
    """What the multiplied rows add up to.

    Attributes:
        constant: terms free of unknowns. size: (n_size,) factor of ζ. level: factor of π.
        points, weights: per free law, abscissae and (r, m) factors of g, g', … there.
        spans, heights: per free law, (r, 2) intervals and (r,) factors of g^(m) all along each.
        state: per free law, (m,) factors of unknown initial values g^(j)(0).
        magnitude: sum of the absolute values of what went into ``constant``.
    """

    constant: float
    size: Array
    level: float
    points: list[list[Array]]
    weights: list[list[Array]]
    state: list[Array]
    spans: list[list[Array]]
    heights: list[list[Array]]
    magnitude: float = field(default=0.0)

    def add(self, amount: float) -> None:
        """Book a constant."""
        self.constant += amount
        self.magnitude += abs(amount)


def bound(plan: Plan, solution: ConeSolution, ends: Sequence[Array] | None = None) -> Bound:
    """The bound that these multipliers give: over all laws, else over the splines' family.

    ``ends``: prices of every law's end (``ends_priced``) where the rows at hand are not quite
    those that were solved.
    """
    steering = controls(plan)
    if steering is None:
        return Bound(in_core_units(plan, over_family(plan, solution)), _family(plan))
    order, prices = steering[0].order if steering else 3, heard(plan, solution)
    if ends is None:
        ends = ends_priced(plan, solution, prices, order)
    ledger = _add_up(plan, solution, prices, steering, ends)
    psi = _psi(ledger, order)
    total = _minimum(plan, solution, ledger, steering, psi)
    over = f"all motion laws with a bounded {NAMES[order]}" if steering else _family(plan)
    level = 0.0 if plan.extra is None else abs(float(solution.x[plan.extra]))
    found = tuple(replace(c, cap=c.rate * level) if c.rate else c for c in steering)
    return Bound(in_core_units(plan, total), over, psi, found)


def _family(plan: Plan) -> str:
    parts = {f"degree {g.space.degree} on {len(g.space.breaks) - 1} intervals" for g in plan.grids}
    return "splines of " + " and ".join(sorted(parts)) if parts else "the given laws"


def in_core_units(plan: Plan, value: float) -> float:
    """The program's objective as a value of the asked quantity."""
    if plan.energy is not None:
        return sqrt(max(value * plan.energy.unit + plan.energy.constant, 0.0))
    if plan.problem.objective.norm(plan.problem.machine) is not None:
        return value * plan.scales.size
    return value * plan.scales.level


def _add_up(
    plan: Plan,
    solution: ConeSolution,
    prices: Sequence[Array],
    steering: Sequence[Control],
    ends: Sequence[Array],
) -> _Ledger:
    """All rows times their multipliers, as functionals of arbitrary laws."""
    laws, order = len(plan.grids), steering[0].order if steering else 3
    ledger = _Ledger(
        constant=0.0,
        size=np.zeros(len(plan.problem.sizing.bounds)),
        level=0.0,
        points=[[] for _ in range(laws)],
        weights=[[] for _ in range(laws)],
        state=[np.zeros(order) for _ in range(laws)],
        spans=[[] for _ in range(laws)],
        heights=[[] for _ in range(laws)],
    )
    _book_blocks(plan, prices, ledger, order)
    _book_parts(plan, solution, prices, ledger, order)
    _book_balls(plan, solution, ledger)
    _book_fixed(plan, solution, ledger)
    psi = _psi(ledger, order) if all(control.weight for control in steering) else ()
    _book_prices(plan, ledger, end_prices(plan, steering, psi, ledger.state, ends))
    _quieten(plan, ledger, order)
    return ledger


def _quieten(plan: Plan, ledger: _Ledger, order: int) -> None:
    """More multipliers of values that are held along windows: those that make ψ small there."""
    for block in plan.exact:
        k = int(np.flatnonzero(block.alpha)[0])
        if block.spans is None or block.stretch is None or len(block.x) == 1 or k >= order:
            continue
        part = (float(block.spans[0, 0]), float(block.spans[-1, 1]))
        psi = _psi(ledger, order)[block.stretch]
        x, mass = quietening(psi, block.x, part, float(block.alpha[k]), order - 1 - k)
        ledger.add(-float(np.sum(mass) * block.rhs[0]))
        weights = mass[:, None] * block.alpha[:order]
        _book_point(plan, ledger, block.stretch, x, weights, order)


def _book_point(
    plan: Plan, ledger: _Ledger, position: int, x: Array, weights: Array, order: int
) -> None:
    """Σ weights[i, k] g^(k)(x_i), split into initial values and an integral over g^(m)."""
    ledger.points[position].append(x)
    ledger.weights[position].append(weights)
    start = plan.settled[position].start
    moments = np.stack([x**n / factorial(n) for n in range(order)]) @ weights
    for j in range(order):
        share = float(sum(moments[j - k, k] for k in range(j + 1)))
        if j < len(start):
            ledger.add(share * float(start[j]))
        else:
            ledger.state[position][j] += share


def _book_blocks(plan: Plan, prices: Sequence[Array], ledger: _Ledger, order: int) -> None:
    for block, z in zip(plan.blocks, prices, strict=True):
        if not np.any(z):
            continue
        if block.kind == "monotone" and block.stretch is not None:
            _book_monotone(plan, ledger, block.stretch, z, order)
        whole = block.spans is None
        if block.kind in ("control", "monotone") or np.any(block.alpha[order:]) or not whole:
            continue  # says nothing more of arbitrary laws, or is the steering itself
        ledger.add(-float(z @ block.rhs))
        ledger.level += block.level * float(np.sum(z))
        if len(block.size):
            ledger.size += block.priced(z)
        if block.stretch is not None:
            x, mass = block.x, z
            if block.alpha.ndim == 1 and block.alpha[order - 1] != 0.0:
                x, mass = spread(block.x, z)
            heard = mass > 0.0
            alpha = block.alpha if block.alpha.ndim == 1 else block.alpha[:, heard]
            weights = mass[heard, None] * alpha[:order].T
            _book_point(plan, ledger, block.stretch, x[heard], weights, order)


def _book_parts(
    plan: Plan, solution: ConeSolution, shares: Sequence[Array], ledger: _Ledger, order: int
) -> None:
    """Rows that hold on a part of a law, equalities among them.

    One of the steering derivative itself adds to ψ all along its part.
    """
    prices = [
        *zip(plan.exact, plan.exact_multipliers(solution.multipliers), strict=True),
        *zip(plan.blocks, shares, strict=True),
    ]
    for block, z in prices:
        if block.spans is None or block.stretch is None or np.any(block.alpha[order + 1 :]):
            continue
        ledger.add(-float(z @ block.rhs))
        if block.alpha[order : order + 1].any():
            ledger.spans[block.stretch].append(block.spans)
            ledger.heights[block.stretch].append(z * block.alpha[order] / np.ptp(block.spans, 1))
            continue
        x, mass = block.x, z
        if block.alpha[order - 1] != 0.0 and len(x) > 3:
            # where a window ends its bound may be met at that very point
            x, mass = spread(x, np.concatenate([[0.0], z[1:-1], [0.0]]))
            x, mass = np.append(x, block.x[[0, -1]]), np.append(mass, z[[0, -1]])
        weights = mass[:, None] * block.alpha[:order]
        _book_point(plan, ledger, block.stretch, x, weights, order)


def _book_monotone(plan: Plan, ledger: _Ledger, position: int, z: Array, order: int) -> None:
    """−g' ≤ 0: c_i − c_(i+1) is −gap/p times a coefficient of g', which stands for g' near by."""
    space = plan.grids[position].space
    p, knots = space.degree, space.knots
    heard = np.flatnonzero(z)
    z, i = z[heard], len(plan.settled[position].first) - 1 + heard
    x = np.mean([knots[i + 2 + j] for j in range(p - 1)], axis=0)
    mass = z * (knots[i + p + 1] - knots[i + 1]) / p
    weights = np.zeros((len(z), order))
    weights[:, 1] = -mass
    _book_point(plan, ledger, position, x, weights, order)


def _book_balls(plan: Plan, solution: ConeSolution, ledger: _Ledger) -> None:
    """Cones on the size with a fixed radius; the objective's own is minimised over later."""
    at = plan.program.equalities + plan.program.inequalities
    for ball in plan.balls:
        v = solution.multipliers[at + 1 : at + 1 + len(ball.shift)]
        at += 1 + len(ball.shift)
        if ball.head is None:
            ledger.add(-float(np.linalg.norm(v)) * ball.radius - float(v @ ball.shift))
            ledger.size -= (ball.matrix.T @ v)[plan.size]


def _book_fixed(plan: Plan, solution: ConeSolution, ledger: _Ledger) -> None:
    """Size variables that leave no choice: their rows come after those of the joints."""
    at = sum(max(joint.highest - joint.lowest + 1, 0) for joint in plan.joints)
    for j, (low, high) in enumerate(plan.problem.sizing.bounds):
        if low == high:
            mu = float(solution.multipliers[at])
            at += 1
            ledger.size[j] += mu
            ledger.add(-mu * low / plan.scales.size)


def _book_prices(plan: Plan, ledger: _Ledger, prices: Sequence[Array]) -> None:
    """Values at the ends of laws, at their prices (m,): what is known of them is paid for.

    A derivative that two laws share has one price; it is worth as much at the start of the law
    behind the joint.
    """
    for position, nu in enumerate(prices):
        known = plan.settled[position].end[: len(nu)]
        ledger.add(-float(nu[: len(known)] @ known))
        _book_point(plan, ledger, position, np.ones(1), nu[None, :], len(nu))
    for joint in plan.joints:
        before, after = joint_rows(joint, plan.problem.free, plan.grids)
        for k in range(joint.lowest, min(joint.highest + 1, len(prices[joint.before]))):
            ratio = after.units[k - joint.lowest] / before.units[k - joint.lowest]
            ledger.state[joint.after][k] += ratio * prices[joint.before][k]


def _psi(ledger: _Ledger, order: int) -> tuple[Switching, ...]:
    """ψ of what was booked on every law."""
    none, nothing, nowhere = np.zeros(0), np.zeros((0, order)), np.zeros((0, 2))
    return tuple(
        switching(
            np.concatenate([none, *points]), np.concatenate([nothing, *weights]), order
        ).raised(np.concatenate([nowhere, *spans]), np.concatenate([none, *heights]))
        for points, weights, spans, heights in zip(
            ledger.points, ledger.weights, ledger.spans, ledger.heights, strict=True
        )
    )


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
    bounds = np.array(plan.problem.sizing.bounds) / plan.scales.size
    if norm is not None:
        # ‖Mζ + m‖ ≥ y·(Mζ + m) for ‖y‖ ≤ 1: y takes up what the rows leave of ζ
        matrix = np.array(norm.matrix)
        if len(matrix) == matrix.shape[1]:
            y = np.linalg.solve(matrix.T, -ledger.size)
        else:  # all but what the norm does not speak of: that is least at one end of its range
            y = np.linalg.lstsq(matrix.T, -ledger.size, rcond=None)[0]
            rest = ledger.size + matrix.T @ y
            paid += float(np.sum(np.min(rest[:, None] * bounds, axis=1)))
        shrink = 1.0 / max(1.0, float(np.linalg.norm(y)))
        return shrink * (paid + float(y @ np.array(norm.shift)) / plan.scales.size)
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
    lost, spent = 0.0, 0.0
    if plan.energy is not None:
        laws, _ = plan.recover(solution.x)
        for factor, law in zip(plan.energy.factors, laws, strict=True):
            spent += float(np.sum((factor @ law.coefficients) ** 2))
    for position, (state, control) in enumerate(zip(ledger.state, steering, strict=True)):
        if not np.any(state):
            continue
        free = plan.problem.free[position].free
        if free is None or free.overshoot:
            return inf
        reach = control.cap / 2.0 if control.cap < inf else 0.0
        if control.rate and plan.extra is not None:
            reach += control.rate * abs(float(solution.x[plan.extra]))
        if control.weight and plan.energy is not None:
            reach += sqrt(2.0 * spent / plan.energy.weights[position])
        lost += float(np.abs(state[1:]).sum()) * 12.0 * (1.0 + reach)
    return lost
