"""Kinematics of a trace point: the curve that it draws on the turning cam, and its constraints.

Symbols: s to s''' displacement and its derivatives per radian of cam angle; z size variables;
Rp prime radius; α pressure angle; κ curvature of the traced curve (of a roller: the pitch curve),
convex positive. Vectors are in the machine frame: origin on the cam's axis, y along an upward
follower, the cam turning counter-clockwise (a clockwise cam is the mirror image). Lengths are in
the unit of s.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from synthesis.catalogue.constraints import AffineNorm, LinearInequality, PressureTerm
from synthesis.catalogue.followers.curvature_bound import CurvatureBound

Vector2 = tuple[Any, Any]


class TracePoint(ABC):
    """A point of the machine that draws a curve on the cam; every follower is one."""

    @abstractmethod
    def position(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        """The trace point (a roller's centre, a face's contact point) and its θ-derivatives.

        Args:
            s: the four values s, s', s'', s''', of any arithmetic type (arrays, intervals).
            z: size variables.

        Returns:
            pairs (x, y) of the point and at least its first two derivatives.
        """

    def drive_direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        """Unit vector along which the follower is driven, and its θ-derivative: up, on a slide."""
        zero = 0.0 * s[0]
        return (zero, zero + 1.0), (zero, zero)

    def lever(self, s: Any, z: Any) -> Any:
        """λ: how far the follower's material at the contact moves along g, per unit of s.

        By virtual work a force N along the unit normal n does N (n · g) times this much per unit
        of s. Negative where the follower moves against the direction of drive as s grows.
        """
        return 1.0

    def normal(self, tangent: Vector2, s: Any, z: Any) -> Vector2:
        """Outward common normal, of any length: of the traced curve, or of a face that has one.

        Args:
            tangent: of the traced curve, which runs clockwise round the cam.
            s, z: as for ``position``.
        """
        tx, ty = tangent
        return -ty, tx

    @abstractmethod
    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        """Numerator N and squared speed W² of the traced curve: κ = N / W³."""

    def curvature_bounds(
        self, side: int, most: float, thrust: PressureTerm | None = None
    ) -> tuple[CurvatureBound, ...]:
        """side · κ ≤ most, most > 0, with its linear relaxation over boxes; () where none is known.

        Args:
            thrust: a limit on the contact pressure, which leaves less curvature.
        """
        return ()

    def pressure_angle_rows(self, slope: float) -> tuple[LinearInequality, ...]:
        """|tan α| ≤ slope, linear in s, s' and z; () where it is not."""
        return ()

    def radius_rows(self, least: float) -> tuple[LinearInequality, ...]:
        """Distance of the traced curve from the axis ≥ least; () where the size implies it."""
        return ()

    def outer_radius_norm(self, s_max: float) -> AffineNorm | None:
        """Largest radius of the traced curve, at displacement ``s_max``, as a norm of z.

        Or a norm that grows with that radius, as ``radius_norm`` does; None where there is none:
        then ``outer_radius_constraints`` state it.
        """
        return None

    def norm_from_radius(self, radius: float) -> float:
        """``radius_norm`` at a prime radius: the inverse of ``radius_from_norm``."""
        return radius

    def nearest_displacement(self, s_max: float) -> float:
        """Displacement between 0 and ``s_max`` at which the traced curve is nearest to the axis."""
        return 0.0


def pressure_angle_sine_cosine(path: TracePoint, s: Any, z: Any) -> tuple[Any, Any]:
    """Sine and cosine of the pressure angle on a traced curve.

    Args:
        s: s and three derivatives, of any arithmetic type [mm, per rad]. z: the size [mm].
    """
    (px, py), (dx, dy), *_ = path.position(s, z)
    nx, ny = path.normal((dx + py, dy - px), s, z)
    (gx, gy), _ = path.drive_direction(s, z)
    length = (nx * nx + ny * ny) ** 0.5
    return (gx * ny - gy * nx) / length, (gx * nx + gy * ny) / length
