"""The cone program a second time, in CVXPY, straight from the problem: a reference for tests.

It shares no row with ``synthesis.optimise.conic``: its unknowns are the spline coefficients of s
over the stroke (all of them, ends and junctions being equations), its rows are scaled by their
largest entry, its integrals are its own.
"""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from synthesis.catalogue.constraints import AffineNorm, LinearInequality
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.optimise.problem.grid import Grid
from synthesis.optimise.problem.problem import Problem
from synthesis.units import FULL_TURN
from tests.lazy import LazyModule

cp: Any = LazyModule("cvxpy")
IN_WINDOW = 4  # points on every interval of a window
DENSE = 4001  # samples of a given law's piece when its worst angle is wanted


@dataclass(frozen=True)
class Optimum:
    """What CVXPY found: the objective in problem units, None where it found nothing."""

    value: float | None
    status: str


def optimum(problem: Problem, grids: Sequence[Grid], level: float = 0.0) -> Optimum:
    """Solve the problem on given grids.

    Args:
        problem: the question. grids: one per free segment.
        level: trial level of a fractional objective, otherwise without effect.
    """
    statement = _Statement(problem, grids)
    value = statement.value(level)
    question = cp.Problem(cp.Minimize(value), list(statement.constraints(level)))
    # Of a badly scaled linear program Clarabel accepts points that break rows within its tolerance
    # and lie one part in 10,000 below the optimum (two laws of degree 5 on uneven knots). The
    # simplex method of HiGHS ends at a vertex, which solves its equations to rounding.
    if question.is_lp():
        accurate = {f"{kind}_feasibility_tolerance": 1e-10 for kind in ("primal", "dual")}
        attempts = [{"solver": cp.HIGHS, **accurate}]
    else:
        # At 1e-10 it does the same: a peak acceleration came out one part in 100,000 too low. The
        # next accuracy is taken where rounding does not allow the one before.
        kinds = ("tol_gap_abs", "tol_gap_rel", "tol_feas")
        accuracies = (1e-12, 1e-10, 1e-8)
        attempts = [{"solver": cp.CLARABEL, **dict.fromkeys(kinds, at)} for at in accuracies]
    for attempt in attempts:
        with warnings.catch_warnings(), contextlib.suppress(cp.SolverError):
            warnings.simplefilter("ignore")  # of reduced accuracy: the status says so too
            question.solve(**attempt)
            if question.status == cp.OPTIMAL:
                break
    if question.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
        return Optimum(None, question.status)
    return Optimum(statement.in_problem_units(float(question.value)), question.status)


