"""Nodes of the branch and bound where motion and size together make limits nonconvex.

With the pivot of an arm free, the pressure angle holds products of the size and of sine and cosine
of the swing; so do all limits of a flat face that swings. A cam that is better than the incumbent
satisfies the relaxation's rows and the incumbent's value, so its size lies in a box and its laws
within bounds, which the relaxation itself gives over all laws. There the limits imply linear rows
(McCormick's under-estimators), and with them the dual bound stays valid: a cam that is no better
than the incumbent need not satisfy them. Rows and bounds tighten each other, in turn.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Self

import numpy as np

from synthesis.catalogue.constraints import NonconvexConstraint
from synthesis.catalogue.limits import Limit, Machine
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.branching.node import Node, Tree, halve
from synthesis.optimise.conic.control import capped_controls
from synthesis.optimise.conic.law_bounds import LawBounds
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import NO_TIGHTENING, ConicModel, formulate, with_rows
from synthesis.optimise.conic.tangent_cuts import Region, TangentPoint, cuts_on_law
from synthesis.optimise.dual_bound.bound import Bound, all_laws, dual_bound, in_problem_units
from synthesis.optimise.heuristics.local_search import improve_from
from synthesis.optimise.problem.grid import Grid, uniform_grid
from synthesis.optimise.problem.problem import NoObjective, Problem
from synthesis.optimise.propagation import law_tightening
from synthesis.optimise.recovery.candidate import Candidate, recover_cam
from synthesis.optimise.refinement.mesh import refine_mesh
from synthesis.optimise.relaxation.size_rows import NEAR, relative_excess, reverse_convex_rows
from synthesis.optimise.state import SolveState, Stage

COARSE = 20  # intervals of the mesh on which laws and sizes are bounded
NODES = 7  # points of a law at which it is bounded
SAMPLES = 200  # points of a segment at which limits are looked at
MAX_MESHES = 5  # meshes of one relaxation, each finer than the one before
FEWEST_ROWS = 40  # points along the bounded part of a law at which implied rows are written
SPARE = 1e-9
"""Relative slack of a value that is held, and least excess of a proof, against rounding."""
REACHED = 1e-5
"""Relative amount beyond what laws on coarse knots reach, so that there is a choice left."""
ITERATIONS, QUICK_ITERATIONS = 4, 2
"""Iterations of bounds and rows; few where the incumbent is a local optimum already."""
LEAST_GAIN = 0.15  # of the gap: what an iteration must gain for another one
KNOT_GAIN = 0.3  # of the gap: what knots must have to gain for a finer mesh
MAX_NODES = 15  # of a thorough proof

Parts = Mapping[int, tuple[float, float]]


@dataclass(frozen=True, eq=False)
class PivotNode(Node):
    """A box of sizes.

    Attributes:
        problem: its sizes in the box.
        parts: of every free law, the part on which implied rows are written.
        sizes, tubes: bounds of the size and of the laws of every better cam.
        about: the last solution, where rows are tangent.
    """

    problem: Problem
    parts: Parts
    grids: tuple[Grid, ...]
    sizes: tuple[tuple[float, float], ...] = ()
    tubes: Mapping[int, LawBounds] = field(default_factory=dict)
    about: TangentPoint | None = None

    @classmethod
    def root(cls, state: SolveState) -> Self | None:
        """The whole domain; None where no nonconvex limit binds, or no incumbent bounds it."""
        started, best, free = state.stopwatch, state.incumbent, state.problem.free
        if best is None or not free:
            return None
        parts = {k: part for k, s in enumerate(free) if (part := nearly_binding_part(best, s))}
        if not parts and isfinite(state.lower):
            return None
        return cls(
            state.problem, parts, state.grids, lower=state.lower, valid_for=state.valid_for,
            is_first=True, started=started,
        )  # fmt: skip

    def node_limit(self, state: SolveState) -> float:
        return MAX_NODES if state.thorough and self.sizes else 1

    def is_pruned(self, state: SolveState) -> bool:
        return state.suffices or state.is_close(
            state.incumbent, state.lower if self.is_first else self.lower
        )

    def process(self, state: SolveState) -> tuple[SolveState, Node]:
        node, quick = self, self.is_first and state.problem.omits_curved_rows and not state.thorough
        for _ in range(QUICK_ITERATIONS if quick else ITERATIONS):
            best, before = _incumbent(state), node.lower
            tighter = tighten_node(state, best, node)
            if tighter is None or (self.is_first and state.time_left <= 0.0):
                break
            node = _solve_relaxation(state, best, tighter)
            if self.is_first:
                # the knots that the bound asks for are those on which a better cam is looked for
                state = state.raise_bound(node.lower, node.valid_for)
                if node.grids != state.grids:
                    state = improve_from(replace(state, grids=node.grids), best)
            best = _incumbent(state)
            least = LEAST_GAIN * (best.value - (node.lower if self.is_first else before))
            if node.is_pruned(state) or node.lower - before < least:
                break
        return state, replace(node, processed=True)

    def branch(self, state: SolveState) -> tuple[SolveState, Sequence[Node]]:
        """Halve the widest range of the sizes."""
        if self.parts and not self.tubes:
            return state, ()  # limits that bind on laws imply no rows, however small the box is
        axis, bounds = int(np.argmax(np.ptp(self.sizes, axis=1))), self.problem.sizing.bounds
        children = []
        for sizes in halve(self.sizes, axis):
            inside = (*bounds[:axis], sizes[axis], *bounds[axis + 1 :])
            problem = replace(self.problem, sizing=replace(self.problem.sizing, bounds=inside))
            child = replace(self, problem=problem, sizes=sizes, processed=False, is_first=False)
            children.append(child)
        return state, children

    def conclude(self, state: SolveState, tree: Tree) -> SolveState:
        lowest = min(tree.leaves, key=lambda leaf: leaf.lower)
        return state.raise_bound(lowest.lower, lowest.valid_for).with_stage(
            Stage(
                "implied rows", f"cone programs in {len(tree.leaves)} boxes", "Clarabel", 0, 0, 0,
                state.stopwatch - self.started, "solved",
                "what a better cam keeps to, and the rows that its limits imply there",
                tree.count,
            )
        )  # fmt: skip


def _incumbent(state: SolveState) -> Candidate:
    assert state.incumbent is not None
    return state.incumbent


def nearly_binding_part(best: Candidate, free: PlacedSegment) -> tuple[float, float] | None:
    """The part of a free law on which a limit with implied rows is nearly binding."""
    problem, x = best.problem, np.linspace(0.0, 1.0, SAMPLES + 1)
    (segment,) = (s for s in problem.segments if s.index == free.index)
    limits = [one for one in problem.limits if any(_relaxable(one, segment, problem.machine))]
    theta = segment.start + segment.angle * x
    worst = relative_excess(problem, segment, theta, best.size, limits)
    binding = x[worst > NEAR]
    if not len(binding) or np.max(worst) < 0.1 * NEAR:
        return None
    step = 2.0 / SAMPLES
    return max(float(binding[0]) - step, 0.0), min(float(binding[-1]) + step, 1.0)


def tighten_node(state: SolveState, best: Candidate, node: PivotNode) -> PivotNode | None:
    """The node with bounds of the sizes and laws of all cams better than ``best``.

    Of laws whose control nothing caps none are known, nor where bounds are to hold for every size:
    no box holds them all. None where time is over.
    """
    problem = node.problem
    grids = tuple(uniform_grid(segment, COARSE).knots_only for segment in problem.free)
    value = _value_to_hold(state, best, grids, node) * (1.0 + SPARE)
    model = formulate(law_tightening.with_value_cap(problem, value), grids)
    ranges = node.sizes or problem.sizing.bounds
    capped = capped_controls(model)
    if capped is None or problem.for_every_size:
        return replace(node, sizes=ranges)
    if node.sizes:
        model = with_rows(model, list(_implied_rows(model, node)))
    sizes = law_tightening.size_bounds(model, capped, ranges)
    tubes = {}
    for position, (low, high) in node.parts.items():
        if state.time_left <= 0.0:
            return None
        nodes = np.linspace(low, high, NODES)
        known = node.tubes.get(position)
        known = known or law_tightening.initial_law_bounds(model, position, capped[position], nodes)
        tubes[position] = law_tightening.tighten_law(
            model, capped, sizes, position, known, state.deadline
        )
    node, norm = replace(node, sizes=sizes, tubes=tubes), problem.objective.norm(problem.machine)
    if norm is None:
        return node
    # the least that the objective can be in the box
    return node.with_bound(Bound(norm.lower_bound(sizes), all_laws(capped[0].order)), best.value)


def _value_to_hold(
    state: SolveState, best: Candidate, grids: tuple[Grid, ...], node: PivotNode
) -> float:
    """The value that better cams do not exceed, or what laws on coarse knots can reach.

    Rows that no spline of the coarse mesh satisfies bound nothing; with the value raised, the laws
    of a few cams that are worse are bounded too, which is valid.
    """
    if not node.sizes or node.problem.objective.norm(node.problem.machine) is None:
        return best.value
    relaxed = formulate(node.problem, grids)
    model = with_rows(relaxed, list(_implied_rows(relaxed, node)))
    solution = solve(model.program, state.time_left)
    if solution.stopped not in USABLE:
        return best.value
    family = in_problem_units(model, model.program.value(solution.x))
    return max(best.value, family * (1.0 + REACHED))


def _solve_relaxation(state: SolveState, best: Candidate, node: PivotNode) -> PivotNode:
    """Solve the node's relaxation on finer and finer meshes, and keep the best dual bound."""
    problem = node.problem
    for _ in range(MAX_MESHES):
        relaxed = formulate(problem, node.grids)
        model = with_rows(relaxed, list(_implied_rows(relaxed, node)))
        solution = solve(model.program, state.time_left)
        if solution.stopped is StopReason.INFEASIBLE and prove_empty(node, state.time_left):
            return replace(node, lower=best.value)
        if solution.stopped not in USABLE:
            break
        bound = dual_bound(model, solution)
        if not bound.switching:
            break
        laws, size = model.recover(solution.x)
        node = replace(node, about=TangentPoint(tuple(law.curve() for law in laws), size))
        # Above the incumbent there is nothing left to bound: no cam of this box is better.
        node = node.with_bound(bound, best.value)
        cam = recover_cam(problem, laws, size, keep_size=True)
        if state.is_close(best, bound.value) or state.time_left <= 0.0:
            break
        # Knots can gain what lies between the best of this family of splines and the bound.
        if cam.value - bound.value < KNOT_GAIN * (best.value - bound.value):
            break
        node = replace(node, grids=refine_mesh(problem, node.grids, cam, bound))
    return node


