"""The relaxation of a traced node, mesh by mesh, and its bound over all laws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import TypeVar

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeSolution, solve
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.branching.node import (
    BindingLimits,
    BoundTask,
    Node,
    excess_along_laws,
    violated_parts,
)
from synthesis.optimise.conic.linear_rows import LinearBlock, Scales, Tightening
from synthesis.optimise.conic.program import ConicModel, formulate, with_rows
from synthesis.optimise.conic.tangent_cuts import TangentPoint
from synthesis.optimise.dual_bound.bound import Bound, dual_bound, infeasibility_bound
from synthesis.optimise.dual_bound.costates import boundary_multipliers
from synthesis.optimise.dual_bound.multiplier_density import MultiplierDensity, PointRuns
from synthesis.optimise.problem.grid import Grid, grid_through, merge_knots, uniform_grid
from synthesis.optimise.propagation.improving_region import ImprovingRegion, Parts
from synthesis.optimise.recovery.candidate import Candidate, recover_cam
from synthesis.optimise.refinement.mesh import MOST_INTERVALS, halve_intervals, refine_mesh
from synthesis.optimise.refinement.row_violations import is_peak, row_violation_peaks
from synthesis.optimise.relaxation import size_rows
from synthesis.optimise.state import SolveState

INTERVALS = 20  # of the first mesh of every node
MESHES, MORE_MESHES = 6, 10
"""Of one relaxation, each finer than the one before, at most; and where its splines hold no better
cam any more: then nothing but knots keeps the bound low."""
VERY_COSTLY = 8.0  # of the mean loss of intervals: halving one takes away seven eighths, as a rule
EARLY_MESHES = 2
"""Of these, up to the first whose knots are kept for the node, and refined for small losses."""
MOST_KEPT = 120  # knots of a law: linear programs on more take longer than their bounds gain
KEPT_LOSS = 2.0
"""Of what is missing: a mesh that loses more says too little of the laws, so a finer one is kept.
"""
MESH_LOSS, LATE_MESH_LOSS = 0.25, 1.0
"""Of what rows must still gain: a loss to coarse knots that does not matter yet; on later meshes,
which take longer."""
SPREAD, DENSE = 28, 200
"""Points between two rows over which their multipliers are distributed; and where finest splines
hold no better cam. What a bound misses falls with the distance of these points."""
ImpliedRows = Sequence[tuple[LinearBlock, LinearBlock, PointRuns | None]]
SAMPLES = 400  # intervals of a law at whose ends limits are looked at
BROKEN = 1e-4  # relative: excess of a row between its points that asks for one more
GAIN = 0.1  # of what is missing: a finer mesh must gain as much for another one


@dataclass(frozen=True, eq=False)
class TracedBox(Node):
    """A box of sizes and a range of values.

    Attributes:
        region: what every better cam of the node satisfies.
        grids: few knots, where the bound asks for them.
        relaxation: the cam of the last one solved, its mesh, and the bound that it gave.
        violated: places on every free law where the cams of relaxations broke linear rows between
            knots: rows are written there too.
        least, most: range of the values of its cams, as far as they belong to no other node.
    """

    task: BoundTask
    region: ImprovingRegion
    grids: tuple[Grid, ...] = ()
    relaxation: tuple[Candidate, tuple[Grid, ...], Bound] | None = None
    violated: tuple[Array, ...] = ()
    least: float = -inf
    most: float = inf

    @property
    def largest_value(self) -> float:
        """The largest value of cams in the node that would be better than the incumbent."""
        return min(self.most, self.task.target)

    @property
    def is_empty(self) -> bool:
        """Whether it holds no such cam."""
        return self.lower >= self.largest_value

    def with_points(self, grids: Sequence[Grid]) -> tuple[Grid, ...]:
        """The meshes with rows at their knots and at ``violated`` alone."""
        both = zip(grids, self.violated or [np.zeros(0) for _ in grids], strict=True)
        return tuple(grid.knots_only.with_points(more) for grid, more in both)

    @property
    def caps_mean_square(self) -> bool:
        """Whether a law is bounded by its mean square: every bound of it is a cone program then."""
        return any(control.cap == inf for control in self.task.controls)


Box = TypeVar("Box", bound=TracedBox)


def rows_of_size(node: TracedBox, scales: Scales) -> list[LinearBlock]:
    """Rows on the size alone that all better cams of a node satisfy."""
    problem, sizes = node.task.problem, node.region.sizes
    rows = list(size_rows.fixed_motion_rows(problem, sizes, scales))
    rows += size_rows.least_norm_rows(problem, sizes, scales)
    norm = problem.objective.norm(problem.machine)
    if norm is not None and isfinite(node.least):
        rows += size_rows.outside_ball_rows(norm, node.least, sizes, scales)
    return rows


def solve_relaxation(state: SolveState, node: Box, *, every_mesh: bool = False) -> Box:
    """Solve the node's relaxation on finer and finer meshes, and keep the best dual bound.

    ``every_mesh``: refine even where rows leave more to gain than knots.
    """
    task, sizes = node.task, node.region.sizes
    # A cam grows in its last size variable: with that left open above there is a cam to every row.
    grown = (sizes[-1][0], task.problem.sizing.bounds[-1][1])
    inside = replace(task.problem.sizing, bounds=(*sizes[:-1], grown))
    problem = replace(task.problem, sizing=inside)
    grids, before, kept_loss = coarse_mesh(node), Bound(-inf, ""), inf
    for number in range(MORE_MESHES):
        # 1. The relaxation: the problem's own rows and those that limits imply at the knots. They
        #    are drawn in as for any cam: this one is offered. The bound is that of the rows asked.
        grids = node.with_points(grids)
        bare = formulate(problem, grids, 0.0, Tightening(state.tighten))
        given = list(size_rows.fixed_motion_rows(problem, sizes, bare.scales))
        given += size_rows.least_norm_rows(problem, sizes, bare.scales)
        implied = node.region.rows(bare, SPREAD, sparing=True)
        model = with_rows(bare, [*given, *(block for block, _, _ in implied)])
        solution = solve(model.program, state.time_left)
        # 2. Its multipliers, distributed over points between the knots: the implied rows hold
        #    there too, and a smoother multiplier gives a better bound over all laws.
        is_infeasible = solution.stopped is StopReason.INFEASIBLE
        if not is_infeasible and solution.stopped not in USABLE:
            return node
        ends = boundary_multipliers(model, solution, task.order)
        bounds = _dual_bounds(model, solution, implied, ends, SPREAD, task.order)
        if is_infeasible:
            for each in bounds:
                node = node.with_bound(each)
            if node.is_empty or state.time_left <= 0.0 or number + 1 >= MESHES:
                break
            grids = halve_intervals(problem, grids)
            continue
        bound = max(bounds, key=lambda each: each.value)
        if not bound.switching:
            return node
        laws, size = model.recover(solution.x)
        cam = recover_cam(problem, laws, size, keep_size=True)
        #    Where the finest splines hold no better cam, more of these points may show that.
        most = max(len(grid.space.breaks) for grid in grids)
        if most > MOST_INTERVALS and bound.value < node.largest_value <= cam.value:
            dense = node.region.rows(bare, DENSE, sparing=True)
            more = _dual_bounds(model, solution, dense, ends, DENSE, task.order)
            bound = max((bound, *more), key=lambda each: each.value)
        # 3. The next program's rows are tangent to the limits at this solution, and are added where
        #    it violates them. They hold for every better cam, wherever they are written.
        node = _with_rows_at(state, node.with_bound(bound), cam, grids, has_rows=bool(implied))
        is_loose = kept_loss > KEPT_LOSS * (node.largest_value - node.lower)
        if number <= EARLY_MESHES or (is_loose and most <= MOST_KEPT):
            node, kept_loss = replace(node, grids=grids), cam.value - bound.value
        node = replace(node, relaxation=(cam, grids, bound))
        # 4. A finer mesh, while this family of splines still has a better cam or costs too much.
        #    Where rows are too few for it, implied ones get more points next time; but not where
        #    bounds are cone programs: there they cost more than they gain.
        if node.is_empty or state.time_left <= 0.0:
            break
        if not _finer_mesh_pays(node, cam, bound, before, number, every_mesh=every_mesh):
            if implied and cam.value < node.largest_value and not node.caps_mean_square:
                node = _with_points(node, _violation_peaks(cam, task.order - 1))
            break
        before = bound
        grids = refine_mesh(problem, grids, cam, bound, very_costly=VERY_COSTLY)
    return node


def _with_rows_at(
    state: SolveState, node: Box, cam: Candidate, grids: tuple[Grid, ...], *, has_rows: bool
) -> Box:
    """The node with next rows tangent at a relaxation's cam, and more where it violates limits.

    ``has_rows``: whether limits had rows in that relaxation. Without any, its cam does not say
    where a relaxation with rows will violate them.
    """
    region, order = node.region, node.task.order
    reference = TangentPoint(tuple(law.curve() for law in cam.laws), cam.size)
    binding, parts = region.binding or frozenset(), dict[int, Parts]()
    if has_rows:
        binding |= BindingLimits.on([cam]).pairs
        known = {law: bounds.parts for (law, _), bounds in region.point_bounds.items()}
        parts = violated_parts(cam, known)
    region = replace(region, reference=reference, binding=binding)
    if parts:
        region = region.with_parts(node.task.problem, node.task.controls, parts)
    # Linear rows get points where the cam violates them most between their own. Rows of the highest
    # order are left out: the multipliers of two that are close alternate, and the bound is worse.
    peaks = row_violation_peaks(replace(state, grids=grids), cam, order - 1)
    return _with_points(replace(node, region=region), peaks)


def _with_points(node: Box, points: Sequence[Array]) -> Box:
    """The node with rows at more points of every law."""
    both = zip(node.violated or points, points, strict=True)
    return replace(node, violated=tuple(np.union1d(*each) for each in both))


def _dual_bounds(
    model: ConicModel, solution: ConeSolution, implied: ImpliedRows, ends: Array, each: int,
    order: int,
) -> list[Bound]:  # fmt: skip
    """Bounds by multipliers, those of implied rows at so many points between two knots."""
    between = [(denser, runs) for _, denser, runs in implied]
    density = MultiplierDensity.of(model, between, each, order)
    evaluate = infeasibility_bound if solution.stopped is StopReason.INFEASIBLE else dual_bound
    return [
        evaluate(density.model, replace(solution, multipliers=masses), ends)
        for masses in density.distribute_single(solution.multipliers, ends)
    ]


def _violation_peaks(cam: Candidate, below: int) -> list[Array]:
    """Points x of every free law where a cam violates limits with rows over boxes most.

    ``below``: those whose rows are of derivatives of a lower order.
    """
    x = np.linspace(0.0, 1.0, SAMPLES + 1)
    return [x[is_peak(excess, BROKEN)] for excess in excess_along_laws(cam, x, below)]


def _finer_mesh_pays(
    node: TracedBox, cam: Candidate, bound: Bound, before: Bound, number: int, *, every_mesh: bool
) -> bool:
    """Whether splines, cam and bound of a mesh, or their loss to its knots, ask for a finer one."""
    missing, lost = node.largest_value - cam.value, cam.value - bound.value
    if not every_mesh:
        fine = lost < (MESH_LOSS if number < EARLY_MESHES else LATE_MESH_LOSS) * missing
        # Knots that gain next to nothing are not what keeps the bound low: a narrower box raises
        # it, and costs no more than a mesh where its bounds are cone programs too.
        idle = bound.value - before.value < GAIN * (node.largest_value - bound.value)
        if (missing > 0.0 and fine) or (node.caps_mean_square and number > EARLY_MESHES and idle):
            return False
    finest = any(len(law.space.breaks) > MOST_INTERVALS for law in cam.laws)
    return number + 1 < MESHES or not (missing > 0.0 or finest)


def coarse_mesh(node: TracedBox) -> tuple[Grid, ...]:
    """Few knots, some of them where rows begin and end."""
    chosen = []
    for position, segment in enumerate(node.task.problem.free):
        hulls = (hull for (law, _), hull in node.region.point_bounds.items() if law == position)
        ends = np.unique([end for hull in hulls for part in hull.parts for end in part])
        breaks = uniform_grid(segment, INTERVALS).space.breaks
        needed = segment.free.knots if segment.free else ()
        chosen.append(grid_through(segment, merge_knots(breaks, ends, needed)))
    return tuple(chosen)
