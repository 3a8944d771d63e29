"""Where a local search ended: the start of the same search for a neighbouring problem."""

from __future__ import annotations

from dataclasses import dataclass

from synthesis.optimise.problem.grid import Grid, SplineLaw


@dataclass(frozen=True, eq=False)
class WarmStart:
    """A local optimum.

    Attributes:
        grids: knots and collocation points of every free law.
        laws, size: the laws, and the size variables [core length units].
    """

    grids: tuple[Grid, ...]
    laws: tuple[SplineLaw, ...]
    size: tuple[float, ...]
