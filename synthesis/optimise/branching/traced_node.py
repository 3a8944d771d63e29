"""Nodes of the branch and bound where limits imply rows over boxes of a traced point, or of motion.

The relaxation leaves these limits out (curvature, Hertz pressure, those of swinging faces), or its
rows are not exact (the pressure angle of arms). But a cam that is better than the incumbent by the
tolerance satisfies the rows of the relaxation and a cap on its value; so its size lies in a box and
its traced point within bounds, which duality gives over all laws. Over these bounds the limits
imply linear rows (McCormick's under-estimators, and planes). Rows and bounds are tightened in turn,
until the node is empty or the bounds no longer change. Then it is divided, in a size or in the
value.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Self

import numpy as np

from synthesis.numerics import clock
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.branching.node import BindingLimits, BoundTask, Node, Tree, halve, is_traced
from synthesis.optimise.conic.linear_rows import LinearBlock, Scales
from synthesis.optimise.conic.program import formulate, with_rows
from synthesis.optimise.conic.tangent_cuts import TangentPoint
from synthesis.optimise.dual_bound.batch import MultiplierDensity
from synthesis.optimise.dual_bound.bound import Bound, dual_bound, infeasibility_bound
from synthesis.optimise.dual_bound.costates import boundary_multipliers
from synthesis.optimise.heuristics.local_search import improve_from
from synthesis.optimise.problem.grid import Grid, grid_through, merge_knots, uniform_grid
from synthesis.optimise.propagation.bound_tightening import tighten_bounds
from synthesis.optimise.propagation.improving_region import ImprovingRegion, initial_region
from synthesis.optimise.propagation.law_tightening import with_value_cap
from synthesis.optimise.recovery.candidate import Candidate, recover_cam
from synthesis.optimise.refinement.mesh import MOST_INTERVALS, halve_intervals, refine_mesh
from synthesis.optimise.refinement.row_violations import row_violations
from synthesis.optimise.relaxation import size_rows
from synthesis.optimise.state import SolveState, Stage

INTERVALS = 20  # of the first mesh of every node
SAMPLES = 200  # points of a segment at which limits are looked at
SPARE = 1e-9  # relative slack of a value that is held, against rounding
FIRST_ITERATIONS, ITERATIONS, FEW_ITERATIONS = 3, 8, 2
"""Of bounds and rows in a node: before a better cam is looked for, at most, if not thorough."""
WIDTH_KEPT = 0.85  # of the bounds' width: an iteration that leaves more is idle
MESHES, MORE_MESHES = 6, 10
"""Of one relaxation, each finer than the one before, at most; and where its splines hold no better
cam any more: then nothing but knots keeps the bound low."""
VERY_COSTLY = 8.0  # of the mean loss of intervals: halving one takes away seven eighths, as a rule
EARLY_MESHES = 2
"""Of these, up to the first whose knots are kept for the node, and refined for small losses."""
MESH_LOSS, LATE_MESH_LOSS = 0.25, 1.0
"""Of what rows must still gain: a loss to coarse knots that does not matter yet; on later meshes,
which take longer."""
SPREAD = 28  # points between two rows over which their multipliers are distributed
GAIN = 0.1  # of what is missing: a finer mesh must gain as much for another one
CAM_HALVINGS = 2
"""Of the intervals of a bound's mesh, for a cam: what knots cost it falls to a tenth of a percent
of the size."""
MOST_CUT = 300  # knots of all laws: more are near enough, and cone programs on twice as many slow
FEW_NODES = 3  # at most, where the budget of a proof is spent and the gap is wide
WIDE = 0.05  # relative gap that is wide
VALUE_SPLIT = 0.4  # of the widest size: values of a node farther apart than that are divided first


@dataclass(frozen=True, eq=False)
class TracedNode(Node):
    """A box of sizes and a range of values.

    Attributes:
        region: what every better cam of the node satisfies.
        grids: few knots, where the bound asks for them.
        relaxation: the cam of the last one solved, its mesh, and the bound that it gave.
        least, most: range of the values of its cams, as far as they belong to no other node.
    """

    task: BoundTask
    region: ImprovingRegion
    grids: tuple[Grid, ...] = ()
    relaxation: tuple[Candidate, tuple[Grid, ...], Bound] | None = None
    least: float = -inf
    most: float = inf

    @classmethod
    def root(cls, state: SolveState) -> Self | None:
        """The whole domain; None where there is nothing to prove, or no way to.

        A quick proof is begun for limits on forces alone.
        """
        started, best, problem = state.stopwatch, state.incumbent, state.problem
        if best is None or problem.objective.quasiconvex or not problem.free:
            return None
        if problem.for_every_size:
            return None  # its boxes of sizes end where the search does
        forces = [limit for limit in problem.limits if limit.needs_load]
        if not state.thorough and not any(is_traced(state, limit) for limit in forces):
            return None
        binding = BindingLimits.on((best, state.relaxed))
        if not binding.pairs and not size_rows.binds_on_fixed_motion(best.problem, best.size):
            return None
        task = BoundTask.of(state, best, state.proof_deadline)
        if task is None:
            return None
        decisive = {problem.limits[number] for _, number in BindingLimits.on([best]).pairs}
        if not all(is_traced(state, limit, task.order) for limit in decisive):
            return None  # a limit that has no rows decides: no bound closes the gap
        region = initial_region(task.problem, task.controls, binding.parts)
        region = replace(region, binding=binding.pairs)
        return cls(
            task, region, lower=state.lower, valid_for=state.valid_for, is_first=True,
            started=started,
        )  # fmt: skip

    def node_limit(self, state: SolveState) -> float:
        if state.thorough:
            return inf
        return FEW_NODES if self.lower < (1.0 - WIDE) * self.task.target else 1

    def is_pruned(self, state: SolveState) -> bool:
        return self.lower >= self.task.target

    @property
    def largest_value(self) -> float:
        """The largest value of cams in the node that would be better than the incumbent."""
        return min(self.most, self.task.target)

    @property
    def is_empty(self) -> bool:
        """Whether it holds no such cam."""
        return self.lower >= self.largest_value

    def process(self, state: SolveState) -> tuple[SolveState, Node]:
        inside = replace(state, deadline=self.task.deadline)
        if not self.is_first:
            return state, tighten(inside, replace(self, upper_half=False), ITERATIONS)._processed()
        node, gained = solve_relaxation(inside, self), True
        for iterations in (FIRST_ITERATIONS, ITERATIONS):
            node = tighten(inside, node, iterations)
            if node.is_pruned(state) or inside.time_left <= 0.0 or not state.thorough:
                break
            if gained:  # where one search found nothing better, none later does
                before = inside.incumbent
                inside, node = _improve_incumbent(inside, node)
                gained = inside.incumbent is not before
        return replace(inside, deadline=state.deadline), node._processed()

    def _processed(self) -> TracedNode:
        """The node as it counts: one without a better cam has none below the target."""
        node = replace(self, processed=True)
        return replace(node, lower=self.task.target) if self.is_empty else node

    def branch(self, state: SolveState) -> tuple[SolveState, Sequence[Node]]:
        """Divide across the widest size, or across the value where its range is wider.

        Not across the last size while there is another: a cam grows in it, so that it bounds
        nothing. Of two halves of the value the better one is processed first: it may be all that
        there is time for.
        """
        if not self.region.is_divisible or clock.now() >= self.task.deadline:
            return state, ()
        child, sizes = replace(self, processed=False, is_first=False), self.region.sizes
        widths = [high - low for low, high in sizes]
        low, high = max(self.least, self.lower), self.largest_value
        norm = self.task.problem.objective.norm(self.task.problem.machine)
        if norm is not None and high - low > VALUE_SPLIT * max(widths[:-1], default=0.0):
            middle = 0.5 * (low + high)
            worse = replace(child, least=middle, lower=max(self.lower, middle), upper_half=True)
            return state, (replace(child, least=low, most=middle), worse)
        boxes = halve(sizes, int(np.argmax(widths[:-1] if any(widths[:-1]) else widths)))
        return state, [replace(child, region=self.region.restrict(box)) for box in boxes]

    def conclude(self, state: SolveState, tree: Tree) -> SolveState:
        """Raise the bound to that of the lowest leaf, after finer meshes for it.

        Where rows gain nothing more, finer knots still may.
        """
        leaves = [leaf for leaf in tree.leaves if isinstance(leaf, TracedNode)]
        lowest = min(leaves, key=lambda leaf: leaf.lower)
        while state.thorough and not lowest.is_pruned(state) and state.time_left > 0.0:
            finer = solve_relaxation(state, lowest, every_mesh=True)._processed()
            if finer.lower <= lowest.lower + GAIN * (lowest.task.target - lowest.lower):
                break
            leaves = [finer if leaf is lowest else leaf for leaf in leaves]
            lowest = min(leaves, key=lambda leaf: leaf.lower)
        # a limit that binds on the cam but had no rows is not in the bound
        limits = enumerate(state.problem.limits)
        binding = BindingLimits.on([state.incumbent]).pairs
        missed = {number for _, number in binding - (lowest.region.binding or frozenset())}
        order = lowest.task.order
        traced = {x.kind for k, x in limits if is_traced(state, x, order) and k not in missed}
        lower = min(lowest.lower, lowest.task.target)
        state = replace(state, modelled_kinds=traced).raise_bound(lower, lowest.valid_for)
        return state.with_stage(
            Stage(
                "implied rows", f"linear and cone programs in {tree.count} boxes",
                "HiGHS, Clarabel", 0, 0, 0, state.stopwatch - self.started, "solved",
                "what a better cam keeps to, and the rows that its curvature implies there",
                tree.count,
            )
        )  # fmt: skip


def _improve_incumbent(state: SolveState, node: TracedNode) -> tuple[SolveState, TracedNode]:
    """A local search on the node's mesh; where it finds a better cam, the task is about that.

    The mesh is where the ideal law has its switches inside the node: fewer knots do more there
    than those with which the relaxation without curvature ended. It is finer than the bound's,
    whose laws may jump: a cam takes more along arcs of curvature, and on ramps of smooth laws.
    """
    if node.relaxation is None:
        return state, node
    cam, grids, bound = node.relaxation
    if any(len(grid.space.breaks) > MOST_INTERVALS for grid in grids):
        grids = node.grids  # those were for the bound's last digits
    grids = refine_mesh(state.problem, grids, cam, bound)
    for _ in range(CAM_HALVINGS):
        if sum(len(grid.space.breaks) for grid in grids) < MOST_CUT:
            grids = halve_intervals(state.problem, grids)
    points, _ = row_violations(replace(state, grids=grids), cam)
    both = zip(grids, points, strict=True)
    state = improve_from(replace(state, grids=tuple(g.with_points(x) for g, x in both)), cam)
    best = state.incumbent
    assert best is not None
    if best.value >= node.task.incumbent.value:
        return state, node
    return state, replace(node, task=BoundTask.of(state, best, node.task.deadline) or node.task)


def tighten(state: SolveState, node: TracedNode, iterations: int) -> TracedNode:
    """Tighten bounds and rows in iterations, each from what the other has shown.

    All laws are tightened at first, and once more before it is given up; in between only those on
    which the relaxation's solution violates a limit: other bounds would not cut it off. At the root
    a quick proof has few iterations, and so has one whose budget has ended.
    """
    among = every = tuple(range(len(node.task.problem.free)))
    for iteration in range(iterations):
        if node.is_empty or not node.grids or state.time_left <= 0.0:
            break
        if node.is_first and iteration >= FEW_ITERATIONS and not state.thorough:
            break
        before, region = node.region.for_laws(among).mean_width, _tighten_region(state, node, among)
        if region is None:
            return solve_relaxation(state, node) if state.time_left > 0.0 else node
        if region.is_empty:
            return replace(node, lower=node.largest_value)
        node = solve_relaxation(state, replace(node, region=region))
        idle = region.for_laws(among).mean_width > WIDTH_KEPT * before
        if idle and among == every:
            break
        among = every if idle else _violating_laws(node) or every
    return node


def _violating_laws(node: TracedNode) -> tuple[int, ...]:
    """The laws of the relaxation's solution that violate limits."""
    reference, problem = node.region.reference, node.task.problem
    if reference is None:
        return ()
    x = np.linspace(0.0, 1.0, SAMPLES + 1)
    violating = []
    for k in sorted({position for position, _ in node.region.point_bounds}):
        law = problem.free[k].with_law(reference.laws[k])
        theta = law.start + law.angle * x
        if np.max(size_rows.relative_excess(problem, law, theta, reference.size)) > 0.0:
            violating.append(k)
    return tuple(violating)


