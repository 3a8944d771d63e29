"""The optimal value of specs near that of a design: estimated by multipliers, and solved again."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.bound import in_core_units
from synthesis.optimise.heuristics.perturbed_optimum import (
    ConvexOptimum,
    NonlinearOptimum,
    PerturbedOptimum,
)
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import objective_value
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.sensitivity.fixed_knots import FixedKnots

LEVEL_STEP = 1e-3  # relative: finite step of the excess by the trial level
SECANTS = 4  # steps to the level without excess; each gains several digits
LEVEL_ACCURACY = 1e-9  # relative: of that level
CONVEX_METHOD = "multipliers of the cone program"
LOCAL_METHOD = "multipliers of IPOPT's local optimum"


class PerturbedDesign(ABC):
    """A finished design as the optimum of its problem.

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
    def estimate(self, spec: DesignSpec) -> float | None:
        """The optimal value of a near spec to first order, by multipliers.

        None where the spec's program has another form.
        """

    @abstractmethod
    def remains_optimal(self, spec: DesignSpec) -> bool:
        """Whether the optimum is known to keep every limit of another spec, at the same value."""

    @abstractmethod
    def solve(self, spec: DesignSpec, deadline: float) -> float | None:
        """The optimal value of a near spec by solving; None where nothing fits."""


@dataclass(frozen=True, eq=False)
class _DirectObjective(PerturbedDesign):
    """An objective that one program minimises."""

    method: str
    knots: FixedKnots
    optimum: PerturbedOptimum
    plan: ConicModel

    @property
    def noise(self) -> float:  # type: ignore[override]
        return self.optimum.noise

    @property
    def value(self) -> float:
        return _on_wire(self.plan, self.optimum.value)

    def estimate(self, spec: DesignSpec) -> float | None:
        plan, _ = self.knots.program(self.knots.formulate(spec))
        value = self.optimum.moved(plan)
        return None if value is None else _on_wire(plan, value)

    def remains_optimal(self, spec: DesignSpec) -> bool:
        return self.optimum.stays(self.knots.program(self.knots.formulate(spec))[0])

    def solve(self, spec: DesignSpec, deadline: float) -> float | None:
        plan, _ = self.knots.program(self.knots.formulate(spec))
        optimum = self.optimum.again(plan, deadline)
        return None if optimum is None else _on_wire(plan, optimum.value)


@dataclass(frozen=True, eq=False)
class _FractionalObjective(PerturbedDesign):
    """A fractional objective: programs minimise the excess over a trial level.

    The optimal value is the level without excess.

    Attributes:
        level: that level [core units]. fall: decrease of the excess per unit of the level.
    """

    method: str
    knots: FixedKnots
    optimum: PerturbedOptimum
    problem: Problem
    level: float
    fall: float

    @property
    def noise(self) -> float:  # type: ignore[override]
        return self.optimum.noise

    @property
    def value(self) -> float:
        return self.problem.objective.to_wire(self.level, self.problem.machine)

    def estimate(self, spec: DesignSpec) -> float | None:
        problem = self.knots.formulate(spec)
        excess = self.optimum.moved(self.knots.program(problem, self.level)[0])
        if excess is None:
            return None
        # Implicit differentiation: the level rises by what the excess gains, over its fall.
        level = self.level + (excess - self.optimum.value) / self.fall
        return problem.objective.to_wire(level, problem.machine)

    def remains_optimal(self, spec: DesignSpec) -> bool:
        return self.optimum.stays(self.knots.program(self.knots.formulate(spec), self.level)[0])

    def solve(self, spec: DesignSpec, deadline: float) -> float | None:
        problem = self.knots.formulate(spec)
        level = _find_level(self.knots, problem, self.optimum, (self.level, self.fall), deadline)
        return None if level is None else problem.objective.to_wire(level, problem.machine)


def perturbed_designs(
    knots: FixedKnots, spec: DesignSpec, deadline: float = inf
) -> Iterator[PerturbedDesign]:
    """The design as an optimum: of the cone program where it is one, then of the nonlinear one.

    Args:
        knots: the design's laws and size. spec: its question.
        deadline: ``time.monotonic()`` at which to stop.
    """
    problem = knots.formulate(spec)
    make = _fractional_objective if problem.objective.quasiconvex else _direct_objective
    for method, convex in ((CONVEX_METHOD, True), (LOCAL_METHOD, False)):
        if convex and problem.has_curved_limits:
            continue
        design = make(knots, problem, method, deadline, convex=convex)
        if design is not None:
            yield design


def _direct_objective(
    knots: FixedKnots, problem: Problem, method: str, deadline: float, *, convex: bool
) -> PerturbedDesign | None:
    plan, _ = knots.program(problem)
    optimum = _optimum(knots, plan, 0, deadline, convex=convex)
    return None if optimum is None else _DirectObjective(method, knots, optimum, plan)


def _optimum(
    knots: FixedKnots, plan: ConicModel, relaxed: int, deadline: float, *, convex: bool
) -> PerturbedOptimum | None:
    if convex:
        return None if plan.problem.has_curved_limits else ConvexOptimum.sought(plan, deadline)
    return NonlinearOptimum.sought(plan, knots.start(plan), relaxed, deadline)


def _fractional_objective(
    knots: FixedKnots, problem: Problem, method: str, deadline: float, *, convex: bool
) -> PerturbedDesign | None:
    # The excess at the design's own level and a little above gives its fall.
    segments = [s.with_law(knots.laws[s.index].curve()) for s in problem.free]
    level = objective_value(problem.with_laws(segments), knots.size)
    optima: list[PerturbedOptimum] = []
    for trial in (level, level * (1.0 + LEVEL_STEP)):
        plan, relaxed = knots.program(problem, trial)
        optimum = (
            optima[0].again(plan, deadline)
            if optima
            else _optimum(knots, plan, relaxed, deadline, convex=convex)
        )
        if optimum is None:
            return None
        optima.append(optimum)
    fall = (optima[0].value - optima[1].value) / (LEVEL_STEP * level)
    if fall <= 0.0:
        return None
    best = _find_level(knots, problem, optima[0], (level, fall), deadline)
    if best is None:
        return None
    optimum = optima[0].again(knots.program(problem, best)[0], deadline)
    if optimum is None:
        return None
    return _FractionalObjective(method, knots, optimum, problem, best, fall)


def _find_level(
    knots: FixedKnots,
    problem: Problem,
    near: PerturbedOptimum,
    guess: tuple[float, float],
    deadline: float,
) -> float | None:
    """The level without excess, by steps with a fixed fall from a guess (level, fall)."""
    level, fall = guess
    for _ in range(SECANTS):
        optimum = near.again(knots.program(problem, level)[0], deadline)
        if optimum is None:
            return None
        step = optimum.value / fall
        level += step
        if abs(step) <= LEVEL_ACCURACY * level:
            break
    return level


def _on_wire(plan: ConicModel, value: float) -> float:
    """A program's objective on the wire."""
    problem = plan.problem
    return problem.objective.to_wire(in_core_units(plan, value), problem.machine)
