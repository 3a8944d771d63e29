"""Numbers left free, angles, lifts and an arm's length: searched for around the convex program.

With them fixed all is as ever. Of angles and lifts a few cone programs on coarse grids say what
they are worth; an arm's length changes what limits say of the size, not convex, and costs a whole
search each. The best point found is solved in full: that no other is better is not proven.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from math import inf

import numpy as np

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import BundlePoint, Function, minimise
from synthesis.optimise.parameters.arm_length import search_length
from synthesis.optimise.parameters.value_function import ValueFunction
from synthesis.optimise.state.solve_state import Stage
from synthesis.spec.design_spec import DesignSpec

TRIED = 33  # lengths of a machine, to find one that serves
SAMPLED, COARSE = 12, 24  # spline intervals: to look around, to descend
CORNERS = 4  # per free direction, towards which samples are taken
SHARES = (0.5, 0.95)  # of the way from the middle to a corner
STARTS = 3
APART = 0.1  # of the box: starts that are nearer than this lead to the same place
RADIUS, ROUNDS = 0.15, 25
LAST_RADIUS, LAST_ROUNDS = 0.03, 20  # on the knots that the full search came to
POLISHED = 4  # times at most
SHARE_OF_TIME = 0.6  # of what is left


def choose_parameters(
    spec: DesignSpec, deadline: float = inf
) -> tuple[DesignSpec, list[float], Stage]:
    """The spec with numbers in place of all that it leaves free to be searched.

    Args:
        spec: with numbers left free. deadline: ``time.monotonic()``; the search takes a part of
            what is left.

    Returns:
        the spec, the numbers in the order of its free parameters, and what it took.
    """
    started = time.perf_counter()
    now, parameters = clock.now(), spec.free_parameters
    stop = inf if deadline == inf else now + SHARE_OF_TIME * max(deadline - now, 0.0)
    worth = ValueFunction(spec.without_deferred(), parameters, stop)
    middle = _middle(worth)
    best = _found(worth, middle)
    numbers = parameters.values_at(middle if best is None else best.u)
    freedom = parameters.polytope.directions.shape[1]
    stage = Stage(
        "proportions", f"search over {freedom} of {len(numbers)} free numbers", "Clarabel",
        len(numbers), 0, worth.calls, time.perf_counter() - started,
        _ended(best, late=clock.now() >= stop),
        "angles and lifts by cutting planes from several starts, lengths one by one",
    )  # fmt: skip
    return spec.with_values(numbers), numbers, stage


def _middle(worth: ValueFunction) -> Array:
    """Where to begin: in the middle of the box, with a machine that reaches its cam."""
    middle = worth.free_parameters.polytope.centre()
    assert middle is not None  # the spec has been checked
    for position in worth.free_parameters.machine_indices:
        tried = [middle, *worth.free_parameters.points_along(middle, position, TRIED)]
        middle = next((u for u in tried if worth.problem(u) is not None), middle)
    return middle


def _ended(best: BundlePoint | None, *, late: bool) -> str:
    """Why the search stopped."""
    if best is None or best.value == inf:
        return "out of time" if late else "nothing found"
    return "out of time, with the best so far" if late else "searched"


def _found(worth: ValueFunction, middle: Array) -> BundlePoint | None:
    """The best point found: of the program's numbers, then of the machine's."""
    machine, best = worth.free_parameters.machine_indices, None
    if len(machine) < len(worth.free_parameters.parameters):
        best = _search(worth, middle)
        middle = middle if best is None else best.u
    for position in machine:
        best = search_length(worth, middle, position) or best
        middle = middle if best is None else best.u
    return best


def _search(worth: ValueFunction, middle: Array) -> BundlePoint | None:
    """The best point found: samples, descents from the best of them, and a polish."""
    polytope = worth.free_parameters.polytope
    corners = polytope.corners(CORNERS * polytope.directions.shape[1])
    points = [middle, *(middle + k * (c - middle) for c in corners for k in SHARES)]
    rough = worth.uniform(middle, SAMPLED)
    around = _best_of(worth.on(rough), points) or _possible(worth, points)
    coarse = worth.on(worth.uniform(middle, COARSE))
    starts = _best_of(coarse, [found.u for found in _apart(around)])
    ends = [minimise(coarse, polytope, start, RADIUS, ROUNDS) for start in starts]
    if not ends:
        return next(iter(around), None)
    best = min(ends, key=lambda one: one.value)
    for _ in range(POLISHED):
        before, fine = best, worth.on(worth.refined(best.u))
        for start in _best_of(fine, [best.u]):
            before, best = start, minimise(fine, polytope, start, LAST_RADIUS, LAST_ROUNDS)
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
        end = minimise(excess, worth.free_parameters.polytope, start, RADIUS, ROUNDS)
        return _best_of(worth.on(mesh), [end.u]) or [BundlePoint(end.u, inf)]
    return []


def _best_of(function: Function, points: Iterable[Array]) -> list[BundlePoint]:
    """Those of the points where the function has a value, the best first."""
    found = [BundlePoint(u, value) for u in points if (value := function(u)) is not None]
    return sorted(found, key=lambda one: one.value)


def _apart(found: list[BundlePoint]) -> list[BundlePoint]:
    """The best few that are not close together."""
    kept: list[BundlePoint] = []
    for one in found:
        if all(float(np.max(np.abs(one.u - other.u))) > APART for other in kept):
            kept.append(one)
    return kept[:STARTS]
