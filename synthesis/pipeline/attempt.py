"""One question of given numbers: laws and size from the optimiser, judged by the certificate.

A cam that the certificate refuses is sought again with limits drawn in a little more. One that
only crosses itself is made larger until it does not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import inf

from synthesis.catalogue.fields import Range
from synthesis.certify import SELF_CROSSING
from synthesis.design.design import Effort, Extreme
from synthesis.numerics import clock
from synthesis.optimise.driver import optimise
from synthesis.optimise.parameters.table_smoothing import Tables, smooth_tables
from synthesis.optimise.problem.nondimensional import NondimensionalSpec
from synthesis.optimise.problem.problem import (
    ObjectiveCap,
    Problem,
    formulate_problem,
    with_smoother_laws,
)
from synthesis.optimise.recovery.candidate import (
    Candidate,
    cam_at_size,
    enlarge_until_feasible,
    given_cam,
    objective_value,
    smallest_size,
)
from synthesis.optimise.recovery.counter_roller import place_counter_roller
from synthesis.optimise.refinement.mesh import FINEST
from synthesis.optimise.state import QUICK, THOROUGH, ProofBudget, SolveState, WarmStart
from synthesis.pipeline.assembly import Bounded, Cam, certify_cam, to_physical_cam, with_size
from synthesis.spec.design_spec import SMALLEST, DesignSpec

FIRST_GROWTH = 0.02  # of the base radius; doubled while the cam crosses itself, then halved
SMALL = 5e-2  # strokes: a smaller base radius is no measure of how much it has to grow
ROUNDING = 1e-12  # strokes: a bound so near to the open end of the size is that
FURTHER_DOWN = (1e-9, 1e-6, 1e-5, 1e-4)
"""Strokes: base radii from which on smaller cams are sought, in turn, near an open end."""
GROWTHS = 14  # radii tried at most
BEYOND_TIGHTENING = 1e-2  # relative violation of a limit that the largest of them cannot mend
AUTO_PROGRAMS = 100
"""Programs for a proof that goes on by itself: 2 to 4 s. A program takes 0.02 to 0.04 s of them,
whatever the family, with all that is computed around it."""
AUTO_SHARE = 0.5  # of the time: such a proof leaves the rest to later objectives and trials
TIGHTENINGS = (1e-7, 1e-6, 1e-5, 1e-4)  # relative amounts by which limits are tightened, in turn


@dataclass(frozen=True, eq=False)
class Goal:
    """When to stop, and where to begin.

    Attributes:
        stop: ``clock.now()`` at which to stop with the best so far.
        warm_start: where a neighbouring question's local search ended.
        sufficient: a value of the first objective [wire] that is good enough, proven best or not.
        smallest: base radius from which on cams are sought where it is open below [strokes].
    """

    stop: float
    warm_start: WarmStart | None = None
    sufficient: float = -inf
    smallest: float = SMALLEST


@dataclass(eq=False)
class Attempt:
    """A question of given numbers, and what solving it came to.

    Attributes:
        question: the spec, with numbers in place of what it leaves free. numbers: these [wire].
        tables: its measured laws, smoothed.
        solved_spec: what was solved; built: the spec of the cam that came out. They differ from the
            question where the place of a counter roller is chosen after the size.
        searches: what the optimiser came to, objective by objective.
        best, bounds: in the question's own units. cam, extremes: in the wire's.
    """

    question: NondimensionalSpec
    numbers: list[float]
    tables: Tables
    solved_spec: DesignSpec
    built: DesignSpec
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
        """Whether the cam keeps everything but that its profile crosses itself."""
        broken = [extreme.limit for extreme in self.extremes if not extreme.holds]
        return bool(broken) and all(limit.startswith(SELF_CROSSING) for limit in broken)

    @property
    def is_smallest_sought(self) -> bool:
        """Whether the base radius is made small, is open below, and as small as was sought."""
        if self.best is None or not self.certified or not self.searches:
            return False
        first = replace(self.searches[0], incumbent=self.best)
        return first.is_smallest_sought

    @property
    def first_bound(self) -> Bounded | None:
        """The lower bound of the first objective, found with a cam or without; of all laws only."""
        if not self.searches or not self.searches[0].covers_all_laws:
            return None
        first = self.searches[0]
        known = Bounded(first.problem.objective, first.lower, first.valid_for)
        return self.bounds[0] if self.bounds else None if first.infeasible else known

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

    def problems(self, smallest: float) -> Iterator[Problem]:
        """The problem of every objective in order; each keeps what those before have reached.

        Whoever takes a problem appends its solution to ``searches`` before the next.
        """
        spec, caps = self.solved_spec, tuple[ObjectiveCap, ...]()
        for objective in spec.objectives():
            problem = formulate_problem(spec, objective, caps, self.tables.segments, smallest)
            yield with_smoother_laws(problem) if spec.tolerance <= FINEST else problem
            solution = self.searches[-1]
            if solution.incumbent is None:
                return
            caps = (*caps, ObjectiveCap(objective, solution.allowance(spec.tolerance)))


def prepare(spec: DesignSpec, goal: Goal, stages: list[Effort]) -> Attempt:
    """Choose what a spec leaves free and smooth its tables: what is left are laws and a size.

    Returns:
        an attempt with nothing solved.
    """
    question, numbers = NondimensionalSpec.of(spec), list[float]()
    free_parameters = spec.free_parameters
    if free_parameters.parameters:
        from synthesis.optimise.parameters.search import choose_parameters

        numbered, stage = choose_parameters(question.scaled, goal.stop)
        stages.append(Effort(**vars(stage)))
        question = question.with_scaled(numbered)
        physical = question.physical
        numbers = free_parameters.values_in(physical.program, physical.follower)
    tables = smooth_tables(question.scaled.placed_segments(), goal.stop)
    stages += [Effort(**vars(stage)) for stage in tables.stages]
    return Attempt(question, numbers, tables, question.scaled, question.scaled)


def solve_and_certify(prepared: Attempt, goal: Goal, stages: list[Effort]) -> Attempt:
    """Solve with limits tightened more and more, until the certificate accepts the cam.

    Only the first solve uses the warm start: a cam that the certificate refuses is no start. The
    bound is the best of all: it is that of the limits as they are.
    """
    attempt = prepared
    for tighten in TIGHTENINGS:
        attempt = with_bound_of(attempt, _solve_tightened(prepared, goal, tighten))
        if attempt.cam is not None:
            question = attempt.question
            attempt.cam = to_physical_cam(question, attempt.solved_spec, attempt.cam)
            attempt.extremes = certify_cam(
                question.physical, attempt.cam, question.to_physical(attempt.built)
            )
        for state in attempt.searches:
            stages += [Effort(**vars(stage)) for stage in state.stages]
        finished = attempt.certified or attempt.crosses_itself or attempt.beyond_tightening
        if finished or clock.now() >= goal.stop:
            break
        goal = replace(goal, warm_start=None)
    return attempt


def _solve_tightened(prepared: Attempt, goal: Goal, tighten: float) -> Attempt:
    """Solve with limits tightened by a relative amount; the cam is left in the question's units."""
    question, numbers, tables = prepared.question, prepared.numbers, prepared.tables
    spec = question.scaled
    sufficient = goal.sufficient / question.units.length
    solved_spec, first, place = spec.without_deferred(), None, None
    while True:
        # 1. Minimise one objective after the other.
        attempt = Attempt(question, numbers, tables, solved_spec, solved_spec)
        last = len(spec.objectives()) - 1
        for rank, problem in enumerate(attempt.problems(goal.smallest)):
            from_start = rank == 0 and first is None
            state = optimise(
                problem, spec.tolerance if rank == last else 0.5 * spec.tolerance, goal.stop,
                tighten, proof=_proof_budget(spec, is_last=rank == last),
                warm_start=goal.warm_start if from_start else None,
                earlier=attempt.searches[-1].incumbent if rank else None,
                sufficient=sufficient if from_start else -inf,
            )  # fmt: skip
            attempt.searches.append(state)
        _take_best(attempt)
        if attempt.best is None or first is not None:
            break
        # 2. What is fixed after the size: the place of a counter roller. Where none suits this
        #    cam, seek the cam again with the farthest place given: the counter cam then has its
        #    say in the laws and the size.
        place = place_counter_roller(spec, attempt.best, goal.stop)
        if place.holds:
            break
        first, solved_spec = attempt, place.spec
    if first is not None:
        attempt.searches = [*first.searches, *attempt.searches]
        if place is not None and not place.farthest:
            attempt.bounds = first.bounds  # another place might suit better: valid for all
    if place is not None:
        attempt.built = place.spec
    return attempt


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
    if known.lower <= own.lower:
        return attempt
    own = replace(own, lower=known.lower, over=known.over)
    return replace(attempt, bounds=[own, *later])