class _Statement:
    """The unknowns, and what is said of them."""

    def __init__(self, problem: Problem, grids: Sequence[Grid]) -> None:
        self.problem, self.unit = problem, problem.length
        self.laws = {
            segment.index: _Law(segment, grid, problem.length)
            for segment, grid in zip(problem.free, grids, strict=True)
        }
        self.size = cp.Variable(len(problem.sizing.bounds))  # over the stroke
        self.level = cp.Variable()
        self.level_unit = max(self._natural_levels(), default=1.0)

    def _natural_levels(self) -> Iterator[float]:
        for segment in self.problem.segments:
            per_turn = abs(segment.lift) / segment.angle ** np.arange(4)
            for row in self.problem.objective.rows(segment, self.problem.machine, 0.0):
                yield float(np.max(np.abs(row.coefficients) * per_turn)) or 1.0

    # -- the objective -----------------------------------------------------------------------

    def value(self, level: float) -> Any:
        objective, machine = self.problem.objective, self.problem.machine
        norm, order = objective.norm(machine), objective.energy_order()
        if norm is not None:
            return self.norm(norm)
        return self.level if order is None else self.mean_square(order, self.energy_unit(order))

    def in_problem_units(self, value: float) -> float:
        objective, machine = self.problem.objective, self.problem.machine
        if objective.norm(machine) is not None:
            return value * self.unit
        order = objective.energy_order()
        if order is None:
            return value * self.level_unit
        return float(np.sqrt(max(value, 0.0) * self.energy_unit(order)))

    def norm(self, norm: AffineNorm) -> Any:
        return cp.norm(np.array(norm.matrix) @ self.size + np.array(norm.shift) / self.unit)

    def energy_unit(self, order: int) -> float:
        """Of the best laws between dwells: ∫ a² = 12, ∫ j² = 720."""
        shares = ((s.lift / s.angle**order) ** 2 * s.angle for s in self.problem.segments)
        return {2: 12.0, 3: 720.0}[order] * sum(shares) / FULL_TURN

    def mean_square(self, order: int, unit: float) -> Any:
        """1/2π ∫ (s^(order))² dθ over ``unit``."""
        parts: list[Any] = []
        for segment in self.problem.segments:
            if segment.index in self.laws:
                parts.append(self.laws[segment.index].square(order, unit))
            else:
                parts.append(_square(segment.placed(), order) / unit)
        return cp.sum(cp.hstack(parts))

    # -- what must hold ----------------------------------------------------------------------

    def constraints(self, level: float) -> Iterator[Any]:
        yield from self._sizes()
        yield from self._joints()
        for segment in self.problem.segments:
            for row in self._rows(segment, level):
                yield from self._row(row, segment)
        for law in self.laws.values():
            yield from law.monotone()

    def _sizes(self) -> Iterator[Any]:
        for variable, (low, high) in zip(self.size, self.problem.sizing.bounds, strict=True):
            if low == high:
                yield variable == low / self.unit
            else:
                yield variable >= low / self.unit
                yield variable <= high / self.unit
        for cone in self.problem.sizing.norm_bounds:
            yield self.norm(cone.norm) <= cone.upper / self.unit
        for limit in self.problem.limits:
            for cone in limit.norm_bounds(self.problem.segments, self.problem.machine):
                yield self.norm(cone.norm) <= cone.upper / self.unit
        for earlier in self.problem.objective_caps:
            norm = earlier.objective.norm(self.problem.machine)
            order = earlier.objective.energy_order()
            if norm is not None:
                yield self.norm(norm) <= earlier.value / self.unit
            if order is not None:
                yield self.mean_square(order, earlier.value**2) <= 1.0

    def _joints(self) -> Iterator[Any]:
        """Neighbours share s and as many derivatives as the free laws among them promise."""
        segments = self.problem.segments
        for before, after in zip(segments, (*segments[1:], segments[0]), strict=True):
            promised = [s.free.smoothness for s in (before, after) if s.free is not None]
            if not promised:
                continue
            for order in range(min(promised) + 1):
                left, entries = self._at(before, 1.0, order)
                right, more = self._at(after, 0.0, order)
                yield (left - right) / max(entries, more) == 0.0
                if order == 0:
                    yield left / self.unit == before.s_end / self.unit

    def _at(self, segment: PlacedSegment, x: float, order: int) -> tuple[Any, float]:
        """s^(order) at one end of a segment, and the largest factor of an unknown in it."""
        if segment.index in self.laws:
            return self.laws[segment.index].at(x, order)
        placed = segment.placed()
        theta = placed.breaks[-1:] if x == 1.0 else placed.breaks[:1]
        return float(placed(theta, order, "left" if x == 1.0 else "right")[0]), 0.0

    def _rows(self, segment: PlacedSegment, level: float) -> Iterator[LinearInequality]:
        machine = self.problem.machine
        for limit in self.problem.limits:
            yield from limit.rows(segment, machine)
        yield from self.problem.objective.rows(segment, machine, level)
        for earlier in self.problem.objective_caps:
            held = 0.0 if earlier.objective.quasiconvex else earlier.value
            for row in earlier.objective.rows(segment, machine, earlier.value):
                yield LinearInequality(row.coefficients, row.size, row.upper - row.level * held)

    def _row(self, row: LinearInequality, segment: PlacedSegment) -> Iterator[Any]:
        size = np.array(row.size or np.zeros(len(self.problem.sizing.bounds))) * self.unit
        level = row.level * self.level_unit
        rest = size @ self.size + level * self.level - row.upper
        if segment.index in self.laws:
            motion, entries = self.laws[segment.index].row(row)
            scale = max(entries, np.abs(size).max(), abs(level))
            excess = (motion + rest) / scale
            yield excess == 0.0 if row.equality else excess <= 0.0
        elif row.size or row.level:
            scale = max(np.abs(size).max(), abs(level))
            yield (_worst(segment.placed(), row.coefficients) + rest) / scale <= 0.0