def prove_empty(node: PivotNode, time_limit: float) -> Bound | None:
    """Prove that no law at all satisfies the implied rows; None where that does not succeed.

    The proof is a positive lower bound of the largest excess of these rows.
    """
    bare = formulate(replace(node.problem, objective=NoObjective()), node.grids)
    model = with_rows(bare, [replace(row, level=-1.0) for row in _implied_rows(bare, node)])
    solution = solve(model.program, time_limit)
    least = dual_bound(model, solution) if solution.stopped in USABLE else None
    return least if least and least.switching and least.value > SPARE else None


def _implied_rows(model: ConicModel, node: PivotNode) -> Iterator[LinearBlock]:
    """Rows that limits imply in the box: tangent at its middle, and at the last solution."""
    yield from reverse_convex_rows(node.problem, node.sizes, model.scales)
    region = Region(node.sizes, (None, node.about) if node.about else (), node.tubes)
    for position, tube in node.tubes.items():
        segment, grid = node.problem.free[position], model.grids[position]
        low, high = tube.nodes[0], tube.nodes[-1]
        points = grid.points[(grid.points >= low) & (grid.points <= high)]
        grid = Grid(grid.space, np.union1d(points, np.linspace(low, high, FEWEST_ROWS)))
        for limit in node.problem.limits:
            for implied in _relaxable(limit, segment, node.problem.machine):
                yield from cuts_on_law(
                    implied, position, segment, grid, model.scales, NO_TIGHTENING, region
                )


def _relaxable(
    limit: Limit, segment: PlacedSegment, machine: Machine
) -> Iterator[NonconvexConstraint]:
    """The nonconvex constraints of a limit that have linear relaxations over small boxes."""
    return (one for one in limit.nonconvex(segment, machine) if one.has_relaxation)
