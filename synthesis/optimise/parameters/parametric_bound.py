"""The dual bound as a function of free angles and lifts: multipliers of one program bound a box.

Rows speak of the motion over the cam angle θ, whatever the length β of its segment and its lift h.
So the multipliers of a cone program at some numbers give a valid bound at any others, once it is
said where on the law they act. They keep their distance from one end of the segment, its anchor:

1. The switching function ψ at θ depends on rows and costates beyond θ alone (``dual_bound.bound``).
   With all distances from the end of the segment kept, ψ is the same function of that distance for
   every length β; a longer segment shows more of it, before its old start, where ψ goes on as the
   polynomial of all rows. Rows of a shorter segment's lost part act at its start, where the law is
   known to be at rest, so that they change nothing. With the start for an anchor the same holds
   the other way round: costates of the end take the place of what is lost.
2. So of all terms of the Lagrangian an angle changes −cap ∫ |ψ| alone, by the ends of the integral.
   It is evaluated at points of the range. A chord of a function F lies above it by (Δ²/8) max |F''|
   at most, F'' = cap |ψ|', by which the points are lowered.
3. Levels s_start and lifts enter right-hand sides and end conditions linearly. So over a box the
   Lagrangian is at least a linear function and a lower convex envelope for each law. The largest of
   several programs' is minimised over the box and the equations that tie the numbers (angles sum to
   a turn): a linear program. Any of its multipliers give a bound, coordinate by coordinate.

At the numbers of the program it is the dual bound there, and its slopes are those of the optimum
(envelope theorem). So around the best numbers it falls with the square of the box's width.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from math import factorial, inf, isfinite

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.numerics.separable import POINTS, Separable, least_of_largest
from synthesis.numerics.solvers.clarabel import ConeSolution
from synthesis.optimise.conic.control import Control, law_controls
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound import row_functionals as terms
from synthesis.optimise.dual_bound.arcs import density_terms
from synthesis.optimise.dual_bound.bound import (
    ROUNDING,
    dual_bound,
    level_price,
    minimum_over_sizes,
    unknown_initial_values,
)
from synthesis.optimise.dual_bound.costates import (
    boundary_multipliers,
    nonnegative_multipliers,
    project_costates,
)
from synthesis.optimise.dual_bound.lagrangian import Lagrangian, sums_at_start
from synthesis.optimise.dual_bound.switching import (
    Switching,
    absolute_integrals,
    mean_absolute,
    restrict_polynomials,
)
from synthesis.optimise.parameters.placement import Placement, is_same_question

LEVEL_TRIALS = 6  # levels tried from the target down
RANGES = 2048  # of laws that are remembered, a kilobyte each: of a search, nearly all at hand


@dataclass(frozen=True, eq=False)
class LawShare:
    """What a law's length changes: −cap ∫ |ψ| and its initial velocity's share.

    Attributes:
        control: cap and rate at the numbers of the program.
        breaks: (n + 1,) distances from the anchor, of the program's length, from 0 up to 1.
        poly: (n, d) ψ between. beyond: (m,) ψ at distances 1 + t, in powers of t.
        weighed: (r,) distances of rows on g itself. velocity: (r,) their multipliers times g'(0).
    """

    control: Control
    breaks: Array
    poly: Array
    beyond: Array
    weighed: Array = field(default_factory=lambda: np.zeros(0))
    velocity: Array = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def of(
        cls, lagrangian: Lagrangian, position: int, control: Control, psi: Switching, end: Array
    ) -> LawShare | None:
        """That of one law; None where neither of its ends can move. ``end``: (m,) costates."""
        order, boundary = control.order, lagrangian.model.boundary_states[position]
        x, weights = lagrangian.functionals(position)
        if _is_known(boundary.start, order) and not boundary.start[2:].any():
            # The start moves, and the distance is from the end.
            start = sums_at_start(x, weights)[0]
            turned = np.ones(len(psi.poly)), np.zeros(len(psi.poly))
            poly = restrict_polynomials(psi.poly, *turned)[::-1]
            share = cls(control, 1.0 - psi.breaks[::-1], poly, _powers(start, 1.0))
            if not boundary.start[1]:
                return share
            if not lagrangian.has_densities(position):
                velocity = boundary.start[1] * weights[0, :, 0]
                return replace(share, weighed=1.0 - x, velocity=velocity)
        if _is_known(boundary.end, order) and not boundary.end[1:].any():
            return cls(control, psi.breaks, psi.poly, _powers(end, -1.0))
        return None

    def at(self, low: float, high: float, level: float) -> Array:
        """The points (POINTS,) of the share over a range of lengths, of the program's."""
        area, own = _parts_of(self, low, high)
        value = own - (self.control.cap + self.control.rate * level) * area
        return np.asarray(value - ROUNDING * np.abs(value))

    def parts(self, low: float, high: float) -> tuple[Array, Array]:
        """What those points are for a unit of the cap, negative, and without it: (POINTS,) both."""
        points = np.linspace(low, high, POINTS)
        breaks, poly = self._up_to(high, points)
        width = np.diff(breaks)
        area = np.concatenate([[0.0], np.cumsum(mean_absolute(poly) * width)])
        area, own = area[np.searchsorted(breaks, points)], np.zeros(POINTS)
        if len(self.weighed):
            # a row on g at a distance d sees the initial velocity over (length − d), or not at all
            moved = np.maximum(points[:, None] - self.weighed, 0.0) - np.maximum(
                1.0 - self.weighed, 0.0
            )
            own = moved @ self.velocity
        if high > low:
            step, inside = points[1] - points[0], breaks[1:] > low
            slopes = poly[:, 1:] * np.arange(1, poly.shape[1]) / width[:, None]
            steepest = np.max(np.abs(slopes).sum(axis=1)[inside], initial=0.0)
            bent = np.abs(self.velocity)[(self.weighed > low) & (self.weighed < high)]
            area = area + steepest * step**2 / 8.0
            own = own - 0.25 * step * np.sum(bent)
        return area, own

    def _up_to(self, high: float, points: Array) -> tuple[Array, Array]:
        """ψ from the anchor to a length, cut at points too."""
        degree = self.poly.shape[1]
        breaks = np.unique(np.concatenate([self.breaks, points, [high]]))
        breaks = breaks[breaks <= high]
        left, right = breaks[:-1], breaks[1:]
        inner = left < 1.0
        piece = np.searchsorted(self.breaks[1:-1], 0.5 * (left + right)[inner], "right")
        first, width = self.breaks[piece], np.diff(self.breaks)[piece]
        poly = np.zeros((len(left), degree))
        poly[inner] = restrict_polynomials(
            self.poly[piece], (left[inner] - first) / width, (right[inner] - first) / width
        )
        outer = np.tile(self.beyond, (int(np.sum(~inner)), 1))
        poly[~inner, : len(self.beyond)] = restrict_polynomials(
            outer, left[~inner] - 1.0, right[~inner] - 1.0
        )
        return breaks, poly


