"""A node of the branch and bound, and the tree of its leaves. Both are immutable.

What a tree over traced limits has to prove is a ``BoundTask``, on the parts of the laws where these
limits are nearly binding.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from math import inf
from typing import Self

import numpy as np

from synthesis.catalogue.limits import Limit
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.control import Control, capped_controls
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.dual_bound.bound import Bound
from synthesis.optimise.problem.grid import round_knots, uniform_grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.propagation.improving_region import Parts, is_stated
from synthesis.optimise.propagation.law_tightening import with_value_cap
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.relaxation import size_rows
from synthesis.optimise.state import SolveState

Sizes = tuple[tuple[float, float], ...]
INTERVALS = 20  # of the mesh on which the caps of the laws are read
SAMPLES = 200  # points of a segment at which limits are looked at
JOINED = 0.08  # share of a segment: parts with binding limits that are no farther apart are one
VIOLATED = 1e-3  # relative excess of a limit above which a place without rows gets them
BINDS = -0.02  # a smooth limit above this, relative, binds or soon will
JERK = 3  # order of the derivative: laws with it capped have two continuous ones


@dataclass(frozen=True, eq=False, kw_only=True)
class Node(ABC):
    """A part of the domain of sizes, with what is known of the better cams in it.

    Attributes:
        lower, valid_for: no cam of this part is below ``lower`` [problem units]; what that covers.
        processed: whether ``process`` has nothing more to do; then the node is branched on.
        upper_half: whether a node was divided by the objective's value and this is the part with
            the larger values, which is processed only while the node limit allows.
        is_first: whether it is the first node of its kind, the whole domain, from which nodes are
            counted. started: ``SolveState.stopwatch`` at that node.
    """

    lower: float = -inf
    valid_for: str = ""
    processed: bool = False
    upper_half: bool = False
    is_first: bool = False
    started: float = 0.0

    @abstractmethod
    def process(self, state: SolveState) -> tuple[SolveState, Node]:
        """Propagate, relax, solve and bound, until a repeat gains too little."""

    @abstractmethod
    def branch(self, state: SolveState) -> tuple[SolveState, Sequence[Node]]:
        """Children that cover the part together; none where there is nothing left to divide."""

    @abstractmethod
    def is_pruned(self, state: SolveState) -> bool:
        """Whether the part holds no cam that is better than the incumbent by the tolerance."""

    @abstractmethod
    def node_limit(self, state: SolveState) -> float:
        """Nodes to process at most, the root among them; asked of a root that was processed."""

    def with_bound(self, bound: Bound, most: float = inf) -> Self:
        """The node with a bound, no larger than ``most``, if that is better than its own."""
        value = min(bound.value, most)
        better = value > self.lower
        return replace(self, lower=value, valid_for=bound.valid_for) if better else self

    @abstractmethod
    def conclude(self, state: SolveState, tree: Tree) -> SolveState:
        """The state at the end of the tree: its bound, and a stage for the report."""


@dataclass(frozen=True, eq=False)
class Tree:
    """The leaves of the tree: every better cam lies in one of them.

    Attributes:
        leaves: open nodes, and nodes that could not be divided.
        first: the first node of its kind, processed; it sets the node limit. count: processed.
    """

    leaves: tuple[Node, ...]
    first: Node | None = None
    count: int = 0

    @property
    def next_node(self) -> Node:
        """The node with the least lower bound; of several the first that is not processed."""
        return min(self.leaves, key=lambda node: (node.lower, node.processed))

    def node_limit(self, state: SolveState) -> float:
        """Nodes to process at most, as long as the budget of the proof lasts."""
        return inf if self.first is None else self.first.node_limit(state)

    def with_processed(self, node: Node, processed: Node) -> Tree:
        """The tree after a node was processed."""
        tree = replace(self, leaves=(*self._without(node), processed), count=self.count + 1)
        return replace(tree, first=processed) if node.is_first else tree

    def with_children(self, node: Node, children: Sequence[Node]) -> Tree:
        """The tree after branching on a node; a root among the children is counted as the first."""
        count = 0 if any(child.is_first for child in children) else self.count
        return replace(self, leaves=(*self._without(node), *children), count=count)

    def _without(self, node: Node) -> tuple[Node, ...]:
        return tuple(leaf for leaf in self.leaves if leaf is not node)


def halve(sizes: Sizes, axis: int) -> tuple[Sizes, Sizes]:
    """A box of sizes, divided in the middle of one of them."""
    (low, high), before, after = sizes[axis], sizes[:axis], sizes[axis + 1 :]
    middle = 0.5 * (low + high)
    return (*before, (low, middle), *after), (*before, (middle, high), *after)


@dataclass(frozen=True, eq=False)
class BoundTask:
    """What is to be proven: no cam has a value below ``target`` [problem units].

    Attributes:
        problem: its laws free to jump in their controls, as all laws are.
        incumbent: the best cam. controls: caps of the free laws' controls, of one order, or of
            their mean squares.
        deadline: ``time.monotonic()`` at which to stop.
    """

    problem: Problem
    incumbent: Candidate
    target: float
    controls: tuple[Control, ...]
    deadline: float

    @property
    def order(self) -> int:
        """Of the derivative that is the control."""
        return self.controls[0].order

    @classmethod
    def of(cls, state: SolveState, incumbent: Candidate, deadline: float) -> Self | None:
        """The task about an incumbent; None where no cap is known of every free law's control."""
        objective, target = state.problem.objective, state.bound_to_prove(incumbent)
        smooth = _with_smoothness(state.problem, JERK - 1)
        coarse = [uniform_grid(segment, INTERVALS) for segment in smooth.free]
        controls = capped_controls(formulate(with_value_cap(smooth, target), coarse))
        if controls is None:
            return None
        aims = (objective, *(cap.objective for cap in smooth.objective_caps))
        if max(aim.energy_order() or 0 for aim in aims) > controls[0].order:
            return None  # laws that jump in their controls have no such mean square
        problem = _with_smoothness(smooth, controls[0].order - 1)
        return cls(problem, incumbent, target, tuple(controls), deadline)


