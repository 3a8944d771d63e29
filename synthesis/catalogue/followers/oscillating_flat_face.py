"""Oscillating flat-face follower: a flat face that swings about a fixed pivot.

Symbols: d distance of the pivot from the cam's axis; f distance of the face from the pivot,
positive towards the axis; ψ angle at the pivot between the line to the axis and the face, ψ0 at
the lowest position; φ = ψ − ψ0 swing; σ = +1 where the lifting face turns against a ccw cam, −1
where it turns with it; w = 1 + σφ'. Derivatives are per radian of the cam. With the unit vectors
u along the face, away from the pivot, and n the face's outward normal, du/dψ = n and dn/dψ = −u.

The face is a line at the distance h = d sinψ − f from the axis: the profile's support function.
Its normal turns by −w per radian as seen from the cam, for that w must not vanish, and so

    contact  r = d cosψ / w                       along u, from the foot of the pivot on the face
    radius   ρ = h + d²h/dχ² = d [sinψ (1 + 2σφ') / w² + cosψ φ'' / w³] − f
    pressure angle  tan α = f / r                 the contact point moves along r n + f u

The base radius is that of the profile on the lowest dwell, Rb = d sinψ0 − f, and |ψ| < 90°: there
contact is on the face's own side of the pivot and a swing lifts.

Multiplied by powers of w every limit reads A d cosψ + B d sinψ ≤ C with A, B and C from the motion
alone, so that with p = d cosψ0, q = d sinψ0 = Rb + f it is linear in the size at every angle
(``swinging_face``). Where d is free z = (p, Rb); where it is a number z = (Rb,).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import (
    AffineNorm,
    Ends,
    LinearInequality,
    NonconvexConstraint,
    NonconvexConstraints,
    NormBounds,
    SizeDomain,
    Vector,
)
from synthesis.catalogue.fields import Number, Range, ends
from synthesis.catalogue.followers.base import FlatFaceFollower
from synthesis.catalogue.followers.kinematics import Face, Link, Vector2
from synthesis.catalogue.followers.pivot import PivotDirection, PivotedFollower, PivotSense
from synthesis.catalogue.followers.swinging_face import (
    RIGHT_ANGLE,
    LeastPivotDistance,
    SwingingFaceConstraint,
)
from synthesis.catalogue.motion import Motion, Segments
from synthesis.numerics.maxima import maximise, maximise_formula
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

SLOWEST = 1e-3  # of the cam's speed: how fast the normal turns on the cam at least


class OscillatingFlatFace(FlatFaceFollower, PivotedFollower):
    """A flat face that swings about a pivot; the lift is the angle of its swing."""

    kind: Literal["oscillating_flat_face"] = "oscillating_flat_face"
    title: ClassVar[str] = "Oscillating flat face, on a pivot"
    size_charts: ClassVar[tuple[tuple[str, ...], ...]] = (("base_radius",), ("p", "base_radius"))
    swing_range: ClassVar[tuple[float, float]] = (-RIGHT_ANGLE, RIGHT_ANGLE)
    face_ends: ClassVar[tuple[str, str]] = ("near", "far")

    centre_distance_mm: Number | Range = Field(
        description="Distance of the pivot from the cam's axis: a number, or a range with an "
        "upper end within which it is free."
    )
    face_offset_mm: float = Field(
        0.0,
        ge=-1e6,
        le=1e6,
        description="Distance of the face from the pivot, positive towards the cam's axis. "
        "At 0 the face points at the pivot, and the pressure angle is 0.",
    )
    sense: PivotSense = Field(
        "opposite", description="Whether the lifting face turns against the cam or with it."
    )
    pivot_direction_deg: PivotDirection = 0.0

    @field_validator("centre_distance_mm")
    @classmethod
    def _ends(cls, distance: float | Range) -> float | Range:
        low, high = ends(distance)
        if not 0.0 < high < math.inf or (low == high and low <= 0.0):
            raise PydanticCustomError(
                "centre_distance_open",
                "centre_distance_mm = {value} leaves the distance of the pivot open or not "
                "positive. Give a positive number, or a range with a positive max.",
                {"value": high if math.isfinite(high) else "∞"},
            )
        return distance

    @property
    def reference(self) -> float:
        return ends(self.centre_distance_mm)[1]  # the largest

    @property
    def reason_without_minimum(self) -> str:
        nearest, _ = ends(self.centre_distance_mm)
        # an offset is a length of its own, which a small cam would have to be measured by
        anywhere = nearest <= 0.0 and self.face_offset_mm == 0.0
        return "the pivot may be as near to the cam's axis as one likes" if anywhere else ""

    def adjustable_dimensions(self) -> Mapping[str, float | Range | None]:
        return {} if self.distance is not None else {"centre_distance_mm": self.centre_distance_mm}

    def feasible_base_radii(self, base_radius: Ends, stroke: float) -> Ends:
        # ψ0 + φ < 90° at the highest lift
        swing = stroke / self.reference
        farthest = ends(self.centre_distance_mm)[1] * math.cos(min(swing, RIGHT_ANGLE))
        return base_radius[0], min(base_radius[1], farthest - self.face_offset_mm)

    def check_dimensions(self, base_radius: Ends, segments: Segments) -> None:
        self._check_turn(segments)
        highest = max(segments, key=lambda s: max(s.s_start, s.s_end))
        swing = max(highest.s_start, highest.s_end) / self.reference
        least, most = self.feasible_base_radii(base_radius, swing * self.reference)
        if swing < RIGHT_ANGLE and least < most + 1e-9 * self.reference:
            return
        at = highest.end if highest.s_end >= highest.s_start else highest.start
        raise PydanticCustomError(
            "face_swings_too_far",
            "at cam angle {at}° (program/{index}) the face has swung by {swing}° and is past the "
            "right angle to the line of centres, from which on it lifts no more: with this pivot "
            "the base radius can be at most {most} mm, and {least} mm is required. Make the lift "
            "or the base radius smaller, or the centre distance larger.",
            {"swing": round(swing / DEGREE, 6), "at": round(at / DEGREE, 4),
             "index": highest.index, "most": f"{most:.6g}", "least": f"{least:.6g}"},
        )  # fmt: skip

    def _check_turn(self, segments: Segments) -> None:
        """Refuse given laws along which the face turns as fast as the cam."""
        for segment in segments:
            if segment.law is None or segment.kind == "dwell" or segment.angle <= 0.0:
                continue
            speed, at = maximise(segment.placed(), (0.0, -self.sigma / self.reference, 0.0, 0.0))
            if speed > 1.0 - SLOWEST:
                raise PydanticCustomError(
                    "face_turns_with_cam",
                    "at cam angle {at}° (program/{index}) the face turns {speed} times as fast as "
                    "the cam and in its sense: it has to stay slower, or it touches the cam "
                    "nowhere. Make the lift smaller, the angle larger, or turn the sense.",
                    {"speed": round(speed, 9), "at": round(at / DEGREE, 4),
                     "index": segment.index},
                )  # fmt: skip

    def radius_norm(self) -> AffineNorm:
        return AffineNorm(((*[0.0] * (len(self.size_names) - 1), 1.0),), (0.0,))

    def size_domain(self, base_radius: Ends) -> SizeDomain:
        farthest, f = ends(self.centre_distance_mm)[1], self.face_offset_mm
        low, high = base_radius[0], max(min(base_radius[1], farthest - f), base_radius[0])
        if self.distance is not None:
            return SizeDomain(((low, high),), (), low)
        centred = AffineNorm(((1.0, 0.0), (0.0, 1.0)), (0.0, f))
        cones = (NormBounds(centred, farthest, "centre_distance"),)
        return SizeDomain(((0.0, farthest), (low, high)), cones, low)

    def profile_radius_rows(self, least: float) -> tuple[LinearInequality, ...]:
        # w ≥ SLOWEST: without it there is no radius; the radius itself is curved
        most = self.reference * (1.0 - SLOWEST)
        return (LinearInequality((0.0, -self.sigma, 0.0, 0.0), (), most),)

    def _limit(self, **terms: float) -> NonconvexConstraint:
        f = self.face_offset_mm
        return SwingingFaceConstraint("", self.reference, self.sigma, f, self.distance, **terms)

    def profile_radius_constraints(self, least: float) -> NonconvexConstraints:
        """ρ ≥ least, contact on the face's own side of the pivot, the pivot not too near."""
        nearest, _ = ends(self.centre_distance_mm)
        free = self.distance is None and nearest > 0.0
        return (
            self._limit(bend=-1.0, cubed=-(self.face_offset_mm + least)),
            self._limit(along=-1.0),
            *((LeastPivotDistance("", nearest, self.face_offset_mm),) if free else ()),
        )

    def pressure_angle_constraints(self, slope: float) -> NonconvexConstraints:
        # |f| ≤ t r
        f = abs(self.face_offset_mm)
        return (self._limit(along=-slope, first=-f),) if f else ()

    def contact_constraints(self, end: str, reach: float) -> NonconvexConstraints:
        sign = -1.0 if end == "near" else 1.0
        return (self._limit(along=sign, first=sign * reach),)

    def outer_radius_constraints(self, largest: float) -> NonconvexConstraints:
        # |p| is stationary where φ' ρ = 0, at its largest on the highest lift: |p| = h there
        return (self._limit(lean=1.0, known=largest + self.face_offset_mm),)

    def pivot(self, z: Any) -> Vector2:
        q = z[-1] + self.face_offset_mm
        return (z[0] if self.distance is None else (self.distance**2 - q * q) ** 0.5), q

    def _rates(self, s: Any) -> tuple[Any, Any, Any]:
        """φ', φ'', φ'''."""
        unit = 1.0 / self.reference
        return s[1] * unit, s[2] * unit, s[3] * unit

    def _contact(self, s: Any, z: Any) -> tuple[Any, Any, Any]:
        """r, r', r''."""
        (c, e), (v, a, j) = self.axis_from_pivot(s, z), self._rates(s)
        w, turn, jerk = v * self.sigma + 1.0, a * self.sigma, j * self.sigma
        r = c / w
        r1 = -(e * v + r * turn) / w
        return r, r1, -(c * (v * v) + e * a + r1 * turn * 2.0 + r * jerk) / w

    def position(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        (ux, uy), (nx, ny) = self.frame(s, z)
        f, (_, (x, y)) = self.face_offset_mm, self.pivot_position(z)
        (r, r1, r2), (v, a, _) = self._contact(s, z), self._rates(s)
        # the pivot + r u − f n; u' = φ' n, n' = −φ' u
        along, across = r1 + v * f, r * v
        along2, across2 = r2 + a * f - across * v, along * v + r1 * v + r * a
        return (
            (r * ux - nx * f + x, r * uy - ny * f + y),
            (along * ux + across * nx, along * uy + across * ny),
            (along2 * ux + across2 * nx, along2 * uy + across2 * ny),
        )

    def link(self, z: Any, degree: Any) -> Link:
        f, d, sigma = self.face_offset_mm, self.distance, self.sigma
        q = z[-1] + f
        p = z[0] if d is None else ((d - q) * (d + q)) ** 0.5
        pivot, along = self.link_frame(p, q, degree)
        normal = sigma * along[1], -sigma * along[0]
        foot = pivot[0] - f * normal[0], pivot[1] - f * normal[1]
        return Link(face=Face(foot, along, normal), pivot=pivot, turn=-int(sigma))

    def drive_direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        (ux, uy), (nx, ny) = self.frame(s, z)
        f, (r, r1, _), (v, *_) = self.face_offset_mm, self._contact(s, z), self._rates(s)
        square = r * r + f * f
        length = np.sqrt(square)
        turn = r1 * -f / square - v  # of the direction, from n towards u
        return (
            ((r * nx + f * ux) / length, (r * ny + f * uy) / length),
            ((r * ux - f * nx) * turn / length, (r * uy - f * ny) * turn / length),
        )

    def lever(self, s: Any, z: Any) -> Any:
        # s is the arc at the reference, contact is at (r, f) from the pivot
        f, (r, *_) = self.face_offset_mm, self._contact(s, z)
        return np.sqrt(r * r + f * f) / self.reference

    def normal(self, tangent: Vector2, s: Any, z: Any) -> Vector2:
        return self.frame(s, z)[1]

    def face_normal_rate(self, s: Any, z: Any) -> Vector2:
        (ux, uy), (nx, ny) = self.frame(s, z)
        v, *_ = self._rates(s)
        return ny - v * ux, -nx - v * uy

    def face_axis(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        (_, (x, y)), still = self.pivot_position(z), 0.0 * s[0]
        return (still + x, still + y), self.frame(s, z)[0]

    def face_radius(self, s: Any, z: Any) -> Any:
        (c, e), (v, a, _) = self.axis_from_pivot(s, z), self._rates(s)
        w = v * self.sigma + 1.0
        radius = e * (v * (2.0 * self.sigma) + 1.0) / (w * w) + c * a / (w * w * w)
        return radius - self.face_offset_mm

    def dimensions(self, z: Vector) -> Mapping[str, float]:
        return {
            "base_radius_mm": z[-1],
            "centre_distance_mm": float(self.pivot_position(z)[0]),
            "face_offset_mm": self.face_offset_mm,
            "initial_angle_deg": self.initial_angle(z) / DEGREE,
        }

    def motion_dimensions(self, motion: Motion, z: Vector) -> Mapping[str, float]:
        """The face that contact needs, from the foot of the pivot on it outwards."""

        def reach(s: Array) -> Array:
            still = np.zeros_like(s[0])
            return np.asarray(self._contact([*s, still, still], z)[0])

        near = -maximise_formula(motion.curve, lambda s: -reach(s), 1)[0]
        far = maximise_formula(motion.curve, reach, 1)[0]
        return {"face_near_mm": near, "face_far_mm": far, "face_width_mm": far - near}
