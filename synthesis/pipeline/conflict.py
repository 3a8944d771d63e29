"""Why nothing fits: an irreducible conflict, and what each number in it would have to be alone.

The pipeline itself is the oracle: a question with some numbers left out or relaxed has a certified
cam, or none was found. So everything named here is shown by a cam, for every follower and limit
alike, and what is claimed to be impossible is what the optimiser has proven.

    1. Deletion filter (Chinneck): leave out one number after the other, for good where the rest
       still has no cam. What remains has none, and has one without any single member.
    2. Each member alone: left out, all others kept. The cam found there says which value suffices;
       a bracket between that and the requested value is narrowed, every end of it tried.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from math import inf, sqrt

from synthesis.catalogue.fields import ends
from synthesis.catalogue.objectives import BaseRadius, Objective, PeakAcceleration, PeakJerk
from synthesis.certify import certify
from synthesis.design.design import Conflict, Relaxation
from synthesis.numerics import clock
from synthesis.pipeline.assembly import restate_problem
from synthesis.pipeline.attempt import Attempt, Goal
from synthesis.pipeline.largest_radius import ANY, Smallest, solve
from synthesis.pipeline.relaxable import Relaxable, relaxable_numbers, relaxed, without
from synthesis.spec.design_spec import DesignSpec
from synthesis.units import DEGREE

DIAGNOSIS_S = 5.0  # for finding out why nothing fits; what is not known by then is said to be so
TOLERANCE = 1e-3  # of a trial for the smallest cam
NEAR_EXCESS = 1e-4  # relative: a base radius this far below its maximum cannot be brought nearer
ACCURACY = 1e-3  # of the way from the requested value: bracket of a sufficient one at the end
ROUNDING = 1e-4  # relative: bracket of a value below which it is not narrowed
WIDE = 4.0  # ratio of a bracket's ends from which on it is halved on a logarithmic scale
CLEARANCE = 0.03  # of the bracket: how near to one of its ends a trial may lie
SPARE = (1e-4, 1e-3, 1e-2)  # relative: above the least value, until a cam has it
SLACK = (0.0, 1e-6, 1e-4, 1e-2, 1.0)  # of the way: added to the value of a cam found without it

OBJECTIVE_OF: dict[str, Objective] = {"acceleration": PeakAcceleration(), "jerk": PeakJerk()}
"""What makes the quantity of a limit small, by the limit's name."""

NEAR = 1e-9  # rad: an extreme at the end of a segment belongs to it

LATE = "the time budget ended before this was known"
ALONE = "no cam was found however far this number alone is relaxed"
SUFFICES = "a cam was found with this value"
DEVIATION = "deviation allowed either way; a cam was found with it"
TOGETHER = "all limits of this name together; a cam was found with this value"


@dataclass(frozen=True, eq=False)
class Trial:
    """What a changed question came to; ``on_time``: whether it was tried to its end.

    ``seconds``: what it took.
    """

    attempt: Attempt
    smallest: Smallest | None
    on_time: bool
    seconds: float = 0.0

    @property
    def certified(self) -> bool:
        """Whether it has a cam."""
        return self.attempt.certified

    @property
    def excess(self) -> float | None:
        """The largest relative excess that is known to be needed; None where none is known.

        That of the smallest cam over the largest base radius, below 0 where it is smaller, or of
        the gentlest law over the limits on the motion.
        """
        if self.smallest is not None:
            return self.smallest.radius / self.smallest.most - 1.0
        searches = self.attempt.searches
        return searches[-1].least_excess if searches else None

    @property
    def proof(self) -> str:
        """Why no cam at all answers the question; empty where that is not proven."""
        if self.smallest is not None and self.smallest.excludes:
            return (
                f"proven: no cam has a base radius below {self.smallest.lower:.6g} mm "
                f"({self.smallest.over})"
            )
        if not self.attempt.searches or self.attempt.numbers:
            return ""
        attempt, question = self.attempt, self.attempt.question
        last = attempt.searches[-1]
        problem = restate_problem(question, question.to_physical(attempt.solved_spec), last.problem)
        if problem.base_circle_conflict or last.infeasibility_proof:
            return problem.base_circle_conflict or last.infeasibility_proof
        if problem.constant_conflict:
            return problem.constant_conflict
        searched = problem.machine.follower.fixable_dimension() is not None
        if last.infeasible and last.relaxed is None and not problem.free and not searched:
            return "proven: no size fits the given laws"
        return ""

    @property
    def undecided(self) -> str:
        """What is known where neither a cam nor a proof that there is none was found."""
        searches = self.attempt.searches
        return searches[-1].undecided if searches else ""


