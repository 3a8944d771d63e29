"""The best multipliers for the bound over all laws, where those of the splines' program fall short.

A spline's multipliers make ψ right on average over each knot interval; the bound pays for its size
everywhere. So the bound itself is made large: over all multipliers of rows that bind, points and
densities, with |ψ| taken at points that lie close where ψ changes sign. It is concave, so this is
one cone program; its answer is one more set of multipliers, and as little trusted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import factorial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array, gauss_points
from synthesis.numerics.solvers.clarabel import ConeProgram, ConeSolution, solve
from synthesis.numerics.solvers.statuses import USABLE
from synthesis.optimise.conic.control import Control, law_controls
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound import row_functionals as terms
from synthesis.optimise.dual_bound.bound import Bound, add_costates, bound_from_lagrangian
from synthesis.optimise.dual_bound.costates import stationarity_conditions
from synthesis.optimise.dual_bound.lagrangian import Lagrangian, shared_derivatives, sums_at_start
from synthesis.optimise.dual_bound.sensitivity import neighbour
from synthesis.optimise.dual_bound.vibration_terms import vibration_terms
from synthesis.optimise.problem.grid import SplineLaw
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.problem.residual_vibration import VibrationTerm

BINDING = 1e-3  # of a row's natural size: what is farther off has no multiplier
BESIDE = np.array([1e-2, 1e-3, 1e-4])  # of a law: ends of cells about a change of sign
NOISE = 1e-6  # of the largest |ψ|
STEP = 0.1  # of the control's range: less is no step
MAX_ITERATIONS = 4  # of moving quadrature points to sign changes of ψ
GAIN = 1e-2  # of what all have gained: an iteration that gains less is the last


def improve_multipliers(
    model: ConicModel,
    solution: ConeSolution,
    known: Bound,
    is_sufficient: Callable[[Bound], bool],
    time_limit: float,
) -> Bound:
    """The bound of the best multipliers of rows that bind at the optimum; at least ``known``."""
    controls = law_controls(model)
    if not controls or any(control.weight for control in controls):
        return known  # of a weighed derivative the end costates alone make the bound exact
    task = _DualProgram.of(model, solution, controls)
    best, result, until = known, known, clock.now() + time_limit
    sign_changes = [_control_steps(law, task.order) for law in model.recover(solution.x)[0]]
    for _ in range(MAX_ITERATIONS):
        # 1. Put quadrature points close about the sign changes of ψ known so far: between them |ψ|
        #    is ±ψ, and the program's integral of it is exact.
        sign_changes = [
            np.union1d(before, psi.sign_changes(NOISE))
            for before, psi in zip(sign_changes, result.switching, strict=True)
        ]
        # 2. The best multipliers for this quadrature. Their bound is evaluated anew from exact
        #    integrals, so that a quadrature that is too coarse costs sharpness, never validity.
        latest, value = task.solve(sign_changes, until - clock.now()), result.value
        if latest is None:
            break
        result = latest
        # 3. Keep the best; the next iteration knows where its ψ changes sign.
        best = max(best, result, key=lambda each: each.value)
        if is_sufficient(best) or not result.value > value:  # both may be −∞
            break
        if result.value - value <= GAIN * (best.value - known.value):
            break
    return best


@dataclass(frozen=True, eq=False)
class _DualProgram:
    """Multipliers of rows that bind, and what is fixed of them.

    Attributes:
        groups: the rows; first those of the vibrations, ‖y‖ where it has a price and y, and last g
            to g^(m−1) at the ends of the laws, times their costates.
        close: which of the program's rows may bind, (m,).
        fixed: what has its multipliers already.
    """

    model: ConicModel
    solution: ConeSolution
    controls: Sequence[Control]
    order: int
    groups: tuple[terms.WeightedRows, ...]
    close: NDArray[np.bool_]
    fixed: terms.Terms

    @classmethod
    def of(
        cls, model: ConicModel, solution: ConeSolution, controls: Sequence[Control],
        close: NDArray[np.bool_] | None = None,
    ) -> _DualProgram:  # fmt: skip
        if close is None:
            close = model.program.rhs - model.program.matrix @ solution.x <= BINDING
        order, z = controls[0].order, solution.multipliers
        groups = [_vibration_rows(model, one) for one, _ in model.vibration_multipliers(z)]
        # Rows that bind, or nearly: by complementary slackness the others have no multiplier. Where
        # two neighbours bind, a density between them (hat functions) may carry the limit.
        for one in terms.row_functionals(model, order):
            own = close[one.first_row : one.first_row + one.count] | one.block.exact
            groups.append(one.point_rows(own))
            if one.uniform:
                groups.append(one.hat_rows(one.block.x).select(np.tile(own[:-1] & own[1:], 2)))
        groups += [
            rows for rows, _ in (*terms.fixed_size_rows(model, z), *terms.cone_rows(model, z))
        ]
        if model.problem.for_every_size:  # no multiplier that rests on a range of the size
            groups = [rows for rows in groups if not rows.size.any()]
        for position, boundary in enumerate(model.boundary_states):
            # g to g^(m−1) at the end of a law, with costates of either sign
            rhs, known = np.zeros(order), boundary.end[:order]
            rhs[: len(known)] = known
            sizes = np.zeros((order, len(model.problem.sizing.bounds)))
            ends = terms.WeightedRows(
                position, np.ones(order), np.eye(order), rhs, sizes, signed=True
            )
            groups.append(ends)
        tangents = terms.energy_tangents(model, solution, order)
        return cls(model, solution, controls, order, tuple(groups), close, tangents)

    @cached_property
    def first(self) -> list[int]:
        """Where every group's masses begin, and the number of all."""
        return [0, *np.cumsum([len(rows.rhs) for rows in self.groups]).tolist()]

    @cached_property
    def end_costates(self) -> NDArray[np.intp]:
        """Which unknowns the costates of g to g^(m−1) at the ends are: (laws, m)."""
        count = len(self.model.grids) * self.order
        return np.arange(self.first[-1] - count, self.first[-1]).reshape(-1, self.order)

    @cached_property
    def vibrations(self) -> list[tuple[VibrationTerm, int]]:
        """Limits on residual vibration, and where the two multipliers y of each are."""
        known = self.model.vibration_multipliers(self.solution.multipliers)
        return [(one, end - 2) for (one, _), end in zip(known, self.first[1:], strict=False)]

    @cached_property
    def per_multiplier(self) -> list[tuple[int, terms.Terms]]:
        """What a unit of each of these multipliers adds to ψ, and which unknown it is."""
        return [
            (at + axis, vibration_terms(self.model, self.order, [(one, unit[None])])[0])
            for one, at in self.vibrations for axis, unit in enumerate(np.eye(2))
        ]  # fmt: skip

    def solve(self, sign_changes: Sequence[Array], time_limit: float) -> Bound | None:
        """One program, its cells close about these turns of ψ; the bound that it gives."""
        # Its point is as little trusted as any: nothing is gained by exact equalities.
        result = solve(self._program(sign_changes), time_limit, project=False)
        return self.bound(result.x) if result.stopped in USABLE else None

    def bound(self, x: Array) -> Bound:
        """The bound of the masses and costates that a point of such a program begins with."""
        lagrangian, laws = Lagrangian(self.model, self.order), len(self.model.grids)
        multipliers = [(one, x[None, at : at + 2]) for one, at in self.vibrations]
        vibrations, error = vibration_terms(self.model, self.order, multipliers)
        for rows, mass in (*self.fixed, *vibrations):
            lagrangian.add_rows(rows, mass)
        lagrangian.psi_error += error
        others = slice(len(self.vibrations), -laws)
        for at, rows in zip(self.first[others], self.groups[others], strict=False):
            mass = x[at : at + len(rows.rhs)]
            mass = mass if rows.signed else np.maximum(mass, 0.0)
            lagrangian.add_rows(rows.select(mass != 0.0), mass[mass != 0.0])
        add_costates(lagrangian, self.controls, x[self.end_costates][None])
        bound = bound_from_lagrangian(self.solution, lagrangian, self.controls)
        return replace(bound, of_neighbour=partial(self.bound_of_neighbour, x[: self.first[-1]]))

    def bound_of_neighbour(self, x: Array, problem: Problem) -> Bound | None:
        """The bound of the same masses and costates for another problem (``sensitivity``)."""
        other = neighbour(self.model, problem)
        controls = None if other is None else law_controls(other)
        if other is None or not controls:
            return None
        task = _DualProgram.of(other, self.solution, controls, self.close)
        return task.bound(x) if task.first[-1] == len(x) else None

    def _program(self, sign_changes: Sequence[Array]) -> ConeProgram:
        """Unknowns: masses and costates, ψ piece by piece, |ψ| at all nodes, y of the norm."""
        model, order, n = self.model, self.order, self.first[-1]
        laws = [self._pieces(k, cuts) for k, cuts in enumerate(sign_changes)]
        caps, rates = (
            np.concatenate([c * law.shares for c, law in zip(each, laws, strict=True)])
            for each in ([c.cap for c in self.controls], [c.rate for c in self.controls])
        )
        offset = np.concatenate([law.offset for law in laws])
        masses = sparse.vstack([law.masses for law in laws])
        pieces = sparse.block_diag([law.recursion for law in laws])
        psi_masses = sparse.vstack([law.psi_masses for law in laws], format="csr")
        psi_pieces = sparse.block_diag([law.psi_pieces for law in laws], format="csr")
        # The initial costates are the first piece of every ψ, the highest derivative first.
        width, start = pieces.shape[1], np.cumsum([0, *(law.recursion.shape[1] for law in laws)])
        first = start[:-1, None] + np.arange(order)[::-1]
        given = np.stack([law.initial for law in laws])
        initial_masses = np.zeros((*first.shape, n))
        for before, after, k, ratio in shared_derivatives(model, order):
            initial_masses[after, k, self.end_costates[before, k]] += ratio
        for column, unit in self.per_multiplier:
            for k in range(len(laws)):
                initial_masses[k, :, column] += _at_start(unit, k, order)
        # What a unit of each unknown adds to the bound by itself.
        objective, along = -np.concatenate([rows.rhs for rows in self.groups]), np.zeros(width)
        for k, ends in enumerate(model.boundary_states):
            known = ends.start[:order]
            along[first[k, : len(known)]] += known
            objective += known @ initial_masses[k, : len(known)]
        # Unknown initial values must vanish, and costates of unknown final ones.
        _, unknown, priced = stationarity_conditions(model, order)
        worthless = np.eye(n)[self.end_costates[~priced]]
        stationary = sparse.eye_array(width, format="csr")[first[unknown]]
        level = np.concatenate([np.full(len(rows.rhs), rows.level) for rows in self.groups])
        size = np.concatenate([rows.size for rows in self.groups]).T
        norm = model.problem.objective.norm(model.problem.machine)
        image = np.zeros((0, len(size))) if norm is None else np.array(norm.matrix)
        shift = np.zeros(0) if norm is None else np.array(norm.shift) / model.scales.size
        one, own = sparse.eye_array(len(offset)), sparse.eye_array(n, format="csr")
        signed = np.concatenate([np.full(len(rows.rhs), rows.signed) for rows in self.groups])
        ball = np.eye(1 + len(image))[:, 1:]
        # The dual, row by row: the pieces of ψ; stationarity in the unknown initial values and in
        # the size; |ψ| from above by ±ψ; multipliers of inequalities not negative; the objective's
        # own multiplier; and the norm of the size, whose dual variable lies in the unit ball.
        table: list[tuple[Any, Any, Any, Any, Array]] = [
            (-masses, pieces, None, None, np.zeros(width)),
            (initial_masses[unknown], stationary, None, None, -given[unknown]),
            (worthless, None, None, None, np.zeros(len(worthless))),
            (size, None, None, image.T, np.zeros(len(size))),
            (psi_masses, psi_pieces, -one, None, -offset),
            (-psi_masses, -psi_pieces, -one, None, offset),
            (-own[np.flatnonzero(~signed)], None, None, None, np.zeros(np.sum(~signed))),
            (-level[None], None, rates[None], None, np.ones(1)),  # the level's share is used up
            (None, None, None, ball, np.eye(1 + len(image))[0]),
        ]
        # A limit on residual vibration with a price on ‖y‖: (‖y‖, y) lies in a cone.
        cones = [at - 1 for one, at in self.vibrations if one.radius > 0.0]
        table += [(-own[at : at + 3], None, None, None, np.zeros(3)) for at in cones]
        rhs = [row[-1] for row in table]
        counts, balls = [len(part) for part in rhs], len(cones) + 1
        columns = n + width + len(offset) + len(image)
        return ConeProgram(
            sparse.csc_matrix((columns, columns)),
            np.concatenate([-objective, -along, caps, -shift]),
            sparse.csc_matrix(sparse.block_array([row[:-1] for row in table])),
            np.concatenate(rhs), sum(counts[:4]), sum(counts[4:-balls]), tuple(counts[-balls:]),
        )  # fmt: skip

    def _pieces(self, position: int, sign_changes: Array) -> _Pieces:
        """ψ of one law between all that acts on it, its pieces tied to the masses."""
        order, n = self.order, self.first[-1]
        own = [(at, rows) for at, rows in zip(self.first, self.groups, strict=False)
               if rows.position == position]  # fmt: skip
        breaks = self.model.grids[position].space.breaks
        cuts, tau, shares = _quadrature([rows for _, rows in own], sign_changes, breaks)
        count, factorials = len(cuts), np.array([factorial(p) for p in range(order)])
        # 1. About a cut, ψ before it is Σ_p C_p (cut − τ)^p / p!. From cut to cut the coefficients
        #    follow by Taylor; a mass at a cut adds its weight on g^(m−1−p) to C_p.
        p, q = np.triu_indices(order)
        taylor = np.diff(cuts)[:, None] ** (q - p) / factorials[q - p]
        cell = np.arange(count - 1)[:, None] * order
        each = np.arange(count * order)
        recursion = _sparse(
            [(each, each, np.ones(len(each))), (cell + p, cell + order + q, -taylor)],
            (count * order, count * order),
        )
        # 2. What every mass adds there, and ψ at the nodes.
        masses, densities = list[tuple[Any, Any, Array]](), list[tuple[Any, Any, Array]]()
        for at, rows in own:
            where, mass = np.searchsorted(cuts, rows.x) * order, at + np.arange(len(rows.x))
            masses += [(where + order - 1 - k, mass, rows.weights[:, k]) for k in range(order)]
            node, which, density = rows.densities(tau)
            densities.append((node, at + which, density))
        beyond = np.searchsorted(cuts, tau)[:, None]
        powers = (cuts[beyond] - tau[:, None]) ** np.arange(order) / factorials
        places = np.arange(len(tau))[:, None], beyond * order + np.arange(order)
        # 3. Vibrations, and what has its multipliers already.
        nodes = np.arange(len(tau))
        densities += [
            (nodes, np.array([column]), _psi(unit, position, tau))
            for column, unit in self.per_multiplier
        ]
        return _Pieces(
            shares, recursion, _sparse(masses, (count * order, n)),
            _sparse([(*places, powers)], (len(tau), count * order)),
            _sparse(densities, (len(tau), n)), _psi(self.fixed, position, tau),
            _at_start(self.fixed, position, order),
        )  # fmt: skip


