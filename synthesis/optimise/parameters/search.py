"""The outer search over numbers left free: angles, lifts and an arm's length.

With them fixed all is as ever, so they are searched for around the convex program, and the best
point is solved in full.

* Lifts of moves that run into each other: one solve of the moves as one (``merged_moves``).
* Other angles and lifts: branch and bound (``number_search``), which bounds all numbers; of angles
  with curved limits ``longer_moves``. Where a gap is left, descents give it a better start: a few
  cone programs on coarse grids give a point's value; samples give starts; a bundle method descends
  from the best, first on a coarse mesh, then on the knots of the full search. Where a whole search
  at the end comes to another value, its knots or its curved limits matter more than a coarse mesh
  shows: then whole searches choose among the samples.
* A length of the machine changes what limits say of the size, and not in a convex way, so each one
  costs a whole search: over all its range, then near the best. A given law's size is exact, so
  that the length can be too; free laws leave some noise. What else can be fixed, the pivot's
  distance, is often best at an end of its range.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from functools import partial
from math import exp, inf, isfinite, log
from typing import Any, TypeVar

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import BundlePoint, Function, minimise
from synthesis.optimise.driver import optimise
from synthesis.optimise.parameters.longer_moves import LongerMoves
from synthesis.optimise.parameters.merged_moves import MergedMoves
from synthesis.optimise.parameters.number_search import (
    ALL_NUMBERS,
    NOTHING,
    Enough,
    NumberProof,
    NumberSearch,
)
from synthesis.optimise.parameters.placement import Placement
from synthesis.optimise.parameters.value_function import SearchedPoint, ValueFunction
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.recovery.candidate import enlarge_until_feasible
from synthesis.optimise.state import QUICK, SINGLE_SHARE, ProofBudget, Stage
from synthesis.spec.design_spec import DesignSpec

LITTLE = 0.05  # relative: descents gain no more than the gap that is left
ALL_NUMBERS_SHARE = 0.95
"""Of the tolerance, for the gap over all numbers, which includes that at single ones."""
FIRST_PROGRAMS = 20
"""For a bound over all numbers before any descent, for each free direction: half a second."""
SAMPLED, COARSE = 12, 24  # spline intervals: of samples, of a descent
CORNERS = 4  # per free direction, towards which samples are taken
SHARES = (0.5, 0.95)  # of the way from the middle to a corner, where samples lie
STARTS = 3  # of descents
DISTANCE = 0.1  # of the box, between starts: nearer ones lead to the same place
RADIUS, MAX_STEPS = 0.15, 25  # first step of a descent, of the box, and steps at most
LAST_RADIUS, LAST_MAX_STEPS = 0.03, 20  # the same on the knots of the full search
POLISHED = 4  # descents on such knots at most; each gives new ones
DESCENTS, EACH_DIRECTION = 2, 8  # by whole searches; how many of these a direction is worth
LAST_STEP = 2e-3  # of the box: where a descent by whole searches ends
WORST = 2.0  # of a start's value: what a point counts where nothing is found
MISLED = 0.02  # relative: a value on a mesh that differs by more from a whole search misleads
SHARE_OF_TIME = 0.6  # of what is left: the best point is still to be solved in full
PROVEN_SHARE = 0.85
"""The same where the best point was solved in full on the way: the certificate is left."""
TRIED = 33  # lengths of a machine, to find one that reaches its cam
ROUGH, FINE = 2e-2, 4e-3  # tolerances of whole searches with free laws, first and last
FEW, MANY = 8, 33
"""Lengths tried first, evenly in their logarithm; the latter where a whole search is cheap."""
ROUGHLY, CLOSELY = 5e-3, 1e-7
"""Relative distance to the best length: with free laws, with given ones."""
NEAR = 0.1  # of a value: so near to an end of its range the end is tried too
INWARDS = 0.02
"""Of the way from an end of the range to the next length tried: whether the end itself is best."""

NOTE = (
    "angles and lifts by branch and bound, angles also by longer moves, then by cutting planes "
    "from several starts and by whole searches where a coarse mesh misleads; lengths one by one"
)
MERGED_NOTE = "moves that run into each other solved as one, its level where they meet left free"

P = TypeVar("P", bound=BundlePoint)


def choose_parameters(
    spec: DesignSpec, deadline: float = inf, proof: ProofBudget = QUICK,
    enough: Enough = NOTHING,
) -> tuple[DesignSpec, Stage, NumberProof | None]:  # fmt: skip
    """Choose all that a spec leaves free.

    Args:
        spec: what is asked.
        deadline: ``time.monotonic()``; a part of the time until then is used.
        proof: what may be spent on a bound over all numbers.
        enough: a value and a bound of the first objective that end the branch and bound.

    Returns:
        the spec with numbers in place, what the search took, and the bound over all numbers; None
        where nothing is known of others.
    """
    started = time.perf_counter()
    now, parameters = clock.now(), spec.free_parameters
    stop = inf if deadline == inf else now + SHARE_OF_TIME * max(deadline - now, 0.0)
    last = inf if deadline == inf else now + PROVEN_SHARE * max(deadline - now, 0.0)
    worth = ValueFunction(spec.without_deferred(), parameters, stop)
    merged = MergedMoves.of(spec.without_deferred())
    found = None if merged is None else _search_merged(worth, merged, last, proof, enough)
    if found is not None:
        numbers, bounded, best = *found, None
    else:
        # The program's numbers first, then the machine's lengths one by one.
        middle, bounded, best = _middle(worth), None, None
        if len(parameters.machine_indices) < len(parameters.parameters):
            best, bounded = _search_program(worth, middle, last, proof, enough)
        for position in parameters.machine_indices:
            middle = middle if best is None else best.u
            best = search_length(worth, middle, position) or best
        numbers = parameters.values_at(middle if best is None else best.u)
    freedom = parameters.polytope.directions.shape[1]
    late = clock.now() >= stop
    if found is None and (best is None or best.value == inf):
        status = "out of time" if late else "nothing found"
    else:
        status = "out of time, with the best so far" if late else "searched"
    stage = Stage(
        "proportions", f"search over {freedom} of {len(numbers)} free numbers", "Clarabel",
        len(numbers), 0, worth.calls, time.perf_counter() - started,
        status,
        NOTE if found is None else MERGED_NOTE,
        exit="" if bounded is None else bounded.exit,
    )  # fmt: skip
    return spec.with_values(numbers), stage, bounded


def _search_merged(
    worth: ValueFunction, merged: MergedMoves, deadline: float, proof: ProofBudget, enough: Enough
) -> tuple[list[float], NumberProof] | None:
    """All numbers, and what is proven of them, of moves solved as one; None without such a cam."""
    numbered, inner, tolerance = merged.spec, None, ALL_NUMBERS_SHARE * worth.spec.tolerance
    if numbered.free_parameters.parameters:
        numbered, _, inner = choose_parameters(numbered, deadline, proof, enough)
        if inner is None:
            return None
    problem = formulate_problem(numbered, numbered.objectives()[0])
    state = optimise(
        problem, tolerance, deadline, proof=QUICK if inner else proof,
        earlier=None if inner is None else inner.cam,
        sufficient=enough.value, sufficient_bound=enough.bound,
    )  # fmt: skip
    worth.calls += 1
    if state.incumbent is None or not (inner is not None or state.covers_all_laws):
        return None
    spec = merged.with_lifts(numbered, state.incumbent)
    own = formulate_problem(spec, spec.objectives()[0])
    cam = enlarge_until_feasible(merged.split(own, state.incumbent))
    numbers = worth.free_parameters.values_in(spec.program, spec.follower)
    lower, valid_for = state.lower, f"{state.valid_for}, {ALL_NUMBERS}"
    if inner is not None:
        lower, valid_for = inner.lower, inner.valid_for
    best = state.incumbent if cam is None else cam
    return numbers, NumberProof(
        np.array(numbers), best.value, lower, valid_for, partial(state.gap_between, best), 1,
        state.stages[-1].exit, cam=cam,
    )  # fmt: skip


def _middle(worth: ValueFunction) -> Array:
    """Where to begin: in the middle of the box, with a machine that reaches its cam."""
    middle = worth.free_parameters.polytope.centre()
    assert middle is not None  # the spec has been checked
    for position in worth.free_parameters.machine_indices:
        tried = [middle, *worth.free_parameters.points_along(middle, position, TRIED)]
        middle = next((u for u in tried if worth.problem(u) is not None), middle)
    return middle


def _search_program(
    worth: ValueFunction, middle: Array, deadline: float, proof: ProofBudget,
    enough: Enough = NOTHING,
) -> tuple[BundlePoint | None, NumberProof | None]:  # fmt: skip
    """The best point found for angles and lifts, and what is proven of all others."""
    placement = Placement.of(worth.free_parameters, worth.problem)
    all_numbers, single = (
        share * worth.spec.tolerance for share in (ALL_NUMBERS_SHARE, SINGLE_SHARE)
    )
    searched = longer = None
    if placement is not None:
        searched = NumberSearch(placement, worth.state, all_numbers, single, enough)
        longer = LongerMoves(
            placement, partial(worth.state, deadline=deadline), searched.bound, all_numbers,
            single, proof,
        )  # fmt: skip
    freedom = worth.free_parameters.polytope.directions.shape[1]

    def prove(start: Array, programs: float) -> NumberProof | None:
        last = clock.programs_solved() + freedom * programs
        return None if searched is None else searched.run(start, last, worth.deadline)

    # 1. Branch and bound: with one or two directions it often closes the gap at once.
    first = prove(middle, FIRST_PROGRAMS)
    if first is not None and (first.gap <= all_numbers or first.is_enough):
        return BundlePoint(first.u, first.value), first
    # 2. Longer moves bound curved limits too, and lose nothing where laws do not decide together.
    suits = longer is not None and (longer.has_one_size or (first is not None and first.curved))
    if first is not None and longer is not None and suits and longer.serves():
        last = clock.programs_solved() + freedom * proof.programs
        other = longer.run(first.u, last, deadline)
        if other is not None:
            first = first.combined(other)
            if longer.has_one_size and isfinite(other.lower):
                return BundlePoint(first.u, first.value), first
    if first is not None and first.gap <= LITTLE:
        return BundlePoint(first.u, first.value), first
    # 3. Descents, which cost little, and branch and bound from where they end.
    best = _descend(worth, middle)
    more = max(proof.programs, FIRST_PROGRAMS)
    again = None if best is None or best.value == inf else prove(best.u, more)
    if again is not None:
        first = again if first is None else first.combined(again)
    # 4. The best cam of all proofs; without one where the descents end, if they have an end.
    if first is not None:
        return BundlePoint(first.u, first.value), first
    return best, None


def _descend(worth: ValueFunction, middle: Array) -> BundlePoint | None:
    """The best point found: samples, descents from the best of them, and a polish."""
    polytope = worth.free_parameters.polytope
    corners = polytope.corners(CORNERS * polytope.directions.shape[1])
    points = [middle, *(middle + k * (c - middle) for c in corners for k in SHARES)]
    rough = worth.uniform(middle, SAMPLED)
    around = _best_of(worth.on(rough), points) or _possible(worth, points)
    coarse = worth.on(worth.uniform(middle, COARSE))
    starts = _best_of(coarse, [one.u for one in _distant(around)])
    ends = [minimise(coarse, polytope, start, RADIUS, MAX_STEPS) for start in starts]
    if not ends:
        return next(iter(around), None)
    best = _polished(worth, min(ends, key=lambda one: one.value))
    whole = worth.solved(best.u, ROUGH, None)
    if abs(whole.value - best.value) <= MISLED * abs(whole.value):
        return best
    # The mesh misleads: whole searches choose among the samples, and go downhill from the best.
    trials = sorted((worth.solved(u, ROUGH, None) for u in points), key=lambda one: one.value)
    lowest = [one for one in _distant([whole, *trials]) if one.cam is not None]
    chosen = _best([whole, *(_downhill(worth, one) for one in lowest[:DESCENTS])])
    return best if chosen.cam is None else chosen


def _downhill(worth: ValueFunction, start: SearchedPoint) -> SearchedPoint:
    """The best of whole searches downhill from a point, by a trust region without derivatives.

    Their values are noisy by their tolerance, so that differences of near points say nothing.
    """
    directions, trials = worth.free_parameters.polytope.directions, [start]

    def value(step: Array) -> float:
        offset = directions @ step
        with np.errstate(divide="ignore", invalid="ignore"):  # as far as the ranges allow
            reach = np.where(offset > 0.0, 1.0 - start.u, start.u) / np.abs(offset)
        share = float(np.min(reach[offset != 0.0], initial=1.0))
        trials.append(worth.solved(start.u + share * offset, ROUGH, None))
        return min(trials[-1].value, WORST * start.value)

    freedom = directions.shape[1]
    options: Any = {
        "initial_tr_radius": RADIUS, "final_tr_radius": LAST_STEP,
        "maxfev": EACH_DIRECTION * (freedom + 1),
    }  # fmt: skip
    minimize(value, np.zeros(freedom), method="COBYQA", options=options)
    return _best(trials)


def _polished(worth: ValueFunction, best: BundlePoint) -> BundlePoint:
    """Downhill from a point on the knots of the full search there, again while that pays."""
    polytope = worth.free_parameters.polytope
    for _ in range(POLISHED):
        before, fine = best, worth.on(worth.refined(best.u))
        for start in _best_of(fine, [best.u]):
            before, best = start, minimise(fine, polytope, start, LAST_RADIUS, LAST_MAX_STEPS)
        if before.value - best.value <= 0.1 * worth.spec.tolerance * abs(best.value):
            break
    return best


def _possible(worth: ValueFunction, points: Iterable[Array]) -> list[BundlePoint]:
    """Where everything fits, if at none of these: downhill from the nearest to it.

    Where nothing fits at all, the point that comes nearest to it, worth ∞.
    """
    mesh = worth.uniform(next(iter(points)), COARSE)
    excess = worth.excess(mesh)
    for start in _best_of(excess, points)[:1]:
        end = minimise(excess, worth.free_parameters.polytope, start, RADIUS, MAX_STEPS)
        return _best_of(worth.on(mesh), [end.u]) or [BundlePoint(end.u, inf)]
    return []


def _best_of(function: Function, points: Iterable[Array]) -> list[BundlePoint]:
    """Those of the points where the function has a value, the best first."""
    results = [BundlePoint(u, value) for u in points if (value := function(u)) is not None]
    return sorted(results, key=lambda one: one.value)


def _distant(points: Sequence[P]) -> list[P]:
    """The best few that are not close together."""
    kept: list[P] = []
    for one in points:
        if all(float(np.max(np.abs(one.u - other.u))) > DISTANCE for other in kept):
            kept.append(one)
    return kept[:STARTS]


def search_length(worth: ValueFunction, start: Array, position: int) -> BundlePoint | None:
    """The best point along one number's range, the others as they are; None where nothing fits."""
    for count in (FEW, MANY):
        trials = _along(worth, start, position, count)
        best = _best(trials)
        if best.cam is not None:
            break
    else:
        return None
    if best.cam.laws:
        return _best([best, *_closer(worth, trials, position, ROUGHLY)])
    # Given laws: with the pivot's distance fixed at the cam's, and at the ends of its range.
    fixable, fixed = best.cam.problem.machine.follower.fixable_dimension(), list[float | None]()
    if fixable is not None:
        at = min(max(fixable.value_in(best.cam.size), fixable.low), fixable.high)
        near = (x for x in (fixable.low, fixable.high) if x != at and abs(x - at) <= NEAR * at)
        fixed = [at, *near]
    every = [best]
    for distance in fixed or [None]:
        trials = _along(worth, start, position, MANY, distance)
        every += [*trials, *_closer(worth, trials, position, CLOSELY, distance)]
    return _best(every)


