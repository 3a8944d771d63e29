"""Finished designs, put together by hand: no solver is needed to write files."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from synthesis.design import Certificate, Design, Extreme, Report, SegmentMotion, SplineCurve
from synthesis.spec import DesignSpec

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
                kind=stretch.kind,
                start_deg=math.degrees(stretch.start),
                angle_deg=segment.angle_deg,
                s_start_mm=stretch.s_start,
                s_end_mm=stretch.s_end,
                law=segment.law.kind if segment.kind != "dwell" else "dwell",
                spline=spline if stretch.law is None else None,
            )
            for stretch, segment in zip(spec.stretches(), spec.program, strict=True)
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
                    bound_over="",
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
