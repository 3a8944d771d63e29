"""A lower bound over every motion law, from the cone program's own multipliers.

The optimum over splines is only the best of its family. Weak duality turns any multipliers
λ ≥ 0 of the rows into a bound for all laws whose m-th derivative is capped (or weighed by the
objective): add λ times the rows to the objective, and minimise over every law pointwise. The
multipliers are used as numbers, not trusted: any λ ≥ 0 gives a valid bound, good ones a tight one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf, sqrt

import numpy as np

from synthesis.formulations.bounds.family import over_family
from synthesis.formulations.bounds.held import quietening
from synthesis.formulations.bounds.ledger import Ledger
from synthesis.formulations.bounds.multiplied import further, said
from synthesis.formulations.bounds.multipliers import ends_priced, heard
from synthesis.formulations.bounds.prices import end_prices
from synthesis.formulations.bounds.resounding import resound
from synthesis.formulations.bounds.switching import Switching, areas
from synthesis.formulations.bounds.tangents import tangents
from synthesis.formulations.cams.closed_form import inverted
from synthesis.formulations.cone.control import Control, controls
from synthesis.formulations.cone.convex import Plan
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


def bound(plan: Plan, solution: ConeSolution, ends: Sequence[Array] | None = None) -> Bound:
    """The bound that these multipliers give: over all laws, else over the splines' family.

    ``ends``: prices of every law's end (``ends_priced``) where the rows at hand are not quite
    those that were solved.
    """
    steering = controls(plan)
    if steering is None:
        return Bound(in_core_units(plan, over_family(plan, solution)), _family(plan))
    order = steering[0].order if steering else 3
    z = heard(plan, solution)
    if ends is None:
        ends = ends_priced(plan, solution, z, order)
    ledger = Ledger(plan, order)
    for rows, mass in tangents(plan, solution, order):
        ledger.book(rows, mass)
    resound(ledger, z)
    _book_rows(plan, ledger, z)
    psi = ledger.psi() if all(control.weight for control in steering) else ()
    ledger.book_ends(end_prices(plan, steering, psi, ledger.state, ends))
    _quieten(plan, ledger)
    return concluded(plan, solution, ledger, steering)


def concluded(
    plan: Plan, solution: ConeSolution, ledger: Ledger, steering: Sequence[Control]
) -> Bound:
    """The bound that follows from what was booked."""
    psi = ledger.psi()
    total = _minimum(plan, solution, ledger, steering, psi)
    over = f"all motion laws with a bounded {NAMES[ledger.order]}" if steering else _family(plan)
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


def _book_rows(plan: Plan, ledger: Ledger, z: Array) -> None:
    """All rows times their multipliers."""
    for one in said(plan, ledger.order, z):
        points, hats = one.masses(z[one.rows : one.rows + one.count])
        heard = points != 0.0
        ledger.book(one.points(heard), points[heard])
        if hats is not None:
            heard = hats != 0.0
            ledger.book(one.hats(heard), hats[heard])
    for rows, mass in further(plan, ledger.order, z):
        ledger.book(rows, mass)


def _quieten(plan: Plan, ledger: Ledger) -> None:
    """More multipliers of values that are held along windows: those that make ψ small there."""
    order = ledger.order
    for block in plan.exact:
        k = int(np.flatnonzero(block.alpha)[0])
        if block.spans is None or block.stretch is None or len(block.x) == 1 or k >= order:
            continue
        part = (float(block.spans[0, 0]), float(block.spans[-1, 1]))
        psi = ledger.psi()[block.stretch]
        x, mass = quietening(psi, block.x, part, float(block.alpha[k]), order - 1 - k)
        ledger.add(-float(np.sum(mass) * block.rhs[0]))
        ledger.act(block.stretch, x, mass[:, None] * block.alpha[:order])


def _minimum(
    plan: Plan,
    solution: ConeSolution,
    ledger: Ledger,
    steering: Sequence[Control],
    psi: Sequence[Switching],
) -> float:
    """The least value of objective plus multiplied rows, after scaling λ to be dual feasible."""
    if all(control.weight for control in steering):
        area: list[float] = []
        capped = sum(p.least(c.cap, c.weight) for p, c in zip(psi, steering, strict=True))
    else:
        area = areas(psi)
        capped = -sum(c.cap * a for a, c in zip(area, steering, strict=True))
    paid: float = ledger.constant + capped - ROUNDING * (ledger.magnitude + abs(capped))
    paid -= _unknown_states(plan, solution, ledger, steering)
    blur = ROUNDING * ledger.spent + ledger.missed
    paid -= sum(
        each * (c.cap if c.cap < inf else (p.peak + each) / (2.0 * c.weight))
        for each, p, c in zip(blur, psi, steering, strict=True)
    )
    norm = plan.problem.objective.norm(plan.problem.machine)
    bounds = np.array(plan.problem.sizing.bounds) / plan.scales.size
    reach = np.max(np.abs(bounds), axis=1)
    if norm is not None:
        # ‖Mζ + m‖ ≥ y·(Mζ + m) for ‖y‖ ≤ 1: y takes up what the rows leave of ζ
        matrix, shift = np.array(norm.matrix), np.array(norm.shift) / plan.scales.size
        if len(matrix) == matrix.shape[1]:
            y = -ledger.size @ inverted(norm.matrix)
            # sizes twice as good as the solution's or better: of others nothing is to be shown
            largest = abs(float(solution.x[plan.extra])) + float(np.linalg.norm(shift))
            far = 2.0 * _stretched(norm.matrix) * largest
            reach = np.minimum(reach, far)
        else:  # all but what the norm does not speak of: that is least at one end of its range
            y = np.linalg.lstsq(matrix.T, -ledger.size, rcond=None)[0]
            rest = ledger.size + matrix.T @ y
            paid += float(np.sum(np.min(rest[:, None] * bounds, axis=1)))
        shrink = 1.0 / max(1.0, float(np.linalg.norm(y)))
        return float(shrink * (paid + y @ shift - ROUNDING * (ledger.sized @ reach)))
    paid += float(np.sum(np.min(ledger.size[:, None] * bounds, axis=1)))
    paid -= ROUNDING * float(ledger.sized @ reach)
    if plan.energy is not None:
        return paid
    price = abs(ledger.level) * ROUNDING - ledger.level
    for a, c, each in zip(area, steering, blur, strict=True):
        price += c.rate * (each + a)
    return paid / price if price > 0.0 else 0.0


@lru_cache(maxsize=64)
def _stretched(matrix: tuple[tuple[float, ...], ...]) -> float:
    """How much longer than its image under an invertible matrix a vector may be."""
    return float(np.linalg.norm(inverted(matrix), 2))


def _unknown_states(
    plan: Plan, solution: ConeSolution, ledger: Ledger, steering: Sequence[Control]
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
        if not np.count_nonzero(state):
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
