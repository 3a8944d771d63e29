"""The main job in the core: example 13-6 sized, with and without a profile radius that bites."""

from __future__ import annotations

from math import pi
from typing import Any

from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import Call, Timing, in_turns
from synthesis import DesignSpec, synthesise
from synthesis.design.design import Design

OMEGA = 10.0
CONVEX: dict[str, Any] = {
    "speed_rpm": OMEGA * 30.0 / pi,
    "program": [
        {"kind": "rise", "angle_deg": 60.0, "lift_mm": 30.0},
        {"kind": "dwell", "angle_deg": 30.0},
        {"kind": "return", "angle_deg": 60.0, "lift_mm": 30.0},
        {"kind": "dwell", "angle_deg": 210.0},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 10.0},
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 45.0},
        {"kind": "jerk", "max_mm_per_s3": 1.5 * 32.0 * 30.0 / (pi / 3.0) ** 3 * OMEGA**3},
    ],
    "tolerance": 5e-3,
}
BITING = CONVEX | {"limits": [*CONVEX["limits"], {"kind": "profile_radius", "min_mm": 12.0}]}
SCENES: dict[str, dict[str, Any]] = {
    "pressure angle 30°/45°, jerk ≤ 1.5 × minimum": CONVEX,
    "the same, tolerance 0.1 %": CONVEX | {"tolerance": 1e-3},
    'and profile radius ≥ 12 mm (not convex), `proof: "quick"`': BITING | {"proof": "quick"},
    'the same, `proof: "auto"`': BITING,
}
TEXT = """Example 13-6's motion with the laws free: 30 mm up over 60°, 30° dwell, 60° back, at 10
rad/s; roller radius 10 mm; tolerance 0.5 % unless said otherwise. Time from the spec to the
certified design, in the core; the gap is proven, to a lower bound over all motion laws."""


def run(effort: Effort = FULL) -> Section:
    """Time and gap of each scene."""
    specs = {name: DesignSpec.model_validate(body) for name, body in SCENES.items()}
    specs = dict(effort.some(list(specs.items())))
    designs: dict[str, Design] = {}
    calls: dict[str, Call] = {
        name: (lambda name=name, spec=spec: designs.update({name: synthesise(spec)}))
        for name, spec in specs.items()
    }
    times = in_turns(calls, effort.repeats(21), effort.warm_up(2))
    rows = [_row(name, times[name], design) for name, design in designs.items()]
    table = Table(("scene", ">time", ">base radius", ">proven gap", "status"), rows)
    return Section(
        "The main job",
        TEXT,
        [table],
        [
            (f"{name}", str(times[name]), f"{_gap(design)}, proven")
            for name, design in designs.items()
        ],
    )


def _row(name: str, time: Timing, design: Design) -> tuple[str, ...]:
    radius = f"{design.dimensions['base_radius_mm']:.4f} mm"
    return name, str(time), radius, _gap(design), design.status


def _gap(design: Design) -> str:
    gap = design.certificate.gap
    return "none" if gap is None else f"{100.0 * gap:.2f} %"
