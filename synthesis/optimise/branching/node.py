"""A node of the branch and bound, and the tree of its leaves. Both are immutable."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Self

from synthesis.optimise.dual_bound.bound import Bound
from synthesis.optimise.state.solve_state import SolveState

Sizes = tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Node(ABC):
    """A part of the domain of sizes, with what is known of the better cams in it.

    Attributes:
        lower, valid_for: no cam of this part is below ``lower`` [core units], and what that covers.
        processed: whether ``process`` has been run; a processed node can only be branched on.
        deferred: whether it is the half with the larger values, which is processed only while the
            node limit allows.
        is_root: whether it is the whole domain: the first node of its kind, from which the nodes of
            this kind are counted. started: ``time.perf_counter()`` of its root.
    """

    lower: float = -inf
    valid_for: str = ""
    processed: bool = False
    deferred: bool = False
    is_root: bool = False
    started: float = 0.0

    @abstractmethod
    def process(self, state: SolveState) -> tuple[SolveState, Node]:
        """Propagate, relax, solve and bound in turns, until a turn gains too little."""

    @abstractmethod
    def branch(self, state: SolveState) -> tuple[SolveState, Sequence[Node]]:
        """Children that cover the part together; none where there is nothing left to divide."""

    @abstractmethod
    def is_pruned(self, state: SolveState) -> bool:
        """Whether the part holds no cam that is better than the incumbent by the tolerance."""

    @abstractmethod
    def node_limit(self, state: SolveState) -> float:
        """Nodes to process at most, the root among them; asked of a root that was processed."""

    def raised(self, bound: Bound, most: float = inf) -> Self:
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
        limit: nodes to process at most. count: nodes processed.
    """

    leaves: tuple[Node, ...]
    limit: float = inf
    count: int = 0

    @property
    def next_node(self) -> Node:
        """The node with the least lower bound; of several the first that is not processed."""
        return min(self.leaves, key=lambda node: (node.lower, node.processed))

    def with_processed(self, node: Node, processed: Node, state: SolveState) -> Tree:
        """The tree after a node was processed; the first of its kind sets the node limit."""
        tree = replace(self, leaves=(*self._without(node), processed), count=self.count + 1)
        return replace(tree, limit=processed.node_limit(state)) if node.is_root else tree

    def with_children(self, node: Node, children: Sequence[Node]) -> Tree:
        """The tree after branching on a node; a root among the children is counted as the first."""
        count = 0 if any(child.is_root for child in children) else self.count
        return replace(self, leaves=(*self._without(node), *children), count=count)

    def _without(self, node: Node) -> tuple[Node, ...]:
        return tuple(leaf for leaf in self.leaves if leaf is not node)


def halve(sizes: Sizes, axis: int) -> tuple[Sizes, Sizes]:
    """A box of sizes, divided in the middle of one of them."""
    (low, high), before, after = sizes[axis], sizes[:axis], sizes[axis + 1 :]
    middle = 0.5 * (low + high)
    return (*before, (low, middle), *after), (*before, (middle, high), *after)
