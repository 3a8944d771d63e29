"""synthesise(spec) -> Design: the whole way through on one page.

    DesignSpec -> Problem -> laws and size -> Motion -> certificate -> Design

The formulations propose, the certificate disposes: a cam that it does not certify is tried again
with limits drawn in a little more, and is never called feasible. One that only crosses itself is
made larger until it does not.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from math import inf

from synthesis import clock
from synthesis.answer import (
    Bounded,
    Cam,
    delivered,
    design,
    in_wire_units,
    judged,
    priced,
    proofs,
    restated,
    with_chosen,
)
from synthesis.certify import CROSSING
from synthesis.design import (
    Conflict,
    Design,
    Extreme,
    Relaxation,
    SmoothnessPrice,
    StageReport,
)
from synthesis.errors import SolverFailed, TimeBudgetExceeded
from synthesis.formulations.cams.candidate import Candidate, given_size, value
from synthesis.formulations.cams.companion import Settled, settled
from synthesis.formulations.cams.smooth import reached
from synthesis.formulations.free_numbers.tables import Tables, smooth_tables
from synthesis.formulations.ladder.polish import FINEST
from synthesis.formulations.ladder.refine import search
from synthesis.formulations.question.problem import Held, calmer, pose
from synthesis.formulations.rounds.neighbour import Neighbour
from synthesis.formulations.rounds.search import Search
from synthesis.limits import Claim
from synthesis.ranges import Range, ends
from synthesis.similitude import Question
from synthesis.spec import DesignSpec

DIAGNOSIS_S = 5.0  # for finding out why nothing fits; what is not known by then is said to be so
FIRST_GROWTH = 0.02  # of the base radius; doubled while the cam crosses itself, then halved
GROWTHS = 16
DRAWN_IN = (1e-7, 1e-6, 1e-5, 1e-4)  # relative amounts by which limits are tightened, in turn


@dataclass(eq=False)
class _Attempt:
    """What one pass over the objectives came to.

    ``posed`` is the question that was solved, ``built`` the spec of the cam that came out: they
    differ from what was asked where something is settled after the size. Like ``best`` and the
    ``bounds`` [core] they are in the question's own units, ``cam`` and ``extremes`` in the wire's.
    """

    posed: DesignSpec
    built: DesignSpec
    searches: list[Search] = field(default_factory=list)
    cam: Cam | None = None
    best: Candidate | None = None
    bounds: list[Bounded] = field(default_factory=list)
    extremes: list[Extreme] = field(default_factory=list)

    @property
    def certified(self) -> bool:
        """Whether there is a cam and every limit holds on it."""
        return self.cam is not None and all(extreme.holds for extreme in self.extremes)

    @property
    def crosses(self) -> bool:
        """Whether nothing is wrong with the cam but that its profile crosses itself."""
        broken = [extreme.limit for extreme in self.extremes if not extreme.holds]
        return bool(broken) and all(limit.startswith(CROSSING) for limit in broken)

    @property
    def hopeless(self) -> bool:
        """Whether drawing the limits in further cannot help."""
        last = self.searches[-1]
        return last.infeasible or not last.problem.free or last.best is None


@dataclass(frozen=True, eq=False)
class Near:
    """What a design leaves to a neighbouring one: its id, and where its local search ended."""

    id: str
    search: Neighbour


def synthesise(spec: DesignSpec, *, deadline: float | None = None) -> Design:
    """Design the cam that a spec asks for.

    Args:
        spec: what is asked.
        deadline: ``time.monotonic()`` at which to stop; the spec's own budget counts as well.

    Returns:
        the design; where nothing fits its status is ``infeasible`` and ``conflict`` says why.

    Raises:
        TimeBudgetExceeded: time ran out before the tolerance was reached; carries the best.
        SolverFailed: no stage gave a usable point, and not even why could be found.
    """
    return synthesise_beside(spec, None, deadline=deadline)[0]


def synthesise_beside(
    spec: DesignSpec, near: Near | None, *, deadline: float | None = None
) -> tuple[Design, Near | None]:
    """The same, begun where a neighbouring design ended, if that helps; and what this one leaves.

    A design that was begun so has ``started_from`` and another id than the spec alone gives: its
    values may differ from that one's, within what its certificate says.

    Raises:
        TimeBudgetExceeded, SolverFailed: as ``synthesise``.
    """
    if spec.load is not None and spec.load.free:
        from synthesis.formulations.free_numbers.sprung import with_spring

        return with_spring(spec, lambda given: synthesise(given, deadline=deadline)), None
    began, now = time.perf_counter(), clock.now()
    budget = min(
        inf if spec.time_budget_s is None else spec.time_budget_s,
        inf if deadline is None else deadline - now,
    )
    stages = list[StageReport]()
    question, numbers = _numbered(Question.of(spec), now + budget, stages)
    tables = smooth_tables(question.natural.stretches(), now + budget)
    stages += [StageReport(**vars(stage)) for stage in tables.stages]
    attempt = _drawn_in(question, tables, now + budget, stages, near)
    if attempt.crosses:
        attempt = _grown(question, tables, attempt, now + budget, stages)
    late = clock.now() >= now + budget
    if not attempt.certified and late:
        raise TimeBudgetExceeded(budget)
    conflict = None if attempt.certified else _conflict(question, attempt)
    built = question.told(attempt.built)
    bounds = in_wire_units(question, attempt.built, attempt.bounds)
    proven = [] if attempt.cam is None else proofs(built, attempt.cam, bounds)
    seconds = time.perf_counter() - began
    found = design(
        built, attempt.cam, attempt.extremes, proven, stages, seconds, conflict
    ).asked_as(question.asked)
    found = with_chosen(found, spec, numbers)
    if spec.price_smoothness:
        price = _price(found, spec, now + budget)
        found = found.model_copy(update={"smoothness_price": price})
    if near is not None and any(tried.from_near for tried in attempt.searches):
        found = found.begun_at(near.id)
    if late and found.status == "feasible":
        raise TimeBudgetExceeded(budget, found)
    behind = attempt.searches[0].left_behind if attempt.searches else None
    return found, None if behind is None else Near(found.id, behind)


def _price(found: Design, question: DesignSpec, stop: float) -> SmoothnessPrice:
    """What splines smoother than C2 cost: the same question for those, solved too."""
    proof, rough = found.certificate, question.roughened()
    if rough is question:
        return priced(proof, proof, "no spline smoother than C2 is asked for")
    if not found.motion or clock.now() >= stop:
        why = "this question has no cam" if not found.motion else "the time budget had ended"
        return priced(proof, None, why)
    try:
        other = synthesise(rough, deadline=stop)
    except TimeBudgetExceeded as error:
        if error.best is None:
            return priced(proof, None, "the time budget ended before there was a C2 cam")
        other = error.best
    except SolverFailed as error:
        return priced(proof, None, str(error))
    if other.status == "infeasible":
        return priced(proof, None, "no C2 cam was certified, although this one is")
    return priced(proof, other.certificate, "")


def _numbered(
    question: Question, stop: float, stages: list[StageReport]
) -> tuple[Question, list[float]]:
    """The question with numbers in place of what it leaves free, and these numbers [wire]."""
    openings = question.asked.openings
    if not openings.free:
        return question, []
    from synthesis.formulations.free_numbers.proportions import chosen

    numbered, _, stage = chosen(question.natural, stop)
    stages.append(StageReport(**vars(stage)))
    found = question.changed(numbered)
    return found, openings.read(found.asked.program, found.asked.follower)


def _drawn_in(
    question: Question,
    tables: Tables,
    stop: float,
    stages: list[StageReport],
    near: Near | None = None,
) -> _Attempt:
    """Attempts with limits drawn in more and more, until the certificate is content with one.

    The first begins at a neighbour's, if there is one: what the certificate refuses was not it.
    """
    for tighten in DRAWN_IN:
        attempt = _attempt(
            question, tables, stop, tighten, near if tighten == DRAWN_IN[0] else None
        )
        for tried in attempt.searches:
            stages += [StageReport(**vars(stage)) for stage in tried.stages]
        settled = attempt.certified or attempt.crosses or attempt.hopeless
        if settled or clock.now() >= stop:
            break
    return attempt


def _grown(
    question: Question, tables: Tables, crossing: _Attempt, stop: float, stages: list[StageReport]
) -> _Attempt:
    """The smallest base radius, by trial, whose cam does not cross itself; else what there was.

    No formulation knows of crossing. The lower bound remains that of the spec as asked, so the
    gap says honestly what the growth has cost; later objectives, which hold what earlier ones
    had reached, keep no bound.
    """
    spec = question.natural
    least, largest = _base_radius(crossing), spec.base_radius_range()[1]
    most, best, step = largest, crossing, FIRST_GROWTH * least
    for _ in range(GROWTHS):
        trial_radius = min(least + step, largest) if best is crossing else 0.5 * (least + most)
        if clock.now() >= stop or trial_radius <= least * (1.0 + 0.1 * spec.tolerance):
            break
        raised = Range(min=trial_radius, max=largest)
        larger = spec.model_copy(update={"base_radius_mm": raised})
        tried = _drawn_in(question.changed(larger), tables, stop, stages)
        if tried.cam is not None and tried.certified:
            built = tried.built.model_copy(update={"base_radius_mm": spec.base_radius_mm})
            extremes = judged(question.asked, tried.cam, question.told(built))
            most, best = _base_radius(tried), replace(tried, built=built, extremes=extremes)
        elif tried.crosses:
            least, step = trial_radius, 2.0 * step
        else:
            break
    if best is crossing:
        return crossing
    first, *later = crossing.bounds
    unknown = [replace(bounded, lower=-inf) for bounded in later]
    return replace(best, bounds=[first, *unknown])


def _base_radius(attempt: _Attempt) -> float:
    assert attempt.best is not None
    return attempt.built.follower.dimensions(attempt.best.size)["base_radius_mm"]


def _attempt(
    question: Question,
    tables: Tables,
    stop: float,
    tighten: float,
    near: Near | None = None,
    *,
    closely: bool = False,
) -> _Attempt:
    """Solve the spec without what is settled after the size, then settle it.

    ``closely``: the latter even where time is over, since its nearest value is what is asked.

    Where no place of a counter roller suits the cam so found, the cam is sought again with the
    farthest place given: the counter cam then has its say in the laws and the size.
    """
    spec = question.natural
    attempt = _solved(spec.alone(), tables, stop, tighten, near)
    if attempt.best is None:
        return attempt
    place = settled(spec, attempt.best, inf if closely else stop)
    if not place.holds:
        first, attempt = attempt, _solved(place.spec, tables, stop, tighten)
        attempt.searches = [*first.searches, *attempt.searches]
        if not place.farthest:
            attempt.bounds = first.bounds  # another place might suit better: those hold for all
        place = Settled(place.spec, True)
    attempt.built = place.spec
    if attempt.cam is not None:
        attempt.cam = delivered(question, attempt.posed, attempt.cam)
        attempt.extremes = judged(question.asked, attempt.cam, question.told(place.spec))
    return attempt


def _solved(
    spec: DesignSpec, tables: Tables, stop: float, tighten: float, near: Near | None = None
) -> _Attempt:
    """Work through the objectives in order; each keeps what the ones before have reached."""
    attempt = _Attempt(spec, spec)
    held: tuple[Held, ...] = ()
    objectives = spec.objectives()
    best: Candidate | None = None
    for rank, objective in enumerate(objectives, start=1):
        share = spec.tolerance if rank == len(objectives) else 0.5 * spec.tolerance
        problem, thorough = pose(spec, objective, held, tables.stretches), spec.proof == "thorough"
        if spec.tolerance <= FINEST:
            problem = calmer(problem)
        start = near.search if near is not None and rank == 1 else None
        tried = search(problem, share, stop, tighten, thorough=thorough, near=start)
        attempt.searches.append(tried)
        if tried.best is None:
            break
        best = tried.best
        attempt.bounds.append(Bounded(objective, tried.lower, tried.over))
        if rank < len(objectives):
            held = (*held, Held(objective, tried.keepable(spec.tolerance)))
    if best is None:
        best = given_size(attempt.searches[0].problem)
        if best is not None:  # the only cam there is: its values are their own bounds
            posed = [pose(spec, objective, (), tables.stretches) for objective in objectives]
            attempt.bounds = [
                Bounded(one.objective, value(one, best.size) * (1.0 - 1e-12), "the one cam given")
                for one in posed
            ]
    if best is not None:
        unreached = objectives[len(attempt.bounds) :]
        attempt.bounds += [Bounded(objective, -inf, "") for objective in unreached]
        splines = {
            stretch.index: (law.space, law.coefficients)
            for stretch, law in zip(attempt.searches[0].problem.free, best.laws, strict=True)
        }
        known = {stretch.index: stretch for stretch in best.problem.stretches}
        whole = tuple(known.get(stretch.index, stretch) for stretch in tables.stretches)
        attempt.cam, attempt.best = Cam(whole, {**tables.splines, **splines}, best.size), best
    return attempt


def _conflict(question: Question, attempt: _Attempt) -> Conflict:
    """Why nothing fits, with what the largest cam of the relaxation comes to: in wire units."""
    from synthesis.formulations.conflict.elastic import diagnose

    last, posed = attempt.searches[-1], question.told(attempt.posed)
    problem = restated(question, posed, last.problem)

    def largest(claim: Claim) -> float | None:
        follower = last.problem.machine.follower
        if last.relaxed is None or claim.quantity != "pitch_curvature":
            return None
        if claim.path in follower.companions:  # a larger main cam leaves it no more room
            return None
        low, high = reached(last.relaxed.problem, last.relaxed.size, claim.path)
        return (high if claim.upper is not None else low) / question.units.length

    until = min(last.deadline, clock.now() + DIAGNOSIS_S)
    found = diagnose(posed, problem, last.grids, largest, until)
    known = problem.cramped or last.impossible or last.undecided
    if known:
        found = found.model_copy(update={"evidence": f"{known}; {found.evidence}"})
    farther = _farther(question.asked, until)
    found = found.model_copy(update={"relaxations": [*found.relaxations, *farther]})
    refused = [e for e in attempt.extremes if not e.holds]
    if not refused:
        return found
    words = ", ".join(f"{e.limit} {e.value} {e.unit} at {e.angle_deg:.3f}°" for e in refused)
    evidence = f"{found.evidence}; the certificate refused the cam at hand: {words}"
    named = (e.limit.replace("_", " ") for e in refused)
    new = [name for name in named if not any(known.startswith(name) for known in found.limits)]
    return found.model_copy(update={"evidence": evidence, "limits": [*found.limits, *new]})


def _farther(spec: DesignSpec, until: float) -> list[Relaxation]:
    """Where a counter roller would have to stand for the cam that is best without it."""
    opened = spec.opened()
    if opened == spec:
        return []
    question = Question.of(opened)
    tables = smooth_tables(question.natural.stretches(), until)
    attempt = _attempt(question, tables, until, DRAWN_IN[0], closely=True)
    if not attempt.certified or attempt.cam is None:
        return []
    built = question.told(attempt.built)
    told, found = built.follower.dimensions(attempt.cam.size), list[Relaxation]()
    for place, (name, asked) in spec.follower.companion_ranges().items():
        low, high = ends(asked)
        if high < told[name]:
            found.append(
                Relaxation(
                    limit=name.rpartition("_")[0],
                    field=f"follower/{place}" + ("" if low == high else "/max"),
                    unit=name.rpartition("_")[2], asked=high, needed=told[name],
                    note="enough for the cam that is best without the counter cam",
                )
            )  # fmt: skip
    return found
