"""How far the search for one problem has come: the best cam, the best bound, what it cost."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from math import inf, isfinite

from synthesis import clock
from synthesis.formulations.bounds.bound import Bound
from synthesis.formulations.cams.candidate import Candidate, grow
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.cone.cuts import Region
from synthesis.formulations.question.grid import Grid
from synthesis.formulations.question.problem import Problem
from synthesis.formulations.rounds.neighbour import Neighbour
from synthesis.solvers.clarabel import ConeSolution

FIRST = 1e-7  # by what limits are drawn in where the certificate has refused no cam yet


@dataclass(frozen=True)
class Stage:
    """What one stage modelled and what it cost."""

    stage: str
    model: str
    solver: str
    unknowns: int
    rows: int
    iterations: int
    seconds: float
    status: str
    note: str = ""


@dataclass(eq=False)
class Search:
    """The state of a search.

    Attributes:
        tolerance: relative gap asked for, of the objective in the wire's unit.
        deadline: ``time.monotonic()`` at which to stop.
        tighten: relative amount by which rows are drawn in against the solver's tolerance.
        margin: the same for rows written at points, against what they miss in between.
        best: best cam so far. relaxed: best cam of the convex relaxation.
        lower, over: best lower bound and the family that it covers.
        infeasible: the cone program has no point. impossible: why no motion law at all would do.
        undecided: what is known where neither a law was found nor none is proven to be there.
        grids: the present knots and points of every free law.
        region: where curved limits are written; tangent: whether they are met there.
        improved: whether a local optimum was sought on the way.
        wide: whether the bound covers every law, not the splines on the present knots alone.
        last: the last cam read from a cone program, whatever it is worth.
        near: where a neighbouring question's local search ended, to begin this one's there.
        left_behind: the same of this question. from_near: whether ``near`` was of use.
        taken_in: kinds of limits that are not convex and that the bound knows of all the same.
        program: the last cone program that had a point, that point and its bound.
    """

    problem: Problem
    tolerance: float
    deadline: float
    tighten: float
    margin: float = 0.0
    best: Candidate | None = None
    relaxed: Candidate | None = None
    lower: float = -inf
    over: str = ""
    infeasible: bool = False
    impossible: str = ""
    undecided: str = ""
    stages: list[Stage] = field(default_factory=list)
    grids: tuple[Grid, ...] = ()
    region: Region | None = None
    tangent: bool = True
    improved: bool = False
    wide: bool = True
    last: Candidate | None = None
    near: Neighbour | None = None
    left_behind: Neighbour | None = None
    from_near: bool = False
    taken_in: Collection[str] = ()
    program: tuple[Plan, ConeSolution, Bound] | None = None

    def left(self) -> float:
        """Seconds left."""
        return self.deadline - clock.now()

    def offer(self, found: Candidate) -> None:
        """Look at a cam of the relaxation, and at what it becomes under the other limits."""
        if self.relaxed is None or found.value < self.relaxed.value:
            self.relaxed = found
        self.finish(found)

    def accept(self, found: Candidate) -> None:
        """A cam under all limits; with curved ones the relaxation's may be no better than it."""
        if self.problem.curved:
            self.offer(found)
        else:
            self.finish(found)

    def finish(self, found: Candidate) -> None:
        """Grow a cam until every limit holds, and keep it if it is the best so far."""
        finished = grow(found, closely=self.tighten > FIRST)
        if finished is not None and (self.best is None or finished.value < self.best.value):
            self.best = finished

    def learn(self, lower: Bound) -> None:
        """Keep a bound over all laws if it is the best so far, a family's if it is the present."""
        value = self._with_least(lower.value)
        if value > self.lower or not lower.switching:
            self.lower, self.over = value, lower.over
            self.wide = bool(lower.switching) or not self.grids
            if self.problem.rigid:
                self.over += "; limits of the face on free laws left out: the cam a local optimum"

    def raise_to(self, lower: float, over: str) -> None:
        """Take a bound that was found elsewhere, if it is better."""
        value = self._with_least(lower)
        if value > self.lower:
            self.lower, self.over = value, over

    def _with_least(self, lower: float) -> float:
        """The least prime radius bounds a norm too."""
        norm = self.problem.objective.norm(self.problem.machine)
        return lower if norm is None else max(lower, self.problem.sizing.least)

    def round_off(self) -> Search:
        """Itself, its bound no less than a circle that is a part of the cam."""
        problem = self.problem
        if problem.circle and problem.objective.norm(problem.machine) is not None:
            circle = problem.objective.from_wire(problem.circle, problem.machine)
            self.raise_to(circle, "every motion law: a dwell below is a part of the base circle")
        return self

    @property
    def limited_by_shape(self) -> bool:
        """Whether limits that are not convex cost more than the tolerance."""
        if self.relaxed is None:
            return False
        if self.best is None:
            return True
        return self.best.value > self.relaxed.value and not self.close(self.best)

    @property
    def short(self) -> bool:
        """Whether curved limits leave more to gain than the tolerance."""
        return self.problem.curved and not self.close(self.best)

    def gap_of(self, found: Candidate | None) -> float:
        """Relative gap of a cam to the bound in the wire's unit, infinite while unknown."""
        return inf if found is None else self._gap(found, self.lower)

    def _gap(self, found: Candidate, lower: float) -> float:
        if not isfinite(lower):
            return inf
        to_wire, machine = self.problem.objective.to_wire, self.problem.machine
        value = to_wire(found.value, machine)
        return (value - to_wire(lower, machine)) / max(abs(value), 1e-300)

    @property
    def gap(self) -> float:
        """That of the relaxation's best cam."""
        return self.gap_of(self.relaxed)

    def keepable(self, tolerance: float) -> float:
        """How large the value may become [core units] and still be within a tolerance."""
        assert self.best is not None
        objective, machine = self.problem.objective, self.problem.machine
        value = objective.to_wire(self.best.value, machine)
        lower = objective.to_wire(self.lower, machine) if isfinite(self.lower) else 0.0
        allowed = lower / (1.0 - 0.98 * min(tolerance, 0.9))
        return objective.from_wire(max(value * (1.0 + 0.1 * tolerance), allowed), machine)

    def close(self, found: Candidate | None) -> bool:
        """Whether a cam is within the tolerance of the bound."""
        return found is not None and self.close_to(found, self.lower)

    def enough(self, lower: float) -> bool:
        """Whether the relaxation's best cam would be within the tolerance of such a bound."""
        return self.relaxed is not None and self.close_to(self.relaxed, self._with_least(lower))

    def close_to(self, found: Candidate, lower: float) -> bool:
        """Whether a cam is within the tolerance of some bound."""
        return self._gap(found, lower) <= 0.99 * self.tolerance
