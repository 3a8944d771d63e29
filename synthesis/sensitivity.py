"""What each limit costs: the change of the optimum with the numbers of the spec.

At an optimum x* of  min f(x) under A x + σ = b, σ in a cone, with multipliers z, data that depend
on a number p change the best value by  dV/dp = z · (dA/dp x* − db/dp)  (envelope theorem; Boyd and
Vandenberghe, Convex Optimization, 5.6.3): what is best need not be sought again. The multipliers
come from the cone program on the finished design's own knots; the matrices' change from stating it
with p a little larger and a little smaller, whatever p is: no formula for any limit is needed.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import ValidationError

from synthesis.design import Design
from synthesis.findings import Sensitivities, Sensitivity
from synthesis.formulations.bound import in_core_units
from synthesis.formulations.convex import EXACT, Plan, formulate
from synthesis.formulations.grid import over
from synthesis.formulations.problem import Problem, pose
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Piecewise
from synthesis.solvers.clarabel import ConeSolution, solve
from synthesis.solvers.statuses import USABLE
from synthesis.spec import DesignSpec

STEP = 1e-5  # relative, for the matrices' change: rounding and curvature both below 1e-9
AGREES = 2e-3  # relative: what the program's value may differ from the design's
FELT = 1e-5  # relative to the value, for a change of a number by all of itself: less is rounding
MANY = 1000.0  # numbers from here on are told for one per cent more instead of one unit
UNIT = re.compile(r"(?P<name>.+)_(?P<unit>mm|deg)(?P<per>_per_s(?P<power>[23])?)?")
KNOWN = "multipliers of the cone program on the design's own knots"


@dataclass(frozen=True, eq=False)
class _Family:
    """The motions among which a design is the best: its own knots, and tables as smoothed."""

    spaces: dict[int, SplineSpace]
    tables: dict[int, Piecewise]

    @staticmethod
    def of(design: Design, spec: DesignSpec) -> _Family:
        """That of a finished design."""
        spaces, tables = dict[int, SplineSpace](), dict[int, Piecewise]()
        for stretch, segment in zip(spec.stretches(), design.motion, strict=True):
            if segment.spline is not None:
                space = SplineSpace(segment.spline.degree, np.array(segment.spline.knots))
                spaces[stretch.index] = space
                if stretch.readings is not None:
                    known = np.array(segment.spline.coefficients)
                    tables[stretch.index] = space.curve(known)
        return _Family(spaces, tables)

    def posed(self, spec: DesignSpec) -> Problem:
        """The first objective of a spec."""
        stretches = [
            stretch.with_law(self.tables[stretch.index])
            if stretch.index in self.tables
            else stretch
            for stretch in spec.stretches()
        ]
        return pose(spec, spec.objectives()[0], (), stretches)

    def stated(self, problem: Problem) -> Plan:
        """Its cone program on these knots."""
        grids = [over(stretch, self.spaces[stretch.index].breaks) for stretch in problem.free]
        return formulate(problem, grids, 0.0, EXACT)


@dataclass(frozen=True, eq=False)
class _Solved:
    """The cone program of a design, solved."""

    spec: DesignSpec
    family: _Family
    plan: Plan
    solution: ConeSolution

    def value(self) -> float:
        """The objective on the wire."""
        return self._worth(self.plan, 0.0)

    def _worth(self, plan: Plan, change: float) -> float:
        """The objective on the wire when the program's value changes by so much."""
        reached = self.plan.program.value(self.solution.x) + change
        problem = plan.problem
        return problem.objective.to_wire(in_core_units(plan, reached), problem.machine)

    def at(self, spec: DesignSpec) -> float | None:
        """The value to first order for another spec; None where its program has another form."""
        plan = self.family.stated(self.family.posed(spec))
        one, other = self.plan.program, plan.program
        if one.matrix.shape != other.matrix.shape or one.cones != other.cones:
            return None
        x, z = self.solution.x, self.solution.multipliers
        moved = (other.matrix - one.matrix) @ x - (other.rhs - one.rhs)
        change = float(z @ moved) + other.value(x) - one.value(x)
        return self._worth(plan, change)


