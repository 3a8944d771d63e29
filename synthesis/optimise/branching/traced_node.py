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
from math import inf
from typing import Self

import numpy as np

from synthesis.numerics import clock
from synthesis.optimise.branching.node import BindingLimits, BoundTask, Node, Tree, halve, is_traced
from synthesis.optimise.branching.traced_relaxation import (
    GAIN,
    TracedBox,
    coarse_mesh,
    rows_of_size,
    solve_relaxation,
)
from synthesis.optimise.conic.program import formulate, with_rows
from synthesis.optimise.heuristics.local_search import improve_from, offer_local_optimum
from synthesis.optimise.problem.grid import count_knots, grid_through
from synthesis.optimise.propagation.bound_tightening import tighten_bounds
from synthesis.optimise.propagation.improving_region import ImprovingRegion, initial_region
from synthesis.optimise.propagation.law_tightening import with_value_cap
from synthesis.optimise.refinement.mesh import MOST_INTERVALS, halve_intervals, refine_mesh
from synthesis.optimise.refinement.row_violations import row_violations
from synthesis.optimise.relaxation import size_rows
from synthesis.optimise.state import SolveState, Stage

SAMPLES = 200  # points of a segment at which limits are looked at
SPARE = 1e-9  # relative slack of a value that is held, against rounding
FIRST_ITERATIONS, ITERATIONS, FEW_ITERATIONS = 2, 8, 2
"""Of bounds and rows in a node: before a better cam is looked for, after that, if not thorough."""
SIZE_KEPT = 0.8  # of the widest size: what bounds of the size must leave less of for new rows
ANEW = 0.3  # of the widest size at which laws were bounded: a part as narrow has theirs anew
WIDTH_KEPT = 0.85  # of the bounds' width: an iteration that leaves more is idle
CAM_HALVINGS = 2
"""Of the intervals of a bound's mesh, for a cam: what knots cost it falls to a tenth of a percent
of the size."""
MOST_CUT, MOST_KNOTS = 300, 500
"""Knots of all laws: more are near enough for a cam, and cone programs on twice as many slow; and
a bound's mesh with more is for its last digits."""
FEW_NODES = 3  # at most, where the budget of a proof is spent and the gap is wide
WIDE = 0.05  # relative gap that is wide
SEARCHED = 0.25  # of the gap at which a better cam was sought: at which one is sought again
VALUE_SPLIT = 0.4  # of the widest size: values of a node farther apart than that are divided first


