"""Where a local search ended, to begin that of a neighbouring question there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from synthesis.formulations.cams.spots import Spots
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.question.grid import Grid, SettledLaw
from synthesis.numerics.piecewise import Array


@dataclass(frozen=True, eq=False)
class Neighbour:
    """Where a local search ended.

    Attributes:
        grids: knots and points of every free law. laws, size: the local optimum, size in mm.
        spots: where smooth limits were written. rows, bounds: multipliers, for IPOPT.
        shape: rows and unknowns of the cone program behind.
    """

    grids: tuple[Grid, ...]
    laws: tuple[SettledLaw, ...]
    size: tuple[float, ...]
    spots: tuple[Spots, ...]
    rows: Array | None
    bounds: Array | None
    shape: tuple[int, int]

    @staticmethod
    def of(
        plan: Plan, grids: Sequence[Grid], spots: Sequence[Spots], x: Array,
        multipliers: tuple[Array | None, Array | None],
    ) -> Neighbour:  # fmt: skip
        """What a local search that ended at x leaves to the next question."""
        laws, size = plan.recover(x)
        rows, bounds = multipliers
        shape = plan.program.matrix.shape
        return Neighbour(tuple(grids), tuple(laws), size, tuple(spots), rows, bounds, shape)
