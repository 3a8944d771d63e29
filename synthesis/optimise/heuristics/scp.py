"""Local optima by cone programs alone: limits that are not convex, each time by their tangents.

Round by round the smooth limits are replaced by their tangents at the last point. What the cone
program finds there is grown until the limits themselves hold; a cam no smaller than the best is
sought half-way back. Under a bounded jerk an optimum is a corner of its rows but for a few
unknowns: there this is Newton's method and ends after three or four rounds, each on a matrix as
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
from synthesis.optimise.problem.grid import Grid, SplineLaw
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate, enlarge_until_feasible, recover_cam
from synthesis.optimise.recovery.constraint_samples import (
    ConstraintSamples,
    add_violated,
    move_samples,
    samples_near,
)

Vector = tuple[float, ...]
ROUNDS = 12
NEAR = -0.6  # limits slacker than this, relative, get no rows
REACH = 0.4  # of the value: by how much a cam may shrink in the first round
BACK = 0.25  # of that, once nothing smaller was found on the way
LEAST_STEP, BOLD = 1.0 / 16.0, 0.5  # of the way; from the latter on tangents move all the way
KEPT = 1e-6  # relative: by how much a start may break rows
STEP = 1e-6  # of a natural unit, for differences
SOURCE = "tangents"


@dataclass(frozen=True)
class ScpTarget:
    """How near a local optimum shall be, relative.

    Attributes:
        close: how far above what the tangents allow its value may lie.
        drawn: by how much smooth limits are drawn in at the points where they are written.
        anew: whether a larger cam than that of the start is welcome: it keeps these.
        sufficient: a value of the objective [core units] at which to stop.
    """

    close: float
    tightened: float
    anew: bool = False
    sufficient: float = -inf


@dataclass(frozen=True, eq=False)
class ScpResult:
    """Where it ended.

    Attributes:
        cam: the best cam, None where there is none. settled: whether it is a local optimum.
        rounds, rows, iterations: cone programs, rows of the last, and iterations of all of them.
    """

    cam: Candidate | None
    settled: bool
    rounds: int
    rows: int
    iterations: int


@dataclass(frozen=True, eq=False)
class Tangent:
    """One expression of a limit at some places of the turn, to first order.

    ``number``: of the expression. ``tightened``: by how much it is drawn in.
    """

    place: ConstraintSamples
    number: int
    cuts: PointInequalities
    tightened: float

    @property
    def finite(self) -> bool:
        """Whether the limit has a value and slopes there."""
        return bool(np.isfinite(self.cuts.upper).all())


def solve_scp(
    model: ConicModel, laws: Sequence[SplineLaw], size: Vector, deadline: float, goal: ScpTarget
) -> ScpResult:
    """Smaller and smaller cams that keep all limits, down to a local optimum.

    Args:
        model: the relaxation; its objective is a norm of the size.
        laws, size: where to begin [mm], best at a cam that keeps all limits.
        deadline: ``time.monotonic()`` at which to stop.
        goal: how near an optimum shall be.
    """
    here = recover_cam(model.problem, *model.recover(model.point(laws, size)), keep_hint=True)
    grown, peaks = enlarge_until_feasible(here), list[ConstraintSamples]()
    keeps = grown is not None and not goal.anew and _satisfies_rows(model, grown)
    best = grown if keeps else None
    here, reach, rows, iterations = grown or here, REACH, 0, 0
    for number in range(ROUNDS):
        # 1. Linearise smooth limits where they nearly bind, within a trust region of the size.
        left = deadline - clock.now()
        tangents = list(_tangents(model, here, peaks, goal.tightened)) if left > 0.0 else None
        if tangents is None or not all(each.finite for each in tangents):
            return ScpResult(best, False, number, rows, iterations)
        blocks = [_block(model, each.place, each.cuts) for each in tangents]
        full = with_rows(model, [*blocks, _trust_region(model, here, reach)])
        # 2. The convex program with these tangents; its cam may break the limits themselves.
        found = solve(full.program, left)
        rows, iterations = len(full.program.rhs), iterations + found.iterations
        if found.stopped not in USABLE:
            return ScpResult(best, False, number + 1, rows, iterations)
        target = recover_cam(model.problem, *model.recover(found.x), keep_hint=True)
        # 3. The farthest cam on the way there that keeps them once enlarged, and is smaller.
        taken, step = _line_search(model, here, target, inf if best is None else best.value)
        peaks += add_violated(
            target.problem, target.size
        )  # where tangents at places said too little
        if taken is None:
            if best is None or here is best:
                return ScpResult(best, False, number + 1, rows, iterations)
            here, reach = best, BACK * reach
            continue
        best = taken
        if best.value <= goal.sufficient:
            return ScpResult(best, True, number + 1, rows, iterations)
        # 4. Stop where tangents at this cam would let it shrink by no more than the tolerance:
        #    the multipliers bound, to first order, what is left to gain.
        free = target.size[-1] > here.size[-1] - 0.99 * reach * here.value
        least = target.value - max(
            _remaining_gain(full, tangents, blocks, target, found.multipliers), 0.0
        )
        if step == 1.0 and free and best.value <= least * (1.0 + goal.close):
            return ScpResult(best, True, number + 1, rows, iterations)
        # tangents are nearest to the truth at the size where the next optimum lies
        here = target if step >= BOLD else taken
        reach *= 2.0 if step == 1.0 else step
    return ScpResult(best, False, ROUNDS, rows, iterations)


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
    """The target cam or one on the way there, grown, that is below a value; and its step."""
    step, tried = 1.0, target
    while step >= LEAST_STEP:
        found = enlarge_until_feasible(tried)
        if found is not None and found.value < value:
            return found, step
        step *= 0.5
        tried = _between(model, here, target, step)
    return None, step


def _between(model: ConicModel, one: Candidate, other: Candidate, share: float) -> Candidate:
    """What lies on the way from one cam to another of the same knots."""
    laws = [
        SplineLaw(b.space, a.coefficients + share * (b.coefficients - a.coefficients))
        for a, b in zip(one.laws, other.laws, strict=True)
    ]
    size = tuple(a + share * (b - a) for a, b in zip(one.size, other.size, strict=True))
    return recover_cam(model.problem, laws, size, keep_hint=True)


def _trust_region(model: ConicModel, here: Candidate, reach: float) -> LinearBlock:
    """The cam shrinks by no more than a share of its value: tangents say nothing far away."""
    growing = -np.eye(len(here.size))[-1]
    least = (here.size[-1] - reach * here.value) / model.scales.size
    return LinearBlock.of_size(growing, np.array([-least]), "")


def _tangents(
    model: ConicModel, here: Candidate, peaks: Sequence[ConstraintSamples], tightened: float
) -> Iterator[Tangent]:
    """Smooth limits to first order, wherever they are near to binding."""
    places = samples_near(here.problem, here.size, NEAR)
    places += [move_samples(peak, here.problem) for peak in peaks]
    for place in places:
        slopes = zip(*_slopes(here.problem, place, here.size), strict=True)
        for number, (value, motion, size) in enumerate(slopes):
            upper = np.sum(motion * place.s, axis=0) + np.array(here.size) @ size - value
            yield Tangent(
                place, number, PointInequalities(motion, size, upper - tightened), tightened
            )


def _remaining_gain(
    full: ConicModel,
    tangents: Sequence[Tangent],
    blocks: Sequence[LinearBlock],
    target: Candidate,
    z: Array,
) -> float:
    """What tangents at the target cam would let it shrink by, to first order: by multipliers."""
    program, gain = full.program, 0.0
    at = program.equalities + program.inequalities - 1 - sum(len(each.rhs) for each in blocks)
    for tangent, own in zip(tangents, blocks, strict=True):
        place, cuts = move_samples(tangent.place, target.problem), tangent.cuts
        value = _expressions(target.problem, place)(place.s, target.size)[tangent.number]
        linear = np.sum(cuts.coefficients * place.s, axis=0) + np.array(target.size) @ cuts.size
        at_target = _block(
            full, place, replace(cuts, upper=linear - value - tangent.tightened), bare=True
        )
        gain += float(z[at : at + len(own.rhs)] @ (at_target.rhs - own.rhs))
        at += len(own.rhs)
    return gain * full.scales.size


def _block(
    model: ConicModel, place: ConstraintSamples, cuts: PointInequalities, *, bare: bool = False
) -> LinearBlock:
    """The rows at the points of a place; where the law is given they are about the size alone."""
    segment = model.problem.segments[place.position]
    if segment.law is None:
        position = model.problem.free.index(segment)
        grid = Grid(model.grids[position].space, place.x)
        return cut_block(
            cuts, SOURCE, position, segment, grid, model.scales, Tightening(), bare=bare
        )
    size = cuts.size.T * model.scales.size
    scale = np.maximum(np.max(np.abs(size), axis=1), 1e-300)
    room = cuts.upper - np.sum(cuts.coefficients * place.s, axis=0)
    return LinearBlock.of_size(size / scale[:, None], room / scale, SOURCE)


def _expressions(settled: Problem, place: ConstraintSamples) -> Callable[[Array, Vector], Array]:
    """A limit's expressions at its places as a function of motion (4, k) and size: (rows, k)."""
    segment, limit = settled.segments[place.position], settled.limits[place.limit]
    theta = segment.start + segment.angle * place.x
    return lambda s, z: np.stack(limit.smooth_constraints(segment, settled.machine, theta, s, z))


def _slopes(settled: Problem, place: ConstraintSamples, size: Vector) -> tuple[Array, Array, Array]:
    """A limit's expressions at its places: values (rows, k), slopes (rows, 4, k), (rows, n, k).

    By central differences: a limit is stated once, for numbers and symbols alike.
    """
    expressions, step = _expressions(settled, place), STEP * settled.length
    angle, motion, sizes = settled.segments[place.position].angle, list[Array](), list[Array]()
    for order in range(4):
        by = step / angle**order * np.eye(4)[:, [order]]
        motion.append(
            (expressions(place.s + by, size) - expressions(place.s - by, size)) / (2.0 * by[order])
        )
    for axis in range(len(size)):
        more, less = (
            tuple(v + sign * step * (k == axis) for k, v in enumerate(size)) for sign in (1.0, -1.0)
        )
        sizes.append((expressions(place.s, more) - expressions(place.s, less)) / (2.0 * step))
    return expressions(place.s, size), np.stack(motion, 1), np.stack(sizes, 1)