def _tighten_region(
    state: SolveState, node: TracedNode, among: Collection[int]
) -> ImprovingRegion | None:
    """The region with tighter bounds of the laws ``among``; None where no law could be bounded.

    A law for which the coarse mesh has no spline under the capped value says nothing. For those the
    cap is raised by what the incumbent is above the target, then their intervals are halved.
    """
    task, grids = node.task, tuple(grid.knots_only for grid in node.grids)
    region = node.region.with_closer_nodes(among)
    region = region.restrict(size_rows.tighten_sizes(task.problem, region.sizes))
    if region.is_empty:
        return region
    pending = frozenset(among)
    slack = (1.0 + SPARE) * task.incumbent.value - task.target
    last = state.last_program if state.programs else inf  # a quick proof has few iterations
    for number, extra in enumerate((0.0, slack, slack)):
        if state.time_left <= 0.0 or not pending or region.is_empty:
            break
        if number == 2:
            finer = halve_intervals(task.problem, grids)
            both = enumerate(zip(grids, finer, strict=True))
            grids = tuple(new.knots_only if k in pending else old for k, (old, new) in both)
        problem = with_value_cap(task.problem, node.largest_value + extra)
        model = formulate(problem, grids)
        model = with_rows(model, _size_rows(replace(node, region=region), model.scales))
        region, pending = tighten_bounds(
            model, task.controls, region, pending, state.time_left, last
        )
    return None if pending == frozenset(among) else region


