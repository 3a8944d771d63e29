"""Where a local search ended, to begin that of a neighbouring question there."""

from __future__ import annotations

from dataclasses import dataclass

from synthesis.formulations.question.grid import Grid, SettledLaw


@dataclass(frozen=True, eq=False)
class Neighbour:
    """Where a local search ended.

    Attributes:
        grids: knots and points of every free law. laws, size: the local optimum, size in mm.
    """

    grids: tuple[Grid, ...]
    laws: tuple[SettledLaw, ...]
    size: tuple[float, ...]
