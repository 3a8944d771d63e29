"""What multiplied rows add up to, as functionals of arbitrary laws: constants, sizes, and ψ."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from synthesis.formulations.bounds.multiplied import Multiplied
from synthesis.formulations.bounds.switching import Switching, switching
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.question.ends import Joint, joint_rows
from synthesis.numerics.piecewise import Array


@dataclass(eq=False)
class Ledger:
    """Rows times their multipliers, booked one after the other.

    Attributes:
        plan: whose rows. order: m, the derivative that steers.
        size: (n_size,) factor of ζ. level: factor of π.
        sized: sum of the absolute values of what went into ``size``.
        missed: what every law's true ψ differs from the polynomials at most.
    """

    plan: Plan
    order: int
    size: Array = field(init=False)
    level: float = 0.0
    sized: Array = field(init=False)
    missed: Array = field(init=False)
    _constant: float = field(default=0.0, init=False)
    _magnitude: float = field(default=0.0, init=False)
    _state: list[Array] = field(init=False)
    _spent: Array = field(init=False)
    _points: list[list[Array]] = field(init=False)
    _weights: list[list[Array]] = field(init=False)
    _spans: list[list[Array]] = field(init=False)
    _polys: list[list[Array]] = field(init=False)
    _started: list[int] = field(init=False)

    def __post_init__(self) -> None:
        laws = range(len(self.plan.grids))
        self.size = np.zeros(len(self.plan.problem.sizing.bounds))
        self.sized, self._spent = np.zeros_like(self.size), np.zeros(len(laws))
        self.missed = np.zeros(len(laws))
        self._state = [np.zeros(self.order) for _ in laws]
        self._points, self._weights = [[] for _ in laws], [[] for _ in laws]
        self._spans, self._polys = [[] for _ in laws], [[] for _ in laws]
        self._started = [0 for _ in laws]

    @property
    def constant(self) -> float:
        """Terms free of unknowns."""
        self._start()
        return self._constant

    @property
    def magnitude(self) -> float:
        """Sum of the absolute values of what went into ``constant``."""
        self._start()
        return self._magnitude

    @property
    def state(self) -> list[Array]:
        """Per free law, (m,) factors of unknown initial values g^(j)(0)."""
        self._start()
        return self._state

    @property
    def spent(self) -> Array:
        """Sum of the absolute values of what went into every law's ψ."""
        self._start()
        return self._spent

    def add(self, amount: float) -> None:
        """Book a constant."""
        self._constant += amount
        self._magnitude += abs(amount)

    def book(self, rows: Multiplied, mass: Array) -> None:
        """Rows times their multipliers (n,)."""
        if np.count_nonzero(mass) < len(mass):
            heard = mass != 0.0
            rows, mass = rows.chosen(heard), mass[heard]
        if not len(mass):
            return
        self.add(-float(mass @ rows.rhs))
        self.size += mass @ rows.size
        self.sized += np.abs(mass) @ np.abs(rows.size)
        if rows.level:
            self.level += rows.level * float(np.sum(mass))
        if rows.position is None:
            return
        self.act(rows.position, rows.x, mass[:, None] * rows.weights)
        if rows.spans is not None and rows.poly is not None:
            self._spans[rows.position].append(rows.spans)
            self._polys[rows.position].append(mass[:, None] * rows.poly)
            self._spent[rows.position] += float(np.abs(mass) @ np.abs(rows.poly[:, 0]))

    def act(self, position: int, x: Array, weights: Array) -> None:
        """Σ weights[i, k] g^(k)(x_i): an integral over g^(m), and initial values."""
        self._points[position].append(x)
        self._weights[position].append(weights)

    def _start(self) -> None:
        """Book the initial values of all that has acted since the last time."""
        for position, arrays in enumerate(self._weights):
            first = self._started[position]
            if first == len(arrays):
                continue
            self._started[position] = len(arrays)
            weights = np.concatenate(arrays[first:])
            size = float(np.abs(weights).sum())
            self._spent[position] += size
            start = self.plan.settled[position].start[: self.order]
            shares = _sums_at_start(np.concatenate(self._points[position][first:]), weights)
            known = len(start)
            for share, value in zip(shares[:known].tolist(), start.tolist(), strict=True):
                self._constant += share * value
                self._magnitude += size * abs(value)  # shares are sums that may cancel
            self._state[position][known:] += shares[known:]

    def book_ends(self, prices: Sequence[Array]) -> None:
        """Values at the ends of laws, at their prices (m,): what is known of them is paid for.

        A derivative that two laws share has one price; it is worth as much at the start of the law
        behind the joint.
        """
        for position, nu in enumerate(prices):
            known = self.plan.settled[position].end[: len(nu)]
            self.add(-float(nu[: len(known)] @ known))
            self.act(position, np.ones(1), nu[None, :])
        for joint in self.plan.joints:
            for k, ratio in carried(self.plan, joint, self.order):
                self.state[joint.after][k] += ratio * prices[joint.before][k]

    def psi(self) -> tuple[Switching, ...]:
        """ψ of what was booked on every law."""
        return tuple(self._psi(position) for position in range(len(self._points)))

    def _psi(self, position: int) -> Switching:
        points = np.concatenate([np.zeros(0), *self._points[position]])
        weights = np.concatenate([np.zeros((0, self.order)), *self._weights[position]])
        found = switching(points, weights, self.order)
        if not self._spans[position]:
            return found
        poly = np.concatenate(self._polys[position])
        used = np.flatnonzero(poly.any(axis=0))
        poly = poly[:, : used[-1] + 1] if len(used) else poly[:, :1]
        return found.raised(np.concatenate(self._spans[position]), poly)


def at_start(x: Array, weights: Array) -> Array:
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
    """The sums over all x of what ``at_start`` says of each: (m,)."""
    order = weights.shape[1]
    moments = (_powers(x, order) @ weights).tolist()
    return np.array([sum(moments[j - k][k] for k in range(j + 1)) for j in range(order)])


def _powers(x: Array, count: int) -> Array:
    """x^n/n! for n < count: (count, n)."""
    found = np.ones((count, len(x)))
    found[1:2] = x
    for n in range(2, count):
        np.multiply(found[n - 1], x / n, out=found[n])
    return found


def carried(plan: Plan, joint: Joint, order: int) -> Iterator[tuple[int, float]]:
    """Derivatives below ``order`` that a joint shares, and what a price before is worth after."""
    before, after = joint_rows(joint, plan.problem.free, plan.grids)
    for k in range(joint.lowest, min(joint.highest + 1, order)):
        at = k - joint.lowest
        yield k, float(after.units[at] / before.units[at])