def solve_spec(spec: DesignSpec, goal: Goal, stages: list[Effort]) -> Attempt:
    """Solve a question with everything in it a constraint; its cam does not cross itself."""
    attempt = solve_and_certify(prepare(spec, goal, stages), goal, stages)
    return enlarge_until_simple(attempt, goal, stages)


def approach_infimum(found: Attempt, goal: Goal, stages: list[Effort]) -> Attempt:
    """The cam of an open base radius nearer to the open end, if it is the smallest that was sought.

    Where the bound is the open end the laws found will do. Where it is not, a best cam may lie
    below where the search began: the question is solved again, further down.
    """
    if not found.is_smallest_sought or found.best is None:
        return found
    trials = _solved_and_resized(found, goal, stages)
    smaller = (t for t in trials if t.certified and _base_radius(t) < _base_radius(found))
    return next(smaller, found)


def _solved_and_resized(found: Attempt, goal: Goal, stages: list[Effort]) -> Iterator[Attempt]:
    """The question solved from further down on, where that may help; the laws found, resized."""
    alone = len(found.searches) == 1  # later objectives would have to be worked through again
    if not (alone and found.bounds[0].infimum) and clock.now() < goal.stop:
        further = replace(goal, smallest=FURTHER_DOWN[0], warm_start=None)
        yield solve_spec(found.question.physical, further, stages)
    for smallest in FURTHER_DOWN if alone else ():
        yield _resized_for(found, smallest)


