"""The vocabulary between limits and formulations: linear rows and cones.

s, s', s'', s'''  displacement and its derivatives per radian [mm, mm/rad, …]
z                 the follower's size variables: (e, s0) of a roller, (Rb) of a face [mm]
P                 the objective's own variable: the level that it pushes down
"""

from __future__ import annotations

import math
from dataclasses import dataclass

Vector = tuple[float, ...]


@dataclass(frozen=True)
class Row:
    """coefficients · (s, s', s'', s''') + size · z + level · P ≤ upper, at every cam angle.

    Of one stretch, that is: of all of it, or of a part.

    Attributes:
        coefficients: four numbers, for s to s'''.
        size: one number per size variable; empty stands for zeros.
        upper: right-hand side.
        level: coefficient of P (only objectives use it).
        source: the objective, or the claim of a limit, that asks for it.
        part: first and last x, in [0, 1], of the stretch where it holds, equal for a point;
            None where it holds all along.
        exact: = upper in place of ≤ upper.
        room: how far below ``upper`` another row allows to go.
    """

    coefficients: tuple[float, float, float, float]
    size: Vector
    upper: float
    level: float = 0.0
    source: str = ""
    part: tuple[float, float] | None = None
    exact: bool = False
    room: float = math.inf


def derivative(order: int, factor: float) -> tuple[float, float, float, float]:
    """Coefficients of a row that holds ``factor`` times the ``order``-th derivative alone."""
    s, v, a, j = (factor if k == order else 0.0 for k in range(4))
    return s, v, a, j


@dataclass(frozen=True)
class Norm:
    """‖matrix · z + shift‖, Euclidean: how a radius depends on the size variables [mm]."""

    matrix: tuple[Vector, ...]
    shift: Vector

    def value(self, z: Vector) -> float:
        """The norm at given size variables [mm]."""
        image = (
            sum(a * v for a, v in zip(row, z, strict=True)) + m
            for row, m in zip(self.matrix, self.shift, strict=True)
        )
        return math.hypot(*image)


@dataclass(frozen=True)
class Cone:
    """norm ≤ radius."""

    norm: Norm
    radius: float
    source: str
