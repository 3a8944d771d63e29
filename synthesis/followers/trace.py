"""What draws a curve on the turning cam: the geometry that certificate, drawings and limits share.

Symbols: s to s''' displacement and its derivatives per radian [mm]; z size variables [mm];
Rp prime radius; α pressure angle; κ curvature of the traced curve, convex positive. Vectors are
in the machine frame: origin on the cam's axis, y along an upward follower, the cam turning
counter-clockwise (a clockwise cam is the mirror image).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from synthesis.terms import Norm, Row, Thrust, Traced

Vector2 = tuple[Any, Any]


class Trace(ABC):
    """A point of the machine that draws a curve on the cam; every follower is one."""

    @abstractmethod
    def traced_point(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        """The traced point and its θ-derivatives in the machine frame: a roller's centre.

        Args:
            s: the four values s, s', s'', s''', of any arithmetic type (arrays, intervals).
            z: size variables.

        Returns:
            pairs (x, y) of the point and at least its first two derivatives.
        """

    @abstractmethod
    def direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        """Unit vector along which the follower is driven, and its θ-derivative."""

    def lever(self, s: Any, z: Any) -> Any:
        """How far the follower's material at the contact moves along ``direction``, per unit of s.

        By virtual work a force N along the unit normal n does N (n · g) times this much per unit
        of s. Negative where the follower moves against the direction of drive as s grows.
        """
        return 1.0

    def normal(self, tangent: Vector2, s: Any, z: Any) -> Vector2:
        """Outward common normal, of any length: of the traced curve, or of a face that has one.

        Args:
            tangent: of the traced curve, which runs clockwise round the cam.
            s, z: as for ``traced_point``.
        """
        tx, ty = tangent
        return -ty, tx

    def face_turn(self, s: Any, z: Any) -> Vector2:
        """How the face's unit normal n turns as seen from the cam: n' + J n; only with a face."""
        raise NotImplementedError(f"{type(self).__name__} has no face")

    def face_axis(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        """Where a face's reach is measured from, and the unit vector along it; only with one."""
        raise NotImplementedError(f"{type(self).__name__} has no face")

    @abstractmethod
    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        """Numerator N and squared speed W² of the traced curve: κ = N / W³."""

    def curvature_implied(
        self, side: int, most: float, thrust: Thrust | None = None
    ) -> tuple[Traced, ...]:
        """What rows are implied by side · κ ≤ most [1/mm], most > 0; () where none is known.

        ``thrust``: what presses a roller besides, which leaves less.
        """
        return ()

    @abstractmethod
    def pressure_angle_rows(self, slope: float) -> tuple[Row, ...]:
        """|tan α| ≤ slope as rows linear in s, s' and z; () where none say it."""

    def radius_rows(self, least: float) -> tuple[Row, ...]:
        """Traced curve at least so far from the axis as rows; () where the size sees to it."""
        return ()

    @abstractmethod
    def outermost(self, s_max: float) -> Norm | None:
        """Largest radius of the traced curve, at displacement ``s_max``, as a norm of z.

        Or what grows with that radius, as for ``prime_radius``; None where it is no norm: then
        ``outer_radius_curves`` say it.
        """

    def value_of(self, radius: float) -> float:
        """The norm ``prime_radius`` at a prime radius [mm]: the inverse of ``radius_of``."""
        return radius

    def nearest(self, s_max: float) -> float:
        """Displacement between 0 and ``s_max`` at which the traced curve is nearest to the axis."""
        return 0.0


class Host(Trace):
    """The main roller's follower, as a closure sees it: what further rollers can be fixed to."""

    def second_arm(self, length: float, angle: float) -> Trace:
        """The roller of a second arm [mm] at its pivot, at an angle [rad]; only with an arm."""
        raise NotImplementedError(f"{type(self).__name__} has no arm")

    def arm_angle(self, s: float, z: tuple[float, ...]) -> float:
        """Angle at its pivot from the line to the axis to the arm [rad]; only with an arm."""
        raise NotImplementedError(f"{type(self).__name__} has no arm")


def leaning(path: Trace, s: Any, z: Any) -> tuple[Any, Any]:
    """Sine and cosine of the pressure angle on a traced curve.

    Args:
        s: s and three derivatives, of any arithmetic type [mm, per rad]. z: the size [mm].
    """
    (px, py), (dx, dy), *_ = path.traced_point(s, z)
    nx, ny = path.normal((dx + py, dy - px), s, z)
    (gx, gy), _ = path.direction(s, z)
    length = (nx * nx + ny * ny) ** 0.5
    return (gx * ny - gy * nx) / length, (gx * nx + gy * ny) / length
