"""Laws of a follower on an arm: the same optima as of a slide, told in degrees."""

from __future__ import annotations

from collections.abc import Callable
from math import pi, radians
from typing import Any

import pytest

from synthesis import DesignSpec, synthesise

LIFT, RISE, BACK, RPM = 31.7, 83.3, 118.9, 137.0
OMEGA = RPM * 2.0 * pi / 60.0
ARM = {
    "kind": "oscillating_roller", "arm_mm": 81.3, "centre_distance_mm": 107.9,
    "roller_radius_mm": 17.9, "sense": "same",
}  # fmt: skip
SLIDE = {"kind": "translating_roller", "roller_radius_mm": 17.9, "offset_mm": 3.1}


def spec(unit: str = "deg", **changes: Any) -> DesignSpec:
    lift = {f"lift_{unit}": LIFT}
    body = {
        "speed_rpm": RPM,
        "program": [
            {"kind": "rise", "angle_deg": RISE} | lift,
            {"kind": "dwell", "angle_deg": 41.2},
            {"kind": "return", "angle_deg": BACK} | lift,
            {"kind": "dwell", "angle_deg": 116.6},
        ],
        "follower": ARM if unit == "deg" else SLIDE,
        "base_radius_mm": 91.7,
        "tolerance": 1e-2,
    }
    return DesignSpec.model_validate(body | changes)


@pytest.mark.parametrize(
    ("kind", "name", "least"),
    [
        ("peak_jerk", "peak_jerk_deg_per_s3", 32.0 * LIFT / radians(RISE) ** 3 * OMEGA**3),
        ("peak_acceleration", "peak_acceleration_deg_per_s2",
         4.0 * LIFT / radians(RISE) ** 2 * OMEGA**2),
    ],
)  # fmt: skip
def test_the_exact_optima_in_degrees(kind: str, name: str, least: float) -> None:
    design = synthesise(spec(objective={"kind": kind}))
    assert design.status == "optimal"
    assert list(design.objectives) == [name]
    assert design.certificate.objective == name
    assert design.certificate.lower_bound <= least * (1.0 + 1e-12)
    assert least * (1.0 - 1e-9) <= design.objectives[name] <= 1.01 * least


def test_a_jerk_limit_in_degrees_bites() -> None:
    # §2: peak acceleration under |j| ≤ J: (J/4)(1 − √(1 − 32/J)), J in units of h/β³
    cap, unit = 50.0, LIFT / radians(RISE) ** 3 * OMEGA**3
    limits = [{"kind": "jerk", "max_deg_per_s3": cap * unit}]
    design = synthesise(spec(objective={"kind": "peak_acceleration"}, limits=limits))
    best = cap / 4.0 * (1.0 - (1.0 - 32.0 / cap) ** 0.5) * LIFT / radians(RISE) ** 2 * OMEGA**2
    value = design.objectives["peak_acceleration_deg_per_s2"]
    assert best * (1.0 - 1e-9) <= value <= 1.01 * best
    (jerk,) = (e for e in design.extremes if e.limit == "jerk")
    assert jerk.unit == "deg/s³"
    assert jerk.field == "jerk/max_deg_per_s3"
    assert jerk.holds
    assert abs(jerk.value) == pytest.approx(cap * unit, rel=1e-3)


def test_the_law_does_not_know_what_it_moves() -> None:
    """The same numbers in mm: the same law, to the last bits."""
    arm, slide = (synthesise(spec(unit, objective={"kind": "rms_jerk"})) for unit in ("deg", "mm"))
    assert arm.objectives["rms_jerk_deg_per_s3"] == pytest.approx(
        slide.objectives["rms_jerk_mm_per_s3"], rel=1e-9
    )
    for here, there in zip(arm.motion, slide.motion, strict=True):
        assert here.levels == pytest.approx(there.levels, abs=1e-12)
        if here.spline is not None:
            assert here.spline.coefficients == pytest.approx(there.spline.coefficients, abs=1e-6)


def test_too_much_jerk_is_told_in_degrees(explain_only: Callable[[str], None]) -> None:
    explain_only("limits/0/max_deg_per_s3")
    least = 32.0 * LIFT / radians(RISE) ** 3 * OMEGA**3
    limits = [{"kind": "jerk", "max_deg_per_s3": 0.9 * least}]
    design = synthesise(spec(limits=limits, objective={"kind": "rms_jerk"}))
    assert design.status == "infeasible"
    (part,) = (r for r in design.conflict.relaxations if r.limit == "jerk")
    assert part.unit == "deg/s³"
    assert part.field == "limits/0/max_deg_per_s3"
    assert part.needed == pytest.approx(least, rel=5e-3)
