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
from math import copysign, exp, inf, log

from scipy.optimize import brentq

from synthesis.catalogue.fields import ends
from synthesis.catalogue.objectives import BaseRadius, Objective, PeakAcceleration, PeakJerk
from synthesis.certify import certify
from synthesis.design.design import Conflict, Relaxation
from synthesis.numerics import clock
from synthesis.pipeline.attempt import Attempt, Goal
from synthesis.pipeline.infeasibility import infeasibility_proof
from synthesis.pipeline.largest_radius import ANY, Smallest, solve
from synthesis.pipeline.relaxable import Relaxable, relaxable_numbers, relaxed, without
from synthesis.spec.design_spec import DesignSpec
from synthesis.units import DEGREE

DIAGNOSIS_S = 5.0
"""For finding out why nothing fits, where the spec gives no time of its own; what is not known by
then is said to be so."""
TOLERANCE = 1e-3  # of a trial for the smallest cam
NEAR_EXCESS = 1e-4  # relative: a base radius this far below its maximum cannot be brought nearer
ACCURACY = 1e-3  # of the way from the requested value: bracket of a sufficient one at the end
ROUNDING = 1e-4  # relative: bracket of a value below which it is not narrowed
WIDE = 4.0  # ratio of a bracket's ends from which on it is halved on a logarithmic scale
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
    def strained(self) -> tuple[str, ...]:
        """The limits on the motion that the gentlest law exceeds; empty where size is the cause."""
        searches = self.attempt.searches
        return searches[-1].strained if searches and self.smallest is None else ()

    @property
    def proof(self) -> str:
        """Why no cam at all answers the question; empty where that is not proven."""
        if self.smallest is not None and self.smallest.excludes:
            return (
                f"proven: no cam has a base radius below {self.smallest.lower:.6g} mm "
                f"({self.smallest.over})"
            )
        return infeasibility_proof(self.attempt)


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
        """The question without some of its numbers; a cam that has more of them answers it too."""
        key = frozenset(numbers)
        for removed, trial in self.known.items():
            if removed == key or (removed < key and trial.certified):
                return trial
        return self.known.setdefault(key, self.ask(without(self.spec, numbers)))

    def seconds_without(self, number: Relaxable) -> float:
        """What the quickest question without this number has taken."""
        known = (trial.seconds for key, trial in self.known.items() if number in key)
        return min(known, default=0.0)

    def least(self, number: Relaxable, original: Trial) -> tuple[float, Trial] | None:
        """The least value of a limit on the motion, with its cam; None if that is not known.

        The question's own least, all other numbers kept: from phase 1, or by making it the
        objective; and a little more where a cam with just that as its limit is not found.
        """
        least: float | None = None
        if original.excess is not None and original.strained == (number.limit,):
            least = (1.0 + original.excess) * number.tightest
        elif original.smallest is None and number.limit in OBJECTIVE_OF:
            objective = OBJECTIVE_OF[number.limit]
            trial = self.ask(without(self.spec, [number]), TOLERANCE, objective)
            least = _value_on(self.spec, number, trial)[0] if trial.certified else None
        if least is None:
            return None
        values = (least * (1.0 + spare) for spare in SPARE)
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
    original = Trial(attempt, smallest, True)
    spec = attempt.question.physical
    if spec.time_budget_s is None:
        deadline = min(deadline, clock.now() + DIAGNOSIS_S)
    oracle = Oracle(spec, deadline)
    numbers = relaxable_numbers(oracle.spec)
    members, proof_trial, complete = _irreducible(oracle, numbers, original)
    # 2. What each member alone would have to be; first those whose trials have been quick, so that
    #    a slow one takes the time of no other.
    changes = {
        number: list(_relaxations(oracle, number, original))
        for number in sorted(members, key=oracle.seconds_without)
    }
    relaxations = [one for number in members for one in changes[number]]
    limits = [str(number) for number in members]
    evidence = _evidence(original, proof_trial, members, complete)
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
    proven = bool(original.proof or proof_trial.proof)
    return Conflict(limits=limits, relaxations=relaxations, evidence=evidence, proven=proven)


def _irreducible(
    oracle: Oracle, numbers: Sequence[Relaxable], original: Trial
) -> tuple[list[Relaxable], Trial, bool]:
    """Numbers that have no cam together, the trial that shows it, and whether all were tried."""
    kept, proof_trial = list(numbers), original
    # What phase 1 names may have no cam by itself: then all others go at once.
    named = [number for number in numbers if number.limit in original.strained]
    if 0 < len(named) < len(numbers) and not oracle.is_late():
        trial = oracle.without([number for number in numbers if number not in named])
        if trial.on_time and not trial.certified:
            kept, proof_trial = list(named), trial
            oracle.without(named[:1])  # most likely the conflict: the second step's first trial
    for number in list(kept):
        if oracle.is_late():
            return kept, proof_trial, False
        trial = oracle.without([one for one in numbers if one not in kept or one is number])
        if not trial.on_time:
            return kept, proof_trial, False
        if not trial.certified:  # the others have no cam without it either
            kept.remove(number)
            proof_trial = trial
    return kept, proof_trial, True


