"""Cams of extremal laws, where no acceleration and no jerk is capped: next to the least size.

They are known of faces that swing (``extremal_move`` of their limit on curvature).

Half-planes of the size that every law keeps (``relaxation.any_law``) have laws that leave them next
to no room, but none that lies on them: it would jump in its velocity. Such laws are known in closed
form for a ramp of any length. So no search is needed: of shorter and shorter ramps the first whose
cam is good enough. A cam proves nothing; what it leaves to the bound is the gap.
"""

from __future__ import annotations

import time
from itertools import product

import numpy as np
from scipy.interpolate import BSpline

from synthesis.catalogue.constraints import ExtremalMove, Vector, enlarged
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.bspline import SplineSpace
from synthesis.optimise.conic.linear_rows import row_excess
from synthesis.optimise.problem.boundary import BoundaryState, boundary_states
from synthesis.optimise.problem.derivative_caps import highest_caps
from synthesis.optimise.problem.grid import Grid, SplineLaw, grid_through
from synthesis.optimise.problem.problem import Problem, with_smoothness
from synthesis.optimise.recovery.candidate import (
    ALLOWED,
    Candidate,
    cam_at_size,
    enlarge_until_feasible,
    recover_cam,
)
from synthesis.optimise.relaxation.any_law import EVERY_LAW, ROUNDING, least_size
from synthesis.optimise.state import SolveState, Stage

RAMPS = (0.4, 0.2, 0.1, 0.05)  # of the tolerance, in turn: a size loses about as much by one
LEAST_RAMP = 1.6e-4  # of a move: with four intervals they are as long as those of any other ramp
DOUBLINGS, HALVINGS = 12, 8  # of the least enlargement that suits: doubled first, then bisected
SPARES = (0.0, 3e-4, 1e-3, 3e-3, 1e-2)  # of the size: what splines may break between knots, in turn
SHARES_OF_OTHERS = (0.0, 0.2, 0.3, 0.5, 0.8)  # of the last variable's enlargement: the others'
SMOOTHNESS = 2  # of these laws at least
BISECTIONS = 40  # of the share of a size that a cone leaves


def try_extremal_laws(state: SolveState) -> SolveState:
    """The state with the cam of extremal laws, and the bound that they come near.

    The same state where a derivative is capped, where another objective's value or a vibration is
    held, or where no such law is known. The wider a ramp, the less a cam jerks: they are tried from
    the widest on.
    """
    problem, norm = state.problem, state.problem.objective.norm(state.problem.machine)
    if norm is None or not (problem.free and problem.omits_curved_rows):
        return state
    if problem.objective_caps or problem.vibration_limits or highest_caps(problem):
        return state
    started, least = time.perf_counter(), least_size(problem)
    if least is None:
        return state
    known = state.raise_bound(norm.value(least) * (1.0 - ROUNDING), EVERY_LAW)
    ramps = dict.fromkeys(max(share * state.tolerance, LEAST_RAMP) for share in RAMPS)
    for ramp, share in product(ramps, SHARES_OF_OTHERS[: None if len(least) > 1 else 1]):
        direction = (*(share for _ in least[1:]), 1.0)
        amount = _least_amount(problem, least, direction, ramp)
        if amount is None or state.time_left <= 0.0:
            continue
        for spare in SPARES:
            size = _larger(problem, least, direction, amount + spare * norm.value(least))
            moves = _moves(problem, size, ramp)
            cam = _cam(problem, size, moves, state.tighten) if moves else None
            better = known.with_incumbent(cam) if cam and _keeps_rows(problem, cam) else known
            if better is not known:
                known = better
                break
        if known.is_good_enough:
            break
    if known.incumbent is None:
        return state
    count = sum(law.space.size for law in known.incumbent.laws)
    seconds = time.perf_counter() - started
    stage = Stage("closed form", "extremal laws", "none", count, 0, 0, seconds, "solved")
    return known.with_stage(stage)


def _least_amount(problem: Problem, least: Vector, direction: Vector, ramp: float) -> float | None:
    """How far in a direction extremal laws with such a ramp keep their limit; None: nowhere."""

    def suits(amount: float) -> bool:
        return bool(_moves(problem, _larger(problem, least, direction, amount), ramp))

    room, low = problem.sizing.bounds[-1][1] - least[-1], 0.0
    for doublings in range(DOUBLINGS):  # next to the largest size no law moves
        high = room * 0.5 ** (DOUBLINGS - doublings)
        if suits(high):
            break
        low = high
    else:
        return None
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if suits(middle) else (middle, high)
    return high


