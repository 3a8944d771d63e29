"""P1 of the reference problems, built by hand: every extreme against a million samples."""

import json
import math

import numpy as np
import pytest

from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.limits import (
    Acceleration,
    CutterRadius,
    Jerk,
    OuterRadius,
    PressureAngle,
    ProfileRadius,
    Velocity,
)
from synthesis.certify import certify, measure_objective
from synthesis.design.design import Extreme
from synthesis.units import DEGREE
from tests.certify.cams import Cam, motion_of, sampled

CYCLOIDAL = LAWS["cycloidal"].curve("rise")
CAM = Cam(
    motion_of(
        [
            ("rise", 60.0, 30.0, CYCLOIDAL),
            ("dwell", 30.0, 0.0, None),
            ("return", 60.0, 30.0, CYCLOIDAL),
            ("dwell", 210.0, 0.0, None),
        ]
    ),
    roller=10.0, e=20.0, s0=math.sqrt(60.0**2 - 20.0**2),
)  # fmt: skip
LIMITS = [
    PressureAngle(rise_deg=30.0, return_deg=45.0, dwell_deg=25.0),
    ProfileRadius(min_mm=3.0),
    CutterRadius(radius_mm=40.0),
    Velocity(max_mm_per_s=600.0),
    Acceleration(max_mm_per_s2=2e4),
    Jerk(max_mm_per_s3=1.2e6),
    OuterRadius(max_mm=70.0),
]
# limit: quantity, segments, sign of the extreme, core to wire
READINGS = {
    "pressure_angle_rise": ("pressure_angle", "rise", 1, lambda a: a / DEGREE),
    "pressure_angle_return": ("pressure_angle", "return", -1, lambda a: a / DEGREE),
    "pressure_angle_dwell": ("pressure_angle", "dwell", -1, lambda a: a / DEGREE),
    "profile_radius": ("pitch_curvature", None, 1, lambda k: 1.0 / k - 10.0),
    "cutter_radius": ("pitch_curvature", None, -1, lambda k: 10.0 - 1.0 / k),
    "acceleration": ("acceleration", None, 1, lambda a: a * 100.0),
    "jerk": ("jerk", None, 1, lambda j: j * 1000.0),
    "outer_radius": ("pitch_radius", None, 1, lambda r: r - 10.0),
}


@pytest.fixture(scope="module")
def extremes() -> dict[str, Extreme]:
    found = certify(CAM.motion, CAM.machine, CAM.size, LIMITS)
    assert len({e.limit for e in found}) == len(found)
    return {e.limit: e for e in found}