def _size_rows(node: TracedNode, scales: Scales) -> list[LinearBlock]:
    """Rows on the size alone that all better cams of a node satisfy."""
    problem, sizes = node.task.problem, node.region.sizes
    rows = list(size_rows.fixed_motion_rows(problem, sizes, scales))
    rows += size_rows.least_norm_rows(problem, sizes, scales)
    norm = problem.objective.norm(problem.machine)
    if norm is not None and isfinite(node.least):
        rows += size_rows.outside_ball_rows(norm, node.least, sizes, scales)
    return rows


def solve_relaxation(
    state: SolveState, node: TracedNode, *, every_mesh: bool = False
) -> TracedNode:
    """Solve the node's relaxation on finer and finer meshes, and keep the best dual bound.

    ``every_mesh``: refine even where rows leave more to gain than knots.
    """
    task, sizes = node.task, node.region.sizes
    # A cam grows in its last size variable: with that left open above there is a cam to every row.
    grown = (sizes[-1][0], task.problem.sizing.bounds[-1][1])
    inside = replace(task.problem.sizing, bounds=(*sizes[:-1], grown))
    problem = replace(task.problem, sizing=inside)
    grids = _coarse_mesh(node)
    for number in range(MORE_MESHES):
        # 1. The relaxation: the problem's own rows and those that limits imply at the knots.
        grids = tuple(grid.knots_only for grid in grids)
        bare = formulate(problem, grids)
        given = list(size_rows.fixed_motion_rows(problem, sizes, bare.scales))
        given += size_rows.least_norm_rows(problem, sizes, bare.scales)
        implied = node.region.rows(bare, SPREAD, sparing=True)
        model = with_rows(bare, [*given, *(block for block, _, _ in implied)])
        solution = solve(model.program, state.time_left)
        # 2. Its multipliers, distributed over points between the knots: the implied rows hold
        #    there too, and a smoother multiplier gives a better bound over all laws.
        between = [(denser, runs) for _, denser, runs in implied]
        density = MultiplierDensity.of(model, between, SPREAD, task.order)
        ends = boundary_multipliers(model, solution, task.order)
        distributed = [
            replace(solution, multipliers=masses)
            for masses in density.distribute_single(solution.multipliers, ends)
        ]
        if solution.stopped is StopReason.INFEASIBLE:
            for each in distributed:
                node = node.with_bound(infeasibility_bound(density.model, each, ends))
            if node.is_empty or state.time_left <= 0.0 or number + 1 >= MESHES:
                break
            grids = halve_intervals(problem, grids)
            continue
        if solution.stopped not in USABLE:
            return node
        bounds = [dual_bound(density.model, each, ends) for each in distributed]
        bound = max(bounds, key=lambda each: each.value)
        if not bound.switching:
            return node
        # 3. The solution is where the next rows are tangent.
        laws, size = model.recover(solution.x)
        cam = recover_cam(problem, laws, size, keep_hint=True)
        reference = TangentPoint(tuple(law.curve() for law in laws), size)
        binding = node.region.binding or frozenset()
        if implied:  # without any rows the solution shows nothing
            binding |= BindingLimits.on([cam]).pairs
        region = replace(node.region, reference=reference, binding=binding)
        node = replace(node.with_bound(bound), region=region)
        if number <= EARLY_MESHES:
            node = replace(node, grids=grids)
        node = replace(node, relaxation=(cam, grids, bound))
        # 4. A finer mesh, while this family of splines still has a better cam or costs too much.
        if node.is_empty or state.time_left <= 0.0:
            break
        missing, lost = node.largest_value - cam.value, cam.value - bound.value
        fine = lost < (MESH_LOSS if number < EARLY_MESHES else LATE_MESH_LOSS) * missing
        if missing > 0.0 and fine and not every_mesh:
            break
        finest = any(len(grid.space.breaks) > MOST_INTERVALS for grid in grids)
        if number + 1 >= MESHES and (missing > 0.0 or finest):
            break
        grids = refine_mesh(problem, grids, cam, bound, very_costly=VERY_COSTLY)
    return node


def _coarse_mesh(node: TracedNode) -> tuple[Grid, ...]:
    """Few knots, some of them where rows begin and end."""
    chosen = []
    for position, segment in enumerate(node.task.problem.free):
        hulls = (hull for (law, _), hull in node.region.point_bounds.items() if law == position)
        ends = np.unique([end for hull in hulls for part in hull.parts for end in part])
        breaks = uniform_grid(segment, INTERVALS).space.breaks
        needed = segment.free.knots if segment.free else ()
        chosen.append(grid_through(segment, merge_knots(breaks, ends, needed)))
    return tuple(chosen)