def _along(
    worth: ValueFunction, start: Array, position: int, count: int, fixed: float | None = None
) -> list[SearchedPoint]:
    points = worth.free_parameters.points_along(start, position, count)
    return [worth.solved(u, ROUGH, fixed) for u in points]


def _best(trials: Sequence[SearchedPoint]) -> SearchedPoint:
    return min(trials, key=lambda trial: trial.value)


def _closer(
    worth: ValueFunction, trials: list[SearchedPoint], position: int, close: float,
    fixed: float | None = None,
) -> list[SearchedPoint]:  # fmt: skip
    """Points between the neighbours of the best one, to a relative distance."""
    parameters, more, best = worth.free_parameters, list[SearchedPoint](), _best(trials)
    if best.cam is None:
        return []
    at, last = trials.index(best), len(trials) - 1
    logarithms = [log(parameters.values_at(trial.u)[position]) for trial in trials]

    def value(logarithm: float) -> float:
        u = parameters.with_value(best.u, position, exp(logarithm))
        more.append(worth.solved(u, FINE, fixed))
        return more[-1].value

    low, high = logarithms[max(at - 1, 0)], logarithms[min(at + 1, last)]
    if at in (0, last):
        inwards = (high if at == 0 else low) - logarithms[at]
        if value(logarithms[at] + INWARDS * inwards) >= best.value:
            return more  # the end of the range is best
    minimize_scalar(value, bounds=(low, high), method="bounded", options={"xatol": close})
    return more