@dataclass(eq=False)
class Oracle:
    """Answers to a question with some of its numbers changed, each asked once."""

    spec: DesignSpec
    stop: float
    known: dict[frozenset[Relaxable], Trial] = field(default_factory=dict)

    def is_late(self) -> bool:
        """Whether nothing more can be tried."""
        return clock.now() >= self.stop

    def ask(
        self, spec: DesignSpec, tolerance: float = 1.0, objective: Objective | None = None
    ) -> Trial:
        """Look for a cam: a small one where the base radius has a maximum, else any.

        A gentle law leaves the size what room there is, and limits on size and curvature ease with
        it; a smallest cam would be sought where they bind.
        """
        low, high = ends(spec.base_radius_mm)
        limited = low < high < inf
        enough = -inf if objective is not None else high if limited else ANY
        objective = objective or (BaseRadius() if limited else PeakAcceleration())
        changes = {
            "objective": objective, "tolerance": TOLERANCE if limited else tolerance,
            "proof": "quick", "report_smoothness_cost": False,
        }  # fmt: skip
        goal = Goal(self.stop, sufficient=enough)
        began = time.perf_counter()
        attempt, smallest = solve(spec.model_copy(update=changes), goal, [])
        on_time = attempt.certified or not self.is_late()
        return Trial(attempt, smallest, on_time, time.perf_counter() - began)

    def without(self, numbers: Collection[Relaxable]) -> Trial:
        """The question without some of its numbers."""
        key = frozenset(numbers)
        if key not in self.known:
            self.known[key] = self.ask(without(self.spec, numbers))
        return self.known[key]

    def seconds_without(self, number: Relaxable) -> float:
        """What the quickest question without this number has taken."""
        known = (trial.seconds for key, trial in self.known.items() if number in key)
        return min(known, default=0.0)

    def least(self, number: Relaxable) -> tuple[float, Trial] | None:
        """The least value of a number that is an objective too, with its cam; None if it is not.

        The question's own least, all other numbers kept, and a little more where that is needed for
        a cam to be found when it is the limit.
        """
        objective = OBJECTIVE_OF.get(number.limit)
        if objective is None:
            return None
        trial = self.ask(without(self.spec, [number]), TOLERANCE, objective)
        reached, _ = _value_on(self.spec, number, trial) if trial.certified else (None, "")
        if reached is None:
            return None
        values = (reached * (1.0 + spare) for spare in SPARE)
        trials = ((value, self.relaxed(number, value, TOLERANCE)) for value in values)
        return next(((value, trial) for value, trial in trials if trial.certified), None)

    def relaxed(self, number: Relaxable, value: float, tolerance: float = 1.0) -> Trial:
        """The question with one number relaxed to a value."""
        return self.ask(relaxed(self.spec, number, value), tolerance)


def explain(attempt: Attempt, smallest: Smallest | None, deadline: float) -> Conflict:
    """Why a question has no cam, and what each of its conflicting numbers would have to be.

    Args:
        attempt: what it came to, without a certified cam.
        smallest: the smallest cam without its maximum of the base radius, where that was sought.
        deadline: ``clock.now()`` at which to stop; what is not known by then is said to be so.
    """
    # 1. The deletion filter, with the pipeline as its oracle.
    asked = Trial(attempt, smallest, True)
    oracle = Oracle(attempt.question.physical, min(deadline, clock.now() + DIAGNOSIS_S))
    numbers = relaxable_numbers(oracle.spec)
    members, shown, complete = _irreducible(oracle, numbers, asked)
    # 2. What each member alone would have to be; first those whose trials have been quick, so that
    #    a slow one takes the time of no other.
    found = {
        number: list(_relaxations(oracle, number, asked))
        for number in sorted(members, key=oracle.seconds_without)
    }
    relaxations = [one for number in members for one in found[number]]
    limits = [str(number) for number in members]
    evidence = _evidence(asked, shown, members, complete)
    # 3. What the certificate refused on the cam at hand, which no member may name.
    refused = [extreme for extreme in attempt.extremes if not extreme.holds]
    if refused:
        values = ", ".join(
            f"{e.limit} {e.evidence if e.value is None else f'{e.value} {e.unit}'} "
            f"at {e.angle_deg:.3f}°"
            for e in refused
        )
        evidence = f"{evidence}; the certificate refused the cam at hand: {values}"
        names = [extreme.limit.replace("_", " ") for extreme in refused]
        limits += [n for n in names if not any(known.startswith(n) for known in limits)]
    return Conflict(limits=limits, relaxations=relaxations, evidence=evidence)


