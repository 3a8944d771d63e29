"""Local optima by cone programs alone: limits that are not convex, each time by their tangents.

In each iteration the smooth limits are replaced by their tangents at the last point. What the cone
program finds there is grown until the limits themselves hold; a cam no smaller than the best is
sought half-way back. Under a bounded jerk an optimum is a corner of its rows but for a few
unknowns: there this is Newton's method and ends after three or four programs, each on a matrix as
sparse as the laws are many. (Sequential convex programming.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf

import numpy as np

from synthesis.catalogue.constraints import PointInequalities
from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import USABLE
from synthesis.optimise.conic.linear_rows import LinearBlock, Tightening
from synthesis.optimise.conic.program import ConicModel, with_rows
from synthesis.optimise.conic.tangent_cuts import cut_block
from synthesis.optimise.dual_bound.bound import in_problem_units
from synthesis.optimise.problem.grid import Grid, SplineLaw
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate, enlarge_until_feasible, recover_cam
from synthesis.optimise.recovery.smooth_limits import (
    ConstraintSamples,
    add_violated,
    constraint_samples,
    move_samples,
)

Vector = tuple[float, ...]
MAX_PROGRAMS = 12  # convex programs at most; three or four suffice where the iteration converges
NEAR = -0.6  # relative value of a smooth limit below which it gets no tangent
REACH = 0.4  # share of the value by which a cam may shrink in the first iteration: the trust region
BACK = 0.25  # factor on the trust region where no smaller cam lies on the way
LEAST_STEP, BOLD = 1.0 / 16.0, 0.5
"""Shares of the way to the target: the least that is tried; from which on tangents move there."""
KEPT = 1e-6  # relative excess of rows by a start that counts as rounding
STEP = 1e-6  # of a natural unit, for central differences: their error is about its square
SOURCE = "tangents"


@dataclass(frozen=True)
class ScpTarget:
    """How near a local optimum shall be, relative.

    Attributes:
        close: how far above what the tangents allow its value may lie.
        tightened: by how much smooth limits are tightened at the points where they are written.
        anew: whether a larger cam than that of the start is welcome: it keeps these.
        sufficient: a value of the objective [problem units] at which to stop.
    """

    close: float
    tightened: float
    anew: bool = False
    sufficient: float = -inf


@dataclass(frozen=True, eq=False)
class ScpResult:
    """Where it ended.

    Attributes:
        cam: the best cam, None where there is none. converged: whether it is a local optimum.
        programs, rows, iterations: cone programs, rows of the last, and iterations of all of them.
    """

    cam: Candidate | None
    converged: bool
    programs: int
    rows: int
    iterations: int


@dataclass(frozen=True, eq=False)
class Tangent:
    """One expression of a limit at some points of the turn, to first order; its rows.

    ``number``: of the expression.
    """

    samples: ConstraintSamples
    number: int
    cuts: PointInequalities
    block: LinearBlock


def solve_scp(
    model: ConicModel, laws: Sequence[SplineLaw], size: Vector, deadline: float, goal: ScpTarget
) -> ScpResult:
    """Smaller and smaller cams that keep all limits, down to a local optimum.

    Args:
        model: the relaxation; its objective is a norm of the size.
        laws, size: where to begin [length], best at a cam that keeps all limits.
        deadline: ``time.monotonic()`` at which to stop.
        goal: how near an optimum shall be.
    """
    here = recover_cam(model.problem, *model.recover(model.point(laws, size)), keep_size=True)
    enlarged, peaks = enlarge_until_feasible(here), list[ConstraintSamples]()
    keeps = enlarged is not None and not goal.anew and _satisfies_rows(model, enlarged)
    best = enlarged if keeps else None
    here, reach = enlarged or here, REACH
    converged, programs, rows, iterations = False, 0, 0, 0
    radius = model.problem.machine.follower.radius_norm()
    while programs < MAX_PROGRAMS and (left := deadline - clock.now()) > 0.0:
        # 1. Linearise smooth limits where they nearly bind, within a trust region of the size.
        tangents = list(_tangents(model, here, peaks, goal.tightened))
        if not all(np.isfinite(each.cuts.upper).all() for each in tangents):
            break
        shrink = -np.eye(len(here.size))[-1]
        far = reach * radius.value(here.size)
        least_size = (here.size[-1] - far) / model.scales.size
        trust = LinearBlock.of_size(shrink, np.array([-least_size]), "")
        full = with_rows(model, [*(each.block for each in tangents), trust])
        # 2. The convex program with these tangents; its cam may violate the limits themselves.
        solution = solve(full.program, left)
        programs, rows = programs + 1, len(full.program.rhs)
        iterations += solution.iterations
        if solution.stopped not in USABLE:
            break
        target = recover_cam(model.problem, *model.recover(solution.x), keep_size=True)
        # 3. The farthest cam on the way there that satisfies them once enlarged, and is smaller.
        candidate, step = _line_search(model, here, target, inf if best is None else best.value)
        # where the limits are violated between the points of the tangents, more of these
        added = add_violated(target.problem, target.size)
        peaks += added
        if candidate is None:
            if best is None or here is best:
                break
            here, reach = best, BACK * reach
            continue
        best = candidate
        if best.value <= goal.sufficient:
            converged = True
            break
        # 4. Stop where tangents at this cam would let it shrink by no more than the tolerance:
        #    the multipliers bound, to first order, what is left to gain.
        free = target.size[-1] > here.size[-1] - 0.99 * far
        gain = _remaining_gain(full, tangents, goal.tightened, target, solution.multipliers)
        value = full.program.value(solution.x)
        lost = in_problem_units(full, value) - in_problem_units(full, value - max(gain, 0.0))
        least = target.value - lost
        if step == 1.0 and free and best.value <= least * (1.0 + goal.close):
            converged = True
            break
        # 5. Tangents move to the target: they are nearest to the truth at the size where the next
        #    optimum lies. The trust region follows the step, but not where points without a
        #    tangent cut the step short: these have one now.
        cut_short = step < 1.0 and bool(added)
        here = target if step >= BOLD and not cut_short else candidate
        reach *= 2.0 if step == 1.0 else 1.0 if cut_short else step
    return ScpResult(best, converged, programs, rows, iterations)


def _satisfies_rows(model: ConicModel, cam: Candidate) -> bool:
    """Whether a cam keeps the model's rows and cones: a neighbour's may not."""
    program = model.program
    slack = program.rhs - program.matrix @ model.point(cam.laws, cam.size)
    at = program.equalities + program.inequalities
    ends = np.cumsum([at, *program.cones])
    cones = [slack[a] - np.linalg.norm(slack[a + 1 : b]) for a, b in pairwise(ends)]
    least = min(*cones, *slack[program.equalities : at], *-np.abs(slack[: program.equalities]))
    return bool(least >= -KEPT)


def _line_search(
    model: ConicModel, here: Candidate, target: Candidate, value: float
) -> tuple[Candidate | None, float]:
    """The target cam or one on the way there, enlarged, that is below a value; and its step."""
    step, trial = 1.0, target
    while step >= LEAST_STEP:
        cam = enlarge_until_feasible(trial)
        if cam is not None and cam.value < value:
            return cam, step
        step *= 0.5
        laws = [
            SplineLaw(b.space, a.coefficients + step * (b.coefficients - a.coefficients))
            for a, b in zip(here.laws, target.laws, strict=True)
        ]
        size = tuple(a + step * (b - a) for a, b in zip(here.size, target.size, strict=True))
        trial = recover_cam(model.problem, laws, size, keep_size=True)
    return None, step


def _tangents(
    model: ConicModel, here: Candidate, peaks: Sequence[ConstraintSamples], tightened: float
) -> Iterator[Tangent]:
    """Smooth limits to first order, wherever they are near to binding."""
    points = constraint_samples(here.problem, here.size, NEAR, NEAR)
    points += [move_samples(peak, here.problem) for peak in peaks]
    for samples in points:
        slopes = zip(*_slopes(here.problem, samples, here.size), strict=True)
        for number, (value, motion, size) in enumerate(slopes):
            upper = np.sum(motion * samples.s, axis=0) + np.array(here.size) @ size - value
            cuts = PointInequalities(motion, size, upper - tightened)
            yield Tangent(samples, number, cuts, _block(model, samples, cuts))


def _remaining_gain(
    full: ConicModel, tangents: Sequence[Tangent], tightened: float, target: Candidate, z: Array
) -> float:
    """What tangents at the target cam would gain, to first order, by multipliers: of the program's
    objective.
    """
    program, gain = full.program, 0.0
    counts = [len(each.block.rhs) for each in tangents]
    at = program.equalities + program.inequalities - 1 - sum(counts)
    for tangent, count in zip(tangents, counts, strict=True):
        samples, cuts = move_samples(tangent.samples, target.problem), tangent.cuts
        value = _expressions(target.problem, samples)(samples.s, target.size)[tangent.number]
        linear = np.sum(cuts.coefficients * samples.s, axis=0) + np.array(target.size) @ cuts.size
        moved = replace(cuts, upper=linear - value - tightened)
        change = _block(full, samples, moved, bare=True).rhs - tangent.block.rhs
        gain += float(z[at : at + count] @ np.nan_to_num(change, posinf=0.0, neginf=0.0))
        at += count
    return gain


def _block(
    model: ConicModel, samples: ConstraintSamples, cuts: PointInequalities, *, bare: bool = False
) -> LinearBlock:
    """The rows at some points; where the law is given they are about the size alone."""
    segment = model.problem.segments[samples.position]
    if segment.law is None:
        position = model.problem.free.index(segment)
        grid = Grid(model.grids[position].space, samples.x)
        return cut_block(
            cuts, SOURCE, position, segment, grid, model.scales, Tightening(), bare=bare
        )
    size = cuts.size.T * model.scales.size
    scale = np.maximum(np.max(np.abs(size), axis=1), 1e-300)
    slack = cuts.upper - np.sum(cuts.coefficients * samples.s, axis=0)
    return LinearBlock.of_size(size / scale[:, None], slack / scale, SOURCE)


def _expressions(problem: Problem, samples: ConstraintSamples) -> Callable[[Array, Vector], Array]:
    """A limit's expressions at its points as a function of motion (4, k) and size: (rows, k)."""
    segment, limit = problem.segments[samples.position], problem.limits[samples.limit]
    theta = segment.start + segment.angle * samples.x

    @np.errstate(divide="ignore", invalid="ignore")  # a trace that stands still has no curvature
    def values(s: Array, z: Vector) -> Array:
        return np.stack(limit.smooth_constraints(segment, problem.machine, theta, s, z))

    return values


