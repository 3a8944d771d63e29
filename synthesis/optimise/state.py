"""State of one solve: incumbent, lower bound, mesh, and what each stage cost.

The state is immutable. Every role of the driver takes one and returns its successor, so that a
role that fails, or is tried and given up, leaves nothing behind.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, isfinite

from synthesis.numerics import clock
from synthesis.numerics.solvers.clarabel import ConeSolution
from synthesis.optimise.conic.linear_rows import Tightening
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.conic.tangent_cuts import Region
from synthesis.optimise.dual_bound.bound import Bound
from synthesis.optimise.problem.grid import Grid, SplineLaw, count_intervals
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import CLEARANCE, Candidate, enlarge_until_feasible

DEFAULT_TIGHTENING = 1e-7  # relative, of the rows, as long as the certificate has refused no cam
SINGLE_SHARE = 0.4
"""Of the tolerance, for the gap at chosen angles and lifts: the rest is for all others."""
AIM = 0.985  # share of the tolerance: the gap that is to be proven
AT_END = 4.0 * CLEARANCE
"""Relative: by how much a cam's size may lie above the least that is sought, and count as that."""


@dataclass(frozen=True)
class ProofBudget:
    """What nodes over parts of the domain may take where the quick proof leaves a gap.

    The quick proof is made whatever it takes; at these limits the rest ends with what is proven.

    Attributes:
        programs: solved after the quick proof: the same on every machine.
        share: of the time from the start to the deadline.
        cam_only: whether there are none in a quick proof, either: only a cam is sought.
    """

    programs: float
    share: float
    cam_only: bool = False


QUICK, THOROUGH = ProofBudget(0.0, 0.5), ProofBudget(inf, 1.0)
"""A quick proof leaves time to others also where its own nodes take long (limits on forces)."""
CAM_ONLY = replace(QUICK, cam_only=True)


@dataclass(frozen=True, eq=False)
class WarmStart:
    """A local optimum.

    Attributes:
        grids: knots and collocation points of every free law.
        laws, size: the laws, and the size variables [length].
    """

    grids: tuple[Grid, ...]
    laws: tuple[SplineLaw, ...]
    size: tuple[float, ...]


@dataclass(frozen=True)
class Stage:
    """What one stage modelled, what it cost, and how far the search was after it.

    ``Effort`` of the report has the same fields and their meaning.
    """

    stage: str
    model: str
    solver: str
    unknowns: int
    rows: int
    iterations: int
    seconds: float
    status: str
    note: str = ""
    nodes: int = 0
    gap: float | None = None
    exit: str = ""


