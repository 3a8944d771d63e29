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

from synthesis.followers.trace import Trace, Vector2
from synthesis.terms import Norm, Row, Vector


@dataclass(frozen=True)
class CounterArm(Trace):
    """The counter roller; the size z is the main follower's.

    Attributes:
        arm: the second arm as a follower of its own. ratio: l2/l.
        matrix, shift: its size variables as an affine map of the main one's.
    """

    arm: Trace
    ratio: float
    matrix: tuple[Vector, ...]
    shift: Vector

    def _seen(self, s: Any, z: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        """s2 to s2''' and z2."""
        return tuple(-self.ratio * value for value in s), tuple(
            sum((a * v for a, v in zip(row, z, strict=True)), m)
            for row, m in zip(self.matrix, self.shift, strict=True)
        )

    def traced_point(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        return self.arm.traced_point(*self._seen(s, z))

    def direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        return self.arm.direction(*self._seen(s, z))

    def lever(self, s: Any, z: Any) -> Any:
        return -self.ratio  # s2 = −(l2/l) s

    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        return self.arm.curvature_terms(*self._seen(s, z))

    def pressure_angle_rows(self, slope: float) -> tuple[Row, ...]:
        return ()  # not linear in s

    def outermost(self, s_max: float) -> Norm:
        # the second arm stands farthest out where the main one is lowest
        own = self.arm.outermost(0.0)
        assert own is not None  # an arm with a roller has one
        rows = [_through(row, self.matrix) for row in own.matrix]
        shift = [
            m + sum(a * b for a, b in zip(row, self.shift, strict=True))
            for row, m in zip(own.matrix, own.shift, strict=True)
        ]
        return Norm(tuple(rows), tuple(shift))

    def value_of(self, radius: float) -> float:
        return self.arm.value_of(radius)

    def nearest(self, s_max: float) -> float:
        return s_max


def _through(row: Vector, matrix: Sequence[Vector]) -> Vector:
    """The row of a linear map behind another one."""
    return tuple(
        sum(a * b for a, b in zip(row, column, strict=True)) for column in zip(*matrix, strict=True)
    )