def _slopes(
    problem: Problem, samples: ConstraintSamples, size: Vector
) -> tuple[Array, Array, Array]:
    """A limit's expressions at its points: values (rows, k), slopes (rows, 4, k), (rows, n, k).

    By central differences: a limit is stated once, for numbers and symbols alike. Where one has no
    tangent, as the curvature of a trace that stands still, the row asks for nothing: 0 ≤ 1.
    """
    expressions, step = _expressions(problem, samples), STEP * problem.length
    angle, z = problem.segments[samples.position].angle, np.array(size)

    def slope(ds: Array, dz: Array, by: float) -> Array:
        more = expressions(samples.s + ds, tuple(z + dz))
        return (more - expressions(samples.s - ds, tuple(z - dz))) / (2.0 * by)

    still, same = np.zeros((4, 1)), np.zeros(len(z))
    steps = step / angle ** np.arange(4)
    motion = [slope(by * row[:, None], same, by) for row, by in zip(np.eye(4), steps, strict=True)]
    sizes = [slope(still, step * row, step) for row in np.eye(len(z))]
    value, by_motion = expressions(samples.s, size), np.stack(motion, 1)
    by_size = np.stack(sizes, 1)
    smooth = np.isfinite(value + by_motion.sum(axis=1) + by_size.sum(axis=1))
    return (
        np.where(smooth, value, -1.0),
        np.where(smooth[:, None], by_motion, 0.0),
        np.where(smooth[:, None], by_size, 0.0),
    )
