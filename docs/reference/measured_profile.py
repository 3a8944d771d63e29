"""The figures of measured-profile.md, and its worked example; `--write` writes the example."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np

from synthesis import DesignSpec, synthesise
from synthesis.exporters import PROFILE_FORMATS, PointOptions
from synthesis.studies.analyse import given_cam
from synthesis.studies.measured import MeasuredCam, ProfileAnalysis, read_back

EXAMPLE = (
    Path(__file__).resolve().parents[2] / "openapi/examples/profile-analyses/spare-roller.json"
)
TOLERANCE = 8e-3  # mm
FOLLOWERS: dict[str, dict[str, Any]] = {
    "roller, offset 7.1": {
        "kind": "translating_roller", "roller_radius_mm": 9.3, "offset_mm": 7.1},
    "knife edge, offset −5.1": {
        "kind": "translating_roller", "roller_radius_mm": 0.0, "offset_mm": -5.1},
    "flat face": {"kind": "translating_flat_face"},
    "roller on an arm": {
        "kind": "oscillating_roller", "arm_mm": 85.0, "centre_distance_mm": 100.0,
        "roller_radius_mm": 9.3},
}  # fmt: skip


def spec(follower: dict[str, Any], **changes: Any) -> DesignSpec:
    """A cam given in full: rise 73.3°, dwell 41.2°, return 88.9°, dwell."""
    swings = follower["kind"].startswith("oscillating")
    lift = {"lift_deg": 16.0} if swings else {"lift_mm": 23.7}
    body = {
        "speed_rpm": 100.0,
        "program": [
            {"kind": "rise", "angle_deg": 73.3, "law": {"kind": "modified_sine"}, **lift},
            {"kind": "dwell", "angle_deg": 41.2},
            {"kind": "return", "angle_deg": 88.9, "law": {"kind": "cycloidal"}, **lift},
            {"kind": "dwell", "angle_deg": 156.6},
        ],
        "follower": follower,
        "base_radius_mm": 141.0 if follower["kind"] == "translating_flat_face" else 41.3,
    }
    return DesignSpec.model_validate(body | changes)


def measured(
    question: DesignSpec, per_degree: float = 2.0, noise: float = 1e-3
) -> list[list[float]]:
    """Points of the exported profile, rounded to 1 µm, each coordinate with noise [mm]."""
    options = PointOptions(points_per_degree=per_degree)
    text = PROFILE_FORMATS["txt"].write(synthesise(question), options).decode()
    points = np.array([[float(cell) for cell in line.split()[:2]] for line in text.splitlines()])
    rng = np.random.default_rng(3)
    return (np.round(points, 3) + noise * rng.standard_normal(points.shape)).tolist()


def errors(question: DesignSpec, found: ProfileAnalysis) -> list[float]:
    """Largest error of displacement to jerk, in the wire's units."""
    motion, travel = given_cam(question).motion, question.follower.travel
    true = motion.derivatives(np.radians(found.table["angle_deg"]))
    columns = [values for name, values in found.table.items() if name[1] == "_"]
    rates = [travel.wire_factor(order, question.machine().omega) for order in range(4)]
    pairs = zip(columns, true, rates, strict=True)
    return [float(np.max(np.abs(np.array(c) - rate * t))) for c, t, rate in pairs]


def table() -> None:
    """What each follower's motion comes back as, from 2 points a degree with 1 µm of noise."""
    for name, follower in FOLLOWERS.items():
        question = spec(follower)
        cam = MeasuredCam(
            speed_rpm=100.0, points_mm=measured(question), follower=follower, tolerance_mm=TOLERANCE
        )
        found = read_back(cam)
        reported = [peak.error for peak in found.peaks[:4]]
        print(f"{name}: {found.fit.points} points, rms {1e3 * found.fit.rms_mm:.2f} µm")
        for peak, error, most in zip(found.peaks, errors(question, found), reported, strict=False):
            print(f"  {peak.curve}: error {error:.3g}, stated {most:.3g} {peak.unit}")


def example() -> dict[str, Any]:
    """A cam with a valley that was made for a small roller, and a larger one on it."""
    question = spec(
        FOLLOWERS["roller, offset 7.1"] | {"roller_radius_mm": 4.1},
        program=[
            {"kind": "return", "angle_deg": 38, "lift_mm": 13.7, "law": {"kind": "cycloidal"}},
            {"kind": "rise", "angle_deg": 41, "lift_mm": 13.7, "law": {"kind": "modified_sine"}},
            {"kind": "dwell", "angle_deg": 281},
        ],
    )
    points = np.round(measured(question, 0.6), 3).tolist()
    return {
        "summary": "A roller too large for a valley",
        "description": "Points of a profile, one every 1.7°, and a roller of 33 mm where one of "
        "4.1 mm belongs: `unreached_hollows` says where it spans the valley, the hollow's "
        "radius and the gap.",
        "value": {
            "name": "spare roller", "speed_rpm": 100.0, "points_mm": points,
            "follower": {"kind": "translating_roller", "roller_radius_mm": 33.0, "offset_mm": 7.1},
            "tolerance_mm": 0.02,
        },
    }  # fmt: skip


if __name__ == "__main__":
    if "--write" in sys.argv:
        text = json.dumps(example(), ensure_ascii=False, indent=1)
        text = re.sub(r"\[\s+(-?[\d.]+),\s+(-?[\d.]+)\s+\]", r"[\1, \2]", text)
        EXAMPLE.write_text(text + "\n", encoding="utf-8")
    table()
    found = read_back(MeasuredCam.model_validate(example()["value"]))
    for place in found.unreached_hollows:
        print(
            f"spare roller: at {place.angle_deg:.2f}° over a hollow of "
            f"{place.hollow_radius_mm:.2f} mm, gap {place.gap_mm:.3f} mm"
        )
