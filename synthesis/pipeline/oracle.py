"""Changed questions put to the pipeline: the oracle of whoever explains why a question has no cam.

Each trial is a whole question, solved and certified. So what it shows holds for every follower and
limit alike: a certified cam, or a proof that there is none, or neither.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from math import inf, isfinite

from pydantic import ValidationError

from synthesis.catalogue.objectives import BaseRadius, Objective, PeakAcceleration
from synthesis.certify import certify, certify_size
from synthesis.numerics import clock
from synthesis.pipeline.assembly import Bounded, in_wire_units
from synthesis.pipeline.attempt import Attempt, prepare, unsolved
from synthesis.pipeline.goal import AUTO_SHARE, Goal
from synthesis.pipeline.infeasibility import (
    contains_angle,
    gentlest_law,
    infeasibility_proof,
    mean_velocity_excess,
)
from synthesis.pipeline.largest_radius import (
    ANY,
    FINEST,
    ROUNDING,
    Smallest,
    above,
    compare,
    excluding_gap,
    first_question,
    minimises_radius,
)
from synthesis.pipeline.relaxable import Relaxable, relaxed, without
from synthesis.spec.design_spec import DesignSpec

COARSEST, COARSE = 1.0, 1e-3  # tolerance of a trial for any cam, and for one near a limit
FINE = 1e-4  # tolerance of a trial that is to bring both ends of a boundary near to each other
ON_KNOTS = 1e-2  # relative: of a bound on a neighbour's knots; the cam is a hundred times nearer
FAR_BELOW = 0.1  # of its maximum: by how much smaller a cam is than those next to it
QUICK: dict[str, object] = {"proof": "quick", "report_smoothness_cost": False}
ALONE = "no cam was found however far this number alone is relaxed: others may conflict as well"


@dataclass(frozen=True, eq=False)
class Trial:
    """What a changed question came to; ``on_time``: whether it was tried to its end."""

    attempt: Attempt
    smallest: Smallest | None
    on_time: bool

    @property
    def certified(self) -> bool:
        """Whether it has a cam."""
        return self.attempt.certified

    @property
    def excess(self) -> float | None:
        """The smallest relative excess that was reached; None where none is known.

        That of the smallest cam over the largest base radius, below 0 where it is smaller, or of
        the gentlest law over the limits on the motion. Of a cam that only the maximum as a
        constraint has led to, none: the smallest one that was found without it is larger.
        """
        smallest = self.smallest
        if smallest is not None and (smallest.radius <= smallest.most or not self.certified):
            return smallest.radius / smallest.most - 1.0
        known = next((each.least_excess for each in self.attempt.searches[-1:]), None)
        if known is not None or self.certified or not self.attempt.searches:
            return known
        mean = mean_velocity_excess(self.attempt)
        if mean is not None:
            return mean
        gentlest = gentlest_law(self.attempt)
        return None if gentlest is None or gentlest.fits else gentlest.share - 1.0

    @property
    def bound_excess(self) -> float | None:
        """An excess below which there is no cam at all; None where none is known."""
        if self.smallest is None:
            return self.excess if self.proof else None
        known = self.smallest.is_bounded and isfinite(self.smallest.lower)
        return self.smallest.lower / self.smallest.most - 1.0 if known else None

    @property
    def strained(self) -> tuple[str, ...]:
        """The limits on the motion that the gentlest law exceeds; empty where size is the cause."""
        searches = self.attempt.searches
        return searches[-1].strained if searches and self.smallest is None else ()

    @property
    def lower(self) -> float | None:
        """The least value of the first objective [wire]; None where it is not known for all cams.

        Bounds at numbers that were chosen, or over splines on some knots, are left out.
        """
        attempt = self.attempt
        if attempt.chosen_values or not all(each.covers_all_laws for each in attempt.searches[:1]):
            return None
        bounds = in_wire_units(attempt.question, attempt.final_spec, attempt.bounds[:1])
        return next((each.lower for each in bounds if isfinite(each.lower)), None)

    @property
    def proof(self) -> str:
        """Why no cam at all answers the question; empty where that is not proven."""
        if self.smallest is not None and self.smallest.excludes:
            return (
                f"proven: no cam has a base radius below {self.smallest.lower:.6g} mm "
                f"({self.smallest.valid_for})"
            )
        return "" if self.certified else infeasibility_proof(self.attempt)


def relative_gap(excess: float, bound_excess: float) -> float:
    """Between a smallest cam and its bound, of the cam; excesses are relative to the maximum."""
    return (excess - bound_excess) / (1.0 + excess)


def gap_left_by(trial: Trial, tolerance: float) -> float:
    """A gap of a trial that is wider than its tolerance, relative; 0 where it has none.

    That of a cam far below its maximum, as near an infimum of 0, says nothing of gaps at it.
    """
    if trial.excess is None or trial.bound_excess is None or trial.excess < -FAR_BELOW:
        return 0.0
    gap = relative_gap(trial.excess, trial.bound_excess)
    return gap if gap > max(tolerance, FINE) else 0.0


def missing_excess(trial: Trial) -> float:
    """By how much an excess is too large for another's search to find a cam; 0 where it is unknown.

    That may end as far from the bound as this one, but no farther than the finest tolerance.
    """
    if trial.excess is None:
        return 0.0
    bound = trial.bound_excess
    gap = FINEST if bound is None else min(relative_gap(trial.excess, bound), FINEST)
    return max(trial.excess + gap, 0.0)


@dataclass(eq=False)
class Oracle:
    """Answers to a question with some of its numbers changed.

    Attributes:
        spec: the question, with the numbers that were chosen for those it leaves free.
        asked: the question as it stands.
        stop: ``clock.now()`` after which nothing more is tried. last_program: the same, counted in
            programs that are solved.
        open_gap: relative, what quick proofs have left between a smallest cam and its bound for
            all the tolerance that was asked.
        has_longer_proofs: whether longer ones follow where that is so.
    """

    spec: DesignSpec
    asked: DesignSpec
    stop: float
    last_program: float = inf
    open_gap: float = 0.0
    has_longer_proofs: bool = False
    known: dict[frozenset[Relaxable], Trial] = field(default_factory=dict)

    def is_late(self) -> bool:
        """Whether nothing more can be tried."""
        return clock.now() >= self.stop or clock.programs_solved() >= self.last_program

    def ask(
        self, spec: DesignSpec, tolerance: float = COARSEST, objective: Objective | None = None,
        near: Trial | None = None, *, exactly: bool = False, enough: float = 0.0,
        cam_only: bool = False, proof: str = "quick",
    ) -> Trial:  # fmt: skip
        """Look for a cam: a small one where the base radius has a maximum, else any.

        For any cam the peak acceleration is minimised, since a law of little acceleration leaves
        limits on size and curvature the most slack; a smallest cam is sought where they bind.
        ``near``: what a question came to that differs little. ``exactly``: whether a smallest cam
        is sought to the tolerance though any that is small enough would do. ``enough``: else, by
        how much, relatively, a cam that ends the search may exceed the maximum. ``cam_only``:
        whether the bound is of no use. ``proof``: how far that there is none is sought; a longer
        one than the quick one ends where its bound excludes the maximum.
        """
        low, high = spec.requested_radii()
        limited = low < high < inf
        any_other = high * (1.0 + enough) if limited else ANY
        sufficient = -inf if objective is not None or (limited and exactly) else any_other
        objective = objective or (BaseRadius() if limited else PeakAcceleration())
        tolerance = min(tolerance, COARSE) if limited and proof == "quick" else tolerance
        mesh = () if near is None or near.smallest is None else near.attempt.mesh(tolerance)
        if mesh and not exactly:  # a cam next to the best comes first, whatever the bound
            tolerance = max(tolerance, ON_KNOTS)
        changes = {**QUICK, "objective": objective, "tolerance": tolerance, "proof": proof}
        bound = above(high) if limited and proof != "quick" else inf
        goal = Goal(
            self.stop, sufficient=sufficient, sufficient_bound=bound, mesh=mesh, cam_only=cam_only
        )
        return self._trial(*compare(spec.model_copy(update=changes), goal, []))

    def ask_as_it_stands(
        self, number: Relaxable, value: float, proof: str, *, cam_only: bool = False
    ) -> Trial:
        """Put the question as anyone would who sends a value, with the spec's proof or a quick one.

        A certified cam shows that the value suffices. The search for it may end with the first.

        What is free stays so: another number may be chosen for it than for the question. Where the
        smallest cam is too large, no smaller one is sought with the maximum as a constraint: by how
        much it is too large says which value to try next.
        """
        spec, stop = relaxed(self.asked, number, value), self.stop
        if proof == "auto" and spec.time_budget_s is not None:
            # The same search as a thorough one that has its part of the time.
            proof, stop = "thorough", min(stop, clock.now() + AUTO_SHARE * spec.time_budget_s)
        most, goal = spec.requested_radii()[1], Goal(stop, cam_only=cam_only)
        if most < inf and minimises_radius(spec):
            # A cam that is small enough ends it, unless it is made better by a later objective; of
            # a longer proof, that there is none does too.
            enough = most if len(spec.objectives()) == 1 else -inf
            bound = inf if proof == "quick" else above(most)
            goal = replace(goal, sufficient=enough, sufficient_bound=bound)
        changes = {**QUICK, "proof": proof}
        trial = self._trial(*compare(spec.model_copy(update=changes), goal, [], finer=True))
        if cam_only and trial.certified and missing_excess(trial) > 0.0:
            # Nearer to its maximum than the finest tolerance tells: a search that has a bound to
            # close ends elsewhere, and perhaps beyond. It is that of anyone who sends the value.
            return self.ask_as_it_stands(number, value, proof)
        return trial

    @property
    def left(self) -> float:
        """Programs that are left where those are counted, else seconds."""
        if self.last_program < inf:
            return self.last_program - clock.programs_solved()
        return self.stop - clock.now()

    def share(self, parts: float) -> Oracle:
        """The same oracle with an equal part of the time and the programs that are left.

        What one part leaves is shared by the parts after it.
        """
        now, solved = clock.now(), clock.programs_solved()
        stop = now + (self.stop - now) / parts
        return replace(self, stop=stop, last_program=solved + (self.last_program - solved) / parts)

    def _trial(self, attempt: Attempt, smallest: Smallest | None) -> Trial:
        return Trial(attempt, smallest, attempt.certified or not self.is_late())

    def without(self, numbers: Collection[Relaxable]) -> Trial:
        """The question without some of its numbers; a cam that has more of them answers it too.

        A cam is sought, and what proof that there is none the relaxation gives besides.
        """
        key = frozenset(numbers)
        for removed, trial in self.known.items():
            if removed == key or (removed < key and trial.certified):
                return trial
        return self.known.setdefault(key, self.ask(without(self.spec, numbers), cam_only=True))

    def proven_without(self, numbers: Collection[Relaxable]) -> Trial:
        """The same question once more, with the spec's own proof."""
        known, spec = self.without(numbers), without(self.spec, numbers)
        if known.certified or known.proof or self.is_late():
            return known
        tolerance = spec.tolerance
        if known.smallest is not None and known.excess:
            tolerance = max(excluding_gap(known.excess), FINEST)
        trial = self.ask(spec, tolerance, exactly=True, proof=spec.proof)
        self.known[frozenset(numbers)] = trial if trial.certified or trial.proof else known
        return self.known[frozenset(numbers)]

    def relaxed(
        self, number: Relaxable, value: float, tolerance: float, near: Trial | None = None, *,
        exactly: bool, enough: float = 0.0, proof: str = "quick",
    ) -> Trial:  # fmt: skip
        """The question with one number relaxed to a value; its cam is one without the number."""
        changed = relaxed(self.spec, number, value)
        trial = self.ask(
            changed, tolerance, near=near, exactly=exactly, enough=enough, proof=proof,
            cam_only=not exactly and proof == "quick",
        )  # fmt: skip
        if trial.certified:
            self.known.setdefault(frozenset([number]), trial)
        return trial

    def bound_excess(self, trial: Trial, number: Relaxable, value: float) -> float:
        """A trial's ``bound_excess`` with another value of a number, by the same multipliers.

        −∞ where they say nothing: where no size is bounded, or by other means than by one program.
        """
        attempt, smallest = trial.attempt, trial.smallest
        if smallest is None or attempt.chosen_values:
            return -inf
        changes = {"objective": BaseRadius(), "tolerance": attempt.solved_spec.tolerance}
        spec = relaxed(self.spec, number, value)
        other = prepare(first_question(spec.model_copy(update=changes)), Goal(self.stop), [])
        # The place of a counter roller is fixed after the size: it is no part of the first search.
        other, objective = unsolved(other, other.solved_spec.without_deferred()), BaseRadius()
        problem = other.problem(objective, (), Goal(inf).smallest)
        lower = attempt.searches[0].bound_of_neighbour(problem)
        (bounded,) = in_wire_units(
            other.question, other.final_spec, [Bounded(objective, lower, "")]
        )
        return bounded.lower / spec.requested_radii()[1] - 1.0 - ROUNDING

    def is_valid(self, number: Relaxable, value: float) -> bool:
        """Whether a spec may have this value of a number, which is not beyond the farthest one."""
        farthest = number.farthest
        if farthest is not None and number.direction * (value - farthest) > 0.0:
            return False
        try:
            DesignSpec.model_validate(relaxed(self.asked, number, value).model_dump())
        except ValidationError:
            return False
        return True

    def value_on(self, number: Relaxable, trial: Trial) -> tuple[float | None, str]:
        """The value that a number would need for a trial's cam, and a note on it.

        None where no value would do.
        """
        attempt, question = trial.attempt, trial.attempt.question
        if attempt.cam is None or not (number.claim or number.dimension):
            return None, ""  # the smallest cam is the value itself; a cam has no such quantity
        final_spec = question.to_physical(attempt.final_spec)
        if number.dimension:
            room = certify_size(self.spec, attempt.cam.size, final_spec.follower)
            known = final_spec.follower.dimensions(attempt.cam.size)[number.dimension]
            claimed = (e.value for e in room if number.claim and e.field == number.claim)
            return next(claimed, known), ""
        motion, machine = attempt.cam.motion, final_spec.machine()
        worst, note = -inf, ""
        for extreme in certify(motion, machine, attempt.cam.size, self.spec.all_limits(), None):
            if extreme.field != number.claim:
                continue
            if extreme.value is None:
                return None, extreme.evidence
            needed = number.value_needed(extreme.value, extreme.width, extreme.bound)
            if number.is_tighter(worst, needed) or worst == -inf:
                worst, note = needed, _place_note(question.physical, extreme.angle_deg)
        return (worst, note) if worst > -inf else (None, ALONE)


def _place_note(spec: DesignSpec, angle_deg: float) -> str:
    """Where on the cam a value is needed, if the law there is given."""
    for s in spec.placed_segments():
        if s.law is not None and s.lift and contains_angle(s, angle_deg):
            return f"; program/{s.index}, whose law is given, needs it"
    return ""