@dataclass(frozen=True, eq=False)
class SolveState:
    """How far the solve of one problem has come.

    Attributes:
        tolerance: relative gap at which to stop, of the objective in the wire's unit.
        deadline: ``time.monotonic()`` at which to stop.
        tighten: relative tightening of all rows against the solver's tolerance.
        programs, cam_only: of a ``ProofBudget``.
        last_program: ``clock.programs_solved()`` from which on only a quick proof is made.
        proof_deadline: ``clock.now()`` from which on nodes over parts of the domain stop.
        sufficient, sufficient_bound: a value of the objective, and a lower bound [wire], at which
            to stop, whatever the gap.
        margin: relative tightening of rows written at points, against their excess in between.
        incumbent: best cam that satisfies all limits.
        relaxed: best cam of the relaxation, which may violate nonconvex limits.
        lower, valid_for: best lower bound [problem units] and the cams that it holds for.
        bound: the dual bound that it is; None where it was proven elsewhere.
        infeasible: the relaxation has no point.
        infeasibility_proof: why no motion law at all satisfies the limits; empty if unproven.
        undecided: what is known where neither a law nor such a proof was found.
        least_excess: by how much, relatively, the gentlest law found exceeds limits on the motion.
        strained: the kinds of limits whose share it makes least; empty where it was not sought.
        stages: what has been solved, in order.
        grids: knots and collocation points of every free law.
        region: where curved limits are linearised.
        tangent: whether the linearised rows hold with equality at the relaxation's solution.
        local_search_done: whether the outer approximation has run a local search.
        covers_all_laws: whether ``lower`` holds for all laws, not only for splines on ``grids``.
        last: the last cam recovered from a cone program, feasible or not.
        warm_start, local_optimum: where the local search of a neighbouring problem, and that of
            this one, ended.
        warm_started: whether ``warm_start`` gave the incumbent.
        modelled_kinds: kinds of nonconvex limits that the lower bound takes into account.
        relaxation: the last cone program with a point, that point and its bound.
    """

    problem: Problem
    tolerance: float
    deadline: float
    tighten: float
    programs: float = 0.0
    last_program: float = -inf
    proof_deadline: float = inf
    cam_only: bool = False
    sufficient: float = -inf
    sufficient_bound: float = inf
    margin: float = 0.0
    incumbent: Candidate | None = None
    relaxed: Candidate | None = None
    lower: float = -inf
    valid_for: str = ""
    bound: Bound | None = None
    infeasible: bool = False
    infeasibility_proof: str = ""
    undecided: str = ""
    least_excess: float | None = None
    strained: tuple[str, ...] = ()
    stages: tuple[Stage, ...] = ()
    grids: tuple[Grid, ...] = ()
    region: Region | None = None
    tangent: bool = True
    local_search_done: bool = False
    covers_all_laws: bool = True
    last: Candidate | None = None
    warm_start: WarmStart | None = None
    local_optimum: WarmStart | None = None
    warm_started: bool = False
    modelled_kinds: Collection[str] = ()
    relaxation: tuple[ConicModel, ConeSolution, Bound] | None = None

    @property
    def time_left(self) -> float:
        """Seconds until the deadline; negative after it."""
        return self.deadline - clock.now()

    @property
    def thorough(self) -> bool:
        """Whether to go on, where nonconvex limits leave a gap, with more than a quick proof."""
        lasts = clock.programs_solved() < self.last_program
        return lasts and clock.now() < self.proof_deadline

    @property
    def proof_budget(self) -> ProofBudget:
        """What is left for a proof, from now on."""
        left, share = self.time_left, 1.0
        if 0.0 < left < inf:
            share = max(self.proof_deadline - clock.now(), 0.0) / left
        return ProofBudget(self.programs, share, self.cam_only)

    def with_proof_begun(self) -> SolveState:
        """The state from which on programs count as those of more than a quick proof."""
        return replace(self, last_program=clock.programs_solved() + self.programs)

    @property
    def tightening(self) -> Tightening:
        """By how much the rows of the next cone program are tightened."""
        return Tightening(self.tighten, self.margin)

    def with_stage(self, stage: Stage) -> SolveState:
        """The state with one more stage in its report: what that has found is in the state."""
        gap = max(self.gap_between(self.incumbent, self.lower), 0.0)
        reported = replace(stage, gap=gap if isfinite(gap) else None)
        return replace(self, stages=(*self.stages, reported))

    def with_exit(self, reason: str) -> SolveState:
        """The state with why the search has ended, in the report of its last stage."""
        *before, last = self.stages or (None,)
        return self if last is None else replace(self, stages=(*before, replace(last, exit=reason)))

    @property
    def stopwatch(self) -> float:
        """Seconds on a clock that stands still in stages reported, so that none counts twice."""
        return time.perf_counter() - sum(stage.seconds for stage in self.stages)

    def with_relaxed(self, cam: Candidate) -> SolveState:
        """Take a cam of the relaxation, and the cam that it becomes under the other limits."""
        better = self.relaxed is None or cam.value < self.relaxed.value
        return (replace(self, relaxed=cam) if better else self).with_incumbent(cam)

    def with_local_optimum(self, cam: Candidate) -> SolveState:
        """Take a cam that satisfies all limits.

        Where limits are curved, the relaxation's best cam may be no better than this one.
        """
        curved = self.problem.has_curved_limits
        return self.with_relaxed(cam) if curved else self.with_incumbent(cam)

    def with_incumbent(self, cam: Candidate) -> SolveState:
        """Enlarge a cam until every limit holds, and keep it if it is the best so far."""
        enlarged = enlarge_until_feasible(cam, densely=self.tighten > DEFAULT_TIGHTENING)
        known = self.incumbent
        if enlarged is None or (known is not None and enlarged.value >= known.value):
            return self
        return replace(self, incumbent=enlarged)

    @property
    def smallest_value(self) -> float:
        """The value of the best cam known, of the relaxation or not; infinite without one."""
        return min((x.value for x in (self.relaxed, self.incumbent) if x is not None), default=inf)

    def with_bound(self, bound: Bound) -> SolveState:
        """Keep the bound of a relaxation.

        One over all laws is kept if it is the best so far. One over splines on the present knots
        replaces what there is: bounds of different families do not compare.
        """
        value = self._with_least_radius(bound.value)
        if value <= self.lower and bound.switching:
            return self
        valid_for = bound.valid_for
        if self.problem.omits_curved_rows:
            valid_for += "; limits of the face on free laws left out: the cam a local optimum"
        covers = bool(bound.switching) or not self.grids
        return replace(self, lower=value, valid_for=valid_for, bound=bound, covers_all_laws=covers)

    def raise_bound(self, lower: float, valid_for: str) -> SolveState:
        """Take a lower bound that was proven elsewhere, if it is better."""
        value = self._with_least_radius(lower)
        if value <= self.lower:
            return self
        return replace(self, lower=value, valid_for=valid_for, bound=None)

    def bound_of_neighbour(self, problem: Problem) -> float:
        """A lower bound over all laws of a problem with other numbers [its units]; −inf: none.

        By the multipliers of the best bound known: it is the nearer, the less the numbers differ.
        """
        again = None if self.bound is None else self.bound.of_neighbour
        found = None if again is None else again(problem)
        return found.value if found is not None and found.switching else -inf

    def _with_least_radius(self, lower: float) -> float:
        """The bound, or the least prime radius where that is larger and bounds the same norm."""
        norm = self.problem.objective.norm(self.problem.machine)
        return lower if norm is None else max(lower, self.problem.sizing.min_norm)

    def gap_between(self, cam: Candidate | None, lower: float) -> float:
        """Relative gap of a cam to a lower bound, in the wire's unit; infinite while unknown.

        It says what is left to do: no cam is sought below a least size, though bounds may be lower.
        """
        if cam is None or not isfinite(lower):
            return inf
        to_wire, machine = self.problem.objective.to_wire, self.problem.machine
        if self.problem.objective.norm(machine) is not None:
            lower = max(lower, self.problem.searched_norm)
        value = to_wire(cam.value, machine)
        return (value - to_wire(lower, machine)) / max(abs(value), 1e-300)

    @cached_property
    def relaxation_gap(self) -> float:
        """Gap of the relaxation's best cam."""
        return self.gap_between(self.relaxed, self.lower)

    def is_close(self, cam: Candidate | None, lower: float | None = None) -> bool:
        """Whether a cam is within the tolerance of a lower bound, or that bound is enough."""
        lower = self.lower if lower is None else lower
        return cam is not None and (
            lower >= self._problem_value(self.sufficient_bound)
            or self.gap_between(cam, lower) <= 0.99 * self.tolerance
        )

    def bound_to_prove(self, cam: Candidate) -> float:
        """The lower bound [problem units] that closes the gap of a cam, or is sufficient."""
        objective, machine = self.problem.objective, self.problem.machine
        value = objective.to_wire(cam.value, machine)
        closing = value - AIM * self.tolerance * abs(value)
        return objective.from_wire(min(closing, self.sufficient_bound), machine)

    @cached_property
    def is_good_enough(self) -> bool:
        """Whether the incumbent is sufficient, or within the tolerance of the lower bound."""
        return self.suffices or self.is_close(self.incumbent)

    @cached_property
    def suffices(self) -> bool:
        """Whether the incumbent is sufficient, or as small as any that is sought."""
        return self.is_sufficient or self.is_smallest_sought

    @property
    def is_sufficient(self) -> bool:
        """Whether the incumbent has a value at which the search may stop."""
        return self.incumbent is not None and self.incumbent.value <= self.sufficient_value

    @cached_property
    def is_smallest_sought(self) -> bool:
        """Whether the incumbent is the smallest cam that is sought.

        Then no search finds a better one; the lower bound holds for all sizes.
        """
        problem, best = self.problem, self.incumbent
        if best is None or problem.objective.norm(problem.machine) is None:
            return False
        return problem.is_smallest_sought(best.size, AT_END)

    @property
    def sufficient_value(self) -> float:
        """The value at which to stop in problem units; −inf where there is none."""
        return self._problem_value(self.sufficient)

    def _problem_value(self, value: float) -> float:
        """A value of the objective [wire] in problem units; one that is infinite stays so."""
        objective, machine = self.problem.objective, self.problem.machine
        return objective.from_wire(value, machine) if isfinite(value) else value

    def problem_tolerance(self, value: float) -> float:
        """The tolerance about a value of the objective, relative, both in problem units.

        That of a small base radius is a much smaller share of the prime radius.
        """
        objective, machine = self.problem.objective, self.problem.machine
        wire = objective.to_wire(value, machine)
        least = objective.from_wire(wire - self.tolerance * abs(wire), machine)
        return (value - least) / max(abs(value), 1e-300)

    def would_close(self, lower: float) -> bool:
        """Whether a lower bound would bring the relaxation's best cam within the tolerance."""
        return self.is_close(self.relaxed, self._with_least_radius(lower))

    @property
    def nonconvex_limits_cost(self) -> bool:
        """Whether limits outside the relaxation cost more than the tolerance."""
        if self.relaxed is None:  # it may know the cam of an earlier objective all the same
            return self.incumbent is not None and not self.is_good_enough
        if self.incumbent is None:
            return True
        return self.incumbent.value > self.relaxed.value and not self.is_good_enough

    @property
    def needs_local_search(self) -> bool:
        """Whether nonconvex limits, in the relaxation or not, leave more than the tolerance."""
        return self.nonconvex_limits_cost or (
            self.problem.has_curved_limits and not self.is_good_enough
        )

    def allowance(self, tolerance: float) -> float:
        """The largest value [problem units] that is still within a tolerance of the best.

        A later objective of an ordered list may use it up.
        """
        assert self.incumbent is not None
        objective, machine = self.problem.objective, self.problem.machine
        value = objective.to_wire(self.incumbent.value, machine)
        lower = objective.to_wire(self.lower, machine) if isfinite(self.lower) else 0.0
        allowed = lower / (1.0 - 0.98 * min(tolerance, 0.9))
        return objective.from_wire(max(value * (1.0 + 0.1 * tolerance), allowed), machine)


def program_stage(name: str, model: ConicModel, solution: ConeSolution, seconds: float) -> Stage:
    """What a cone program was, and what it cost, for the report."""
    rows, unknowns = model.program.matrix.shape
    conic = any(
        len(ball.shift) > 1 for ball in model.cone_blocks
    )  # a ball of one row is two half-spaces
    intervals = count_intervals(model.grids)
    kind = "QP" if model.energy is not None else "SOCP" if conic else "LP"
    return Stage(
        name, f"{kind}, {intervals} spline intervals", "Clarabel",
        unknowns, rows, solution.iterations, seconds, solution.stopped.value,
    )  # fmt: skip


def solvers_of(state: SolveState, known: tuple[str, ...] = ()) -> tuple[str, ...]:
    """The solvers that a solve's stages have used, after those known, each named once."""
    used = (name for stage in state.stages for name in stage.solver.split(", ") if name != "none")
    return tuple(dict.fromkeys((*known, *used)))


Optimise = Callable[..., SolveState]  # ``driver.optimise``, as strategies call it
