"""Terms of the Lagrangian as functionals of arbitrary laws: what a unit of their multipliers does.

Rows: a row's multiplier may sit at its point. Where the row reads the same all along a law or a
window it holds between its points too, and its multiplier may be a density there.

Fixed sizes and cones: a cone ‖M ζ + m‖ ≤ r with dual vector (‖v‖, v) is the valid row
v · (M ζ + m) ≤ ‖v‖ r, by Cauchy and Schwarz, whatever v.

Mean square: (g^(k))² ≥ 2 y g^(k) − y² for any y, with equality where g^(k) = y. So where the
objective weighs a lower derivative than the one that is capped, this tangent takes its place: it
is linear in the law and never above the objective.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import comb, factorial
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeSolution
from synthesis.optimise.conic.control import MeanSquareCap
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel

Which = NDArray[Any] | slice
EVERY = slice(None)
DEGREE = 4  # of what a density of g itself adds to ψ where the third derivative is the control
RISING_SHARE = {"mean": 0.5, "falling": 0.0, "rising": 1.0}  # of a density, by kind of block
PARTS = 4  # of a knot interval where y is not linear there


@dataclass(frozen=True, eq=False)
class WeightedRows:
    """n multipliers of one kind on one law: Σ weights · (g, g', …) (x) and a share of ∫ g^(m).

    Attributes:
        position: of the law, None where there is no motion in the rows.
        x: (n,) and weights: (n, m), which come to ψ before x.
        spans, poly: (n, 2) and (n, DEGREE + 1), what ψ gets on these spans as well, in s from 0 to
            1 along them; None: nothing.
        rhs: (n,) right-hand sides. size: (n, n_size) factors of ζ. level: factor of π.
        signed: of either sign, as the rows are equalities.
    """

    position: int | None
    x: Array
    weights: Array
    rhs: Array
    size: Array
    level: float = 0.0
    signed: bool = False
    spans: Array | None = None
    poly: Array | None = None

    @classmethod
    def of_size(cls, rhs: Array, size: Array, *, signed: bool = False) -> Self:
        """Rows without motion: rhs (n,), size (n, n_size)."""
        return cls(None, np.zeros(len(rhs)), np.zeros((len(rhs), 1)), rhs, size, signed=signed)

    def psi(self, tau: Array) -> Array:
        """What a unit of each adds to ψ at τ (q,): (q, n)."""
        order = self.weights.shape[1]
        ahead = np.maximum(self.x - tau[:, None], 0.0)
        result = np.where(self.x > tau[:, None], self.weights[:, -1], 0.0)
        for k in range(order - 1):
            result += self.weights[:, k] * ahead ** (order - 1 - k) / factorial(order - 1 - k)
        row, column, density = self.densities(tau)
        result[row, column] += density
        return result

    def densities(self, tau: Array) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
        """The part of ``psi`` that acts along spans alone: rows, columns and values, (k,) each."""
        if self.poly is None or self.spans is None:
            nowhere = np.zeros(0, dtype=np.intp)
            return nowhere, nowhere, np.zeros(0)
        low, high = self.spans.T
        row, column = np.nonzero((low <= tau[:, None]) & (tau[:, None] < high))
        s, poly = (tau[row] - low[column]) / (high - low)[column], self.poly[column]
        return row, column, np.asarray(sum(poly[:, j] * s**j for j in range(poly.shape[1])))

    def select(self, which: NDArray[Any]) -> WeightedRows:
        """Some of them: a mask or numbers."""
        names = ("x", "weights", "rhs", "size", "spans", "poly")
        parts = {name: part[which] for name in names if (part := getattr(self, name)) is not None}
        return replace(self, **parts)


Terms = list[tuple[WeightedRows, Array]]
"""Rows with their multipliers, (n,) or (q, n)."""


@dataclass(frozen=True, eq=False)
class RowFunctional:
    """What a block says of arbitrary laws: at its points, and by densities between them.

    Attributes:
        first_row: number of its first row in the program. order: m, the order of the control.
    """

    model: ConicModel
    block: LinearBlock
    first_row: int
    order: int

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.block.rhs)

    @property
    def jumps(self) -> bool:
        """Whether a point multiplier makes ψ jump."""
        return self.block.highest_order == self.order - 1

    @property
    def uniform(self) -> bool:
        """Whether its rows read the same everywhere, at points that ascend, so that densities
        between neighbouring points are multipliers as well.
        """
        block = self.block
        same = block.alpha.ndim == 1 and block.size.ndim == 1
        return same and block.highest_order < self.order and block.ascending

    @property
    def may_be_density(self) -> bool:
        """Whether its multipliers may be densities along an arc, where ψ would jump at points."""
        return self.jumps and self.uniform

    def point_rows(self, which: Which = EVERY) -> WeightedRows:
        """All of its rows, or some: a mask or numbers."""
        block, order, rhs = self.block, self.order, self.block.rhs[which]
        size = np.zeros((len(rhs), len(self.model.problem.sizing.bounds)))
        if len(block.size):
            size[:] = _of_rows(block.size, which)
        x, weights = block.x[which], np.zeros((len(rhs), order))
        spans = poly = None
        if block.kind == "monotone" and block.segment is not None:
            # Coefficients in order act as −g' ≤ 0 near by.
            first = len(self.model.boundary_states[block.segment].first) - 1
            here = slice(first, first + self.count)
            x, slopes = (a[here][which] for a in self.model.grids[block.segment].space.step_slopes)
            weights[:, 1] = slopes
        elif block.highest_order == order or block.kind in RISING_SHARE:
            # Rows of the control itself on a part of a law, and means over it, add to ψ all along.
            assert block.spans is not None
            spans, alpha = block.spans[which], np.zeros((len(rhs), order + 1))
            alpha[:] = _of_rows(block.alpha.T, which)[..., : order + 1]
            rising = RISING_SHARE.get(block.kind, 0.5)
            hats = Hats(spans[:, 0], spans[:, 1], np.full(len(rhs), rising), alpha[:, :order])
            x, weights, poly = hats.left, hats.weights, hats.poly
            # the density itself: 2 (1 − s) over the width of a falling hat, 2 s of a rising one
            steep = 2.0 * alpha[:, order] / np.ptp(spans, axis=1)
            poly[:, 0] += (1.0 - rising) * steep
            poly[:, 1] += (2.0 * rising - 1.0) * steep
        else:
            weights[:] = _of_rows(block.alpha.T, which)[..., :order]
        return WeightedRows(
            block.segment, x, weights, rhs, size, block.level, block.exact, spans, poly
        )

    def hat_rows(self, nodes: Array) -> WeightedRows:
        """The densities between neighbouring nodes (n,): falling hats, then rising ones."""
        hats = Hats.between(nodes, self.block.alpha[: self.order])
        of = self.point_rows(np.zeros(len(hats.left), dtype=np.intp))
        return replace(of, x=hats.left, weights=hats.weights, spans=hats.spans, poly=hats.poly)

    def distribute(self, z: Array, *, dense: bool = False) -> tuple[Array, Array, Array]:
        """Multipliers z (r,) shared out: what stays at the points (r,); nodes of densities (n,),
        linear in between, and their masses (n,).

        ``dense``: whether there are many points in a knot interval, with the multipliers of a
        density already: then it is linear between these points.

        A point multiplier on the derivative just below the control makes ψ jump; where that
        bound is met along an arc the true multiplier is a density, and ψ vanishes there. Where a
        window ends its bound may be met at that very point.
        """
        windowed, none = self.block.spans is not None, np.zeros(0)
        if not self.may_be_density or (windowed and len(z) <= 3):
            return z, none, none
        kept, nodes = np.zeros_like(z), self.block.x
        if windowed:
            kept[[0, -1]] = z[[0, -1]]
        mass = z - kept
        if not self.block.exact and not dense:
            alone, nodes, mass = self._quadrature(mass)
            kept += alone
        return kept, nodes, mass

    def _quadrature(self, mass: Array) -> tuple[Array, Array, Array]:
        """Multipliers (r,) ≥ 0 as a quadrature of a density, with one node in a knot interval.

        A spline meets a row at about one point of an interval, and the multipliers at the others
        are 0 or next to it: a density through all of them would come and go with the knots.

        Returns:
            (r,) multipliers of single points, where no interval beside theirs has any; (n,) nodes,
            each at the centroid of its interval's multipliers, and (n,) their sums.
        """
        assert self.block.segment is not None
        x, breaks = self.block.x, self.model.grids[self.block.segment].space.breaks
        _, interval = np.unique(np.searchsorted(breaks, x, "right"), return_inverse=True)
        sums = np.pad(np.bincount(interval, mass), 1)
        single = ((sums[:-2] == 0.0) & (sums[2:] == 0.0))[interval]
        spread = np.where(single, 0.0, mass)
        weight = np.where(spread > 0.0, spread, np.finfo(float).tiny)
        nodes = np.bincount(interval, weight * x) / np.bincount(interval, weight)
        return mass - spread, nodes, np.asarray(np.bincount(interval, spread), dtype=float)


def _of_rows(each: Array, which: Which) -> Array:
    """What is said of some rows, where something is said row by row; else what is said of all."""
    return each if each.ndim == 1 else each[which]


def row_functionals(
    model: ConicModel, order: int, z: Array | None = None
) -> Iterator[RowFunctional]:
    """All rows that speak of arbitrary laws, or of the size alone; those of multipliers z ≠ 0."""
    for at, block in model.numbered_blocks:
        if z is not None and not np.count_nonzero(z[at : at + len(block.rhs)]):
            continue
        # Of the others one is the control's own cap, and the rest only hold for splines.
        if block.kind == "monotone":
            speaks = True
        elif block.spans is not None:
            speaks = block.highest_order <= order
        else:
            speaks = block.kind != "control" and block.highest_order < order and not block.exact
        if speaks:
            yield RowFunctional(model, block, at, order)


@dataclass(frozen=True, eq=False)
class Hats:
    """Hats on intervals of a law, all of one row alpha · (g, g', …) or of one row each.

    Attributes:
        left, right: (n,) a < b. rising: (n,) share of the weight that is at b: 0 of a falling hat,
            1 of a rising one, 1/2 of an even density.
        alpha: (n, m) factors of g to g^(m−1).
    """

    left: Array
    right: Array
    rising: Array
    alpha: Array

    @classmethod
    def between(cls, nodes: Array, alpha: Array) -> Self:
        """All between neighbours of ascending nodes (n,): falling ones, then rising ones."""
        count = len(nodes) - 1
        rising = np.repeat([0.0, 1.0], count)
        return cls(
            np.tile(nodes[:-1], 2), np.tile(nodes[1:], 2), rising, np.tile(alpha, (2 * count, 1))
        )

    @property
    def spans(self) -> Array:
        """From a to b: (n, 2)."""
        return np.stack([self.left, self.right], axis=1)

    @property
    def weights(self) -> Array:
        """Weights (n, m) on g, g', … at a that act like the hats on all that lies before a."""
        width = self.right - self.left
        order = self.alpha.shape[1]
        result = self.alpha.copy()
        if order > 1:
            mean = (1.0 + self.rising) / 3.0 * width
            result[:, 1:] += mean[:, None] * self.alpha[:, :-1]
        if order > 2:
            result[:, 2] += (1.0 + 2.0 * self.rising) / 12.0 * width**2 * self.alpha[:, 0]
        return result

    @property
    def poly(self) -> Array:
        """What they add to ψ between a and b: (n, DEGREE + 1) in s, from 0 to 1 along it.

        ∫ ρ(x) (x − τ)^p/p! dx over x > τ; with v = 1 − s it is 2 h^p v^(p+2)/(p+2)! of a falling
        one, and 2 h^p [v^(p+1)/(p+1)! − v^(p+2)/(p+2)!] of a rising one.
        """
        width, order = self.right - self.left, self.alpha.shape[1]
        powers = width[:, None] ** np.arange(order - 1, -1, -1)
        falling, rising = FALLING[-order:], RISING[-order:]
        shapes = falling + self.rising[:, None, None] * (rising - falling)
        return np.asarray(np.einsum("nk,nkj->nj", self.alpha * powers, shapes))


def _shifted_power(n: int) -> Array:
    """2 (1 − s)^n / n!: (DEGREE + 1,)."""
    result = np.zeros(DEGREE + 1)
    result[: n + 1] = [2.0 * comb(n, j) * (-1.0) ** j / factorial(n) for j in range(n + 1)]
    return result


FALLING = np.stack([_shifted_power(p + 2) for p in (2, 1, 0)])  # for k = m − 1 − p
RISING = np.stack([_shifted_power(p + 1) for p in (2, 1, 0)]) - FALLING


def distribute_to_intervals(x: Array, mass: Array) -> tuple[Array, Array]:
    """Point multipliers (r,) shared out to the intervals between, by their widths.

    Returns masses of falling hats and of rising ones, (r − 1,) each.
    """
    gaps = np.diff(x)
    reach = np.concatenate([gaps, [0.0]]) + np.concatenate([[0.0], gaps])
    return mass[:-1] * gaps / reach[:-1], mass[1:] * gaps / reach[1:]


def fixed_size_rows(model: ConicModel, z: Array) -> Terms:
    """Sizes that leave no choice, equalities with their multipliers; z: (m,) or (q, m)."""
    sizes, unit = model.problem.sizing.bounds, model.scales.size
    # their rows come after those of the junctions
    at = sum(max(junction.highest - junction.lowest + 1, 0) for junction in model.junctions)
    fixed = [(j, low / unit) for j, (low, high) in enumerate(sizes) if low == high]
    return [
        (
            WeightedRows.of_size(np.array([value]), np.eye(len(sizes))[[j]], signed=True),
            z[..., at + k : at + k + 1],
        )
        for k, (j, value) in enumerate(fixed)
    ]


def cone_rows(model: ConicModel, z: Array) -> Terms:
    """Cones of fixed radius, each as its row in the direction of the solver's multipliers (m,)."""
    result, at = Terms(), model.program.equalities + model.program.inequalities
    for cone in model.cone_blocks:
        v = z[at + 1 : at + 1 + len(cone.shift)]
        at += 1 + len(cone.shift)
        if cone.bound_column is None and cone.vibration is None and cone.energy is None:
            rhs = np.array([np.linalg.norm(v) * cone.radius + v @ cone.shift])
            size = -(cone.matrix.T @ v)[model.size]
            result.append((WeightedRows.of_size(rhs, size[None]), np.ones(1)))
    return result


def mean_square_rooms(model: ConicModel, caps: Sequence[MeanSquareCap]) -> Terms:
    """What capped mean squares may come to, times their multipliers: constants."""
    nothing = np.zeros((1, len(model.problem.sizing.bounds)))
    return [
        (WeightedRows.of_size(np.array([cap.multiplier * cap.room]), nothing), np.ones(1))
        for cap in caps
    ]


def energy_tangents(model: ConicModel, solution: ConeSolution, order: int) -> Terms:
    """What the objective is worth at least, as rows with their multipliers; none of other kinds.

    y is the solution's own derivative, linear between points. ``order``: m, of the control.
    """
    if model.energy is None or model.energy.order >= order:
        return []
    terms, k, sizes = [], model.energy.order, len(model.problem.sizing.bounds)
    laws, _ = model.recover(solution.x)
    for position, law in enumerate(laws):
        weight = float(model.energy.weights[position]) / model.energy.unit
        breaks = law.space.breaks
        if law.space.degree - k > 1:
            inner = breaks[:-1, None] + np.diff(breaks)[:, None] * (np.arange(PARTS) / PARTS)
            breaks = np.append(inner.ravel(), 1.0)
        y, width = law.curve().derivatives(breaks, k)[k], np.diff(breaks)
        hats, count = Hats.between(breaks, 2.0 * weight * np.eye(order)[k]), 2 * len(width)
        linear = WeightedRows(
            position, hats.left, hats.weights, np.zeros(count), np.zeros((count, sizes)),
            signed=True, spans=hats.spans, poly=hats.poly,
        )  # fmt: skip
        square = np.sum(width * (y[:-1] ** 2 + y[:-1] * y[1:] + y[1:] ** 2)) / 3.0
        constant = WeightedRows.of_size(np.array([weight * square]), np.zeros((1, sizes)))
        terms.append((linear, 0.5 * np.concatenate([width * y[:-1], width * y[1:]])))
        terms.append((constant, np.ones(1)))
    return terms
