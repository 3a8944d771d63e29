"""A local search begun where that of a neighbouring question ended: at its laws and its size.

The cam so found is a local optimum as good as any other, and is judged as any other; but it
depends on the neighbour, in its last digits or, where there are several local optima, in more.
"""

from __future__ import annotations

from collections.abc import Sequence

from synthesis.formulations.nonconvex.by_tangents import by_tangents
from synthesis.formulations.question.grid import Grid
from synthesis.formulations.rounds.search import Search

STAGE = "tangents, from a neighbour"


def from_neighbour(state: Search) -> bool:
    """The local search begun at the neighbour's; whether that gave a cam.

    It does not where the neighbour's knots are fewer than the bound's rounds ask for here.
    """
    near, before, own = state.near, state.best, state.grids
    if near is None or not _as_fine(near.grids, own):
        return False
    state.grids = near.grids
    found = by_tangents(state, near.laws, near.size, STAGE)
    state.from_near = found and state.best is not before
    if not state.from_near:
        state.grids = own
    return state.from_near


def _as_fine(grids: Sequence[Grid], wanted: Sequence[Grid]) -> bool:
    """Whether every law has the degree and at least the knots that are wanted."""
    return len(grids) == len(wanted) and all(
        grid.space.degree == other.space.degree and grid.space.size >= other.space.size
        for grid, other in zip(grids, wanted, strict=True)
    )