# Boxes that share a range of one number, and one box at several levels, ask for the same again.
_parts_of = lru_cache(maxsize=RANGES)(LawShare.parts)


def _is_known(state: Array, order: int) -> bool:
    """Whether all derivatives below the control's are known at an end."""
    return len(state) >= order


def _powers(costates: Array, sign: float) -> Array:
    """Σ_k costates_k (sign t)^(m−1−k)/(m−1−k)! in powers of t."""
    m = len(costates)
    return np.array([sign**n * costates[m - 1 - n] / factorial(n) for n in range(m)])


@dataclass(frozen=True, eq=False)
class ParametricBound:
    """What the multipliers of one program say of other numbers.

    Attributes:
        placement: where segments lie, as functions of the numbers u.
        u: those of the program. solution: its multipliers. lagrangian: at its numbers.
        shares: of every free law.
        constant: what all comes to at u besides laws and sizes. slope: (n,) its derivatives.
    """

    placement: Placement
    u: Array
    solution: ConeSolution
    lagrangian: Lagrangian
    shares: tuple[LawShare, ...]
    constant: float
    slope: Array

    @cached_property
    def price(self) -> float:
        """What the Lagrangian charges for a unit of the objective's level at u."""
        each = (one.control.rate * area for one, area in zip(self.shares, self._areas, strict=True))
        return level_price(self.lagrangian) + sum(each)

    @property
    def _areas(self) -> list[float]:
        """∫ |ψ| of every law at u."""
        return absolute_integrals([Switching(one.breaks, one.poly) for one in self.shares])

    def over(self, low: Array, high: Array, level: float) -> Separable:
        """The Lagrangian over a box, its minimum over laws and sizes taken [core units].

        With a norm it is the bound. Otherwise it is per unit of the level's price, and where it is
        not negative no cam reaches ``level`` [core units].
        """
        place, model = self.placement, self.lagrangian.model
        norm = model.problem.objective.norm(model.problem.machine)
        level /= model.scales.level
        length = place.angles.at(self.u)
        least, most = (each / length for each in place.angles.range_over(low, high))
        total, values = self.constant - float(self.slope @ self.u), dict[int, Array]()
        for position, (share, k) in enumerate(zip(self.shares, place.coordinates, strict=True)):
            if k is None:
                total += float(share.at(1.0, 1.0, level)[0])
            else:
                values[k] = share.at(least[position], most[position], level)
        magnitude = abs(total) + float(self.lagrangian.magnitude[0])
        magnitude += float(np.abs(self.slope) @ np.maximum(np.abs(low), np.abs(high)))
        total -= ROUNDING * magnitude
        # Sizes: an affine function of what the laws come to, that rises.
        zero, one = (minimum_over_sizes(self.solution, self.lagrangian, x) for x in (0.0, 1.0))
        if not isfinite(zero) or (norm is None and self.price <= 0.0):
            return Separable(-inf, self.slope, values)
        if norm is None:
            zero -= level * level_price(self.lagrangian)
            unit = model.scales.level / self.price
            factor = unit
        else:
            unit = model.scales.size
            factor = unit * (one - zero)
        scaled = {k: factor * value for k, value in values.items()}
        return Separable(factor * total + unit * zero, factor * self.slope, scaled)


