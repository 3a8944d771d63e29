"""A maximum of the base radius: compared with the smallest cam instead of constraining the search.

An upper bound on the objective cuts off no optimum: minimising the base radius with a maximum has
the same optimal cams as without it, or none. So the question is solved without the maximum, and
value and lower bound of the answer are compared with it.

    value ≤ maximum        the answer stands
    lower bound > maximum  infeasible, proven over what the bound covers
    otherwise              the optimiser is asked again, the maximum a constraint

Where something else is made small, or the base radius is fixed, the constraint stays in the search,
and the smallest cam is sought where that finds none (a phase 1): one that is small enough is a cam
for the question, and the start of another search. Where the base radius is fixed and nothing else
is made small, phase 1 comes first, with the proof that is asked for: any cam that is small enough
ends it. At the fixed radius itself a search has no room left where that radius is the smallest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

from synthesis.catalogue.constraints import enlarged
from synthesis.catalogue.fields import Range, ends
from synthesis.catalogue.followers import AnyFollower
from synthesis.catalogue.objectives import BaseRadius, PeakAcceleration
from synthesis.certify import certify_size
from synthesis.design.design import Effort
from synthesis.numerics import clock
from synthesis.pipeline.assembly import Bounded, Cam, certify_cam, in_wire_units
from synthesis.pipeline.attempt import Attempt, prepare, solve_and_certify, with_bound_of
from synthesis.pipeline.goal import Goal
from synthesis.pipeline.infeasibility import infeasibility_proof
from synthesis.pipeline.radius_search import approach_infimum, enlarge_until_simple, solve_spec
from synthesis.spec.design_spec import DesignSpec

ROUNDING = 1e-9  # relative: what a bound must lie above the maximum by to exclude every cam
ROUNDING_DOWN = 1e-12  # relative: a bound that is a number of the question itself
ENOUGH = 0.5  # of the way from a smallest cam to its maximum: a bound there lies above the latter
FINER, FINEST = 0.1, 1e-6  # of the tolerance from one solve to the next, and its least
FINDABLE = 10.0  # of the tolerance: by so much a finer one may find a smaller cam
LEAST_ACCELERATION = (1.0, 1e-3)  # tolerances of that search: on few knots, then on many
ANY = 1e300  # a value of an objective that every cam has
SECANT_STEPS = 8  # for the size with a given base radius: it is almost linear in the size


def excluding_gap(excess: float) -> float:
    """A gap, relative to the smallest cam, whose bound lies above the maximum.

    ``excess``: by how much, relative to the maximum, that cam is larger.
    """
    return ENOUGH * excess / (1.0 + excess)


def above(most: float) -> float:
    """A lower bound of the base radius that excludes every cam with a maximum [mm]."""
    return most * (1.0 + 2.0 * ROUNDING)


@dataclass(frozen=True, eq=False)
class Smallest:
    """The smallest cam found without the maximum, as an answer to the question with it.

    Attributes:
        attempt: its certificate is that of the question with the maximum.
        radius: its base radius. most: the maximum [mm].
        lower: no cam has a smaller base radius [mm], −inf where that is not known. valid_for: the
            cams that this covers.
    """

    attempt: Attempt
    radius: float
    most: float
    lower: float
    valid_for: str

    @property
    def is_bounded(self) -> bool:
        """Whether no cam at all is smaller than the lower bound.

        A bound at numbers that were chosen says nothing of other numbers, one over splines on some
        knots nothing of other laws, and one above a cam is none.
        """
        known = not self.attempt.chosen_values or self.attempt.number_bound is not None
        sound = known and self.lower <= self.radius * (1.0 + ROUNDING)
        return sound and all(search.covers_all_laws for search in self.attempt.searches[:1])

    @property
    def excludes(self) -> bool:
        """Whether the lower bound proves that no cam is as small as the maximum asks."""
        return self.is_bounded and self.lower > self.most * (1.0 + ROUNDING)


def first_question(spec: DesignSpec) -> DesignSpec:
    """The question to begin with: without its maximum of the base radius, if that is minimised."""
    wider = _without(spec, "max") if minimises_radius(spec) else None
    return wider or spec


def solve_with_maximum(
    spec: DesignSpec, goal: Goal, stages: list[Effort]
) -> tuple[Attempt, Smallest | None]:
    """Solve a question, its maximum of the base radius treated as described above.

    Args:
        spec: what is asked. goal: when to stop. stages: appended to.

    Returns:
        what came out, and the smallest cam without the maximum where that was sought.
    """
    return complete(spec, *first_attempt(spec, goal, stages), goal, stages)


def first_attempt(
    spec: DesignSpec, goal: Goal, stages: list[Effort]
) -> tuple[Attempt, list[Smallest | None]]:
    """What the first question comes to, and the smallest cam of phase 1 where that came before.

    Args:
        spec: what is asked. goal: when to stop. stages: appended to.

    Returns:
        the attempt, and a list: of that cam, None where none was found; empty without a phase 1.
    """
    (least, most), known = spec.requested_radii(), list[Smallest | None]()
    if least == most and all(each.kind == "base_radius" for each in spec.objectives()):
        # Every cam of the fixed radius is a best one: any that is as small will do.
        wider, enough = _wider_questions(spec)[0], replace(goal, sufficient=most, warm_start=None)
        known = [smallest := _smallest(spec, solve_spec(wider, enough, stages))]
        if smallest is not None and smallest.attempt.certified:
            return smallest.attempt, known
    first = first_question(spec)
    if first is not spec:
        goal = replace(goal, excluding_bound=above(most))
    return solve_and_certify(prepare(first, goal, stages), goal, stages), known


def compare(
    spec: DesignSpec, goal: Goal, stages: list[Effort], *, finer: bool = False
) -> tuple[Attempt, Smallest | None]:
    """As ``solve_with_maximum``, but a smallest cam that is too large ends it, best or not.

    For whoever wants to know by how much it is too large. ``finer``: if a finer tolerance finds no
    smaller one either. Then a cam that is found here is found by ``solve_with_maximum`` too.
    """
    first, known = first_attempt(spec, goal, stages)
    if first_question(spec) is not spec:
        first = enlarge_until_simple(first, goal, stages)
        smallest = _smallest(spec, first)
        if finer:
            smallest = _decided(spec, first_question(spec), smallest, goal, stages)
        if smallest is not None:
            return smallest.attempt, smallest
    return complete(spec, first, known, goal, stages)


def complete(
    spec: DesignSpec, first: Attempt, known: list[Smallest | None], goal: Goal, stages: list[Effort]
) -> tuple[Attempt, Smallest | None]:
    """Make the answer to a question of what its first question came to.

    Args:
        first, known: as ``first_attempt`` returns them. All else is as of ``solve_with_maximum``.
    """
    # 1. A cam that crosses itself is made larger; one as small as any that is sought, smaller.
    attempt = approach_infimum(enlarge_until_simple(first, goal, stages), goal, stages)
    limited, minimised = _without(spec, "max") is not None, minimises_radius(spec)
    smallest, most = None, ends(spec.base_radius_mm)[1]
    # 2. The smallest cam without the maximum, and its bound, compared with it: the answer, or the
    #    proof that there is none; else the maximum is a constraint of the search.
    if limited and minimised:
        smallest = _smallest(spec, attempt)
        smallest = _decided(spec, first_question(spec), smallest, goal, stages)
        if smallest is not None and (smallest.attempt.certified or smallest.excludes):
            return smallest.attempt, smallest
        if clock.now() >= goal.stop:
            return smallest.attempt if smallest is not None else attempt, smallest
        goal = replace(goal, warm_start=None)  # its cam, if there is one, is too large
        attempt = solve_spec(spec, goal, stages)
    # 3. Phase 1: any cam that is small enough will do, whatever the objective.
    elif limited and not attempt.certified and not infeasibility_proof(attempt):
        nearest = Goal(goal.stop, sufficient=most, cam_only=goal.cam_only)
        for number, open_spec in enumerate(_wider_questions(spec)):
            if number < len(known):
                found = known[number]
            elif clock.now() < goal.stop:
                found = _smallest(spec, solve_spec(open_spec, nearest, stages))
            else:
                break
            smallest = _decided(spec, open_spec, found, nearest, stages) or smallest
            if smallest is not None and smallest.excludes:
                return attempt, smallest
            if smallest is not None and smallest.attempt.certified:
                return _restart_from(spec, smallest, goal, stages), smallest
    # 4. A cam of the least peak acceleration, where none was found.
    attempt = _with_least_acceleration(spec, attempt, goal, stages)
    if minimised and smallest is not None and smallest.is_bounded:
        attempt = with_bound_of(first, attempt)
    informs = minimised or (smallest is not None and smallest.radius > most)
    return attempt, smallest if informs else None  # of what the maximum costs


def _decided(
    spec: DesignSpec, wider: DesignSpec, smallest: Smallest | None, goal: Goal, stages: list[Effort]
) -> Smallest | None:
    """The smallest cam, with ever finer tolerances while the maximum lies between bound and cam.

    By quick proofs, where these close the gap; where they do not, or nodes have closed it, by the
    spec's own, each in half of the time that is left. ``wider``: the question without the maximum.
    """
    tolerance, proof = spec.tolerance, "quick"
    while smallest is not None and clock.now() < goal.stop:
        known, excess = smallest.attempt, smallest.radius / smallest.most - 1.0
        gap = 1.0 - smallest.lower / smallest.radius
        decided = known.certified or smallest.excludes or excess <= 0.0
        if decided or not smallest.is_bounded or (known.chosen_values and goal.stop == inf):
            break  # each search over numbers takes as many programs again
        nodes = [stage.nodes for search in known.searches[:1] for stage in search.stages]
        is_near = 1.0 - smallest.most / smallest.radius <= FINDABLE * tolerance
        longer = spec.proof != "quick" and not known.chosen_values  # over numbers it takes too long
        by_nodes = longer and (proof != "quick" or any(nodes))
        may_be_finer = tolerance > FINEST and (gap <= tolerance if by_nodes else is_near)
        if may_be_finer:
            tolerance, proof = max(tolerance * FINER, FINEST), spec.proof if by_nodes else "quick"
        elif longer and not by_nodes and gap <= spec.tolerance and tolerance < spec.tolerance:
            tolerance, proof = max(excluding_gap(excess), FINEST), spec.proof
        else:
            break
        if proof != "quick":
            goal = replace(goal, stop=clock.now() + 0.5 * (goal.stop - clock.now()))
        finer = wider.model_copy(update={"tolerance": tolerance, "proof": proof})
        # Its laws are next to the best: on their knots one that is small enough is found at once.
        alone, most = len(finer.objectives()) == 1, smallest.most
        near = replace(
            goal, warm_start=None, mesh=known.mesh(FINEST), sufficient=most if alone else -inf,
            sufficient_bound=inf if proof == "quick" else above(most), excluding_bound=above(most),
        )  # fmt: skip
        smallest = _smaller(smallest, _smallest(spec, solve_spec(finer, near, stages)))
    return smallest


def _smaller(known: Smallest, other: Smallest | None) -> Smallest:
    """The smaller of two cams, with the better bound of both.

    On a finer mesh a cam may be farther from the best: the solver's last digits are lost there.
    """
    if other is None:
        return known
    better, worse = (known, other) if other.radius > known.radius else (other, known)
    if not worse.is_bounded or (better.is_bounded and worse.lower <= better.lower):
        return better
    attempt = better.attempt
    if attempt.chosen_values:  # bounds at single numbers are of other ones than those of this cam
        attempt = replace(attempt, number_bound=worse.attempt.number_bound)
    else:
        attempt = with_bound_of(worse.attempt, attempt)
    return replace(better, attempt=attempt, lower=worse.lower, valid_for=worse.valid_for)


def minimises_radius(spec: DesignSpec) -> bool:
    """Whether the base radius is minimised first, and not given."""
    least, most = spec.requested_radii()
    return spec.objectives()[0].kind == "base_radius" and least < most


def _with_least_acceleration(
    spec: DesignSpec, known: Attempt, goal: Goal, stages: list[Effort]
) -> Attempt:
    """What came out, or a cam of the least peak acceleration where none was found or excluded.

    The best cam strains limits that no relaxation states, and may be refused for them. A law of
    little acceleration leaves the size the most slack. Bounds remain those known.
    """
    if known.certified or known.crosses_itself or known.chosen_values or infeasibility_proof(known):
        return known
    if spec.objectives()[0].kind == "peak_acceleration" or clock.now() >= goal.stop:
        return known
    if any(search.least_excess for search in known.searches):  # phase 1 found no law
        return known
    for tolerance in LEAST_ACCELERATION:
        changes = {"objective": PeakAcceleration(), "tolerance": tolerance, "proof": "quick"}
        changed = spec.model_copy(update=changes)
        other = solve_spec(changed, Goal(goal.stop, sufficient=ANY), stages)
        if other.certified:
            break
    else:
        return known
    unknown = [Bounded(each, -inf, "") for each in known.question.scaled.objectives()]
    other = replace(other, question=known.question, bounds=unknown)
    return with_bound_of(known, other)


def _wider_questions(spec: DesignSpec) -> list[DesignSpec]:
    """Questions for the smallest cam: without either end of the base radius, and with its least."""
    wider = (_without(spec, "min", "max"), _without(spec, "max"))
    questions = [each for each in wider if each is not None]
    if len(questions) == 2 and questions[0].base_radius_mm == questions[1].base_radius_mm:
        del questions[1]
    return [each.model_copy(update={"objective": BaseRadius()}) for each in questions]


def _restart_from(
    spec: DesignSpec, smallest: Smallest, goal: Goal, stages: list[Effort]
) -> Attempt:
    """The question solved from the smallest cam on; that cam itself where this finds none."""
    behind = smallest.attempt.searches[0].local_optimum
    alone = all(objective.kind == "base_radius" for objective in spec.objectives())
    if alone or behind is None or smallest.attempt.chosen_values or clock.now() >= goal.stop:
        return smallest.attempt
    again = solve_spec(spec, replace(goal, warm_start=behind), stages)
    return again if again.certified else smallest.attempt


def _without(spec: DesignSpec, *open_ends: str) -> DesignSpec | None:
    """The spec without ends of its base radius; None where these leave no larger range to search.

    An open range is searched up to an end of its own: one beyond it that is asked for stays. Where
    a maximum lies below the start of an open one's search, that goes further down by itself.
    """
    low, high = ends(spec.base_radius_mm)
    if high == inf:
        return None
    kept = {} if low == -inf or "min" in open_ends else {"min": low}
    opened = spec.model_copy(update={"base_radius_mm": Range(**kept) if kept else None})
    return opened if opened.searched_radii()[1] >= spec.searched_radii()[1] else None


def _smallest(spec: DesignSpec, wider: Attempt) -> Smallest | None:
    """The cam that was found without the maximum, judged with it; None where there is none."""
    if not wider.certified or wider.cam is None:
        return None
    restored = {
        "base_radius_mm": spec.base_radius_mm, "objective": spec.objective,
        "tolerance": spec.tolerance, "proof": spec.proof,
    }  # fmt: skip
    question = replace(wider.question, physical=wider.question.physical.model_copy(update=restored))
    final_spec = question.to_physical(wider.final_spec)
    radius = final_spec.follower.dimensions(wider.cam.size)["base_radius_mm"]
    least, most = spec.requested_radii()
    cam, bounds = wider.cam, wider.bounds
    if not least <= radius <= most:  # above it by a clearance only, or below the least allowed
        nearest = min(max(radius, least), most)
        cam = Cam(cam.segments, cam.splines, _resized(final_spec.follower, cam.size, nearest))
    if spec.objectives() != wider.solved_spec.objectives() or radius < least:
        bounds = [Bounded(objective, -inf, "") for objective in spec.objectives()]
        bounds[:1] = wider.bounds[:1] if bounds[0].objective.kind == "base_radius" else bounds[:1]
    least_scaled = least / question.units.length
    bounds = _with_least_radius(bounds, wider, least_scaled)
    first, number_bound = wider.bounds[0], None
    if wider.chosen_values:  # a bound at these says nothing of others; the least one allowed does
        first = wider.number_bound or replace(first, lower=-inf, valid_for="")
        (first,) = _with_least_radius([first], wider, least_scaled)
        number_bound = first if first.lower > -inf else None
    (bounded,) = in_wire_units(wider.question, wider.final_spec, [first])
    if cam is wider.cam:  # what is traced all round is as it was: only dimensions are judged anew
        before = certify_size(wider.question.physical, cam.size, final_spec.follower)
        traced = wider.extremes[: len(wider.extremes) - len(before)]
        extremes = [*traced, *certify_size(question.physical, cam.size, final_spec.follower)]
    else:
        extremes = certify_cam(question.physical, cam, final_spec)
    attempt = replace(
        wider, question=question, cam=cam, bounds=bounds, extremes=extremes,
        number_bound=number_bound,
    )  # fmt: skip
    if not attempt.certified:
        attempt = replace(attempt, cam=None, bounds=[], extremes=[])
    return Smallest(attempt, radius, most, bounded.lower, bounded.valid_for)


def _with_least_radius(bounds: list[Bounded], smallest: Attempt, least: float) -> list[Bounded]:
    """The bounds, that of the base radius no less than the least one allowed.

    ``least``: in the unit of the question solved.
    """
    first, *later = bounds
    if first.objective.kind != "base_radius" or least <= 0.0:
        return bounds
    requested = first.objective.from_wire(least, smallest.final_spec.machine()) * (
        1.0 - ROUNDING_DOWN
    )
    if requested <= first.lower:
        return bounds
    valid_for = "all cams with the least base radius asked for"
    return [replace(first, lower=requested, valid_for=valid_for, infimum=False), *later]


def _resized(follower: AnyFollower, size: tuple[float, ...], radius: float) -> tuple[float, ...]:
    """The size raised or lowered to a base radius [mm], by the secant method."""

    def excess(step: float) -> float:
        return follower.dimensions(enlarged(size, step))["base_radius_mm"] - radius

    before, at = 0.0, -excess(0.0)
    for _ in range(SECANT_STEPS):
        slope = excess(at) - excess(before)
        if slope == 0.0:
            break
        before, at = at, at - excess(at) * (at - before) / slope
    return enlarged(size, at)
