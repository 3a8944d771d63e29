"""One design question for every limit and objective of the catalogue, in which it matters.

A new limit or objective joins by one entry here: `LIMITS[kind]` is a spec in which the limit is
reached, `OBJECTIVES[kind]` one in which the proven bound is near the value. The conformance tests
take every kind of the registries through its scene and name a kind that has none.
"""

from __future__ import annotations

from typing import Any

Spec = dict[str, Any]
SPLINE: Spec = {"kind": "spline"}
ROLLER: Spec = {"kind": "translating_roller", "roller_radius_mm": 9.0}
FACE: Spec = {"kind": "translating_flat_face"}
PRESSURE_ANGLE: Spec = {"kind": "pressure_angle", "rise_deg": 32.0, "return_deg": 38.0}
JERK: Spec = {"kind": "jerk", "max_mm_per_s3": 700_000.0}
SPRING: Spec = {
    "kind": "slide",
    "moving_mass_kg": 2.0,
    "spring": {"rate_n_per_mm": 3.0, "preload_n": 30.0},
    "contact": {"width_mm": 12.0},
}


def question(*limits: Spec, law: Spec = SPLINE, follower: Spec = ROLLER, **changes: Any) -> Spec:
    """25 mm up in 90° and down in 110° at 120 rpm, two dwells between: the smallest cam."""
    lift = {"lift_mm": 25.0, "law": law}
    return {
        "speed_rpm": 120.0,
        "program": [
            {"kind": "rise", "angle_deg": 90.0} | lift,
            {"kind": "dwell", "angle_deg": 40.0},
            {"kind": "return", "angle_deg": 110.0} | lift,
            {"kind": "dwell", "angle_deg": 120.0},
        ],
        "follower": follower,
        "limits": list(limits),
        "tolerance": 0.01,
    } | changes


def sized(objective: str, *limits: Spec, **changes: Any) -> Spec:
    """The same with the cam's size given, so that only the motion is chosen."""
    follower = ROLLER | {"offset_mm": 0.0}
    given = {"base_radius_mm": 60.0, "follower": follower, "objective": {"kind": objective}}
    return question(*limits, **(given | changes))


LIMITS: dict[str, Spec] = {
    "pressure_angle": question(PRESSURE_ANGLE, JERK),
    "profile_radius": question({"kind": "profile_radius", "min_mm": 7.0}, JERK, follower=FACE),
    "cutter_radius": question(
        {"kind": "cutter_radius", "radius_mm": 90.0}, PRESSURE_ANGLE, law={"kind": "cycloidal"}
    ),
    "velocity": sized("rms_acceleration", {"kind": "velocity", "max_mm_per_s": 240.0}),
    "acceleration": sized("rms_jerk", {"kind": "acceleration", "max_mm_per_s2": 8_000.0}),
    "jerk": sized("peak_acceleration", {"kind": "jerk", "max_mm_per_s3": 700_000.0}),
    "outer_radius": question(
        {"kind": "outer_radius", "max_mm": 80.0}, JERK, objective={"kind": "peak_pressure_angle"}
    ),
    "face_width": question(
        {"kind": "face_width", "left_mm": 20.0, "right_mm": 25.0},
        {"kind": "profile_radius", "min_mm": 5.0},
        follower=FACE,
        base_radius_mm={"max": 150.0},
        objective={"kind": "peak_acceleration"},
    ),
    "counter_base_radius": question(
        PRESSURE_ANGLE,
        {"kind": "counter_base_radius", "min_mm": 75.0},
        law={"kind": "cycloidal"},
        follower=ROLLER
        | {"offset_mm": 0.0, "closure": {"kind": "conjugate", "roller_radius_mm": 9.0}},
    ),
    "contact_force": sized(
        "rms_jerk",
        {"kind": "contact_force", "min_n": 20.0},
        load=SPRING | {"spring": {"rate_n_per_mm": 0.4, "preload_n": 28.0}},
    ),
    "hertz_pressure": question(
        {"kind": "hertz_pressure", "max_mpa": 120.0}, JERK, follower=FACE, load=SPRING
    ),
    "camshaft_torque": sized(
        "rms_jerk", {"kind": "camshaft_torque", "max_n_m": 2.0}, load=SPRING, tolerance=0.05
    ),
    "residual_vibration": sized(
        "rms_acceleration",
        {"kind": "residual_vibration", "natural_frequency_hz": 21.0, "max_mm": 0.01},
    ),
}

OBJECTIVES: dict[str, Spec] = {
    "base_radius": question(PRESSURE_ANGLE, JERK),
    "peak_acceleration": sized("peak_acceleration", JERK),
    "peak_jerk": sized("peak_jerk"),
    "rms_acceleration": sized("rms_acceleration", JERK),
    "rms_jerk": sized("rms_jerk"),
    "peak_pressure_angle": question(
        JERK, base_radius_mm=60.0, objective={"kind": "peak_pressure_angle"}
    ),
    "peak_drive_force": sized("peak_drive_force", JERK, load=SPRING),
}
