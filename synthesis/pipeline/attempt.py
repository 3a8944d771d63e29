"""One question of given numbers: laws and size from the optimiser, judged by the certificate.

A cam that the certificate refuses is sought again with limits tightened a little more.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import inf, isfinite

from synthesis.catalogue.objectives import BaseRadius, Objective
from synthesis.certify import SELF_CROSSING
from synthesis.design.design import Effort, Extreme
from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.optimise.driver import optimise
from synthesis.optimise.parameters.table_smoothing import Tables, smooth_tables
from synthesis.optimise.problem.nondimensional import NondimensionalSpec
from synthesis.optimise.problem.problem import (
    ObjectiveCap,
    Problem,
    formulate_problem,
    with_smoother_laws,
)
from synthesis.optimise.recovery.candidate import Candidate, given_cam, objective_value
from synthesis.optimise.recovery.counter_roller import place_counter_roller
from synthesis.optimise.refinement.polish import (
    COARSEST_POLISH,
    grids_on_switches,
    polish_intervals,
)
from synthesis.optimise.state import AT_END, SINGLE_SHARE, SolveState
from synthesis.pipeline.assembly import Bounded, Cam, certify_cam, to_physical_cam
from synthesis.pipeline.goal import Goal, proof_budget
from synthesis.spec.design_spec import DesignSpec

ROUNDING = 1e-12  # strokes: a bound so near to the open end of the size is that
SAME = 1e-6  # relative: what a cam may lose when its laws are put together again
BEYOND_TIGHTENING = 1e-2  # relative violation of a limit that no tightening below repairs
SWITCHING = 3  # degree of splines whose highest derivative may step at a knot as the best law's
OWN_SHARE = 0.1  # of an allowance: how near to the least value that objective itself is brought
TIGHTENINGS = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
"""Relative amounts by which limits are tightened, in turn."""


@dataclass(eq=False)
class Attempt:
    """A question of given numbers, and what solving it came to.

    Attributes:
        question: the spec, with numbers in place of what it leaves free.
        chosen_values: these numbers [wire].
        number_bound: of the first objective over all numbers; None where that is not known.
        start: the cam that the search over all numbers ended with; None where there is none.
        tables: its measured laws, smoothed.
        solved_spec: what the optimiser solves. final_spec: the spec of the finished cam. Both
            differ from the question where the place of a counter roller is chosen after the size.
        first: the attempt with the counter roller's place open, where it had none for that cam.
        searches: the optimiser's final states, objective by objective.
        best, bounds: in the question's own units. cam, extremes: in the wire's.
    """

    question: NondimensionalSpec
    chosen_values: list[float]
    tables: Tables
    solved_spec: DesignSpec
    final_spec: DesignSpec
    first: Attempt | None = None
    number_bound: Bounded | None = None
    start: Candidate | None = None
    searches: list[SolveState] = field(default_factory=list)
    best: Candidate | None = None
    bounds: list[Bounded] = field(default_factory=list)
    cam: Cam | None = None
    extremes: list[Extreme] = field(default_factory=list)

    @property
    def certified(self) -> bool:
        """Whether there is a cam and every limit holds on it."""
        return self.cam is not None and all(extreme.holds for extreme in self.extremes)

    @property
    def crosses_itself(self) -> bool:
        """Whether the cam keeps every limit, but its profile crosses itself."""
        broken = [extreme.limit for extreme in self.extremes if not extreme.holds]
        return bool(broken) and all(limit.startswith(SELF_CROSSING) for limit in broken)

    @property
    def is_smallest_sought(self) -> bool:
        """Whether the cam is the smallest sought, its base radius minimised and open below."""
        is_open = self.question.physical.requested_radii()[0] <= 0.0
        if self.best is None or not self.certified or not (self.searches and is_open):
            return False
        first = replace(self.searches[0], incumbent=self.best)
        return first.problem.is_open_below and first.is_smallest_sought

    @property
    def first_bound(self) -> Bounded | None:
        """The lower bound of the first objective, found with a cam or without; of all laws only."""
        if not self.searches or not self.searches[0].covers_all_laws:
            return None
        first = self.searches[0]
        known = Bounded(first.problem.objective, first.lower, first.valid_for)
        return self.bounds[0] if self.bounds else None if first.infeasible else known

    def mesh(self, tolerance: float) -> tuple[Array, ...]:
        """Knots for a neighbouring question: equal intervals, and where the first best laws switch.

        With them the splines are next to the best laws. Nothing where there is no such law, where
        laws are so smooth that a switch is a ramp, or where rows of curved limits need few knots.
        """
        best = self.searches[0].relaxed if self.searches else None
        if best is None or any(law.space.degree > SWITCHING for law in best.laws):
            return ()
        problem = self.searches[0].problem
        if problem.has_curved_limits:
            return ()
        grids = grids_on_switches(problem, best, polish_intervals(tolerance))
        return tuple(grid.space.breaks for grid in grids)

    @property
    def beyond_tightening(self) -> bool:
        """Whether tighter limits cannot repair the cam: it misses one by more than they move."""
        last = self.searches[-1]
        missing = any(
            not extreme.holds and extreme.margin is not None and extreme.bound
            and -extreme.margin > BEYOND_TIGHTENING * abs(extreme.bound)
            for extreme in self.extremes
        )  # fmt: skip
        return last.infeasible or not last.problem.free or last.incumbent is None or missing

    def tolerance(self, rank: int) -> float:
        """The tolerance of an objective: each but the last leaves half of it to those after it.

        That of the first one leaves a part to numbers that were not chosen. One with an allowance
        leaves most of that.
        """
        tolerance, objectives = self.solved_spec.tolerance, self.solved_spec.objectives()
        if rank == 0 and self.number_bound is not None:
            return SINGLE_SHARE * tolerance
        if rank >= len(objectives) - 1:
            return tolerance
        allowed = objectives[rank].allowed_gap(tolerance)
        return 0.5 * tolerance if allowed == tolerance else max(tolerance, OWN_SHARE * allowed)

    def problem(
        self, objective: Objective, caps: tuple[ObjectiveCap, ...], smallest: float
    ) -> Problem:
        """That of one objective, where those before it are held."""
        spec = self.solved_spec
        problem = formulate_problem(spec, objective, caps, self.tables.segments, smallest)
        return with_smoother_laws(problem) if spec.tolerance <= COARSEST_POLISH else problem

    def problems(self, smallest: float) -> Iterator[Problem]:
        """The problem of every objective in order; each keeps what those before have reached.

        Where none is named, and the cam is as small as any may be (by the radius of a hub, say), at
        last the rms jerk again: what it was allowed buys nothing there. No bound comes of that.
        Whoever takes a problem appends its solution to ``searches`` before the next.
        """
        spec, caps = self.solved_spec, tuple[ObjectiveCap, ...]()
        for objective in spec.objectives():
            yield self.problem(objective, caps, smallest)
            solution = self.searches[-1]
            if solution.incumbent is None:
                return
            allowed = solution.allowance(objective.allowed_gap(spec.tolerance))
            caps = (*caps, ObjectiveCap(objective, allowed))
        if spec.objective is None and len(caps) > 1 and _is_least(self.searches[-1]):
            first, size = spec.objectives()[0], caps[-1:]
            yield formulate_problem(spec, first, size, self.tables.segments, smallest)


def prepare(spec: DesignSpec, goal: Goal, stages: list[Effort]) -> Attempt:
    """Choose what a spec leaves free and smooth its tables: what is left are laws and a size.

    Returns:
        an attempt with nothing solved.
    """
    question, chosen_values = NondimensionalSpec.of(spec), list[float]()
    bounded, start = None, None
    free_parameters = spec.free_parameters
    if free_parameters.parameters:
        from synthesis.optimise.parameters.number_search import NOTHING, Enough
        from synthesis.optimise.parameters.search import choose_parameters

        budget = proof_budget(spec, goal, is_last=len(spec.objectives()) == 1)
        # Lengths of the machine change nothing in the jerk of the motion: where no objective is
        # named, they are those of the smallest cam.
        by_size = spec.objective is None and bool(free_parameters.machine_indices)
        aim = {"objective": BaseRadius() if by_size else spec.objective}
        by_aim = question.scaled.model_copy(update=aim)
        unit = question.units.length
        enough = Enough(goal.sufficient / unit, goal.sufficient_bound / unit)
        enough = NOTHING if by_size else enough
        numbered, stage, proof = choose_parameters(by_aim, goal.stop, budget, enough)
        numbered = numbered.model_copy(update={"objective": spec.objective})
        if proof is not None and isfinite(proof.lower) and not by_size:
            bounded, start = Bounded(spec.objectives()[0], proof.lower, proof.valid_for), proof.cam
        stages.append(Effort(**vars(stage)))
        question = question.with_scaled(numbered)
        physical = question.physical
        chosen_values = free_parameters.values_in(physical.program, physical.follower)
    tables = smooth_tables(question.scaled.placed_segments(), goal.stop)
    stages += [Effort(**vars(stage)) for stage in tables.stages]
    scaled = question.scaled
    return Attempt(question, chosen_values, tables, scaled, scaled, None, bounded, start)


def solve_and_certify(prepared: Attempt, goal: Goal, stages: list[Effort]) -> Attempt:
    """Solve with limits tightened more and more, until the certificate accepts the cam.

    Only the first solve uses the warm start: a cam that the certificate refuses is no start. The
    bound is the best of all: it is that of the limits as they are.
    """
    question, attempt = prepared.question, prepared
    spec, unit = question.scaled, question.units.length
    for tighten in TIGHTENINGS:
        known = attempt
        next_attempt: Attempt | None = unsolved(prepared, spec.without_deferred())
        start = prepared.start if tighten == TIGHTENINGS[0] else None
        while next_attempt is not None:
            attempt = next_attempt
            # 1. Minimise one objective after the other.
            for rank, problem in enumerate(attempt.problems(goal.smallest)):
                from_start = rank == 0 and attempt.first is None
                state = optimise(
                    problem, attempt.tolerance(rank), goal.stop, tighten,
                    proof=proof_budget(spec, goal, is_last=rank >= len(spec.objectives()) - 1),
                    warm_start=goal.warm_start if from_start else None,
                    earlier=attempt.searches[-1].incumbent if rank else start,
                    sufficient=max(goal.sufficient / unit, _value(start)) if from_start else -inf,
                    sufficient_bound=goal.sufficient_bound / unit if from_start else inf,
                    mesh=goal.mesh if from_start else (),
                )  # fmt: skip
                attempt.searches.append(state)
                if rank == 0 and _has_no_cam(state, goal.excluding_bound / unit):
                    break
            _take_best(attempt)
            # 2. What is fixed after the size: the place of a counter roller.
            next_attempt = _place_counter_roller(attempt, goal.stop)
        attempt = with_bound_of(known, attempt)
        # 3. Certify the cam in the wire's units.
        if attempt.cam is not None:
            attempt.cam = to_physical_cam(question, attempt.solved_spec, attempt.cam)
            attempt.extremes = certify_cam(
                question.physical, attempt.cam, question.to_physical(attempt.final_spec)
            )
        for state in attempt.searches:
            stages += [Effort(**vars(stage)) for stage in state.stages]
        finished = attempt.certified or attempt.crosses_itself or attempt.beyond_tightening
        if finished or clock.now() >= goal.stop:
            break
        mesh = attempt.mesh(attempt.tolerance(0)) or goal.mesh
        goal = replace(goal, warm_start=None, mesh=mesh)
    return attempt


def _value(cam: Candidate | None) -> float:
    """The value of a cam that is good enough [wire]; −∞ without one."""
    if cam is None:
        return -inf
    value = cam.problem.objective.to_wire(cam.value, cam.problem.machine)
    return value + SAME * abs(value)


def _has_no_cam(state: SolveState, excluding: float) -> bool:
    """Whether the bound of a first objective is as large as one [wire] that excludes every cam."""
    objective, machine = state.problem.objective, state.problem.machine
    return state.covers_all_laws and objective.to_wire(state.lower, machine) >= excluding


def unsolved(attempt: Attempt, spec: DesignSpec, first: Attempt | None = None) -> Attempt:
    """An attempt at the same question, to be solved with another spec."""
    given = attempt.question, attempt.chosen_values, attempt.tables
    return Attempt(*given, spec, spec, first, attempt.number_bound)


def _place_counter_roller(attempt: Attempt, stop: float) -> Attempt | None:
    """Choose the place of a counter roller for the best cam, if the spec leaves it open.

    Returns:
        an attempt still to be solved, with the farthest place given, where no place suits this cam:
        its laws and size are then chosen under the limits of both rollers. None otherwise.
    """
    first = attempt.first
    if first is None and attempt.best is not None:
        place = place_counter_roller(attempt.question.scaled, attempt.best, stop)
        if not place.holds:
            bounds = [] if place.farthest else attempt.bounds
            return unsolved(attempt, place.spec, replace(attempt, bounds=bounds))
        attempt.final_spec = place.spec
    if first is not None:
        attempt.searches = [*first.searches, *attempt.searches]
        # Where another place might suit better, only the bound without a place is valid for all.
        attempt.bounds = first.bounds or attempt.bounds
    return None


def with_bound_of(other: Attempt, attempt: Attempt) -> Attempt:
    """An attempt with the lower bound of its first objective, or that of another, if better.

    The other's question is the same, or has all cams of this one: its bound over all laws holds
    here too.
    """
    known = other.first_bound
    if known is None:
        return attempt
    own, *later = attempt.bounds or (
        Bounded(objective, -inf, "") for objective in attempt.solved_spec.objectives()
    )
    if known.lower <= own.lower or known.objective.kind != own.objective.kind:
        return attempt
    own = replace(own, lower=known.lower, valid_for=known.valid_for)
    return replace(attempt, bounds=[own, *later])


def _nears_open_end(state: SolveState) -> bool:
    """Whether a bound is the open end of the size, and the cam the smallest that was sought.

    The cam of a later objective may be larger by what that objective was allowed: the open end is
    the infimum all the same.
    """
    problem = state.problem
    at_end = state.lower <= problem.least_norm + ROUNDING * problem.length
    return at_end and problem.is_open_below and state.is_smallest_sought


def _is_least(state: SolveState) -> bool:
    """Whether the cam of a search for the smallest has the least size that is allowed or sought."""
    best, least = state.incumbent, state.problem.searched_norm
    return best is not None and best.value <= least * (1.0 + AT_END)


def _take_best(attempt: Attempt) -> None:
    """The best cam of the searches, and the bound of every objective; nothing without a cam."""
    spec, tables, searches = attempt.solved_spec, attempt.tables, attempt.searches
    objectives = spec.objectives()
    solved = [state for state in searches if state.incumbent is not None]
    best = solved[-1].incumbent if solved else None
    if best is not None:
        attempt.bounds = [
            Bounded(objective, state.lower, state.valid_for, _nears_open_end(state))
            for objective, state in zip(objectives, solved, strict=False)
        ]
    else:
        # Where laws and size are given, the one cam has no search: each of its values is its own
        # lower bound.
        best = given_cam(searches[0].problem)
    if best is None:
        return
    if not solved:
        problems = (formulate_problem(spec, each, (), tables.segments) for each in objectives)
        attempt.bounds = [
            Bounded(
                each.objective, objective_value(each, best.size) * (1.0 - 1e-12),
                "the one cam given",
            )
            for each in problems
        ]  # fmt: skip
    unreached = objectives[len(attempt.bounds) :]
    attempt.bounds += [Bounded(objective, -inf, "") for objective in unreached]
    splines = {
        segment.index: (law.space, law.coefficients)
        for segment, law in zip(searches[0].problem.free, best.laws, strict=True)
    }
    known = {segment.index: segment for segment in best.problem.segments}
    whole = tuple(known.get(segment.index, segment) for segment in tables.segments)
    attempt.cam, attempt.best = Cam(whole, {**tables.splines, **splines}, best.size), best
