"""Cams that nobody should build, each with the rule that has to speak first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Spec = dict[str, Any]


def program(
    lift: float = 30.0, rise: float = 90.0, law: str = "cycloidal", unit: str = "mm"
) -> list[Spec]:
    """Rise, dwell, return, dwell; the second dwell takes what is left."""
    move = {f"lift_{unit}": lift, "law": {"kind": law}}
    return [
        {"kind": "rise", "angle_deg": rise, **move},
        {"kind": "dwell", "angle_deg": 40.0},
        {"kind": "return", "angle_deg": rise, **move},
        {"kind": "dwell", "angle_deg": 320.0 - 2.0 * rise},
    ]


def cam(base: float | Spec | None = 50.0, roller: float = 10.0, **more: Any) -> Spec:
    """A plain cam that is in order: 30 mm in 90° of a cycloidal at 60 rpm."""
    return {
        "speed_rpm": 60.0, "program": program(), "base_radius_mm": base,
        "follower": {"kind": "translating_roller", "roller_radius_mm": roller, "offset_mm": 0.0},
        "limits": [], **more,
    }  # fmt: skip


def slide(mass: float = 2.0, rate: float = 5.0, preload: float = 100.0, **spring: Any) -> Spec:
    pressed = {"rate_n_per_mm": rate, "preload_n": preload, **spring}
    return {"kind": "slide", "moving_mass_kg": mass, "spring": pressed}


def angles(limit: float) -> list[Spec]:
    return [{"kind": "pressure_angle", "rise_deg": limit, "return_deg": limit}]


def pusher() -> Spec:
    """The first cam of a newcomer: nothing but a pressure angle is asked for."""
    move = {"lift_mm": 45.0, "law": {"kind": "spline"}}
    return {
        "speed_rpm": 200.0,
        "program": [
            {"kind": "rise", "angle_deg": 120.0, **move},
            {"kind": "dwell", "angle_deg": 60.0},
            {"kind": "return", "angle_deg": 100.0, **move},
            {"kind": "dwell", "angle_deg": 80.0},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 16.0},
        "limits": angles(30.0),
        "objective": {"kind": "base_radius"},
        "proof": "quick",
        "tolerance": 0.05,
    }


GOOD = cam(base=70.0)
"""Nothing to be said of it."""

FIRST: Mapping[str, tuple[str, str, Spec]] = {
    "the pusher": ("sharp_nose", "stop", pusher()),
    "a hub without room": ("hub", "stop", cam(None, program=program(20.0, 155.0),
                                              follower={"kind": "translating_flat_face"},
                                              limits=[{"kind": "profile_radius", "min_mm": 2.0}])),
    "a hub that the torque does not allow": (
        "hub", "stop",
        cam(base=None, limits=angles(60.0), load={"kind": "slide", "moving_mass_kg": 1.0,
            "spring": {"rate_n_per_mm": 10.0, "preload_n": 20000.0}},
            program=program(10.0, 120.0)),
    ),
    "a shaft that is too thin for the load": (
        "hub", "caution", cam(None, limits=angles(30.0), shaft_diameter_mm=20.0,
                              load=slide(1.0, 10.0, 5000.0)),
    ),
    "a bore wider than the base circle": (
        "hub", "stop", cam(20.0, body={"thickness_mm": 10.0, "bore_mm": 50.0}),
    ),
    "a nose that is a point": (
        "sharp_nose", "stop", cam(base=None, roller=20.0, limits=angles(60.0), proof="quick",
                                  program=program(20.0, 30.0)),
    ),
    "a harmonic at 300 rpm": (
        "jumps", "caution", cam(70.0, speed_rpm=300.0, program=program(law="simple_harmonic")),
    ),
    "constant velocity at 120 rpm": (
        "jumps", "stop", cam(70.0, speed_rpm=120.0, program=program(law="constant_velocity")),
    ),
    "a motion that nothing but size limits": (
        "rough_motion", "caution",
        cam(None, program=program(law="spline"), proof="quick", tolerance=0.1,
            objective={"kind": "base_radius"},
            limits=[*angles(30.0), {"kind": "profile_radius", "min_mm": 10.0}]),
    ),
    "float": ("contact_force", "stop", cam(70.0, speed_rpm=400.0, load=slide(8.0))),
    "a spring beyond solid": (
        "spring_solid", "stop", cam(70.0, load=slide(1.0, 5.0, 100.0, solid_mm=45.0)),
    ),
    "a spring that is nearly solid": (
        "spring_solid", "caution", cam(70.0, load=slide(1.0, 5.0, 100.0, solid_mm=54.0)),
    ),
    "hardly no float": (
        "contact_force", "note", cam(70.0, speed_rpm=300.0, load=slide(2.0, 5.0, 37.0)),
    ),
    "a roller of 16 mm on a large cam at 3000 rpm": (
        "roller_speed", "caution", cam(60.0, 8.0, speed_rpm=3000.0, program=program(5.0)),
    ),
    "pressure angles in radians": ("unit_suspicion", "caution", cam(None, limits=angles(0.52))),
    "radians, and no cam that keeps them": (
        "unit_suspicion", "caution",
        cam(None, limits=[*angles(0.52), {"kind": "outer_radius", "max_mm": 200.0}]),
    ),
    "a stroke in metres": ("unit_suspicion", "caution", cam(40.0, program=program(0.03))),
    "a slide that jams": ("pressure_angle", "stop", cam(8.0, 4.0, program=program(60.0, 60.0))),
    "a steep arm": (
        "pressure_angle", "caution",
        cam(80.0, program=program(45.0, 80.0, unit="deg"),
            follower={"kind": "oscillating_roller", "roller_radius_mm": 15.0, "arm_mm": 85.0,
                      "centre_distance_mm": 120.0}),
    ),
    "a pressure that dents bearings": (
        "contact_pressure", "stop",
        cam(70.0, shaft_diameter_mm=40.0,
            load={**slide(2.0, 50.0, 20000.0), "contact": {"width_mm": 0.5}}),
    ),
    "a contact wider than the cam": (
        "contact_pressure", "caution",
        cam(70.0, load={**slide(2.0, 5.0, 500.0), "contact": {"width_mm": 15.0}},
            body={"thickness_mm": 12.0, "bore_mm": 20.0}),
    ),
    "a knife edge": ("knife_edge", "caution", cam(70.0, 0.0)),
    "a train that is too soft": (
        "period_ratio", "note",
        cam(70.0, limits=[{"kind": "residual_vibration", "natural_frequency_hz": 8.0,
                           "max_mm": 30.0}]),
    ),
}  # fmt: skip
"""Code and severity of the first warning, and the spec."""
