"""The best multipliers for the bound over all laws, where those of the splines' program fall short.

A spline's multipliers make ψ right on average over each knot interval; the bound pays for its size
everywhere. So the bound itself is made large: over all multipliers of rows that bind, points and
densities, with |ψ| taken at points that lie close where ψ changes sign. It is concave, so this is
one cone program; its answer is one more set of multipliers, and as little trusted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from synthesis import clock
from synthesis.formulations.bounds.bound import Bound, concluded
from synthesis.formulations.bounds.ledger import Ledger, at_start, carried
from synthesis.formulations.bounds.multiplied import Multiplied, further, said
from synthesis.formulations.bounds.prices import end_prices
from synthesis.formulations.bounds.resounding import resound, resounding
from synthesis.formulations.bounds.tangents import tangents
from synthesis.formulations.cone.control import Control, controls
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.question.grid import SettledLaw
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeProgram, ConeSolution, solve
from synthesis.solvers.statuses import USABLE

BINDING = 1e-3  # of a row's natural size: what is farther off has no multiplier
BESIDE = np.array([1e-2, 1e-3, 1e-4])  # of a law: ends of cells about a change of sign
NOISE = 1e-6  # of the largest |ψ|
STEP = 0.1  # of the steering derivative's range: less is no step
ROUNDS = 4
GAIN = 1e-9  # relative: less is not worth another round


def sharper(
    plan: Plan,
    solution: ConeSolution,
    known: Bound,
    enough: Callable[[Bound], bool],
    seconds: float,
) -> Bound:
    """The bound of the best multipliers, at least the one that is known.

    Args:
        plan: the rows. solution: its optimum, which tells what rows bind.
        known: the bound of the solution's own multipliers.
        enough: whether a bound is as good as is asked. seconds: what is left.
    """
    steering = controls(plan)
    if not steering or any(control.weight for control in steering):
        return known  # of a weighed derivative the end prices alone make the bound exact
    task = _Task.of(plan, solution, steering)
    best, found, until = known, known, clock.now() + seconds
    turns = [_steps(law, task.order) for law in plan.recover(solution.x)[0]]
    for _ in range(ROUNDS):
        turns = [
            np.union1d(before, psi.turns(NOISE))
            for before, psi in zip(turns, found.switching, strict=True)
        ]
        latest, value = task.solved(turns, until - clock.now()), found.value
        if latest is None:
            break
        found = latest
        best = max(best, found, key=lambda each: each.value)
        if enough(best) or abs(found.value - value) <= GAIN * abs(value):
            break
    return best


@dataclass(frozen=True, eq=False)
class _Task:
    """Multipliers of rows that bind, and what is fixed of them.

    Attributes:
        groups: the rows, the last ones g to g^(m−1) at the ends of the laws, at their prices.
        fixed: what has its multipliers already.
    """

    plan: Plan
    solution: ConeSolution
    steering: Sequence[Control]
    groups: tuple[Multiplied, ...]
    fixed: Sequence[tuple[Multiplied, Array]]

    @classmethod
    def of(cls, plan: Plan, solution: ConeSolution, steering: Sequence[Control]) -> _Task:
        order = steering[0].order
        slack = plan.program.rhs - plan.program.matrix @ solution.x
        groups = []
        for one in said(plan, order):
            near = slack[one.rows : one.rows + one.count] <= BINDING
            near |= one.block.exact
            groups.append(one.points(near))
            if one.alike:
                groups.append(one.hats(np.tile(near[:-1] & near[1:], 2)))
        groups += [rows for rows, _ in further(plan, order, solution.multipliers)]
        groups += [_ends(plan, position, order) for position in range(len(plan.grids))]
        fixed = tangents(plan, solution, order)
        fixed += [(rows, mass) for rows, mass, _ in resounding(plan, order, solution.multipliers)]
        return cls(plan, solution, steering, tuple(groups), fixed)

    @property
    def order(self) -> int:
        return self.steering[0].order

    @cached_property
    def first(self) -> list[int]:
        """Where every group's masses begin, and the number of all."""
        return [0, *np.cumsum([len(rows.rhs) for rows in self.groups]).tolist()]

    @cached_property
    def prices(self) -> NDArray[np.intp]:
        """Which unknowns the prices of g to g^(m−1) at the ends are: (laws, m)."""
        shape = len(self.plan.grids), self.order
        return self.first[-1] - shape[0] * shape[1] + np.arange(shape[0] * shape[1]).reshape(shape)

    def solved(self, turns: Sequence[Array], seconds: float) -> Bound | None:
        """One program, its cells close about these turns of ψ; the bound that it gives."""
        found = solve(self._program(turns), seconds)
        if found.stopped not in USABLE:
            return None
        ledger, laws = Ledger(self.plan, self.order), len(self.plan.grids)
        for rows, mass in self.fixed:
            ledger.book(rows, mass)
        resound(ledger, self.solution.multipliers, booked=True)
        for at, rows in zip(self.first[:-1], self.groups[:-laws], strict=False):
            mass = found.x[at : at + len(rows.rhs)]
            ledger.book(rows, mass if rows.signed else np.maximum(mass, 0.0))
        near = list(found.x[self.prices])
        ledger.book_ends(end_prices(self.plan, self.steering, (), ledger.state, near))
        return concluded(self.plan, self.solution, ledger, self.steering)

    def _program(self, turns: Sequence[Array]) -> ConeProgram:
        """Unknowns: masses and prices, |ψ| at all nodes, y of the norm."""
        nodes = [
            _nodes([g for g in self.groups if g.position == k], turns[k], grid.space.breaks)
            for k, grid in enumerate(self.plan.grids)
        ]
        caps, rates = (
            np.concatenate([c * share for c, (_, share) in zip(each, nodes, strict=True)])
            for each in ([c.cap for c in self.steering], [c.rate for c in self.steering])
        )
        psi, offset = self._psi([tau for tau, _ in nodes])
        worth, (matched, unmatched) = self._worth(), self._matched()
        level = np.concatenate([np.full(len(rows.rhs), rows.level) for rows in self.groups])
        size = np.concatenate([rows.size for rows in self.groups]).T
        norm = self.plan.problem.objective.norm(self.plan.problem.machine)
        image = np.zeros((0, len(size))) if norm is None else np.array(norm.matrix)
        shift = np.zeros(0) if norm is None else np.array(norm.shift) / self.plan.scales.size
        one, own = sparse.eye_array(len(offset)), sparse.eye_array(self.first[-1], format="csr")
        signed = np.concatenate([np.full(len(rows.rhs), rows.signed) for rows in self.groups])
        ball = np.eye(1 + len(image))[:, 1:]
        table: list[tuple[Any, Any, Any, Array]] = [
            (matched, None, None, -unmatched),
            (size, None, image.T, np.zeros(len(size))),
            (psi, -one, None, -offset),
            (-psi, -one, None, offset),
            (-own[np.flatnonzero(~signed)], None, None, np.zeros(np.sum(~signed))),
            (-level[None], rates[None], None, np.ones(1)),  # the level's own share is all used up
            (None, None, ball, np.eye(1 + len(image))[0]),
        ]
        rhs = [row[-1] for row in table]
        counts = [len(part) for part in rhs]
        width = self.first[-1] + len(offset) + len(image)
        return ConeProgram(
            sparse.csc_matrix((width, width)),
            np.concatenate([-worth, caps, -shift]),
            sparse.csc_matrix(sparse.block_array([row[:-1] for row in table])),
            np.concatenate(rhs), sum(counts[:2]), sum(counts[2:-1]), (counts[-1],),
        )  # fmt: skip

    def _psi(self, nodes: Sequence[Array]) -> tuple[Array, Array]:
        """ψ at all nodes: (q, n) what a unit of each adds, (q,) what the fixed ones make it."""
        found = [np.zeros((len(tau), self.first[-1])) for tau in nodes]
        for at, rows in zip(self.first, self.groups, strict=False):
            if rows.position is not None:
                found[rows.position][:, at : at + len(rows.rhs)] = rows.psi(nodes[rows.position])
        given = [np.zeros(len(tau)) for tau in nodes]
        for rows, mass in self.fixed:
            if rows.position is not None:
                given[rows.position] += rows.psi(nodes[rows.position]) @ mass
        return np.vstack(found), np.concatenate(given)

    @cached_property
    def _starts(self) -> tuple[Array, Array]:
        """Initial values: (laws, m, n) what a unit of each comes to in them, (laws, m) given."""
        shape = len(self.plan.grids), self.order
        found, given = np.zeros((*shape, self.first[-1])), np.zeros(shape)
        for at, rows in zip(self.first, self.groups, strict=False):
            if rows.position is not None:
                here = slice(at, at + len(rows.rhs))
                found[rows.position][:, here] = at_start(rows.x, rows.weights).T
        for rows, mass in self.fixed:
            if rows.position is not None:
                given[rows.position] += mass @ at_start(rows.x, rows.weights)
        for joint in self.plan.joints:
            for k, ratio in carried(self.plan, joint, self.order):
                found[joint.after, k, self.prices[joint.before, k]] += ratio
        return found, given

    def _worth(self) -> Array:
        """What a unit of each is worth by itself: (n,)."""
        worth = -np.concatenate([rows.rhs for rows in self.groups])
        for ends, state in zip(self.plan.settled, self._starts[0], strict=True):
            known = ends.start[: self.order]
            worth += known @ state[: len(known)]
        return worth

    def _matched(self) -> tuple[Array, Array]:
        """What must come to nothing: unknown initial values, prices of unknown final ones.

        Returns:
            (r, n) and (r,): what unknowns and given masses come to.
        """
        found, given = self._starts
        joints = self.plan.joints
        shared = {(j.before, k) for j in joints for k, _ in carried(self.plan, j, self.order)}
        rows, rest = [np.zeros((0, self.first[-1]))], [np.zeros(0)]
        for position, ends in enumerate(self.plan.settled):
            beyond = range(len(ends.end), self.order)
            worthless = [self.prices[position, k] for k in beyond if (position, k) not in shared]
            rows += [found[position, len(ends.start) :], np.eye(self.first[-1])[worthless]]
            rest += [given[position, len(ends.start) :], np.zeros(len(worthless))]
        return np.vstack(rows), np.concatenate(rest)