def _resized_for(found: Attempt, smallest: float) -> Attempt:
    """The laws found with the smallest cam that keeps the limits, sought from a base radius on."""
    (search,), best, cam, question = found.searches, found.best, found.cam, found.question
    assert best is not None
    assert cam is not None
    sought = found.solved_spec.searched_radii(smallest)[0]
    given = replace(best.problem, smallest_sought=sought)
    size = smallest_size(given)
    resized = enlarge_until_feasible(cam_at_size(given, best.laws, size or best.size))
    if resized is None:
        return found
    cam = with_size(question, question.to_physical(found.solved_spec), cam, resized.size)
    extremes = certify_cam(question.physical, cam, question.to_physical(found.built))
    problem = replace(search.problem, smallest_sought=sought)
    search = replace(search, problem=problem, incumbent=resized)
    return replace(found, searches=[search], best=resized, cam=cam, extremes=extremes)


def enlarge_until_simple(crossing: Attempt, goal: Goal, stages: list[Effort]) -> Attempt:
    """The smallest base radius, by trial, whose cam does not cross itself; else what there was.

    No formulation knows of crossing. The lower bound remains that of the spec as asked, so the
    gap says honestly what the growth has cost; later objectives, which hold what earlier ones
    had reached, keep no bound.
    """
    if not crossing.crosses_itself:
        return crossing
    question, again = crossing.question, replace(goal, warm_start=None)
    spec = question.scaled
    least, largest = _base_radius(crossing), spec.base_radius_range()[1]
    most, best = largest, crossing
    step = FIRST_GROWTH * max(least, SMALL * spec.stroke())
    accuracy = min(spec.tolerance, FIRST_GROWTH)
    for _ in range(GROWTHS):
        trial_radius = min(least + step, largest) if best is crossing else 0.5 * (least + most)
        if clock.now() >= goal.stop or trial_radius <= least * (1.0 + 0.1 * accuracy):
            break
        raised = Range(min=trial_radius, max=largest)
        larger = spec.model_copy(update={"base_radius_mm": raised, "proof": "quick"})
        trial = question.with_scaled(larger)
        larger_cam = solve_and_certify(
            Attempt(trial, crossing.numbers, crossing.tables, larger, larger), again, stages
        )
        if larger_cam.cam is not None and larger_cam.certified:
            built = larger_cam.built.model_copy(update={"base_radius_mm": spec.base_radius_mm})
            extremes = certify_cam(question.physical, larger_cam.cam, question.to_physical(built))
            most = _base_radius(larger_cam)
            best = replace(larger_cam, question=question, built=built, extremes=extremes)
            if larger_cam.searches[0].suffices:
                break
        elif larger_cam.crosses_itself:
            least, step = trial_radius, 2.0 * step
        else:
            break
    if best is crossing:
        return crossing
    first, *later = crossing.bounds
    unknown = [replace(bounded, lower=-inf) for bounded in later]
    return replace(best, bounds=[first, *unknown])


def _proof_budget(spec: DesignSpec, *, is_last: bool) -> ProofBudget:
    """What may be spent on a proof; of an objective with others after it no more than their share.

    ``auto`` spends part of the time that the spec gives; where it gives none, a number of programs,
    so that the answer depends on no machine's speed.
    """
    programs = AUTO_PROGRAMS if spec.time_budget_s is None else inf
    auto = ProofBudget(programs, AUTO_SHARE)
    budget = {"quick": QUICK, "auto": auto, "thorough": THOROUGH}[spec.proof]
    return budget if is_last else replace(budget, share=min(budget.share, AUTO_SHARE))


def _base_radius(attempt: Attempt) -> float:
    assert attempt.best is not None
    return attempt.built.follower.dimensions(attempt.best.size)["base_radius_mm"]


def _nears_open_end(state: SolveState) -> bool:
    """Whether a bound is the open end of the size, and the cam the smallest that was sought.

    The cam of a later objective may be larger by what that objective was allowed: the open end is
    the infimum all the same.
    """
    problem = state.problem
    at_end = state.lower <= problem.least_norm + ROUNDING * problem.length
    return at_end and state.is_smallest_sought


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
    else:  # laws and size are given: the only cam there is, its values their own bounds
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
