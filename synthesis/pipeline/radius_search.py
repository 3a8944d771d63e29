"""Base radii tried one after the other, where the optimiser's own cam is not the answer.

A cam that only crosses itself is made larger until it does not: no row of the optimiser excludes
that. One that is the smallest sought of an open base radius is made smaller.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import inf

from synthesis.catalogue.constraints import Vector
from synthesis.catalogue.fields import range_between
from synthesis.design.design import Effort
from synthesis.numerics import clock
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import cam_at_size, enlarge_until_feasible, smallest_size
from synthesis.pipeline.assembly import certify_cam, with_size
from synthesis.pipeline.attempt import Attempt, prepare, solve_and_certify, unsolved
from synthesis.pipeline.goal import Goal
from synthesis.spec.design_spec import DesignSpec

FIRST_GROWTH = 0.02  # of the base radius; doubled while the cam crosses itself, then halved
SMALL = 5e-2  # strokes: a smaller base radius is no measure of how much it has to grow
FURTHER_DOWN = (1e-9, 1e-6, 1e-5, 1e-4)
"""Strokes: base radii from which on smaller cams are sought, in turn, near an open end."""
GROWTHS = 14  # radii tried at most


def solve_spec(spec: DesignSpec, goal: Goal, stages: list[Effort]) -> Attempt:
    """Solve a question with a maximum of the base radius, if it has one, as a constraint.

    A cam that crosses itself is enlarged until it does not.
    """
    attempt = solve_and_certify(prepare(spec, goal, stages), goal, stages)
    return enlarge_until_simple(attempt, goal, stages)


def approach_infimum(found: Attempt, goal: Goal, stages: list[Effort]) -> Attempt:
    """A smaller cam, where the base radius is open below and the cam found the smallest sought.

    Where the lower bound is the open end itself, the laws found are kept and the size is made
    smaller. Elsewhere the best cam may lie below the radius from which on the search began: the
    question is solved again from a smaller one on.
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
    size = smallest_size(given) or _smallest_at_dimension(given, best.size)
    resized = enlarge_until_feasible(cam_at_size(given, best.laws, size or best.size))
    if resized is None:
        return found
    cam = with_size(question, question.to_physical(found.solved_spec), cam, resized.size)
    extremes = certify_cam(question.physical, cam, question.to_physical(found.final_spec))
    problem = replace(search.problem, smallest_sought=sought)
    search = replace(search, problem=problem, incumbent=resized)
    return replace(found, searches=[search], best=resized, cam=cam, extremes=extremes)


def _smallest_at_dimension(given: Problem, size: Vector) -> Vector | None:
    """The smallest size of given laws with a free pivot kept as far as it is; None: none known."""
    pinning = given.machine.follower.fixable_dimension()
    if pinning is None:
        return None
    value = pinning.value_in(size)
    found = smallest_size(given.with_follower(pinning.fixed_at(value)))
    return None if found is None else pinning.full_size(value, found)


def enlarge_until_simple(
    self_crossing_attempt: Attempt, goal: Goal, stages: list[Effort]
) -> Attempt:
    """The smallest cam, by trial base radii, that does not cross itself; the attempt without one.

    No row of the optimiser excludes that a profile crosses itself. The lower bound remains that of
    the spec as asked, so that the gap includes the growth; later objectives, which hold what
    earlier ones had reached, keep no bound.
    """
    if not self_crossing_attempt.crosses_itself:
        return self_crossing_attempt
    question = self_crossing_attempt.question
    # Bounds that tell whether there is a cam as asked are none of a raised minimum.
    again = replace(goal, warm_start=None, sufficient_bound=inf, excluding_bound=inf)
    spec = question.scaled
    least, largest = _base_radius(self_crossing_attempt), spec.base_radius_range()[1]
    most, best = largest, self_crossing_attempt
    step = FIRST_GROWTH * max(least, SMALL * spec.stroke())
    accuracy = min(spec.tolerance, FIRST_GROWTH)
    for _ in range(GROWTHS):
        found_none = best is self_crossing_attempt
        trial_radius = min(least + step, largest) if found_none else 0.5 * (least + most)
        if clock.now() >= goal.stop or trial_radius <= least * (1.0 + 0.1 * accuracy):
            break
        raised = range_between(trial_radius, largest)
        larger = spec.model_copy(update={"base_radius_mm": raised, "proof": "quick"})
        trial_question = question.with_scaled(larger)
        trial = unsolved(replace(self_crossing_attempt, question=trial_question), larger)
        larger_cam = solve_and_certify(trial, again, stages)
        if larger_cam.cam is not None and larger_cam.certified:
            final_spec = larger_cam.final_spec.model_copy(
                update={"base_radius_mm": spec.base_radius_mm}
            )
            extremes = certify_cam(
                question.physical, larger_cam.cam, question.to_physical(final_spec)
            )
            most = _base_radius(larger_cam)
            best = replace(larger_cam, question=question, final_spec=final_spec, extremes=extremes)
            if larger_cam.searches[0].is_sufficient:
                break
        elif larger_cam.crosses_itself:
            least, step = trial_radius, 2.0 * step
        else:
            break
    if best is self_crossing_attempt:
        return self_crossing_attempt
    first, *later = self_crossing_attempt.bounds
    unknown = [replace(bounded, lower=-inf) for bounded in later]
    return replace(best, bounds=[first, *unknown])


def _base_radius(attempt: Attempt) -> float:
    assert attempt.best is not None
    return attempt.final_spec.follower.dimensions(attempt.best.size)["base_radius_mm"]