def sensitivities(design: Design) -> Sensitivities:
    """How the first objective changes with every limit and range of a finished design's spec.

    Where something decides that no cone program knows of (a curvature, a pressure angle on an
    arm), nothing is said, and ``evidence`` says so.
    """
    proof, spec = design.certificate, design.numbered.alone()

    def told(found: list[Sensitivity], evidence: str) -> Sensitivities:
        return Sensitivities(
            objective=proof.objective, value=proof.value, sensitivities=found, evidence=evidence
        )

    if not design.motion or not proof.certified or proof.value is None:
        return told([], "there is no certified cam")
    family = _Family.of(design, spec)
    problem = family.posed(spec)
    if problem.objective.fractional or problem.curved:
        return told([], "not known: this objective or follower leads to no single cone program")
    plan = family.stated(problem)
    solution = solve(plan.program)
    if solution.stopped not in USABLE:
        return told([], f"not known: the solver stopped with {solution.word}")
    solved = _Solved(spec, family, plan, solution)
    if abs(solved.value() - proof.value) > AGREES * abs(proof.value):
        return told([], "not known: limits that are not convex, such as a curvature, decide too")
    found = [each for path in _numbers(spec) if (each := _one(solved, path, proof.objective))]
    weight = {each.field: abs(each.per_unit) * max(abs(each.asked), 1.0) for each in found}
    return told(sorted(found, key=lambda each: -weight[each.field]), KNOWN)


def _numbers(spec: DesignSpec) -> Iterator[tuple[str | int, ...]]:
    """Where the spec has numbers that limit the cam."""
    document = spec.model_dump(mode="json", exclude_none=True)
    roots: list[tuple[str, ...]] = [("limits",), ("base_radius_mm",)]
    roots += [("follower", name) for name in spec.follower.adjustable()]
    for root in roots:
        at: Any = document
        for key in root:
            at = at.get(key) if isinstance(at, dict) else None
        yield from _leaves(at, root)


def _leaves(at: Any, path: tuple[str | int, ...]) -> Iterator[tuple[str | int, ...]]:
    if isinstance(at, dict):
        for key, inner in at.items():
            yield from _leaves(inner, (*path, key))
    elif isinstance(at, list):
        for index, inner in enumerate(at):
            yield from _leaves(inner, (*path, index))
    elif isinstance(at, float):
        yield path


def _one(solved: _Solved, path: tuple[str | int, ...], objective: str) -> Sensitivity | None:
    """One number moved up and down; None where the spec or the program does not bear that."""
    document = solved.spec.model_dump(mode="json")
    holder: Any = document
    for key in path[:-1]:
        holder = holder[key]
    asked = float(holder[path[-1]])
    step = STEP * max(abs(asked), 1e-3 * solved.spec.stroke())
    values = []
    for moved in (asked + step, asked - step):
        changed = copy.deepcopy(document)
        holder = changed
        for key in path[:-1]:
            holder = holder[key]
        holder[path[-1]] = moved
        try:
            values.append(solved.at(DesignSpec.model_validate(changed)))
        except ValidationError:
            return None
    above, below = values
    if above is None or below is None:
        return None
    slope = (above - below) / (2.0 * step)
    if abs(slope) * max(abs(asked), 1.0) <= FELT * abs(solved.value()):
        slope = 0.0
    words = _words(path, asked, slope, objective)
    return Sensitivity(field=_pointer(path), asked=asked, per_unit=slope, words=words)


def _words(path: Sequence[str | int], asked: float, slope: float, objective: str) -> str:
    """As a person would say it: 1 deg more in rise_deg makes base_radius 0.8 mm smaller."""
    pointer, (_, unit) = _pointer(path), _with_unit(next(filter(_has_unit, reversed(path)), ""))
    if slope == 0.0:
        return f"{pointer} does not decide"
    name, of = _with_unit(objective)
    amount, change = (f"1 {unit}", slope) if abs(asked) < MANY else ("1 %", 0.01 * slope * asked)
    way = "larger" if change > 0.0 else "smaller"
    return f"{amount} more in {pointer} makes {name} {abs(change):.4g} {of} {way}"


def _pointer(path: Sequence[str | int]) -> str:
    return "".join(f"/{part}" for part in path)


def _has_unit(part: str | int) -> bool:
    return isinstance(part, str) and bool(_with_unit(part)[1])


def _with_unit(field: str | int) -> tuple[str, str]:
    """A field's name without its unit, and the unit: max, mm/s³ of max_mm_per_s3."""
    found = UNIT.fullmatch(str(field))
    if found is None:
        return str(field), ""
    power = {"2": "²", "3": "³"}.get(found["power"] or "", "")
    return found["name"], found["unit"] + (f"/s{power}" if found["per"] else "")
