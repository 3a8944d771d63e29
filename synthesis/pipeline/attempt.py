"""One question of given numbers: laws and size from the optimiser, judged by the certificate.

A cam that the certificate refuses is sought again with limits drawn in a little more. One that
only crosses itself is made larger until it does not.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf

from synthesis.catalogue.fields import Range
from synthesis.certify import SELF_CROSSING
from synthesis.design.design import Extreme, StageReport
from synthesis.numerics import clock
from synthesis.optimise.driver import optimise
from synthesis.optimise.parameters.table_smoothing import Tables
from synthesis.optimise.problem.nondimensional import NondimensionalSpec
from synthesis.optimise.problem.problem import ObjectiveCap, formulate_problem, with_smoother_laws
from synthesis.optimise.recovery.candidate import Candidate, given_cam, objective_value
from synthesis.optimise.recovery.counter_roller import CounterRollerPlacement, place_counter_roller
from synthesis.optimise.refinement.knot_polish import FINEST
from synthesis.optimise.state.solve_state import SolveState
from synthesis.optimise.state.warm_start import WarmStart
from synthesis.pipeline.assembly import Bounded, Cam, certify_cam, to_physical_cam
from synthesis.spec.design_spec import DesignSpec

FIRST_GROWTH = 0.02  # of the base radius; doubled while the cam crosses itself, then halved
GROWTHS = 16
BEYOND_TIGHTENING = 1e-2  # relative violation of a limit that the largest of them cannot mend
TIGHTENINGS = (1e-7, 1e-6, 1e-5, 1e-4)  # relative amounts by which limits are tightened, in turn


@dataclass(frozen=True, eq=False)
class Goal:
    """When to stop, and where to begin.

    Attributes:
        stop: ``clock.now()`` at which to stop with the best so far.
        warm_start: where a neighbouring question's local search ended.
        sufficient: a value of the first objective [wire] that is good enough, proven best or not.
    """

    stop: float
    warm_start: WarmStart | None = None
    sufficient: float = -inf


@dataclass(eq=False)
class Attempt:
    """What one pass over the objectives came to.

    ``solved_spec`` is the spec that was solved, ``built`` that of the cam that came out: they
    differ from the requested one where the place of a counter roller is chosen after the size. Like
    ``best`` and the ``bounds`` [core] they are in the question's own units, ``cam`` and
    ``extremes`` in the wire's.
    """

    solved_spec: DesignSpec
    built: DesignSpec
    searches: list[SolveState] = field(default_factory=list)
    cam: Cam | None = None
    best: Candidate | None = None
    bounds: list[Bounded] = field(default_factory=list)
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
    def beyond_tightening(self) -> bool:
        """Whether tighter limits cannot repair the cam: it misses one by more than they move."""
        last = self.searches[-1]
        missing = any(
            not extreme.holds and extreme.margin is not None and extreme.bound
            and -extreme.margin > BEYOND_TIGHTENING * abs(extreme.bound)
            for extreme in self.extremes
        )  # fmt: skip
        return last.infeasible or not last.problem.free or last.incumbent is None or missing


def solve_and_certify(
    question: NondimensionalSpec,
    tables: Tables,
    goal: Goal,
    stages: list[StageReport],
) -> Attempt:
    """Solve with limits tightened more and more, until the certificate accepts the cam.

    Only the first attempt uses the warm start: a cam that the certificate refuses is no start.
    """
    for tighten in TIGHTENINGS:
        attempt = _solve_once(question, tables, goal, tighten)
        for tried in attempt.searches:
            stages += [StageReport(**vars(stage)) for stage in tried.stages]
        finished = attempt.certified or attempt.crosses_itself or attempt.beyond_tightening
        if finished or clock.now() >= goal.stop:
            break
        goal = replace(goal, warm_start=None)
    return attempt


def enlarge_until_simple(
    question: NondimensionalSpec,
    tables: Tables,
    crossing: Attempt,
    goal: Goal,
    stages: list[StageReport],
) -> Attempt:
    """The smallest base radius, by trial, whose cam does not cross itself; else what there was.

    No formulation knows of crossing. The lower bound remains that of the spec as asked, so the
    gap says honestly what the growth has cost; later objectives, which hold what earlier ones
    had reached, keep no bound.
    """
    spec = question.scaled
    least, largest = _base_radius(crossing), spec.base_radius_range()[1]
    most, best, step = largest, crossing, FIRST_GROWTH * least
    accuracy = min(spec.tolerance, FIRST_GROWTH)
    for _ in range(GROWTHS):
        trial_radius = min(least + step, largest) if best is crossing else 0.5 * (least + most)
        if clock.now() >= goal.stop or trial_radius <= least * (1.0 + 0.1 * accuracy):
            break
        raised = Range(min=trial_radius, max=largest)
        larger = spec.model_copy(update={"base_radius_mm": raised})
        again = replace(goal, warm_start=None)
        tried = solve_and_certify(question.with_scaled(larger), tables, again, stages)
        if tried.cam is not None and tried.certified:
            built = tried.built.model_copy(update={"base_radius_mm": spec.base_radius_mm})
            extremes = certify_cam(question.physical, tried.cam, question.to_physical(built))
            most, best = _base_radius(tried), replace(tried, built=built, extremes=extremes)
        elif tried.crosses_itself:
            least, step = trial_radius, 2.0 * step
        else:
            break
    if best is crossing:
        return crossing
    first, *later = crossing.bounds
    unknown = [replace(bounded, lower=-inf) for bounded in later]
    return replace(best, bounds=[first, *unknown])


def _base_radius(attempt: Attempt) -> float:
    assert attempt.best is not None
    return attempt.built.follower.dimensions(attempt.best.size)["base_radius_mm"]


def _solve_once(
    question: NondimensionalSpec, tables: Tables, goal: Goal, tighten: float
) -> Attempt:
    """Solve the spec without what is fixed after the size, then fix that.

    Where no place of a counter roller suits the cam so found, the cam is sought again with the
    farthest place given: the counter cam then has its say in the laws and the size.
    """
    spec = question.scaled
    scaled = replace(goal, sufficient=goal.sufficient / question.units.length)
    attempt = _solve_objectives(spec.without_deferred(), tables, scaled, tighten)
    if attempt.best is None:
        return attempt
    place = place_counter_roller(spec, attempt.best, goal.stop)
    if not place.holds:
        # No place suits this main cam: seek the cam again with the farthest place given.
        first, attempt = attempt, _solve_objectives(place.spec, tables, Goal(goal.stop), tighten)
        attempt.searches = [*first.searches, *attempt.searches]
        if not place.farthest:
            attempt.bounds = first.bounds  # another place might suit better: those hold for all
        place = CounterRollerPlacement(place.spec, True)
    attempt.built = place.spec
    if attempt.cam is not None:
        attempt.cam = to_physical_cam(question, attempt.solved_spec, attempt.cam)
        attempt.extremes = certify_cam(
            question.physical, attempt.cam, question.to_physical(place.spec)
        )
    return attempt


def _solve_objectives(spec: DesignSpec, tables: Tables, goal: Goal, tighten: float) -> Attempt:
    """Work through the objectives in order; each keeps what the ones before have reached."""
    attempt = Attempt(spec, spec)
    held: tuple[ObjectiveCap, ...] = ()
    objectives = spec.objectives()
    best: Candidate | None = None
    for rank, objective in enumerate(objectives, start=1):
        share = spec.tolerance if rank == len(objectives) else 0.5 * spec.tolerance
        problem = formulate_problem(spec, objective, held, tables.segments)
        if spec.tolerance <= FINEST:
            problem = with_smoother_laws(problem)
        tried = optimise(
            problem, share, goal.stop, tighten, thorough=spec.proof == "thorough",
            warm_start=goal.warm_start if rank == 1 else None,
            sufficient=goal.sufficient if rank == 1 else -inf,
        )  # fmt: skip
        attempt.searches.append(tried)
        if tried.incumbent is None:
            break
        best = tried.incumbent
        attempt.bounds.append(Bounded(objective, tried.lower, tried.valid_for))
        if rank < len(objectives):
            held = (*held, ObjectiveCap(objective, tried.allowance(spec.tolerance)))
    if best is None:
        best = given_cam(attempt.searches[0].problem)
        if best is not None:  # the only cam there is: its values are their own bounds
            problems = [
                formulate_problem(spec, objective, (), tables.segments) for objective in objectives
            ]
            attempt.bounds = [
                Bounded(
                    one.objective,
                    objective_value(one, best.size) * (1.0 - 1e-12),
                    "the one cam given",
                )
                for one in problems
            ]
    if best is not None:
        unreached = objectives[len(attempt.bounds) :]
        attempt.bounds += [Bounded(objective, -inf, "") for objective in unreached]
        splines = {
            segment.index: (law.space, law.coefficients)
            for segment, law in zip(attempt.searches[0].problem.free, best.laws, strict=True)
        }
        known = {segment.index: segment for segment in best.problem.segments}
        whole = tuple(known.get(segment.index, segment) for segment in tables.segments)
        attempt.cam, attempt.best = Cam(whole, {**tables.splines, **splines}, best.size), best
    return attempt
