"""Finished designs, put together by hand: no solver is needed to write files."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import BSpline, PPoly

from synthesis.design.design import Certificate, Design, Extreme, Report, SegmentMotion, SplineCurve
from synthesis.spec.design_spec import DesignSpec

Builder = Callable[..., Design]

P1_PROGRAM: list[dict[str, Any]] = [
    {"kind": "rise", "angle_deg": 60, "lift_mm": 30, "law": {"kind": "cycloidal"}},
    {"kind": "dwell", "angle_deg": 30},
    {"kind": "return", "angle_deg": 60, "lift_mm": 30, "law": {"kind": "cycloidal"}},
    {"kind": "dwell", "angle_deg": 210},
]
P1_LIMITS: list[dict[str, Any]] = [
    {"kind": "pressure_angle", "rise_deg": 30, "return_deg": 45},
    {"kind": "velocity", "max_mm_per_s": 650},
    {"kind": "acceleration", "max_mm_per_s2": 1.4e4},
    {"kind": "jerk", "max_mm_per_s3": 1.2e6},
]
# Clamped cubics, C² with rest at both ends: first three coefficients 0, last three 1.
SPLINE = SplineCurve(
    degree=3,
    knots=[0.0, 0.11, 0.23, 0.4, 0.52, 0.7, 0.83, 1.0],
    coefficients=[0.0, 0.0, 0.0, 0.12, 0.37, 0.68, 0.91, 1.0, 1.0, 1.0],
)


def extreme(limit: str, unit: str, value: float, angle: float, bound: float, field: str) -> Extreme:
    margin = bound - abs(value)
    return Extreme(
        limit=limit,
        value=value,
        unit=unit,
        angle_deg=angle,
        bound=bound,
        margin=margin,
        width=1e-9,
        holds=margin > 0,
        evidence="by hand",
        field=field,
    )


@pytest.fixture(scope="session")
def build() -> Builder:
    """Design of a translating roller cam: program, offset, prime radius, roller and the rest."""

    def made(
        program: list[dict[str, Any]] | None = None,
        *,
        offset: float = 20.0,
        prime: float = 60.0,
        roller: float = 10.0,
        rotation: str = "ccw",
        speed_rpm: float = 300.0 / math.pi,  # 10 rad/s
        name: str = "example 13-6",
        limits: list[dict[str, Any]] | None = None,
        extremes: list[Extreme] | None = None,
        spline: SplineCurve = SPLINE,
        status: str = "feasible",
    ) -> Design:
        spec = DesignSpec.model_validate(
            {
                "name": name,
                "speed_rpm": speed_rpm,
                "rotation": rotation,
                "program": P1_PROGRAM if program is None else program,
                "follower": {
                    "kind": "translating_roller",
                    "roller_radius_mm": roller,
                    "offset_mm": offset,
                },
                "base_radius_mm": prime - roller,
                "limits": P1_LIMITS if limits is None else limits,
            }
        )
        size = (offset, math.sqrt(prime**2 - offset**2))
        motion = [
            SegmentMotion(
                kind=placed.kind,
                start_deg=math.degrees(placed.start),
                angle_deg=segment.angle_deg,
                s_start_mm=placed.s_start,
                s_end_mm=placed.s_end,
                law=segment.law.kind if segment.kind != "dwell" else "dwell",
                spline=spline if placed.law is None else None,
            )
            for placed, segment in zip(spec.placed_segments(), spec.program, strict=True)
        ]
        return Design.model_validate(
            {
                "id": "0123456789abcdef0123456789abcdef",
                "name": name,
                "engine_version": "0.1.0",
                "status": status,
                "rotation": rotation,
                "speed_rpm": speed_rpm,
                "follower": "translating_roller",
                "dimensions": dict(spec.follower.dimensions(size)),
                "size": list(size),
                "objectives": {"base_radius": prime - roller},
                "motion": motion if status != "infeasible" else [],
                "extremes": extremes or [],
                "certificate": Certificate(
                    certified=True,
                    objective="base_radius",
                    value=prime - roller,
                    lower_bound=None,
                    bound_valid_for="",
                    gap=None,
                ),
                "report": Report(stages=[], seconds=0.0),
                "spec": spec,
            }
        )

    return made


@pytest.fixture(scope="session")
def p1(build: Builder) -> Design:
    return build()


@pytest.fixture(scope="session")
def unspecial(build: Builder) -> Design:
    """No size is round, the offset is negative, the cam turns clockwise, two laws are splines."""
    return build(
        [
            {"kind": "dwell", "angle_deg": 17.3},
            {"kind": "rise", "angle_deg": 71.9, "lift_mm": 13.71, "law": {"kind": "spline"}},
            {"kind": "dwell", "angle_deg": 0},
            {"kind": "rise", "angle_deg": 48.35, "lift_mm": 9.07, "law": {"kind": "cycloidal"}},
            {"kind": "dwell", "angle_deg": 23.45},
            {"kind": "return", "angle_deg": 101.7, "lift_mm": 22.78, "law": {"kind": "spline"}},
            {"kind": "dwell", "angle_deg": 97.3},
        ],
        offset=-7.3,
        prime=41.9,
        roller=8.6,
        rotation="cw",
        speed_rpm=173.0,
        name="unspecial",
        limits=[],
    )


# --- the same cam from the book's formulas, typed again ------------------------------------------

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    """Textbook formulas for a design, from cam angle in degrees and the side meant."""

    design: Design

    def motion(self, degrees: Array, side: Array | int = 0) -> Array:
        """s and three derivatives per radian: (4, n)."""
        meant = np.asarray(degrees) + 1e-8 * np.asarray(side)
        found = np.zeros((4, len(degrees)))
        moving = [segment for segment in self.design.motion if segment.angle_deg > 0.0]
        for number, segment in enumerate(moving):
            end = moving[number + 1].start_deg if number + 1 < len(moving) else 361.0
            here = (meant >= segment.start_deg) & (meant < end)
            lift = segment.s_end_mm - segment.s_start_mm
            x = (degrees[here] - segment.start_deg) / segment.angle_deg
            law = np.zeros((4, len(x)))
            if segment.law == "cycloidal":
                w = 2.0 * np.pi
                law[0] = x - np.sin(w * x) / w
                law[1] = 1.0 - np.cos(w * x)
                law[2] = w * np.sin(w * x)
                law[3] = w * w * np.cos(w * x)
            elif segment.spline is not None:
                law = self.spline(segment.spline, x, (meant - degrees)[here] / segment.angle_deg)
            beta = math.radians(segment.angle_deg)
            found[:, here] = lift * law / beta ** np.arange(4)[:, None]
            found[0, here] += segment.s_start_mm
        return found

    @staticmethod
    def spline(curve: SplineCurve, x: Array, aside: Array) -> Array:
        p = curve.degree
        knots = np.concatenate([np.zeros(p), curve.knots, np.ones(p)])
        pieces = PPoly.from_spline(BSpline(knots, np.array(curve.coefficients), p))
        piece = np.searchsorted(pieces.x, x + aside, side="right") - 1
        piece = np.clip(piece, p, len(pieces.x) - p - 2)
        out = np.zeros((4, len(x)))
        for order in range(4):
            for i in np.unique(piece):
                at = piece == i
                row = np.polyder(pieces.c[:, i], order) if order else pieces.c[:, i]
                out[order, at] = np.polyval(row, x[at] - pieces.x[i])
        return out

    def curves(self, degrees: Array, side: Array | int = 0) -> dict[str, Array]:
        """Pitch curve, profile, curvature and pressure angle."""
        e = self.design.dimensions["offset_mm"]
        roller = self.design.dimensions["roller_radius_mm"]
        s, s1, s2, _ = self.motion(degrees, side)
        sin, cos = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
        height = s + math.sqrt(self.design.dimensions["prime_radius_mm"] ** 2 - e**2)
        x, y = height * sin + e * cos, height * cos - e * sin
        dx = s1 * sin + height * cos - e * sin
        dy = s1 * cos - height * sin - e * cos
        speed = np.hypot(dx, dy)
        mirror = -1.0 if self.design.rotation == "cw" else 1.0
        u = s1 - e
        curvature = (height**2 + u * (2.0 * s1 - e) - height * s2) / (height**2 + u**2) ** 1.5
        return {
            "pitch_x": mirror * x,
            "pitch_y": y,
            "profile_x": mirror * (x + roller * dy / speed),
            "profile_y": y - roller * dx / speed,
            "curvature": curvature,
            "pressure_angle": np.degrees(np.arctan(u / height)),
        }

    def points(self, degrees: Array, curve: str = "profile", side: Array | int = 0) -> Array:
        """(n, 2)."""
        found = self.curves(degrees, side)
        return np.column_stack([found[f"{curve}_x"], found[f"{curve}_y"]])


@pytest.fixture(scope="session")
def truth() -> type[Truth]:
    return Truth


@pytest.fixture(params=["p1", "unspecial"])
def cam(request: pytest.FixtureRequest) -> Design:
    return request.getfixturevalue(request.param)