def _nodes(groups: Sequence[Multiplied], turns: Array, breaks: Array) -> tuple[Array, Array]:
    """Points of cells between all that acts on a law, and their shares of it: Gauss points.

    Two where ψ is a parabola, three where a density adds to it.
    """
    near = turns[:, None] + np.concatenate([-BESIDE, BESIDE])
    cuts, spans = [breaks, near.ravel()], [np.zeros((0, 2))]
    for rows in groups:
        cuts.append(rows.x)
        if rows.spans is not None:
            cuts.append(rows.spans.ravel())
            spans.append(rows.spans)
    found = np.unique(np.clip(np.concatenate(cuts), 0.0, 1.0))
    middle, (low, high) = 0.5 * (found[:-1] + found[1:]), np.concatenate(spans).T
    bent = np.any((low < middle[:, None]) & (middle[:, None] < high), axis=1)
    tau, shares = list[Array](), list[Array]()
    for count, chosen in ((2, ~bent), (3, bent)):
        node, share = np.polynomial.legendre.leggauss(count)
        width = np.diff(found)[chosen, None] / 2.0
        tau.append((middle[chosen, None] + width * node).ravel())
        shares.append((width * share).ravel())
    return np.concatenate(tau), np.concatenate(shares)


def _steps(law: SettledLaw, order: int) -> Array:
    """The ends of a law, and knots at which its steering derivative steps."""
    breaks = law.space.breaks
    level = law.curve().derivatives(0.5 * (breaks[1:] + breaks[:-1]), order)[order]
    stepped = np.abs(np.diff(level)) > STEP * np.ptp(level)
    return np.concatenate([[0.0, 1.0], breaks[1:-1][stepped]])


def _ends(plan: Plan, position: int, order: int) -> Multiplied:
    """g to g^(m−1) at the end of a law, at prices of either sign."""
    rhs = np.zeros(order)
    known = plan.settled[position].end[:order]
    rhs[: len(known)] = known
    sizes = np.zeros((order, len(plan.problem.sizing.bounds)))
    return Multiplied(position, np.ones(order), np.eye(order), rhs, sizes, signed=True)