def _irreducible(
    oracle: Oracle, numbers: Sequence[Relaxable], asked: Trial
) -> tuple[list[Relaxable], Trial, bool]:
    """Numbers that have no cam together, the trial that shows it, and whether all were tried."""
    kept, shown = list(numbers), asked
    for number in numbers:
        if oracle.is_late():
            return kept, shown, False
        trial = oracle.without([one for one in numbers if one not in kept or one is number])
        if not trial.on_time:
            return kept, shown, False
        if not trial.certified:  # the others have no cam without it either
            kept.remove(number)
            shown = trial
    return kept, shown, True


def _evidence(asked: Trial, shown: Trial, members: list[Relaxable], complete: bool) -> str:
    """How the conflict is known, and what of it is proven."""
    known = asked.proof or shown.proof or asked.undecided
    parts = [known] if known else []
    if asked.smallest is not None and asked.smallest.radius > asked.smallest.most:
        radius = asked.smallest.radius
        bound = "" if asked.smallest.excludes or asked.smallest.lower <= 0.0 else (
            f", and none below {asked.smallest.lower:.6g} mm is possible ({asked.smallest.over})"
        )  # fmt: skip
        parts.append(f"without base_radius_mm/max a cam of {radius:.6g} mm was found{bound}")
    if not (shown.proof or asked.proof):
        parts.append("no cam was found that keeps these limits; that there is none is not proven")
    if not complete:
        parts.append(LATE)
    elif members:
        parts.append("leaving out any one of those named, a cam was found")
    else:
        parts.append("leaving out all that the spec limits, none was found either")
    spec = asked.attempt.question.physical
    if ends(spec.base_radius_mm)[1] == inf:
        parts.append(f"base radii up to {spec.base_radius_range()[1]:.6g} mm were searched")
    return "; ".join(parts)


def _relaxations(oracle: Oracle, number: Relaxable, asked: Trial) -> Iterator[Relaxation]:
    """What one number alone would have to be, field by field."""
    needed, note = _sufficient(oracle, number, asked)
    tight = [
        (path, requested)
        for path, requested in zip(number.paths, number.requested, strict=True)
        if needed is None or number.is_tighter(requested, needed)
    ]
    for path, requested in tight:
        yield Relaxation(
            limit=number.limit, field=path, unit=number.unit, requested=requested, needed=needed,
            note=TOGETHER if needed is not None and len(tight) > 1 else note,
        )  # fmt: skip


def _sufficient(oracle: Oracle, number: Relaxable, asked: Trial) -> tuple[float | None, str]:
    """A value of one number with which the question has a cam, near the least such value."""
    if oracle.is_late():
        return None, LATE
    # The maximum of the base radius: the smallest cam has the best value there is.
    if number.minimised and asked.smallest is not None:
        return asked.smallest.radius, SUFFICES
    # Without the number, a cam shows a value that suffices; no cam: no value would do.
    if number.dimension:  # its value on the smallest cam, not on any
        trial = oracle.ask(without(oracle.spec, [number]), TOLERANCE, BaseRadius())
    else:
        trial = oracle.without([number])
    if not trial.certified:
        return None, ALONE if trial.on_time else LATE
    reached, note = _value_on(oracle.spec, number, trial)
    if reached is None:
        return None, note
    at_once = bool(note or number.dimension)
    # The least value: an objective of its own where there is one, else the end of a bracket.
    best = oracle.least(number) or _narrowed(oracle, number, reached, asked, at_once=at_once)
    if best is None:
        return None, LATE if oracle.is_late() else ALONE
    value, trial = best
    _, note = _value_on(oracle.spec, number, trial)
    return value, (DEVIATION if number.sense == "±" else SUFFICES) + note