@dataclass(frozen=True, eq=False)
class TracedNode(TracedBox):
    """A box of sizes and a range of values, as a node of the tree.

    Attributes:
        laws_bounded_at: the widest size of the part in which its laws were bounded.
        searched_at: the gap at which a better cam was sought; 0 where that found none.
    """

    laws_bounded_at: float = inf
    searched_at: float = inf

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
        return state.suffices or self.lower >= self.task.target

    def process(self, state: SolveState) -> tuple[SolveState, Node]:
        inside = replace(state, deadline=self.task.deadline)
        if not self.is_first:
            node = _about_incumbent(state, replace(self, upper_half=False))
            if self.caps_mean_square:
                inside, node = _process_sparingly(inside, node)
            else:
                inside, node = tighten(inside, node, ITERATIONS)
            return replace(inside, deadline=state.deadline), node._processed()
        node = solve_relaxation(inside, self)
        inside, node = tighten(inside, node, FIRST_ITERATIONS + ITERATIONS)
        node = replace(node, laws_bounded_at=node.region.widest_size)
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
    Where the bound's has very many knots, fewer are tried first.
    """
    if node.relaxation is None:
        return state, node
    cam, grids, bound = node.relaxation
    finest = max(len(grid.space.breaks) for grid in grids)
    meshes = [grids] if finest <= MOST_INTERVALS else []
    if count_knots(grids) > MOST_KNOTS or not meshes:
        meshes.insert(0, node.grids or coarse_mesh(node))  # those were for the bound's last digits
    for mesh in meshes:
        mesh = refine_mesh(state.problem, mesh, cam, bound)
        for _ in range(CAM_HALVINGS):
            if count_knots(mesh) < MOST_CUT:
                mesh = halve_intervals(state.problem, mesh)
        points, _ = row_violations(replace(state, grids=mesh), cam)
        both = zip(mesh, points, strict=True)
        state = improve_from(replace(state, grids=tuple(g.with_points(x) for g, x in both)), cam)
        best = state.incumbent
        assert best is not None
        if best.value < node.task.incumbent.value:
            return state, _about_incumbent(state, node)
    return state, node


def _process_sparingly(state: SolveState, node: TracedNode) -> tuple[SolveState, TracedNode]:
    """A part of the domain under a cap on a mean square, where each bound is a cone program.

    A relaxation takes a few of them, bounds of all laws hundreds. These follow the sizes, but
    slowly: so they are sought anew, on few knots, where the sizes have become much narrower. Under
    such a cap the root's rows are loose, and knots for a better cam are known in small parts alone.
    """
    node = _tighten_sparingly(state, node)
    missing = 1.0 - node.lower / node.largest_value
    if not node.is_empty and missing < min(WIDE, SEARCHED * node.searched_at) and state.thorough:
        before = state.incumbent
        state, node = _improve_incumbent(state, node)
        found = state.incumbent is not before
        node = replace(node, searched_at=missing if found else 0.0)
    return state, node


def _tighten_sparingly(state: SolveState, node: TracedNode) -> TracedNode:
    """Its relaxation, then again with tighter sizes, and with tighter laws where that pays."""
    node = solve_relaxation(state, node)
    if not node.is_empty and node.grids and state.time_left > 0.0:
        every, before = range(len(node.task.problem.free)), node.region.widest_size
        region = _tighten_region(state, node, every, laws=False) or node.region
        if region.is_empty:
            return replace(node, lower=node.largest_value)
        node = replace(node, region=region)
        if region.widest_size < SIZE_KEPT * before:
            node = solve_relaxation(state, node)
    if not node.is_empty and node.region.widest_size <= ANEW * node.laws_bounded_at:
        node = replace(node, laws_bounded_at=node.region.widest_size, grids=coarse_mesh(node))
        _, node = tighten(state, node, 1)
    return node


def _offer_relaxation(state: SolveState, node: TracedNode) -> tuple[SolveState, TracedNode]:
    """The relaxation's cam, enlarged until all limits hold, as an incumbent.

    A narrow region's rows are nearly the limits themselves, so that little is added to its size.
    """
    if node.relaxation is None:
        return state, node
    laws, size = node.relaxation[0].laws, node.relaxation[0].size
    every = list(zip(state.problem.free, laws, node.violated, strict=True))
    if any(s.free and s.free.smoothness >= law.space.degree for s, law, _ in every):
        return state, node  # its laws may jump where those of the problem must not
    grids = tuple(grid_through(s, law.space.breaks).with_points(x) for s, law, x in every)
    found, _ = offer_local_optimum(replace(state, grids=grids), laws, size)
    state = replace(found, grids=state.grids)
    return state, _about_incumbent(state, node)


def _about_incumbent(state: SolveState, node: TracedNode) -> TracedNode:
    """The node with a lower target where a better cam was found, in this part or in another."""
    best, task = state.incumbent, node.task
    if best is None or best is task.incumbent:
        return node
    return replace(node, task=BoundTask.of(state, best, task.deadline) or task)


def tighten(state: SolveState, node: TracedNode, iterations: int) -> tuple[SolveState, TracedNode]:
    """Tighten bounds and rows in iterations, each from what the other has shown.

    All laws are tightened at first, and once more before it is given up; in between only those on
    which the relaxation's solution violates a limit: other bounds would not cut it off. At the root
    a quick proof has few iterations, and so has one whose budget has ended. There a better cam is
    looked for after some of them, and again as long as one is found: it narrows the bounds too, and
    at the end it may be all that is missing.
    """
    among = every = tuple(range(len(node.task.problem.free)))
    searches = node.is_first and state.thorough
    for iteration in range(iterations):
        if node.is_empty or not node.grids or state.time_left <= 0.0:
            break
        if node.is_first and iteration >= FEW_ITERATIONS and not state.thorough:
            break
        before, region = node.region.for_laws(among).mean_width, _tighten_region(state, node, among)
        if region is None:
            node = solve_relaxation(state, node) if state.time_left > 0.0 else node
            break
        if region.is_empty:
            return state, replace(node, lower=node.largest_value)
        node = solve_relaxation(state, replace(node, region=region))
        idle, best = region.for_laws(among).mean_width > WIDTH_KEPT * before, state.incumbent
        if node.is_first:
            state, node = _offer_relaxation(state, node)
        if searches and (idle or iteration + 1 >= FIRST_ITERATIONS):
            if not node.is_pruned(state) and state.time_left > 0.0:
                state, node = _improve_incumbent(state, node)
            searches = state.incumbent is not best  # else no later one finds a better cam
        if idle and among == every and state.incumbent is best:
            break
        among = every if idle else _violating_laws(node) or every
    return _offer_relaxation(state, node)


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
    state: SolveState, node: TracedNode, among: Collection[int], *, laws: bool = True
) -> ImprovingRegion | None:
    """The region with tighter bounds of the laws ``among``; None where no law could be bounded.

    A law for which the coarse mesh has no spline under the capped value says nothing. For those the
    cap is raised by what the incumbent is above the target, then their intervals are halved.
    """
    task, grids = node.task, node.with_points(node.grids)
    region = node.region.with_closer_nodes(among)
    region = region.restrict(size_rows.tighten_sizes(task.problem, region.sizes))
    if region.is_empty:
        return region
    pending = frozenset(among)
    slack = (1.0 + SPARE) * task.incumbent.value - task.target
    is_size = task.problem.objective.norm(task.problem.machine) is not None
    last = state.last_program if state.programs else inf  # a quick proof has few iterations
    for number, extra in enumerate((0.0, slack, slack)):
        if state.time_left <= 0.0 or not pending or region.is_empty:
            break
        if number == 2:
            finer = halve_intervals(task.problem, grids)
            both = enumerate(zip(grids, finer, strict=True))
            grids = tuple(new if k in pending else old for k, (old, new) in both)
            grids = node.with_points(grids)
        problem = with_value_cap(task.problem, node.largest_value + extra)
        model = formulate(problem, grids)
        model = with_rows(model, rows_of_size(replace(node, region=region), model.scales))
        # a cap on a size ends the region too: it is widened as much, and bounds of both hold
        wider = region.widened(extra) if is_size else region
        tighter, pending = tighten_bounds(
            model, task.controls, wider, pending, state.time_left, last, laws=laws
        )
        region = tighter.within(region)
    return None if pending == frozenset(among) else region