def _evidence(original: Trial, proof_trial: Trial, members: list[Relaxable], complete: bool) -> str:
    """How the conflict is known, and what of it is proven."""
    undecided = [search.undecided for search in original.attempt.searches[-1:]]
    known = (original.proof, proof_trial.proof, *undecided)
    parts = [reason for reason in known if reason][:1]
    smallest = original.smallest
    if smallest is not None and smallest.radius > smallest.most:
        bound = "" if smallest.excludes or smallest.lower <= 0.0 else (
            f", and none below {smallest.lower:.6g} mm is possible ({smallest.over})"
        )  # fmt: skip
        size = f"{smallest.radius:.6g} mm"
        parts.append(f"without base_radius_mm/max a cam of {size} was found{bound}")
    if not (proof_trial.proof or original.proof):
        parts.append("no cam was found that keeps these limits; that there is none is not proven")
    if not complete:
        parts.append(LATE)
    elif members:
        parts.append("leaving out any one of those named, a cam was found")
    else:
        parts.append("leaving out all that the spec limits, none was found either")
    spec = original.attempt.question.physical
    if ends(spec.base_radius_mm)[1] == inf and not (proof_trial.proof or original.proof):
        parts.append(f"base radii up to {spec.base_radius_range()[1]:.6g} mm were searched")
    return "; ".join(parts)


def _relaxations(oracle: Oracle, number: Relaxable, original: Trial) -> Iterator[Relaxation]:
    """What one number alone would have to be, field by field."""
    needed, note = _sufficient(oracle, number, original)
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


def _sufficient(oracle: Oracle, number: Relaxable, original: Trial) -> tuple[float | None, str]:
    """The value of a number nearest to the requested one with which a cam was found; a note."""
    if oracle.is_late():
        return None, LATE
    # The maximum of the base radius: the smallest cam has the best value there is.
    if number.minimised and original.smallest is not None:
        return original.smallest.radius, SUFFICES
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
    best = oracle.least(number, original) or _narrow(
        oracle, number, reached, original, at_once=at_once
    )
    if best is None:
        return None, LATE if oracle.is_late() else ALONE
    value, trial = best
    _, note = _value_on(oracle.spec, number, trial)
    return value, (DEVIATION if number.sense == "±" else SUFFICES) + note


def _narrow(
    oracle: Oracle, number: Relaxable, reached: float, original: Trial, *, at_once: bool
) -> tuple[float, Trial] | None:
    """The least value with which a cam is found, to an accuracy, and it; None where none is found.

    The root of the excess, by Brent's method. ``reached``: the value on a cam that was found
    without the number; ``at_once``: whether most likely no other value will do.
    """
    requested = bad = number.tightest
    best: tuple[float, Trial] | None = None

    def excess(value: float) -> float:
        """Above 0 where no cam is found; 0, which ends the search, next to the least value."""
        nonlocal best
        trial = oracle.relaxed(number, value)
        if not trial.on_time:
            raise TimeoutError
        known = None if trial.excess is None else trial.excess + 0.5 * NEAR_EXCESS
        if not trial.certified:
            return known if known is not None and known > 0.0 else 1.0
        best = (value, trial)
        if known is None or known >= 0.0:
            return -1.0 if known is None else 0.0
        return 0.0 if known >= -0.5 * NEAR_EXCESS else known

    known = {requested: max(1.0 if original.excess is None else original.excess, NEAR_EXCESS)}
    way = reached - requested or abs(reached)
    guesses = [reached + beyond * way for beyond in SLACK]  # it may have no room with the number
    step = (known[requested] + TOLERANCE) * abs(requested)
    if original.excess is not None and 0.0 < step < abs(reached - requested):
        guesses.insert(0, requested + copysign(step, way))  # in proportion to the excess
    try:
        # 1. Bracket the least value.
        for end in guesses:
            known[end] = excess(end)
            if known[end] <= 0.0:
                break
            bad = end
        else:
            return None
        # 2. Narrow the bracket, of wide ones the logarithm.
        if known[end] < 0.0 and at_once:
            near = end + ACCURACY * (requested - end)
            known[near] = excess(near)
            if known[near] > 0.0:
                return best
            end = near
        if known[end] < 0.0:
            width = max(ACCURACY * abs(end - requested), ROUNDING * abs(end))
            wide = bad * end > 0.0 and not 1.0 / WIDE < end / bad < WIDE
            at = {log(value / bad) if wide else value: known[value] for value in (bad, end)}
            low, high = at
            brentq(
                lambda x: at[x] if x in at else excess(bad * exp(x) if wide else x),
                low, high, xtol=0.5 * (ACCURACY if wide else width),
            )  # fmt: skip
    except TimeoutError:
        pass  # the best so far
    return best


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
