"""The best value under a spec beside that of a finished design: to first order, and sought."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

from synthesis.formulations.bounds.bound import in_core_units
from synthesis.formulations.cams.candidate import value
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.nonconvex.nearby import Convex, Nearby, Smooth
from synthesis.formulations.question.problem import Problem
from synthesis.sensitivity.family import Family
from synthesis.spec import DesignSpec

LEVEL_STEP = 1e-3  # relative, for how the excess over a trial level falls as that rises
CHORDS = 4
STAYS = 1e-9  # of the level
EXACTLY = "multipliers of the cone program"
LOCALLY = "multipliers of IPOPT's local optimum"


class Beside(ABC):
    """A finished design as the optimum of its question.

    Attributes:
        method: how its multipliers are known. noise: relative error of values.
    """

    method: str
    noise: float

    @property
    @abstractmethod
    def value(self) -> float:
        """The objective on the wire."""

    @abstractmethod
    def to_first_order(self, spec: DesignSpec) -> float | None:
        """What is best for a spec beside the design's, by multipliers; None: another form."""

    @abstractmethod
    def stays(self, spec: DesignSpec) -> bool:
        """Whether the optimum is known to keep every limit of another spec, with its value."""

    @abstractmethod
    def sought(self, spec: DesignSpec, deadline: float) -> float | None:
        """The same by solving; None where nothing fits."""


@dataclass(frozen=True, eq=False)
class _Direct(Beside):
    """Of an objective that one program makes small."""

    method: str
    family: Family
    optimum: Nearby
    plan: Plan

    @property
    def noise(self) -> float:  # type: ignore[override]
        return self.optimum.noise

    @property
    def value(self) -> float:
        return _worth(self.plan, self.optimum.value)

    def to_first_order(self, spec: DesignSpec) -> float | None:
        plan, _ = self.family.stated(self.family.posed(spec))
        value = self.optimum.moved(plan)
        return None if value is None else _worth(plan, value)

    def stays(self, spec: DesignSpec) -> bool:
        return self.optimum.stays(self.family.stated(self.family.posed(spec))[0])

    def sought(self, spec: DesignSpec, deadline: float) -> float | None:
        plan, _ = self.family.stated(self.family.posed(spec))
        found = self.optimum.again(plan, deadline)
        return None if found is None else _worth(plan, found.value)


@dataclass(frozen=True, eq=False)
class _Levelled(Beside):
    """Of an objective that programs tell a trial level's excess of; the best leaves none.

    Attributes:
        level: at which there is none [core units]. fall: of the excess, per unit of the level.
    """

    method: str
    family: Family
    optimum: Nearby
    problem: Problem
    level: float
    fall: float

    @property
    def noise(self) -> float:  # type: ignore[override]
        return self.optimum.noise

    @property
    def value(self) -> float:
        return self.problem.objective.to_wire(self.level, self.problem.machine)

    def to_first_order(self, spec: DesignSpec) -> float | None:
        problem = self.family.posed(spec)
        excess = self.optimum.moved(self.family.stated(problem, self.level)[0])
        if excess is None:
            return None
        level = self.level + (excess - self.optimum.value) / self.fall
        return problem.objective.to_wire(level, problem.machine)

    def stays(self, spec: DesignSpec) -> bool:
        return self.optimum.stays(self.family.stated(self.family.posed(spec), self.level)[0])

    def sought(self, spec: DesignSpec, deadline: float) -> float | None:
        problem = self.family.posed(spec)
        level = _settled(self.family, problem, self.optimum, (self.level, self.fall), deadline)
        return None if level is None else problem.objective.to_wire(level, problem.machine)


def besides(family: Family, spec: DesignSpec, deadline: float = inf) -> Iterator[Beside]:
    """The design as an optimum, of the simplest program that can tell first.

    Args:
        family: the design's motions and size. spec: its question.
        deadline: ``time.monotonic()`` at which to stop.
    """
    problem = family.posed(spec)
    make = _levelled if problem.objective.fractional else _direct
    for method, convex in ((EXACTLY, True), (LOCALLY, False)):
        if convex and problem.curved:
            continue
        found = make(family, problem, method, deadline, convex=convex)
        if found is not None:
            yield found


def _direct(
    family: Family, problem: Problem, method: str, deadline: float, *, convex: bool
) -> Beside | None:
    plan, _ = family.stated(problem)
    optimum = _optimum(family, plan, 0, deadline, convex=convex)
    return None if optimum is None else _Direct(method, family, optimum, plan)


def _optimum(
    family: Family, plan: Plan, eased: int, deadline: float, *, convex: bool
) -> Nearby | None:
    if convex:
        return None if plan.problem.curved else Convex.sought(plan, deadline)
    return Smooth.sought(plan, family.start(plan), eased, deadline)


def _levelled(
    family: Family, problem: Problem, method: str, deadline: float, *, convex: bool
) -> Beside | None:
    stretches = [s.with_law(family.laws[s.index].curve()) for s in problem.free]
    level = value(problem.settled(stretches), family.size)
    found: list[Nearby] = []
    for trial in (level, level * (1.0 + LEVEL_STEP)):
        plan, eased = family.stated(problem, trial)
        optimum = (
            found[0].again(plan, deadline)
            if found
            else _optimum(family, plan, eased, deadline, convex=convex)
        )
        if optimum is None:
            return None
        found.append(optimum)
    fall = (found[0].value - found[1].value) / (LEVEL_STEP * level)
    if fall <= 0.0:
        return None
    settled = _settled(family, problem, found[0], (level, fall), deadline)
    if settled is None:
        return None
    optimum = found[0].again(family.stated(problem, settled)[0], deadline)
    if optimum is None:
        return None
    return _Levelled(method, family, optimum, problem, settled, fall)


def _settled(
    family: Family,
    problem: Problem,
    near: Nearby,
    guess: tuple[float, float],
    deadline: float,
) -> float | None:
    """The level of no excess, by chords from a guess and the fall there."""
    level, fall = guess
    for _ in range(CHORDS):
        found = near.again(family.stated(problem, level)[0], deadline)
        if found is None:
            return None
        step = found.value / fall
        level += step
        if abs(step) <= STAYS * level:
            break
    return level


def _worth(plan: Plan, value: float) -> float:
    """A program's objective on the wire."""
    problem = plan.problem
    return problem.objective.to_wire(in_core_units(plan, value), problem.machine)