def _narrowed(
    oracle: Oracle, number: Relaxable, reached: float, asked: Trial, *, at_once: bool
) -> tuple[float, Trial] | None:
    """The least value with which a cam is found, to an accuracy, and it; None where none is found.

    ``reached``: the value on a cam that was found without the number; ``at_once``: whether
    a value next to it is tried first, since most likely no other will do. The bracket between the
    requested value and a sufficient one is narrowed by the secant through the excesses of the last
    two trials; where these say nothing, the value is first relaxed step by step, then the bracket
    is halved.
    """
    requested = bad = number.tightest
    best: tuple[float, Trial] | None = None
    points = [] if asked.excess is None else [(bad, asked.excess)]
    slack, misses = iter(SLACK), 0
    while not oracle.is_late():
        end = reached if best is None else best[0]
        near = abs(end - bad) <= max(ACCURACY * abs(end - requested), ROUNDING * abs(end))
        if near and best is not None:
            break
        if near or (bad - end) * (end - requested) > 0.0:
            step = next(slack, None)  # the cam found without the number has no room with it
            if step is None:
                return None
            value = reached + step * (reached - requested or abs(reached))
        elif at_once and best is None and bad == requested:
            value = end + ACCURACY * (requested - end)
        else:
            value = _next_value(points, bad, end, misses, relaxing=best is None)
        trial = oracle.relaxed(number, value)
        if trial.excess is not None:
            points = [*points[-1:], (value, trial.excess)]
        if trial.certified:
            best, misses = (value, trial), 0
            if trial.excess is not None and -trial.excess <= NEAR_EXCESS:
                break  # its smallest cam is as large as allowed
        elif trial.on_time:
            bad, misses = value, misses + (len(points) == 2)
    return best


def _next_value(
    points: Sequence[tuple[float, float]], bad: float, end: float, misses: int, *, relaxing: bool
) -> float:
    """The value to be tried next, between ``bad`` and ``end``.

    Args:
        points: values and relative excesses of the last trials that have one.
        misses: how many secants in a row have ended below the root.
        relaxing: whether no sufficient value is known yet, ``end`` being a guess.
    """
    span = end - bad
    low, high = sorted((bad + CLEARANCE * span, end - CLEARANCE * span))
    if len(points) == 2 and points[0][1] != points[1][1]:
        (first, e), (second, f) = points
        aim = -0.5 * min(NEAR_EXCESS, abs(f))  # a little more than enough
        value = second + (aim - f) * (second - first) / (f - e)
        value = bad + (value - bad) * 2.0**misses  # farther each time that it was not enough
        if (value - bad) * span > 0.0:
            return value if abs(value - bad) < abs(high - bad) else bad + 0.5 * span
    if relaxing:  # in proportion to the excess, or by half
        step = points[0][1] + TOLERANCE if points else 0.5
        value = bad + step * abs(bad) * (1.0 if span > 0.0 else -1.0)
        if low <= value <= high:
            return value
    if bad * end > 0.0 and not 1.0 / WIDE < end / bad < WIDE:
        return sqrt(bad * end) * (1.0 if end > 0.0 else -1.0)
    return bad + 0.5 * span


def _value_on(spec: DesignSpec, number: Relaxable, trial: Trial) -> tuple[float | None, str]:
    """The value that a number would need for a cam that was found without it, and a note on it."""
    attempt, question = trial.attempt, trial.attempt.question
    assert attempt.cam is not None
    built = question.to_physical(attempt.built)
    if number.dimension:
        return built.follower.dimensions(attempt.cam.size)[number.dimension], ""
    motion, machine = attempt.cam.motion, built.machine()
    worst, note = -inf, ""
    for extreme in certify(motion, machine, attempt.cam.size, spec.all_limits(), None):
        if extreme.field != number.claim:
            continue
        if extreme.value is None:
            return None, extreme.evidence
        needed = number.value_needed(extreme.value, extreme.width, extreme.bound)
        if number.is_tighter(worst, needed) or worst == -inf:
            worst, note = needed, _place_note(spec, extreme.angle_deg)
    return (worst, note) if worst > -inf else (None, ALONE)


def _place_note(spec: DesignSpec, angle_deg: float) -> str:
    """Where on the cam a value is needed, if the law there is given."""
    angle = angle_deg * DEGREE
    for s in spec.placed_segments():
        if s.law is not None and s.lift and s.start - NEAR <= angle <= s.end + NEAR:
            return f"; program/{s.index}, whose law is given, needs it"
    return ""