def _vibration_rows(model: ConicModel, vibration: VibrationTerm) -> terms.WeightedRows:
    """Constants of a limit on residual vibration: of ‖y‖, where that has a price, and of y."""
    price = [vibration.radius] if vibration.radius > 0.0 else []
    rhs = np.array([*price, *-vibration.shift])
    size = np.zeros((len(rhs), len(model.problem.sizing.bounds)))
    return terms.WeightedRows.of_size(rhs, size, signed=True)


def _psi(known: terms.Terms, position: int, tau: Array) -> Array:
    """What rows with their multipliers add to ψ of one law at τ: (r,)."""
    result = np.zeros(len(tau))
    for rows, mass in known:
        if rows.position == position:
            result += rows.psi(tau) @ mass.ravel()
    return result


def _at_start(known: terms.Terms, position: int, order: int) -> Array:
    """What they add to the sums at the start of the law: (m,)."""
    result = np.zeros(order)
    for rows, mass in known:
        if rows.position == position:
            result += mass.ravel() @ sums_at_start(rows.x[:, None], rows.weights[:, None])
    return result


def _sparse(entries: Sequence[tuple[Any, Any, Array]], shape: tuple[int, int]) -> Any:
    """A matrix of rows, columns and values, each broadcast; what shares a place adds up."""
    each = [np.broadcast_arrays(*one) for one in entries]
    row, column, value = (
        np.concatenate([np.zeros(0, dtype=int), *(one[i].ravel() for one in each)])
        for i in range(3)
    )
    return sparse.csr_array((value, (row, column)), shape=shape)


