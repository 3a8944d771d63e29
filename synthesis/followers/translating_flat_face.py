"""Translating flat-face follower, its face perpendicular to the slide.

Symbols: Rb base radius; ρ signed radius of the profile, negative where it is undercut.
The face is the line y = Rb + s of the machine frame, so Rb + s is the profile's support function:
ρ = Rb + s + s'', and contact is at the distance s' from the slide's line (Norton ch. 8).

The traced point is the contact point (s', Rb + s) itself. Its tangent on the cam is (ρ, 0): along
the face, whatever the motion. The curvature of such a curve is 1/|ρ|, which hides undercut; so
radius and normal are those of the face, which knows which side is out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal

from synthesis.followers.base import Follower, Measure, Shape, Sizing
from synthesis.followers.flank import Flank, Vector2
from synthesis.motion import Motion
from synthesis.numerics.peaks import peak
from synthesis.terms import Cone, Norm, Row


class TranslatingFlatFace(Follower):
    """A flat face on a slide whose line passes through the cam's axis."""

    kind: Literal["translating_flat_face"] = "translating_flat_face"
    title: ClassVar[str] = "Translating flat face, perpendicular to its slide"
    size_charts: ClassVar[tuple[tuple[str, ...], ...]] = (("base_radius",),)
    always_convex: ClassVar[bool] = True

    @property
    def roller_radius(self) -> float:
        return 0.0

    def sizing(self, base_radius: tuple[float, float]) -> Sizing:
        return Sizing((base_radius,), (), base_radius[0])

    def prime_radius(self) -> Norm:
        return Norm(((1.0,),), (0.0,))

    def raised(self, z: tuple[float, ...], amount: float) -> tuple[float, ...]:
        return (z[0] + amount,)

    def room(
        self, z: tuple[float, ...], bounds: Sequence[tuple[float, float]], cones: Sequence[Cone]
    ) -> float:
        largest = min([bounds[0][1], *(cone.radius - cone.norm.shift[0] for cone in cones)])
        return max(largest - z[0], 0.0)

    def reaching(self, z: tuple[float, ...], radius: float) -> tuple[float, ...]:
        return (max(z[0], radius),)

    def outermost(self, s_max: float) -> Norm:
        # |p|² = s'² + (Rb + s)² is stationary where s' ρ = 0: on the axis, at the highest lift
        return Norm(((1.0,),), (s_max,))

    def pressure_angle_rows(self, slope: float) -> tuple[Row, ...]:
        return ()  # the face's own tilt, 0

    def profile_radius_rows(self, least: float) -> tuple[Row, ...]:
        # Rb + s + s'' ≥ least
        return (Row((-1.0, 0.0, -1.0, 0.0), (-1.0,), -least),)

    def profile_radius_measure(self, flank: Flank, least: float) -> Measure:
        return Measure("face_radius", least, None, float)

    def contact_rows(self, left: float, right: float) -> tuple[Row, ...]:
        return (Row((0.0, -1.0, 0.0, 0.0), (), left), Row((0.0, 1.0, 0.0, 0.0), (), right))

    def traced_point(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        return (s[1], s[0] + z[0]), (s[2], s[1]), (s[3], s[2])

    def direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        zero = 0.0 * s[0]
        return (zero, zero + 1.0), (zero, zero)

    def normal(self, tangent: Vector2, s: Any, z: Any) -> Vector2:
        return self.direction(s, z)[0]

    def face_turn(self, s: Any, z: Any) -> Vector2:
        zero = 0.0 * s[0]
        return zero + 1.0, zero  # J (0, 1): the cam turns, the face does not

    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        radius = s[0] + s[2] + z[0]
        return radius * abs(radius), radius * radius

    def shape(self, motion: Motion, z: tuple[float, ...]) -> Shape:
        wide = self.motion_dimensions(motion, z)
        foot = z[0] + float(motion.derivatives([0.0], 0)[0, 0])
        return Shape((0.0, foot), 0.0, wide["face_left_mm"], wide["face_right_mm"])

    def dimensions(self, z: tuple[float, ...]) -> Mapping[str, float]:
        return {"base_radius_mm": z[0]}

    def motion_dimensions(self, motion: Motion, z: tuple[float, ...]) -> Mapping[str, float]:
        """The face that contact needs: to the left and right of the slide's line on a ccw cam."""
        left, _ = peak(motion.curve, (0.0, -1.0, 0.0, 0.0))
        right, _ = peak(motion.curve, (0.0, 1.0, 0.0, 0.0))
        return {"face_left_mm": left, "face_right_mm": right, "face_width_mm": left + right}