def _larger(problem: Problem, least: Vector, direction: Vector, amount: float) -> Vector:
    """A size larger in a direction, its first variables as small as the cones ask for."""
    size = tuple(a + amount * b for a, b in zip(least, direction, strict=True))

    def scaled(share: float) -> Vector:
        return (*(share * each for each in size[:-1]), size[-1])

    def inside(share: float) -> bool:
        return all(cone.norm.value(scaled(share)) <= cone.upper for cone in problem.norm_bounds)

    if inside(1.0):
        return size
    share = 0.0
    for halvings in range(1, BISECTIONS):
        share += 0.5**halvings * inside(share + 0.5**halvings)
    return scaled(share)


def _moves(problem: Problem, size: Vector, ramp: float) -> list[ExtremalMove]:
    """The extremal laws at a size; nothing where one of them breaks its limit, or none is known."""
    moves = list[ExtremalMove]()
    for segment in problem.free:
        ends = segment.s_start, segment.s_end
        bends = (curve for curve in problem.curved_limits_on(segment) if curve.order > 1)
        each = [curve.extremal_move(segment.angle, *ends, size, ramp) for curve in bends]
        if not each or any(move is None for move in each):
            return []
        moves += [move for move in each[-1:] if move is not None]
    return moves


def _cam(
    problem: Problem, size: Vector, moves: list[ExtremalMove], tighten: float
) -> Candidate | None:
    """The cam of moves at a size, raised until all limits hold; None where none allowed does.

    ``tighten``: relative, what it is larger by for the sake of the certificate's enclosures.
    """
    grids = tuple(
        # in steps, as of a law of class C1, the acceleration would follow it badly
        grid_through(with_smoothness(segment, SMOOTHNESS), move.breaks)
        for segment, move in zip(problem.free, moves, strict=True)
    )
    states, _ = boundary_states(problem.segments, grids)
    every = zip(problem.free, moves, grids, states, strict=True)
    cam = recover_cam(problem, [_law(*each) for each in every], size, keep_size=True)
    found = enlarge_until_feasible(cam)
    if found is None:
        return None
    more = tighten * problem.machine.follower.radius_norm().value(found.size)
    larger = enlarged(found.size, min(more, problem.max_enlargement(found.size)))
    return cam_at_size(found.problem, found.laws, larger)


def _keeps_rows(problem: Problem, cam: Candidate) -> bool:
    """Whether laws keep what limits say of the motion in rows: extremal ones know of none."""
    laws = {segment.index: segment for segment in cam.problem.segments}
    return not any(
        row.equality or row_excess(row, laws[free.index], cam.size) > ALLOWED * problem.length
        for free in problem.free
        for row in problem.limit_rows(free)
    )


def _law(segment: PlacedSegment, move: ExtremalMove, grid: Grid, state: BoundaryState) -> SplineLaw:
    """The spline whose acceleration has the values of a move as coefficients, at their abscissae.

    Such a spline is a mean of these values everywhere (Schoenberg's approximation), so it bends no
    more than the move itself does. What it misses its end by, its ramp and the rest mend.
    """
    assert segment.free is not None
    space = SplineSpace(grid.space.degree - 2, grid.space.breaks)
    values = np.interp(space.greville, move.x, move.acceleration) * segment.angle**2 / segment.lift
    at_rest = [segment.free.continuity_at(at_start=start) - 1 for start in (True, False)]
    values[: max(at_rest[0], 0)] = 0.0
    values[len(values) - max(at_rest[1], 0) :] = 0.0
    on_ramp = values * np.abs(values) / np.max(np.abs(values))  # next to nothing elsewhere
    both = [BSpline(space.knots, v, space.degree) for v in (values, on_ramp)]
    speeds, ends = ([float(each.antiderivative(k)(1.0)) for each in both] for k in (1, 2))
    factors = np.linalg.solve([speeds, ends], [0.0, 1.0])
    mended = factors[0] * values + factors[1] * on_ramp
    c = BSpline(space.knots, mended, space.degree).antiderivative(2).c[: grid.space.size]
    return SplineLaw(grid.space, state.expand(c[len(state.first) : len(c) - len(state.last)]))