@dataclass(frozen=True, eq=False)
class _Pieces:
    """ψ of one law, linear in its pieces and in the masses.

    Attributes:
        shares: of the nodes in the integral, (r,).
        recursion, masses: the pieces (c, c) are what the masses (c, n) make of them.
        psi_pieces, psi_masses: ψ at the nodes by the pieces, (r, c), and by densities, (r, n).
        offset, initial: what the fixed do to ψ at the nodes, (r,), and to the initial values, (m,).
    """

    shares: Array
    recursion: Any
    masses: Any
    psi_pieces: Any
    psi_masses: Any
    offset: Array
    initial: Array


def _quadrature(
    groups: Sequence[terms.WeightedRows], sign_changes: Array, breaks: Array
) -> tuple[Array, Array, Array]:
    """The ends of cells between all that acts on a law, Gauss points and their shares of it.

    Two points where ψ is a parabola, three where a density adds to it.
    """
    close = sign_changes[:, None] + np.concatenate([-BESIDE, BESIDE])
    cuts, spans = [breaks, close.ravel()], [np.zeros((0, 2))]
    for rows in groups:
        cuts.append(rows.x)
        if rows.spans is not None:
            cuts.append(rows.spans.ravel())
            spans.append(rows.spans)
    result = np.unique(np.clip(np.concatenate(cuts), 0.0, 1.0))
    middle, (low, high) = 0.5 * (result[:-1] + result[1:]), np.concatenate(spans).T
    cubic = np.any((low < middle[:, None]) & (middle[:, None] < high), axis=1)
    tau, shares = list[Array](), list[Array]()
    for count, chosen in ((2, ~cubic), (3, cubic)):
        points, weights = gauss_points(result, count)
        tau.append(points[chosen].ravel())
        shares.append(weights[chosen].ravel())
    return result, np.concatenate(tau), np.concatenate(shares)


def _control_steps(law: SplineLaw, order: int) -> Array:
    """The ends of a law, and knots at which its control steps."""
    breaks = law.space.breaks
    level = law.curve().derivatives(0.5 * (breaks[1:] + breaks[:-1]), order)[order]
    stepped = np.abs(np.diff(level)) > STEP * np.ptp(level)
    return np.concatenate([[0.0, 1.0], breaks[1:-1][stepped]])
