"""The counter roller of conjugate cams on an arm: a second arm at the same pivot.

Symbols: l, ψ main arm and its angle at the pivot, from the line to the cam's axis; l2 second arm, γ
the fixed angle between the two. The second arm lies beyond that line, at the angle ψ2 = γ − ψ:
seen from the counter cam it is an oscillating roller of the other sense, which swings by −φ. So
with s2 = −(l2/l) s every formula of the main arm holds for it too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from synthesis.catalogue.constraints import AffineNorm, LinearInequality, Vector
from synthesis.catalogue.followers.kinematics import TracePoint, Vector2


@dataclass(frozen=True)
class CounterArm(TracePoint):
    """The counter roller; the size z is the main follower's.

    Attributes:
        arm: the second arm as a follower of its own. ratio: l2/l.
        matrix, shift: its size variables as an affine map of the main one's.
    """

    arm: TracePoint
    ratio: float
    matrix: tuple[Vector, ...]
    shift: Vector

    def _seen(self, s: Any, z: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        """s2 to s2''' and z2."""
        return tuple(-self.ratio * value for value in s), tuple(
            sum((a * v for a, v in zip(row, z, strict=True)), m)
            for row, m in zip(self.matrix, self.shift, strict=True)
        )

    def position(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        return self.arm.position(*self._seen(s, z))

    def drive_direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        return self.arm.drive_direction(*self._seen(s, z))

    def lever(self, s: Any, z: Any) -> Any:
        return -self.ratio  # s2 = −(l2/l) s

    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        return self.arm.curvature_terms(*self._seen(s, z))

    def pressure_angle_rows(self, slope: float) -> tuple[LinearInequality, ...]:
        return ()  # not linear in s

    def outer_radius_norm(self, s_max: float) -> AffineNorm:
        # the second arm stands farthest out where the main one is lowest
        own = self.arm.outer_radius_norm(0.0)
        assert own is not None  # an arm with a roller has one
        rows = [_through(row, self.matrix) for row in own.matrix]
        shift = [
            m + sum(a * b for a, b in zip(row, self.shift, strict=True))
            for row, m in zip(own.matrix, own.shift, strict=True)
        ]
        return AffineNorm(tuple(rows), tuple(shift))

    def norm_from_radius(self, radius: float) -> float:
        return self.arm.norm_from_radius(radius)

    def nearest_displacement(self, s_max: float) -> float:
        return s_max


def _through(row: Vector, matrix: Sequence[Vector]) -> Vector:
    """The row of a linear map behind another one."""
    return tuple(
        sum(a * b for a, b in zip(row, column, strict=True)) for column in zip(*matrix, strict=True)
    )