def bound_over_box(
    bounds: Sequence[ParametricBound], low: Array, high: Array, target: float
) -> tuple[float, Array]:
    """A lower bound for all numbers in a box (n,), (n,) that the equations allow, from several.

    Args:
        bounds: of programs at any numbers. target: above this nothing is gained.

    Returns:
        the bound, and the numbers where it is least: (n,). Both in the program's units.
    """
    first = bounds[0].lagrangian.model
    polytope = bounds[0].placement.polytope
    if first.problem.objective.norm(first.problem.machine) is not None:
        parts = [one.over(low, high, 0.0) for one in bounds]
        return least_of_largest(parts, polytope, low, high)
    # Of a level p: where the excess over p is not negative, none up to p is possible. It falls
    # about as p grows, so that what lacks at one level says where the next is tried.
    level, numbers = target, 0.5 * (low + high)
    for trial in range(LEVEL_TRIALS):
        parts = [one.over(low, high, level) for one in bounds]
        excess, numbers = least_of_largest(parts, polytope, low, high)
        if excess >= 0.0:
            return level, numbers
        level += 2.0**trial * excess
        if level <= 0.0:
            break
    return -inf, numbers


def parametric_bound(
    placement: Placement, u: Array, model: ConicModel, solution: ConeSolution
) -> ParametricBound | None:
    """The bound as a function of the numbers, from the multipliers of a program at u.

    Rows that hold in a region of the program's own numbers only (cuts) are left out, which is
    valid. None where nothing caps the control of the laws, or no end of a law can move; and where
    the program is that of another problem: with a size fixed, or of another objective.
    """
    controls = law_controls(model)
    if not is_same_question(model.problem, placement.problem):
        return None
    if not controls or model.energy is not None or model.epigraph is None:
        return None
    order = controls[0].order
    z = nonnegative_multipliers(model, solution)
    for at, block in model.numbered_blocks:
        if block.origin is None and block.kind != "monotone" and block.source != "bounds":
            z[at : at + len(block.rhs)] = 0.0
    # 1. Rows at the program's own numbers; their right-hand sides move with the levels. Along arcs
    # their multipliers are moved as in the dual bound, which this bound is at these numbers.
    lagrangian, slope = Lagrangian(model, order), np.zeros(len(u))
    row_functionals = list(terms.row_functionals(model, order, z))
    arcs = any(one.may_be_density for one in row_functionals)
    psi = dual_bound(model, solution).switching if arcs else ()
    for one in row_functionals:
        own = z[one.first_row : one.first_row + one.count]
        points, nodes, masses = one.distribute(own)
        nonzero = points != 0.0
        lagrangian.add_rows(one.point_rows(nonzero), points[nonzero])
        for rows, mass in density_terms(one, nodes, masses, psi):
            lagrangian.add_rows(rows, mass)
        origin = one.block.origin
        if origin is not None:
            moved = float(own.sum()) * origin.row.coefficients[0] / origin.scale
            slope += moved * placement.starts.slope[placement.index[origin.segment.index]]
    for rows, mass in (*terms.fixed_size_rows(model, z), *terms.cone_rows(model, z)):
        lagrangian.add_rows(rows, mass)
    # 2. End conditions with their costates; that of g moves with the lift.
    near = boundary_multipliers(model, solution, order, z)
    lagrangian.reduce()
    costates = project_costates(model, lagrangian.initial_costates, near)
    lagrangian.add_boundary_costates(costates)
    lifts = placement.lifts.at(u)
    for position, boundary in enumerate(model.boundary_states):
        moved = costates[0, position, 0] * boundary.end[0] / lifts[position]
        slope -= moved * placement.lifts.slope[position]
    # 3. ψ of every law, as a function of its length where that is free.
    shares = [
        _share(lagrangian, position, control, psi, costates[0, position], placement)
        for position, (control, psi) in enumerate(zip(controls, lagrangian.psi(), strict=True))
    ]
    known = tuple(share for share in shares if share is not None)
    if len(known) < len(shares):
        return None
    constant = float(lagrangian.constant[0])
    # What is left of unknown initial values is next to nothing, and paid for.
    reach = [0.5 * (c.cap + c.rate * abs(float(solution.x[model.epigraph]))) for c in controls]
    grown = [_growth(placement, u, position, order) for position in range(len(controls))]
    lost = unknown_initial_values(lagrangian, [r * g for r, g in zip(reach, grown, strict=True)])
    constant -= max(grown, default=1.0) * float(lost[0])
    return ParametricBound(placement, u, solution, lagrangian, known, constant, slope)


def _share(
    lagrangian: Lagrangian, position: int, control: Control, psi: Switching, end: Array,
    placement: Placement,
) -> LawShare | None:  # fmt: skip
    """The share of one law; None where its angle is free and neither of its ends can move."""
    if placement.coordinates[position] is None:
        return LawShare(control, psi.breaks, psi.poly, np.zeros(control.order))
    return LawShare.of(lagrangian, position, control, psi, end)


def _growth(placement: Placement, u: Array, position: int, order: int) -> float:
    """By how much initial values of a law, in units of the program's, may be larger elsewhere."""
    zero, one = np.zeros(len(u)), np.ones(len(u))
    angle, lift = placement.angles.at(u)[position], abs(placement.lifts.at(u)[position])
    least, most = (each[position] for each in placement.angles.range_over(zero, one))
    small, large = (abs(each[position]) for each in placement.lifts.range_over(zero, one))
    longest, shortest = max(most / angle, 1.0), min(least / angle, 1.0)
    lifted = max(small, large, lift) / min(small, large, lift)
    return float(lifted * (longest / shortest) ** order)
