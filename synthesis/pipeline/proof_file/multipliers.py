"""The multipliers of a cone program as a proof file states them, for the checker's own rows.

A row of the program and the checker's row of the same limit differ by a factor. What a multiplier
does to g^(k) on a free law, or to the size, is the same in both: so it is changed by what the two
rows have there. All multipliers may have one factor in common.

In a proof file cam angles are in degrees and lengths in mm. With c = π/180 the checker's rows read:

    derivatives     ± dᵏs/d(degree)ᵏ ≤ …
    pressure angle  ± (v − c e) − c tan α (s0 + s) ≤ 0
    profile radius  −(a + c² s) − c² Rb ≤ …           under a flat face
    face width      ± v ≤ …
    forward         ∓ h v ≤ 0, h the lift
    contact force   ± (k s + c v + m a) ≤ …  on a slide
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, sqrt, tan
from typing import Any

import numpy as np

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.limits.motion import SegmentBound
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.maxima import maximise
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeSolution
from synthesis.optimise.conic.control import (
    Control,
    law_controls,
    mean_square_caps,
    weighed_controls,
)
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.arcs import density_terms, with_densities_of_control
from synthesis.optimise.dual_bound.bound import add_costates
from synthesis.optimise.dual_bound.costates import (
    best_costates,
    boundary_multipliers,
    nonnegative_multipliers,
)
from synthesis.optimise.dual_bound.lagrangian import Lagrangian
from synthesis.optimise.dual_bound.row_functionals import (
    RowFunctional,
    Terms,
    WeightedRows,
    energy_tangents,
    fixed_size_rows,
    row_functionals,
)
from synthesis.optimise.dual_bound.switching import Switching
from synthesis.optimise.problem.mean_square import Energy
from synthesis.optimise.problem.problem import Problem
from synthesis.spec.design_spec import DesignSpec
from synthesis.units import DEGREE

GIVEN = 3  # order that a file states where no law is free, so that it plays no part
DIGITS = 8  # of a multiplier: what is lost is of the second order, as each row binds where it is
SQUARE_FIGURES = 12  # of the multiplier of a mean square
PLACES = 9  # decimals of a point on a law, likewise
HATS = ("falling", "rising")  # kinds of blocks whose multipliers are masses of hats on spans
SOURCES = {"face_left": "face_width", "face_right": "face_width"}  # a row's, if not its limit's


class _Priced(Energy):
    """A mean square that is held, times its multiplier."""

    @property
    def unit(self) -> float:
        return 1.0


@dataclass(frozen=True)
class Group:
    """Multipliers of one row of a limit on one segment, as in the file."""

    segment: int
    limit: str
    side: int
    points: Array
    densities: Array


def multipliers(
    model: ConicModel, solution: ConeSolution, spec: DesignSpec, length: float
) -> list[dict[str, Any]]:
    """The multipliers of a program, the best first; none where nothing caps every law.

    Args:
        model, solution: the program in problem units, and any multipliers of it.
        spec: the question [wire]. length: the problem's unit of length [mm].
    """
    z = nonnegative_multipliers(model, solution)
    controls, model = _controls(model, z)
    at_points = model, z
    if model.problem.free and not controls:  # where a limit on s'' and the size caps s'' as well
        model, z = with_densities_of_control(model, z) or at_points
        controls = law_controls(model) or []
        if not controls:
            return []
    order = controls[0].order if controls else GIVEN
    squares, tangents = _squares(model, solution, controls, length)
    rows, found = list(row_functionals(model, order, z)), list[dict[str, Any]]()
    psi: tuple[Switching, ...] = ()
    # as they are; then, where a limit binds along an arc, those for which ψ is small there
    for _ in range(1 + any(one.may_be_density for one in rows)):
        groups, lagrangian = list[Group](tangents), Lagrangian(model, order)
        for each, mass in energy_tangents(model, solution, order):
            lagrangian.add_rows(each, mass)
        for one in rows:
            own = z[one.first_row : one.first_row + one.count]
            points, nodes, masses = one.distribute(own)
            nonzero = points != 0.0
            densities = density_terms(one, nodes, masses, psi)
            for each, mass in ((one.point_rows(nonzero), points[nonzero]), *densities):
                lagrangian.add_rows(each, mass)
            groups += _groups(one, points, densities, model, spec, length)
        for each, mass in fixed_size_rows(model, z):
            lagrangian.add_rows(each, mass)
        costates = _costates(lagrangian, controls, solution, *at_points)
        psi = lagrangian.psi()
        ends = {s.index: nu for s, nu in zip(model.problem.free, costates[0], strict=True)}
        found.insert(0, _as_stated(order, groups, ends, squares))
    return found


def _controls(model: ConicModel, z: Array) -> tuple[list[Control], ConicModel]:
    """The controls of every free law, empty where some law has none, and the model to go on with.

    A mean square that is held beside a limit on the control adds to its weight; one of a lower
    order is worth its tangents, as that of an objective is, and stands in that one's place.
    """
    held = mean_square_caps(model, z)
    plain = tuple(cone for cone in model.cone_blocks if cone.energy is None)
    controls = law_controls(replace(model, cone_blocks=plain))
    if not controls or len(held) != 1 or model.energy is not None:
        return controls or weighed_controls(model, held) or [], model
    (square,), energies = held, [c.energy for c in model.cone_blocks if c.energy is not None]
    weights = square.multiplier * square.weights
    if square.order == controls[0].order:
        return [
            replace(one, weight=one.weight + float(own))
            for one, own in zip(controls, weights, strict=True)
        ], model
    if square.order < controls[0].order and square.multiplier > 0.0:
        own, root = energies[0], sqrt(square.multiplier)
        factors = tuple(root * factor for factor in own.factors)
        return controls, replace(model, energy=_Priced(own.order, factors, 0.0, weights, own.least))
    return controls, model


def _costates(
    lagrangian: Lagrangian,
    controls: Sequence[Control],
    solution: ConeSolution,
    model: ConicModel,
    z: Array,
) -> Array:
    """Add the end conditions, with the best multipliers of these: (1, laws, m)."""
    near = boundary_multipliers(model, solution, lagrangian.order, z)
    if not all(c.weight and isfinite(c.cap) for c in controls) or not controls:
        return add_costates(lagrangian, controls, near)
    # where caps are reached everywhere the bound's slope says little: from those without caps on
    lagrangian.reduce()
    given, psi = lagrangian.initial_costates, lagrangian.psi()
    free = [replace(control, cap=inf) for control in controls]
    near = best_costates(model, free, psi, given)
    found = best_costates(model, controls, psi, given, near)
    lagrangian.add_boundary_costates(found)
    return found


def _squares(
    model: ConicModel, solution: ConeSolution, controls: Sequence[Control], length: float
) -> tuple[dict[str, float], list[Group]]:
    """The multipliers of mean squares, by name, and tangents of one of a lower order than ψ's.

    A weight of ∫ (g^(k))² dx is multiplier · h²/d^(2k−1) where ∫ (s^(k))² per degree is multiplied.
    """
    held = model.problem.objective_caps
    names = {each.objective.energy_order(): f"held/{k}" for k, each in enumerate(held)}
    energy, order = model.energy, controls[0].order if controls else GIVEN
    weights, k = np.array([control.weight for control in controls]), order
    if energy is not None:
        k = energy.order
        if model.problem.objective.energy_order() == k:
            names[k] = "objective"
        weights = energy.weights / energy.unit
    if not model.problem.free:  # of given laws alone any multiplier will do
        return {"objective": 1.0} if energy is not None else {}, []
    if k not in names or not weights.any():
        return {}, []
    moves = [(s.lift * length, s.angle / DEGREE) for s in model.problem.free]
    (lift, degrees), *_ = moves
    squares = {names[k]: float(weights[0]) * degrees ** (2 * k - 1) / lift**2}
    tangents = []
    for rows, mass in energy_tangents(model, solution, order):
        if rows.position is not None:
            lift, degrees = moves[rows.position]
            factor = 2.0 * float(weights[rows.position]) * degrees**k / lift
            table = _linear(rows, mass)
            table[:, 2:] *= factor
            index = model.problem.free[rows.position].index
            tangents.append(Group(index, names[k], 1, np.zeros((0, 2)), table))
    return squares, tangents


def broken_by_given_law(problem: Problem, spec: DesignSpec) -> Iterator[dict[str, Any]]:
    """A limit on the motion alone that a given law breaks, at the angle where it is worst."""
    given = [segment for segment in problem.segments if segment not in problem.free]
    for segment in given:
        for row in problem.limit_rows(segment):
            if any(row.size) or row.interval is not None:
                continue
            worst, place = maximise(segment.placed(), row.coefficients)
            name, _ = _limit_of(row, spec, problem)
            if worst > row.upper and name:
                side = -1 if row.coefficients[max(row.orders)] < 0.0 else 1
                table = np.array([[_share_at(segment, place), 1.0]])
                group = Group(segment.index, name, side, table, np.zeros((0, 4)))
                yield _as_stated(GIVEN, [group], {}, {})


def peak_of_given_laws(problem: Problem, order: int) -> tuple[dict[str, Any], float] | None:
    """Where a derivative of the given laws is largest, as a row of the objective, and its peak.

    The row alone is broken by every smaller peak, whatever the other laws and the size.
    """
    found = [
        (*maximise(segment.placed(), coefficients), side, segment)
        for segment in problem.segments
        if segment not in problem.free
        for side in (1, -1)
        for coefficients in [tuple(side * float(k == order) for k in range(4))]
    ]
    worst, place, side, segment = max(found, key=lambda each: each[0], default=(0.0, 0.0, 1, None))
    if segment is None or worst <= 0.0:
        return None
    table = np.array([[_share_at(segment, place), 1.0]])
    group = Group(segment.index, "objective", side, table, np.zeros((0, 4)))
    return _as_stated(order, [group], {}, {}), worst


def _share_at(segment: PlacedSegment, place: float) -> float:
    """Where on a segment a cam angle lies, from 0 to 1."""
    return min(max((place - segment.start) / segment.angle, 0.0), 1.0)


def _limit_of(row: LinearInequality, spec: DesignSpec, problem: Problem) -> tuple[str, str]:
    """The name in a proof file of the limit of a row, and its kind; "" where it has none."""
    source = SOURCES.get(row.source, row.source)
    asked = enumerate(spec.limits)  # of contact forces those that ask for this end
    own = ((k, each) for k, each in asked if getattr(each, f"{source[-3:]}_n", 0) is not None)
    names = {f"limits/{k}": str(limit.kind) for k, limit in own}
    for limit in problem.limits:  # windows and points have names of their own
        if isinstance(limit, SegmentBound) and limit.name == row.source:
            return f"program/{limit.segment}/{limit.place}/{limit.order}", str(limit.kind)
    names["no_undercut"] = "profile_radius"  # what every cam keeps, if no limit asks for more
    if source.startswith("peak_"):  # what is minimised counts as a limit, and what is held
        held = enumerate(problem.objective_caps)
        names = {f"held/{k}": source for k, each in held if each.objective.kind == source}
        names = names or {"objective": source}
        source, names = source[5:], {name: kind[5:] for name, kind in names.items()}
    return next((each for each in names.items() if source.startswith(each[1])), ("", ""))


def _groups(
    one: RowFunctional,
    points: Array,
    densities: Terms,
    model: ConicModel,
    spec: DesignSpec,
    length: float,
) -> Iterator[Group]:
    """What a block of rows comes to; nothing of a size's own range, which the checker knows."""
    block, nonzero = one.block, points != 0.0
    rows, x = one.point_rows(nonzero), one.block.x[nonzero]
    if block.kind == "monotone":
        assert block.segment is not None
        segment = model.problem.free[block.segment]
        lift = segment.lift * length
        factor = segment.angle / DEGREE / lift**2
        table = np.stack([rows.x, -rows.weights[:, 1] * points[nonzero] * factor], axis=1)
        yield Group(segment.index, "forward", 1, table, np.zeros((0, 4)))
        return
    if block.origin is None:
        return
    found = _row(block, model, spec, length)
    if found is None:
        return
    limit, side, factor = found
    if block.segment is None:  # of a given motion, the place where the row is nearest
        segment, row = block.origin.segment, block.origin.row
        _, place = maximise(segment.placed(), row.coefficients)
        x = np.full_like(x, _share_at(segment, place))
    table = np.stack([x, points[nonzero] * factor], axis=1)
    spread = np.concatenate([np.zeros((0, 4)), *(_linear(*each) for each in densities)])
    if block.kind in HATS:  # a density alone, of a derivative that is limited itself
        assert block.spans is not None
        height = 2.0 * points[nonzero] / np.ptp(block.spans[nonzero], axis=1)
        spread, table = np.zeros((len(height), 4)), table[:0]
        spread[:, :2], spread[:, 2 + HATS.index(block.kind)] = block.spans[nonzero], height
    spread[:, 2:] *= factor
    # of equalities multipliers may have either sign: those of each side
    for way in (1, -1) if block.origin.row.equality else (1,):
        own = [np.column_stack([part[:, :n], np.maximum(way * part[:, n:], 0.0)])
               for part, n in ((table, 1), (spread, 2))]  # fmt: skip
        yield Group(block.origin.segment.index, limit, way * side, *own)