def _with_smoothness(problem: Problem, smoothness: int) -> Problem:
    """The problem with as many continuous derivatives of every free law."""
    free = {
        s.index: replace(s, free=replace(s.free, smoothness=smoothness))
        for s in problem.free
        if s.free is not None
    }
    return replace(problem, segments=tuple(free.get(s.index, s) for s in problem.segments))


@dataclass(frozen=True, eq=False)
class BindingLimits:
    """Where limits with rows over boxes bind on the free laws of some cams.

    Attributes:
        pairs: positions of laws and numbers of limits that bind on them.
        parts: of every law on which one does, the parts where one of these nearly does.
    """

    pairs: frozenset[tuple[int, int]]
    parts: Mapping[int, Parts]

    @classmethod
    def on(cls, cams: Iterable[Candidate | None]) -> Self:
        """On any of these cams."""
        pairs, x = set[tuple[int, int]](), np.linspace(0.0, 1.0, SAMPLES + 1)
        worst = dict[int, Array]()
        for problem, size in ((cam.problem, cam.size) for cam in cams if cam is not None):
            moving = [segment for segment in problem.segments if segment.free is not None]
            for position, segment in enumerate(moving):
                theta = segment.start + segment.angle * x
                for number, limit in enumerate(problem.limits):
                    if not limit.box_bounds(segment, problem.machine):
                        continue
                    excess = size_rows.relative_excess(problem, segment, theta, size, [limit])
                    if np.max(excess) > BINDS:
                        pairs.add((position, number))
                        worst[position] = np.maximum(worst.get(position, excess), excess)
        return cls(frozenset(pairs), {k: _parts_near(x, excess) for k, excess in worst.items()})


def excess_along_laws(cam: Candidate, x: Array, below: float = inf) -> list[Array]:
    """By how much every free law of a cam exceeds limits with rows over boxes, relative, at x.

    ``below``: limits whose rows are of derivatives of a lower order alone.
    """
    machine, result = cam.problem.machine, list[Array]()
    for segment in (each for each in cam.problem.segments if each.free is not None):
        limits = [
            limit for limit in cam.problem.limits
            if any(implied.order < below for implied in limit.box_bounds(segment, machine))
        ]  # fmt: skip
        theta = segment.start + segment.angle * x
        result.append(size_rows.relative_excess(cam.problem, segment, theta, cam.size, limits))
    return result


def violated_parts(cam: Candidate, known: Mapping[int, Parts]) -> dict[int, Parts]:
    """Parts of laws, besides those known, on which a cam violates limits with rows over boxes."""
    result, x = dict[int, Parts](), np.linspace(0.0, 1.0, SAMPLES + 1)
    for position, excess in enumerate(excess_along_laws(cam, x)):
        outside = excess > VIOLATED
        for low, high in known.get(position, ()):
            outside &= (x < low) | (x > high)
        if not np.any(outside):
            continue
        result[position] = tuple(
            (low, high) for low, high in _parts_near(x, excess)
            if np.any(outside[(low <= x) & (x <= high)])
        )  # fmt: skip
    return result


def _parts_near(x: Array, excess: Array) -> Parts:
    """Parts of a law, sampled at x, where a limit nearly binds; knots will be at their ends."""
    where = np.flatnonzero(excess > size_rows.NEAR)
    runs = np.split(where, np.flatnonzero(np.diff(where) > JOINED * SAMPLES) + 1)
    ends = np.array([[x[run[0]] - 2.0 / SAMPLES, x[run[-1]] + 2.0 / SAMPLES] for run in runs])
    places = round_knots(np.clip(ends, 0.0, 1.0))
    return tuple((float(low), float(high)) for low, high in places)


def is_traced(state: SolveState, limit: Limit, order: int = 3) -> bool:
    """Whether a limit implies rows where a traced point is nearly known.

    ``order``: of the control.
    """
    of_laws = (limit.box_bounds(s, state.problem.machine) for s in state.problem.segments)
    return any(is_stated(implied, order) for implied in chain.from_iterable(of_laws))
