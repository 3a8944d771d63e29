"""Translating flat-face follower; its face may be tilted against its slide.

Symbols: Rb base radius; τ tilt; c offset of the slide's line; n = (−sin τ, cos τ) the face's
outward normal and t = (cos τ, sin τ) the direction along it, fixed in the machine frame;
ρ signed radius of the profile, negative where it is undercut.

The face is a line that keeps its direction, and moving it by s along the slide moves it by s cos τ
along its normal. So its distance from the axis, the profile's support function, is
h = Rb + s cos τ, and ρ = h + h'' = Rb + (s + s'') cos τ: the tilt shortens the motion that the cam
sees, nothing else. Contact is at h n + h' t (Norton ch. 8 for τ = 0). The slide's line crosses the
face at (c, (Rb + c sin τ)/cos τ + s); seen from there contact is at
s' cos τ − s sin τ − Rb tan τ − c/cos τ along the face, so the offset only says where on the face.
The pressure angle is τ throughout.

The traced point is the contact point itself. Its tangent on the cam is ρ t: along the face,
whatever the motion. The curvature of such a curve is 1/|ρ|, which hides undercut; so radius and
normal are those of the face, which knows which side is out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import AffineNorm, Ends, LinearInequality, SizeDomain, Vector
from synthesis.catalogue.followers.base import FlatFaceFollower, InverseKinematics
from synthesis.catalogue.followers.kinematics import Face, Link, Vector2
from synthesis.catalogue.motion import Motion
from synthesis.numerics.maxima import maximise
from synthesis.units import DEGREE

LEAST_TILT = 1e-3  # degrees


class TranslatingFlatFace(FlatFaceFollower, InverseKinematics):
    """A flat face on a slide that moves in a straight line past the cam's axis."""

    kind: Literal["translating_flat_face"] = "translating_flat_face"
    title: ClassVar[str] = "Translating flat face, perpendicular to its slide or tilted"
    size_charts: ClassVar[tuple[tuple[str, ...], ...]] = (("base_radius",),)
    face_ends: ClassVar[tuple[str, str]] = ("left", "right")

    tilt_deg: float = Field(
        0.0,
        gt=-90.0,
        lt=90.0,
        description="How far the face is turned from perpendicular to its slide: positive in "
        "the sense in which the cam turns. It is the pressure angle.",
    )
    offset_mm: float = Field(
        0.0,
        ge=-1e6,
        le=1e6,
        description="Distance of the slide's line from the cam's axis, positive to the right "
        "of an upward follower on a ccw cam. It only says where on the face contact is.",
    )

    @field_validator("tilt_deg")
    @classmethod
    def _tilted_or_not(cls, tilt: float) -> float:
        if 0.0 < abs(tilt) < LEAST_TILT:
            raise PydanticCustomError(
                "tilt_too_small",
                "tilt_deg = {tilt} is less than {least}°, which cannot be distinguished from "
                "perpendicular. Give 0, or a larger tilt.",
                {"tilt": tilt, "least": LEAST_TILT},
            )
        return tilt

    @property
    def _tilt(self) -> Ends:
        """cos τ and sin τ."""
        return math.cos(self.tilt_deg * DEGREE), math.sin(self.tilt_deg * DEGREE)

    def size_domain(self, base_radius: Ends) -> SizeDomain:
        return SizeDomain((base_radius,), (), base_radius[0])

    def outer_radius_norm(self, s_max: float) -> AffineNorm:
        # |p|² = h² + h'² is stationary where h' ρ = 0: on the normal, at the highest lift
        return AffineNorm(((1.0,),), (s_max * self._tilt[0],))

    def pressure_angle_rows(self, slope: float) -> tuple[LinearInequality, ...]:
        # |tan τ| ≤ slope: true or not, whatever the motion and the size
        steepness = abs(math.tan(self.tilt_deg * DEGREE))
        return (LinearInequality((0.0, 0.0, 0.0, 0.0), (), slope - steepness),) if steepness else ()

    def profile_radius_rows(self, least: float) -> tuple[LinearInequality, ...]:
        # Rb + (s + s'') cos τ ≥ least
        cos, _ = self._tilt
        return (LinearInequality((-cos, 0.0, -cos, 0.0), (-1.0,), -least),)

    @property
    def _contact(self) -> tuple[float, float, float, float]:
        """Contact along the face from the slide's line: factors of s, s' and Rb, and the rest."""
        cos, sin = self._tilt
        return -sin, cos, -sin / cos, -self.offset_mm / cos

    def contact_rows(self, end: str, reach: float) -> tuple[LinearInequality, ...]:
        sign = -1.0 if end == "left" else 1.0
        s, v, base, rest = (sign * each for each in self._contact)
        return (LinearInequality((s, v, 0.0, 0.0), (base,) if base else (), reach - rest),)

    def position(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        cos, sin = self._tilt
        h = (z[0] + s[0] * cos, s[1] * cos, s[2] * cos, s[3] * cos)
        return tuple((h[k + 1] * cos - h[k] * sin, h[k] * cos + h[k + 1] * sin) for k in range(3))

    def link(self, z: Any, degree: Any) -> Link:
        tilt, still = self.tilt_deg * degree, 0.0 * z[0]
        cos, sin, c = np.cos(tilt), np.sin(tilt), self.offset_mm
        face = Face((still + c, (z[0] + c * sin) / cos), (cos, sin), (-sin, cos))
        return Link(face=face, slide=(still, still + 1.0))

    def pose(self, point: Any, normal: Any) -> tuple[Any, Any]:
        # the support function over its angle: h = Rb + s cos τ, the normal turned by τ
        (x, y), (nx, ny) = point, normal
        return np.arctan2(nx, ny) + self.tilt_deg * DEGREE, (x * nx + y * ny) / self._tilt[0]

    def size_at_lowest(self, position: float) -> Vector:
        return (position * self._tilt[0],)

    def clearance(self, away: Any, up: Any) -> Any:
        cos, sin = self._tilt
        nx, ny = up[0] * cos - up[1] * sin, up[0] * sin + up[1] * cos
        return -(away[0] * nx + away[1] * ny)

    def normal(self, tangent: Vector2, s: Any, z: Any) -> Vector2:
        (cos, sin), zero = self._tilt, 0.0 * s[0]
        return zero - sin, zero + cos

    def face_normal_rate(self, s: Any, z: Any) -> Vector2:
        (cos, sin), zero = self._tilt, 0.0 * s[0]
        return zero + cos, zero + sin  # J n: the cam turns, the face does not

    def face_axis(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        (cos, sin), zero = self._tilt, 0.0 * s[0]
        crossed = s[0] + (z[0] + self.offset_mm * sin) / cos  # by the slide's line
        return (zero + self.offset_mm, crossed), (zero + cos, zero + sin)

    def face_radius(self, s: Any, z: Any) -> Any:
        return (s[0] + s[2]) * self._tilt[0] + z[0]

    def dimensions(self, z: Vector) -> Mapping[str, float]:
        beside = {"offset_mm": self.offset_mm} if self.offset_mm else {}
        return {"base_radius_mm": z[0], **beside}

    def motion_dimensions(self, motion: Motion, z: Vector) -> Mapping[str, float]:
        """The face that contact needs: to the left and right of the slide's line on a ccw cam."""
        s, v, base, rest = self._contact
        shift = base * z[0] + rest
        left = maximise(motion.curve, (-s, -v, 0.0, 0.0))[0] - shift
        right = maximise(motion.curve, (s, v, 0.0, 0.0))[0] + shift
        return {"face_left_mm": left, "face_right_mm": right, "face_width_mm": left + right}
