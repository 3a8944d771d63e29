"""Why no cam at all answers a question: the theorems on which the word ``infeasible`` rests.

Each covers everything that was asked: all motion laws where laws are free, all sizes, all numbers.
A solver's status, an end of our own of an open range, numbers that were chosen and a clock prove
nothing; where only these speak, the question is unsolved.

``infeasibility_proof`` lists the theorems, each a function. Those that are proven on the way stand
where they are: ``Problem.base_circle_conflict`` and ``Problem.constant_conflict``; of phase 1
``PhaseOneResult.impossible``, kept in the state, and ``excess_proof``. Two more stand elsewhere:
that of a maximum of the base radius, ``Smallest.excludes`` in ``largest_radius``, and those over
all free angles and lifts in ``free_numbers``. A proof for fewer limits than were asked for is one
for all of them; ``conflict`` uses it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from math import inf, pi

import numpy as np

from synthesis.catalogue.constraints import NormBounds, affine_range
from synthesis.catalogue.motion import PlacedSegment
from synthesis.design.design import Extreme
from synthesis.optimise.conic.linear_rows import row_excess
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.problem.residual_vibration import amplitude
from synthesis.optimise.recovery.candidate import given_cam
from synthesis.optimise.relaxation.any_law import least_along, size_conflict
from synthesis.optimise.strategy.phase_one import (
    INTERVALS,
    PhaseOneResult,
    excess_proof,
    minimise_excess,
)
from synthesis.pipeline.assembly import restate_problem
from synthesis.pipeline.attempt import Attempt
from synthesis.units import DEGREE

ROUNDING = 1e-9  # relative to a bound, or to the stroke: an excess below it is none
SAME = 1e-12  # of 1: entries of matrices that differ by rounding alone
NEAR = 1e-9  # rad: an extreme at the end of a segment belongs to it


@lru_cache(maxsize=16)
def infeasibility_proof(attempt: Attempt) -> str:
    """Why no cam answers a question, as a sentence with what it covers; empty without a proof.

    Args:
        attempt: the question, and what solving it came to.
    """
    if attempt.chosen_values or not attempt.searches:
        return ""  # other numbers might do
    # The first search is bound by the question alone, later ones by what earlier ones reached.
    search, question = attempt.searches[0], attempt.question
    solved = question.scaled.without_deferred()
    problem = restate_problem(question, question.to_physical(solved), search.problem)
    placed = question.scaled.placed_segments()
    given = {segment.index for segment in placed if segment.law is not None}  # but for tables
    theorems: tuple[Callable[[], str], ...] = (
        lambda: problem.base_circle_conflict,
        lambda: problem.constant_conflict,
        lambda: _given_law_conflict(problem, given),
        lambda: _given_vibration_conflict(problem, given),
        lambda: _mean_velocity_conflict(problem),
        lambda: _given_cam_conflict(problem, attempt, given),
        lambda: search.infeasibility_proof,
        lambda: size_conflict(problem),
        lambda: _cone_conflict(problem),
        lambda: _gentlest_law_conflict(attempt),
        lambda: excess_proof(search.problem, search.deadline),
    )
    return next((proof for theorem in theorems if (proof := theorem())), "")


@lru_cache(maxsize=16)
def gentlest_law(attempt: Attempt) -> PhaseOneResult | None:
    """The gentlest law under the linear rows of a question (phase 1), where its search made none.

    Searches with curved limits, and those for a least dimension, make none of their own. None
    where one did, where no law is free, and where no derivative is capped. What the time of the
    question leaves unsettled stays so: a share that is not the least yet, a bound below 1.
    """
    search = attempt.searches[0]
    problem = search.problem
    known = search.strained or search.least_excess is not None or search.infeasibility_proof
    if not problem.free or known:
        return None
    grids = [uniform_grid(segment, INTERVALS) for segment in problem.free]
    return minimise_excess(problem, grids, 0.0, search.deadline)


def _gentlest_law_conflict(attempt: Attempt) -> str:
    """Which caps even the gentlest law exceeds: curved limits, left out, would exclude more."""
    gentlest = gentlest_law(attempt)
    return "" if gentlest is None else gentlest.impossible


def _given_law_conflict(problem: Problem, given: set[int]) -> str:
    """Which limit on the motion alone a given law exceeds: no size and no other law mends it."""
    for segment in problem.segments:
        if segment.index not in given:
            continue
        for row in problem.limit_rows(segment):
            over = -inf if any(row.size) else row_excess(row, segment, ())
            if over > ROUNDING * (abs(row.upper) + problem.length):
                name = row.source.replace("_", " ")
                return f"proven: the law given for program/{segment.index} breaks {name}"
    return ""


def _given_vibration_conflict(problem: Problem, given: set[int]) -> str:
    """Which limit on residual vibration a run of given laws exceeds: it speaks of no size."""
    for vibration in problem.vibration_limits:
        most = vibration.max_amplitude + ROUNDING * problem.length
        if given.issuperset(vibration.run) and amplitude(vibration, problem.segments) > most:
            run = ", ".join(f"program/{index}" for index in vibration.run)
            return f"proven: the laws given for {run} break {vibration.source.replace('_', ' ')}"
    return ""


def _mean_velocity_conflict(problem: Problem) -> str:
    """Which limit lies below a mean velocity: by the mean value theorem every law reaches that."""
    for segment, name, mean, most in _mean_velocities(problem):
        if mean > most + ROUNDING * abs(mean):
            return f"proven: {name} is below the mean velocity over program/{segment.index}"
    return ""


def mean_velocity_excess(attempt: Attempt) -> float | None:
    """By how much mean velocities exceed their limits at most, relatively; None if none does."""
    problem = attempt.searches[0].problem
    excesses = [mean / most - 1.0 for _, _, mean, most in _mean_velocities(problem) if most > 0.0]
    worst = max(excesses, default=0.0)
    return worst if worst > ROUNDING else None


def _mean_velocities(problem: Problem) -> Iterator[tuple[PlacedSegment, str, float, float]]:
    """Of every limit on the velocity of a free law: segment, name, mean velocity, its most."""
    for segment in problem.free:
        for row in problem.limit_rows(segment):
            if row.orders != (1,) or any(row.size) or row.interval is not None:
                continue
            mean = row.coefficients[1] * segment.lift / segment.angle
            yield segment, row.source.replace("_", " "), mean, row.upper


def _given_cam_conflict(problem: Problem, attempt: Attempt, given: set[int]) -> str:
    """Which limits the only cam breaks: its laws and size are given, or the motion at a place."""
    jumps = {e.angle_deg for e in attempt.extremes if e.limit.endswith("_jump")}
    of_motion = [
        extreme
        for extreme in _broken(attempt.extremes)
        if extreme.field == "continuity"
        or extreme.field.startswith("program")
        or (extreme.value is None and extreme.angle_deg in jumps)
        if all(s.index in given for s in problem.segments if contains_angle(s, extreme.angle_deg))
    ]
    if of_motion:
        names = ", ".join(dict.fromkeys(e.limit.replace("_", " ") for e in of_motion))
        return f"proven: the motion is given there, and breaks {names}"
    everything = len(given) == len(attempt.question.scaled.program)
    fixed = attempt.solved_spec.without_deferred() == attempt.final_spec
    if everything and fixed and given_cam(attempt.searches[0].problem) is not None:
        names = ", ".join(
            dict.fromkeys(e.limit.replace("_", " ") for e in _broken(attempt.extremes))
        )
        return f"proven: laws and size are given, and that one cam breaks {names}" if names else ""
    return ""


def _broken(extremes: list[Extreme]) -> Iterator[Extreme]:
    """Those that are broken for certain: by more than their enclosure is wide."""
    for extreme in extremes:
        if not extreme.holds and (extreme.margin is None or extreme.margin < -extreme.width):
            yield extreme


def contains_angle(segment: PlacedSegment, angle_deg: float) -> bool:
    """Whether a cam angle lies on a segment, its ends included."""
    beyond = (angle_deg * DEGREE - segment.start + NEAR) % (2.0 * pi)
    return beyond <= segment.angle + 2.0 * NEAR


def _cone_conflict(problem: Problem) -> str:
    """Which cone of the size no size keeps that is as large as the least base radius asks.

    ‖Az + a‖² − ‖Mz + m‖² is affine in z where AᵀA = MᵀM, M and m those of the prime radius: that is
    its least plus the difference's least, over the bounds and over all sizes that fit the laws.
    """
    radius = problem.machine.follower.radius_norm()
    matrix, shift = np.array(radius.matrix), np.array(radius.shift)
    square = matrix.T @ matrix
    for cone in problem.norm_bounds if not problem.open_above else ():
        other, moved = np.array(cone.norm.matrix), np.array(cone.norm.shift)
        if not np.allclose(other.T @ other, square, rtol=0.0, atol=SAME):
            continue
        slope = tuple((2.0 * (other.T @ moved - matrix.T @ shift)).tolist())
        constant = float(moved @ moved - shift @ shift)
        least, _ = affine_range(slope, constant, problem.sizing.bounds)
        if len(matrix) == len(slope) == 2 and any(slope):
            circle = NormBounds(radius, inf, "base_radius", lower=problem.least_norm)
            least = max(least, least_along(problem, slope, circle) + constant)
        if problem.least_norm**2 + least > (cone.upper + ROUNDING * problem.length) ** 2:
            name = cone.source.replace("_", " ")
            return f"proven: no size keeps the least base radius and {name} together"
    return ""