@pytest.mark.parametrize("limit", sorted(READINGS))
def test_it_agrees_with_a_million_samples(extremes, limit):
    quantity, kind, sign, to_wire = READINGS[limit]
    if limit in ("acceleration", "jerk"):  # as large downwards as upwards
        sign = 1 if extremes[limit].value > 0.0 else -1
    where = CAM.segments(*([kind] if kind else []))
    found, _ = sampled(CAM, quantity, where, sign, 1_000_000 // CAM.motion.curve.count)
    reference, extreme = to_wire(sign * found), extremes[limit]
    assert extreme.value == pytest.approx(reference, rel=1e-9)
    assert abs(extreme.value - reference) <= extreme.width + 1e-12 * abs(reference)
    assert extreme.width < 2e-10 * max(abs(extreme.value), abs(extreme.bound)) * 10.0


def test_the_verdicts(extremes):
    broken = {name for name, extreme in extremes.items() if not extreme.holds}
    assert broken == {"pressure_angle_return", "outer_radius"}
    a = extremes["pressure_angle_return"]
    assert extremes["pressure_angle_rise"].bound == 30.0
    assert (a.bound, a.margin) == (-45.0, pytest.approx(a.value + 45.0))
    assert a.margin == pytest.approx(-2.906433216, abs=1e-8)
    assert 90.0 < a.angle_deg < 150.0


def test_values_in_closed_form(extremes):
    assert abs(extremes["velocity"].value) == pytest.approx(1800.0 / math.pi, rel=1e-12)
    peak = 2.0 * math.pi * 30.0 / (math.pi / 3.0) ** 2 * 100.0
    assert abs(extremes["acceleration"].value) == pytest.approx(peak, rel=1e-12)
    peak = 4.0 * math.pi**2 * 30.0 / (math.pi / 3.0) ** 3 * 1000.0
    assert abs(extremes["jerk"].value) == pytest.approx(peak, rel=1e-12)
    # at the ends of the turn's dwells: the highest pitch point, the resting follower
    top = math.hypot(CAM.e, CAM.s0 + 30.0) - 10.0
    assert extremes["outer_radius"].value == pytest.approx(top, rel=1e-13)
    rest = math.degrees(math.asin(20.0 / 60.0))
    assert extremes["pressure_angle_dwell"].value == pytest.approx(-rest, rel=1e-13)
    assert extremes["base_radius_positive"].value == pytest.approx(50.0)
    assert extremes["prime_circle_angle"].value == pytest.approx(rest)


def test_the_wire_takes_it(extremes):
    for extreme in extremes.values():
        body = extreme.model_dump_json()
        json.loads(body, parse_constant=pytest.fail)
        assert Extreme.model_validate_json(body) == extreme


def test_objectives():
    def value(name: str) -> float:
        found = measure_objective(name, CAM.motion, CAM.machine, CAM.size)
        assert found.lower <= found.value <= found.upper
        assert found.width < 1e-9 * found.value
        return found.value

    beta = math.pi / 3.0
    assert value("prime_radius") == pytest.approx(60.0, rel=1e-15)
    assert value("acceleration") == pytest.approx(2.0 * math.pi * 30.0 / beta**2, rel=1e-12)
    assert value("jerk") == pytest.approx(4.0 * math.pi**2 * 30.0 / beta**3, rel=1e-12)
    # ∫ sin² over a whole wave is half its length, on rise and return
    rms = 2.0 * math.pi * 30.0 / beta**2 * math.sqrt(beta / (2.0 * math.pi))
    assert value("rms_acceleration") == pytest.approx(rms, rel=1e-13)
    rms = 4.0 * math.pi**2 * 30.0 / beta**3 * math.sqrt(beta / (2.0 * math.pi))
    assert value("rms_jerk") == pytest.approx(rms, rel=1e-13)
    steepest, _ = sampled(CAM, "pressure_angle", CAM.segments("rise", "return"), -1, 100_000)
    assert value("pressure_slope") == pytest.approx(math.tan(steepest), rel=1e-10)


def test_a_circle_is_a_circle():
    cam = Cam(motion_of([("dwell", 360.0, 0.0, None)]), 7.3, -11.9, 33.1)
    prime = math.hypot(11.9, 33.1)
    limits = [ProfileRadius(min_mm=1.0), OuterRadius(max_mm=50.0), CutterRadius(radius_mm=99.0)]
    radius, outer, cutter, *_ = certify(cam.motion, cam.machine, cam.size, limits)
    assert radius.value == pytest.approx(prime - 7.3, rel=1e-13)
    assert outer.value == pytest.approx(prime - 7.3, rel=1e-13)
    assert radius.width < 1e-11
    assert (cutter.value, cutter.margin, cutter.holds) == (None, None, True)
    found = measure_objective("rms_jerk", cam.motion, cam.machine, cam.size)
    assert (found.value, found.upper) == (0.0, 0.0)
    for name in ("jerk", "pressure_slope"):
        assert measure_objective(name, cam.motion, cam.machine, cam.size).upper == 0.0


def test_seen_from_behind():
    behind = CAM.mirrored()
    there = {e.limit: e for e in certify(behind.motion, behind.machine, behind.size, LIMITS)}
    here = {e.limit: e for e in certify(CAM.motion, CAM.machine, CAM.size, LIMITS[1:])}
    for name in ("profile_radius", "cutter_radius", "outer_radius"):
        assert there[name].value == pytest.approx(here[name].value, rel=1e-10)
        if name != "outer_radius":  # held over a whole dwell
            assert there[name].angle_deg == pytest.approx(360.0 - here[name].angle_deg, abs=1e-3)
    assert there["pressure_angle_rise"].value == pytest.approx(47.906433216, abs=1e-8)
    assert there["pressure_angle_return"].value == pytest.approx(-27.802088733, abs=1e-8)


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3])
def test_lengths_in_another_unit_give_the_same_angles(scale):
    scaled = Cam(
        motion_of(
            [
                ("rise", 60.0, 30.0 * scale, CYCLOIDAL),
                ("dwell", 30.0, 0.0, None),
                ("return", 60.0, 30.0 * scale, CYCLOIDAL),
                ("dwell", 210.0, 0.0, None),
            ]
        ),
        10.0 * scale, CAM.e * scale, CAM.s0 * scale,
    )  # fmt: skip
    limits = [LIMITS[0], ProfileRadius(min_mm=3.0 * scale), OuterRadius(max_mm=70.0 * scale)]
    here = certify(CAM.motion, CAM.machine, CAM.size, [LIMITS[0], LIMITS[1], LIMITS[6]])
    there = certify(scaled.motion, scaled.machine, scaled.size, limits)
    for a, b in zip(here[:5], there[:5], strict=True):
        factor = scale if a.unit == "mm" else 1.0
        assert b.value == pytest.approx(a.value * factor, rel=1e-12)
        assert b.holds == a.holds


def test_angles_wider_than_a_right_angle_do_not_pass():
    below = Cam(CAM.motion, 10.0, 20.0, -CAM.s0)  # the roller below the cam's axis
    found = {e.limit: e for e in certify(below.motion, below.machine, below.size, LIMITS[:1])}
    assert not found["prime_circle_angle"].holds
    assert not found["pressure_angle_dwell"].holds
    assert (
        measure_objective("pressure_slope", below.motion, below.machine, below.size).upper == np.inf
    )