def _row(
    block: LinearBlock, model: ConicModel, spec: DesignSpec, length: float
) -> tuple[str, int, float] | None:
    """The limit and side of a block's rows, and the factor on their multipliers."""
    assert block.origin is not None
    segment, row = block.origin.segment, block.origin.row
    (name, kind), machine = _limit_of(row, spec, model.problem), spec.machine()
    if not name:
        return None
    if block.segment is not None:
        if not row.orders:
            return None
        # as large a share of the derivative as the checker's row has, with ±1 but for a force
        order = 1 if kind == "jerk" else max(row.orders)
        factor = abs(block.alpha[order]) * (segment.angle / DEGREE) ** order
        factor /= abs(segment.lift * length)
        if kind == "contact_force" and machine.load is not None:
            factor /= machine.load.coefficients(machine.omega)[order] / DEGREE**order
        side = -1 if row.coefficients[order] < 0.0 and kind != "profile_radius" else 1
        return name, side, float(factor)
    if kind not in ("pressure_angle", "profile_radius") or not len(block.size):
        return None  # the checker has no row of it, or the size is known
    # on a given motion: as large a share of the size, its last variable
    share = abs(float(block.size[-1])) / (model.scales.size * length)
    if kind == "profile_radius":
        return name, 1, share / DEGREE**2
    if not name.startswith("limits/"):
        return None
    allowed = getattr(spec.limits[int(name.removeprefix("limits/"))], f"{segment.kind}_deg")
    return name, 1 if row.size[0] < 0.0 else -1, share / (DEGREE * tan(allowed * DEGREE))


