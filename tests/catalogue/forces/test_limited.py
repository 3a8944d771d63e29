"""Cams designed under limits on forces, and measured by means that know nothing of the product.

Only what is exported is used: points of the profile and of the motion.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from synthesis import Design, DesignSpec, synthesise
from synthesis.exporters import MOTION_FORMATS, MotionOptions

RPM, MASS, RATE, PRELOAD, WIDTH, ROLLER, E, NU = 317.0, 2.1, 6.3, 410.0, 12.3, 9.7, 206e3, 0.3
POINTS = [(7.0, 0.0), (58.0, 480.0), (97.0, 480.0), (97.0, 0.0)]
BODY: dict[str, Any] = {
    "speed_rpm": RPM,
    "program": [
        {"kind": "rise", "angle_deg": 71.3, "lift_mm": 28.9, "law": {"kind": "spline"}},
        {"kind": "dwell", "angle_deg": 25.7},
        {"kind": "return", "angle_deg": 83.1, "lift_mm": 28.9, "law": {"kind": "spline"}},
        {"kind": "dwell", "angle_deg": 179.9},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": ROLLER},
    "load": {
        "kind": "slide", "moving_mass_kg": MASS,
        "spring": {"rate_n_per_mm": RATE, "preload_n": PRELOAD},
        "process": [{"angle_deg": a, "force_n": f} for a, f in POINTS],
        "contact": {"width_mm": WIDTH},
    },
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 30, "return_deg": 45},
        {"kind": "jerk", "max_mm_per_s3": 3e7},
    ],
    "tolerance": 5e-3,
    "proof": "quick",
}  # fmt: skip


def limited(*limits: dict[str, Any], **load: Any) -> Design:
    body = BODY | {"limits": [*BODY["limits"], *limits], "load": BODY["load"] | load}
    return synthesise(DesignSpec.model_validate(body))


@pytest.fixture(scope="module")
def free() -> Design:
    return limited()


@pytest.fixture(scope="module")
def pressed() -> Design:
    return limited({"kind": "hertz_pressure", "max_mpa": 700.0})


def columns(design: Design) -> dict[str, np.ndarray]:
    text = MOTION_FORMATS["csv"].write(design, MotionOptions(points_per_degree=20.0)).decode()
    rows = list(csv.DictReader(io.StringIO(text)))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def even(design: Design) -> tuple[np.ndarray, np.ndarray]:
    """Displacement on an even grid of the turn: θ [rad] and s [mm], without doubled angles."""
    table = columns(design)
    degrees, first = np.unique(table["theta_deg"], return_index=True)
    kept = np.isin(np.round(degrees * 20.0, 9) % 1.0, (0.0,)) & (degrees < 360.0)
    return np.radians(degrees[kept]), table["s_mm"][first][kept]


def turn(values: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """d/dθ by central differences of the fourth order round the turn."""
    h = theta[1] - theta[0]
    return (8.0 * (np.roll(values, -1) - np.roll(values, 1))
            - (np.roll(values, -2) - np.roll(values, 2))) / (12.0 * h)  # fmt: skip


def measured(design: Design) -> dict[str, np.ndarray]:
    """Force, pressure and torque from the exported displacement and two lengths alone."""
    theta, s = even(design)
    omega, e = RPM * 2.0 * np.pi / 60.0, design.dimensions["offset_mm"]
    height = np.sqrt(design.dimensions["prime_radius_mm"] ** 2 - e**2) + s
    # the centre of the roller as seen from the cam; its path by differences
    x = height * np.sin(theta) + e * np.cos(theta)
    y = height * np.cos(theta) - e * np.sin(theta)
    dx, dy = turn(x, theta), turn(y, theta)
    ddx, ddy = turn(dx, theta), turn(dy, theta)
    speed = np.hypot(dx, dy)
    bend = (dy * ddx - dx * ddy) / speed**3
    lift = np.sin(theta), np.cos(theta)  # the slide's direction
    cos = (-dy * lift[0] + dx * lift[1]) / speed
    v, a = turn(s, theta) * omega * 1e-3, turn(turn(s, theta), theta) * omega**2 * 1e-3
    degrees = np.degrees(theta)
    process = np.interp(degrees, *zip(*POINTS[:3], strict=True))
    process = np.where((degrees < 7.0) | (degrees >= 97.0), 0.0, process)
    drive = MASS * a + RATE * s + PRELOAD + process
    force = drive / cos
    radius = 1.0 / bend - ROLLER
    elastic = 2.0 * (1.0 - NU**2) / E
    with np.errstate(invalid="ignore"):
        pressure = np.sqrt(force * (1.0 / ROLLER + 1.0 / radius) / (np.pi * WIDTH * elastic))
    return {
        "theta": degrees, "force": force, "pressure": pressure, "torque": drive * v / omega
    }  # fmt: skip


def inside(values: np.ndarray) -> np.ndarray:
    """Without the neighbours of jumps of the jerk, where differences see less."""
    return values[np.isfinite(values)]


def test_a_hertz_limited_cam_keeps_its_limit_everywhere(free: Design, pressed: Design) -> None:
    reported = {extreme.limit: extreme for extreme in pressed.extremes}["hertz_pressure"]
    assert pressed.certificate.certified
    assert reported.holds
    assert 699.0 < reported.value <= 700.0
    assert free.forces.flanks[0].largest_pressure_mpa.value > 750.0
    assert pressed.dimensions["base_radius_mm"] > free.dimensions["base_radius_mm"] + 1.0
    for design in (free, pressed):
        found = inside(measured(design)["pressure"])
        assert len(found) > 7_000
        most = design.forces.flanks[0].largest_pressure_mpa.value
        assert found.max() == pytest.approx(most, rel=2e-3)
    assert inside(measured(pressed)["pressure"]).max() <= 700.0 * (1.0 + 1e-3)


def test_forces_and_torque_are_those_of_the_exported_motion(pressed: Design) -> None:
    found, forces = measured(pressed), pressed.forces
    assert found["force"].max() == pytest.approx(forces.flanks[0].largest_n.value, rel=1e-3)
    assert found["force"].min() == pytest.approx(forces.flanks[0].smallest_n.value, rel=5e-3)
    assert found["torque"].max() == pytest.approx(forces.torque.largest_n_m.value, rel=1e-3)
    assert found["torque"].mean() == pytest.approx(forces.torque.mean_n_m, rel=1e-3)
    assert np.sqrt(np.mean(found["torque"] ** 2)) == pytest.approx(forces.torque.rms_n_m, rel=1e-3)
    assert forces.torque.work_j == pytest.approx(forces.torque.process_work_j, rel=1e-12)


@pytest.mark.parametrize(
    ("limit", "name", "short"),
    [
        ({"kind": "contact_force", "min_n": 330.0}, "contact_force_min", 330.0),
        ({"kind": "contact_force", "max_n": 1085.0}, "contact_force_max", 1085.0),
        ({"kind": "camshaft_torque", "max_n_m": 31.0}, "camshaft_torque", 31.0),
    ],
)
def test_each_limit_bites(free: Design, limit: dict[str, Any], name: str, short: float) -> None:
    """The cam without it breaks it; with it, it holds, is used up, and costs size."""
    alone = free.forces.flanks[0], free.forces.torque
    was = {
        "contact_force_min": alone[0].smallest_n.value,
        "contact_force_max": alone[0].largest_n.value,
        "camshaft_torque": alone[1].largest_n_m.value,
    }[name]
    assert (was < short) == (name == "contact_force_min")
    design = limited(limit)
    reported = {extreme.limit: extreme for extreme in design.extremes}[name]
    assert design.certificate.certified
    assert reported.value == pytest.approx(short, rel=2e-3)
    assert design.dimensions["base_radius_mm"] > free.dimensions["base_radius_mm"]


def test_a_force_that_nothing_can_keep_is_named_in_the_conflict(
    explain_only: Callable[[str], None],
) -> None:
    explain_only("limits/2/min_n")
    given = [move | {"law": {"kind": "cycloidal"}} for move in BODY["program"][::2]]
    program = [given[0], BODY["program"][1], given[1], BODY["program"][3]]
    limits = [*BODY["limits"], {"kind": "contact_force", "min_n": 1e3}]
    body = BODY | {"program": program, "limits": limits}
    design = synthesise(DesignSpec.model_validate(body))
    assert design.status == "unsolved"
    named = {change.limit for change in design.conflict.relaxations}
    assert "contact_force_min" in named


@pytest.mark.parametrize(
    ("limit", "name", "short"),
    [
        ({"kind": "contact_force", "max_n": 1000.0}, "contact_force_max", 1000.0),
        ({"kind": "hertz_pressure", "max_mpa": 610.0}, "hertz_pressure", 610.0),
    ],
)
def test_a_process_force_may_jump_in_the_middle_of_a_rise(
    limit: dict[str, Any], name: str, short: float
) -> None:
    """Where the limit decides just before the jump, that side is kept too."""
    points = [(0, 0), (33.3, 400), (33.3, -60), (117.7, -60), (117.7, 300), (140, 0)]
    process = [{"angle_deg": a, "force_n": f} for a, f in points]
    design = limited(limit, process=process)
    reported = {extreme.limit: extreme for extreme in design.extremes}[name]
    assert design.certificate.certified
    assert reported.value == pytest.approx(short, rel=2e-3)
    # held along an arc that ends at a jump
    assert min(abs(reported.angle_deg - jump) for jump in (33.3, 117.7)) < 4.0


@pytest.mark.parametrize("tilt", [0.0, -8.3])
def test_under_a_flat_face_the_pressure_is_linear_and_the_gap_closes(tilt: float) -> None:
    """p² = N/(B ρ): force and radius are linear in law and size, so the bound is over all laws."""
    points = [(0, 150), (97, 150), (97, 0), (360, 0), (360, 150)]
    process = [{"angle_deg": a, "force_n": f} for a, f in points]
    body = BODY | {
        "follower": {"kind": "translating_flat_face", "tilt_deg": tilt},
        "load": BODY["load"] | {"process": process},
        "limits": [BODY["limits"][1], {"kind": "hertz_pressure", "max_mpa": 480.0}],
    }
    design = synthesise(DesignSpec.model_validate(body))
    assert design.status == "optimal"
    assert "all motion laws" in design.certificate.bound_valid_for
    # on the finished cam, by radius and force from the motion alone
    theta = np.linspace(0.0, 2.0 * np.pi, 20_001)[:-1]
    s, _v, a, _ = design.curve.derivatives(theta)
    cos, omega = np.cos(np.radians(tilt)), RPM * 2.0 * np.pi / 60.0
    radius = design.dimensions["base_radius_mm"] + (s + a) * cos
    process_n = np.where(np.degrees(theta) < 97.0, 150.0, 0.0)
    force = (MASS * a * omega**2 * 1e-3 + RATE * s + PRELOAD + process_n) / cos
    elastic = 2.0 * (1.0 - NU**2) / E
    pressure = np.sqrt(np.maximum(force, 0.0) / radius / (np.pi * WIDTH * elastic))
    assert pressure.max() == pytest.approx(480.0, rel=1e-3)
    assert pressure.max() <= 480.0 * (1.0 + 1e-9)