class _Law:
    """The spline of one free segment: s = unit · Σ c_i B_i(x), x = (θ − start)/β."""

    def __init__(self, segment: PlacedSegment, grid: Grid, unit: float) -> None:
        self.segment, self.grid, self.unit = segment, grid, unit
        self.c = cp.Variable(grid.space.size)
        self.basis = BSpline(grid.space.knots, np.eye(grid.space.size), grid.space.degree)

    def at(self, x: float, order: int) -> tuple[Any, float]:
        table = self.basis(x, nu=order) * (self.unit / self.segment.angle**order)
        return table @ self.c, float(np.abs(table).max())

    def row(self, row: LinearInequality) -> tuple[Any, float]:
        """Σ coefficients[k] s^(k) where it is limited, and its largest entry.

        At the grid's points; but a bound on s''' alone, and on a derivative that is linear
        between knots, is one on the derivative's own spline coefficients. On a part of the law
        at many points of it.
        """
        coefficients = row.coefficients
        orders = [k for k, a in enumerate(coefficients) if a]
        order = orders[0] if len(orders) == 1 else 0
        if row.interval is None and (order == 3 or (order and self.grid.space.degree - order == 1)):
            raised = self.basis.derivative(order)
            count = self.grid.space.size - order
            table = raised.c[:count] * (coefficients[order] / self.segment.angle**order)
        else:
            scaled = [coefficients[k] / self.segment.angle**k for k in orders]
            values = [self.basis(self.points(row), nu=k) for k in orders]
            table = np.tensordot(scaled, values, axes=1)
        return (table * self.unit) @ self.c, float(np.abs(table).max()) * self.unit

    def points(self, row: LinearInequality) -> Array:
        """Where a row is written."""
        if row.interval is None:
            return self.grid.points
        low, high = row.interval
        if low == high:
            return np.array([low])
        breaks, points = self.grid.space.breaks, self.grid.points
        ends = np.union1d(breaks[(breaks > low) & (breaks < high)], [low, high])
        if not row.equality and not row.coefficients[3]:
            return np.union1d(ends, points[(points > low) & (points < high)])
        inner = np.linspace(1e-9, 1.0 - 1e-9, IN_WINDOW)  # the jerk may jump at knots
        return np.asarray((ends[:-1, None] + np.diff(ends)[:, None] * inner).ravel())

    def monotone(self) -> Iterator[Any]:
        assert self.segment.free is not None
        if not self.segment.free.overshoot:
            yield np.sign(self.segment.lift) * cp.diff(self.c) >= 0.0

    def square(self, order: int, unit: float) -> Any:
        """Its share of the mean square over ``unit``."""
        nodes, weights = np.polynomial.legendre.leggauss(self.grid.space.degree + 2)
        left, width = self.grid.space.breaks[:-1], np.diff(self.grid.space.breaks)
        x = (left[:, None] + np.outer(width, nodes + 1.0) / 2.0).ravel()
        share = (np.outer(width, weights) / 2.0).ravel() * self.segment.angle / FULL_TURN
        table = self.basis(x, nu=order) * (self.unit / self.segment.angle**order)
        return cp.sum_squares((np.sqrt(share / unit)[:, None] * table) @ self.c)


def _worst(curve: Piecewise, coefficients: Sequence[float]) -> float:
    """Largest Σ coefficients[k] f^(k) on dense samples of every piece."""
    left, width = curve.breaks[:-1, None], np.diff(curve.breaks)[:, None]
    theta = (left + width * np.linspace(0.0, 1.0, DENSE)).ravel()
    piece = np.repeat(np.arange(curve.count), DENSE)
    return float(np.max(sum(a * curve.at(theta, piece, k) for k, a in enumerate(coefficients))))


def _square(curve: Piecewise, order: int) -> float:
    """1/2π ∫ (f^(order))² by the trapezium rule on dense samples, improved once."""
    total = 0.0
    for piece, (left, right) in enumerate(zip(curve.breaks[:-1], curve.breaks[1:], strict=True)):
        theta = np.linspace(left, right, DENSE)
        value = curve.at(theta, np.full(DENSE, piece), order) ** 2
        fine, coarse = np.trapezoid(value, theta), np.trapezoid(value[::2], theta[::2])
        total += float(4.0 * fine - coarse) / 3.0
    return total / FULL_TURN