def _linear(rows: WeightedRows, mass: Array) -> Array:
    """Hats on spans as densities that are linear there: (n, 4), ends and values at the ends."""
    assert rows.spans is not None
    assert rows.poly is not None
    found = dict[tuple[float, float], list[float]]()
    # ψ gets 1 − 2 s + s² of a falling hat and 1 − s² of a rising one, and little beside that
    rising = np.abs(rows.poly[:, 1]) < np.abs(rows.poly[:, 0])
    for (left, right), up, each in zip(rows.spans.tolist(), rising, mass, strict=True):
        values = found.setdefault((left, right), [0.0, 0.0])
        values[int(up)] += 2.0 * float(each) / (right - left)
    return np.array([[*span, *values] for span, values in found.items()]).reshape(-1, 4)


def _as_stated(
    order: int, groups: list[Group], costates: dict[int, Array], squares: dict[str, float]
) -> dict[str, Any]:
    """The multipliers by segment, in units of the largest, rounded."""
    tables = [group.points[:, 1] for group in groups] + list(costates.values())
    unit = max((float(np.abs(each).max()) for each in tables if each.size), default=1.0) or 1.0
    parts = []
    for index in sorted({*costates, *(group.segment for group in groups)}):
        rows = [
            {
                "limit": group.limit,
                "side": group.side,
                "multipliers": _rounded(group.points, unit, 1) + _rounded(group.densities, unit, 2),
            }
            for group in groups
            if group.segment == index
        ]
        kept = [row for row in rows if row["multipliers"]]
        ends = _rounded(costates.get(index, np.zeros(0))[None], unit, 0)
        parts.append({"segment": index, "rows": kept, "ends": ends[0] if ends else []})
    found: dict[str, Any] = {"order": order, "segments": parts}
    if squares:
        # of these alone the loss is of the first order where a bound is none of a mean square
        found["squares"] = {
            name: float(f"{value / unit:.{SQUARE_FIGURES}g}") for name, value in squares.items()
        }
    return found


def _rounded(table: Array, unit: float, places: int) -> list[list[float]]:
    """Rows of places, then of multipliers over their unit: those that rounding leaves."""
    rows = []
    for row in table.tolist():
        x = [round(each, PLACES) for each in row[:places]]
        values = [round(each / unit, DIGITS) for each in row[places:]]
        if any(values) and sorted(set(x)) == x:
            rows.append([*x, *values])
    return rows
