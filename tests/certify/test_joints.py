"""One-sided values, jumps, joins and overshoot."""

import json
import math

import numpy as np
import pytest

from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.limits import Acceleration, CutterRadius, Jerk, ProfileRadius, Velocity
from synthesis.catalogue.motion import FreeLaw, Motion
from synthesis.certify import certify, measure_objective, motion_checks
from synthesis.certify.piecewise_motion import PiecewiseMotion
from synthesis.design.design import Extreme
from synthesis.numerics.box_search import Budget
from synthesis.numerics.piecewise import Piecewise
from tests.certify.cams import Cam, motion_of, spline

LIFT, OMEGA = 17.3, 5.9
BETA = math.radians(63.0)
ALL = [
    Velocity(max_mm_per_s=1e9), Acceleration(max_mm_per_s2=1e9), Jerk(max_mm_per_s3=1e9),
    ProfileRadius(min_mm=0.0), CutterRadius(radius_mm=4.7),
]  # fmt: skip


def cam_of(rise: Piecewise, back: Piecewise, free: FreeLaw | None = None) -> Cam:
    segments = [
        ("rise", 63.0, LIFT, rise), ("dwell", 40.0, 0.0, None),
        ("return", 77.0, LIFT, back), ("dwell", 180.0, 0.0, None),
    ]  # fmt: skip
    return Cam(motion_of(segments, free), 4.1, 6.7, 35.3, OMEGA)


def judged(cam: Cam) -> dict[str, Extreme]:
    found = certify(cam.motion, cam.machine, cam.size, ALL)
    for extreme in found:
        json.loads(extreme.model_dump_json(), parse_constant=pytest.fail)
    return {e.limit: e for e in found}


def law(kind: str) -> Piecewise:
    return LAWS[kind].curve("rise")


@pytest.mark.parametrize(
    ("kind", "jump", "angles"),
    [
        ("parabolic", 8.0, (31.5,)),  # from +4 to −4 in the middle
        ("simple_harmonic", math.pi**2 / 2.0, (0.0, 63.0, 360.0)),
        ("cubic_2_3", 6.0, (0.0, 63.0, 360.0)),
    ],
)
def test_a_jump_of_the_acceleration_is_an_infinite_jerk(kind, jump, angles):
    cam = cam_of(law(kind), law("cycloidal"))
    found = judged(cam)
    jerk = found["jerk"]
    assert (jerk.value, jerk.margin, jerk.holds) == (None, None, False)
    size = jump * LIFT / BETA**2 * OMEGA**2
    assert jerk.evidence.startswith(f"acceleration jumps by {size:.6g} mm/s² at ")
    assert any(jerk.angle_deg == pytest.approx(angle) for angle in angles)
    for name in ("velocity", "acceleration", "profile_radius", "cutter_radius"):
        assert found[name].holds
    assert jerk.bound == 1e9
    report = found["acceleration_jump"]
    assert report.value == pytest.approx(size, rel=1e-9)
    assert (report.bound, report.holds) == (None, True)
    assert "velocity_jump" not in found
    jerk_now = measure_objective("jerk", cam.motion, cam.machine, cam.size)
    assert jerk_now.lower == math.inf
    assert measure_objective("rms_jerk", cam.motion, cam.machine, cam.size).value == math.inf
    assert measure_objective("acceleration", cam.motion, cam.machine, cam.size).upper < math.inf
    # one-sided: the parabolic law's curvature uses both of its accelerations
    peak = {"parabolic": 4.0, "simple_harmonic": math.pi**2 / 2.0, "cubic_2_3": 6.0}[kind]
    a = found["acceleration"]
    assert abs(a.value) >= peak * LIFT / BETA**2 * OMEGA**2 * (1.0 - 1e-12)


def test_a_jump_between_the_end_and_the_beginning_of_the_turn():
    rise = Piecewise.of([0.0, 1.0], [[0.0, 0.0, 6.0, -8.0, 3.0]])  # s''(0) = 12, s''(1) = 0
    segments = [("rise", 90.0, LIFT, rise), ("return", 270.0, LIFT, law("cycloidal"))]
    found = judged(Cam(motion_of(segments), 4.1, 6.7, 35.3, OMEGA))
    assert found["jerk"].value is None
    assert found["jerk"].angle_deg == pytest.approx(360.0)
    size = 12.0 * LIFT / (math.pi / 2.0) ** 2 * OMEGA**2
    assert found["acceleration_jump"].value == pytest.approx(size)


def test_a_jump_of_the_velocity_breaks_everything_above_it():
    found = judged(cam_of(law("constant_velocity"), law("cycloidal")))
    v = LIFT / BETA
    assert found["velocity"].holds
    assert found["velocity"].value == pytest.approx(v * OMEGA) or found["velocity"].value < 0.0
    for name in ("acceleration", "jerk"):
        assert not found[name].holds
        assert found[name].value is None
        assert found[name].evidence.startswith(f"velocity jumps by {v * OMEGA:.6g} mm/s at ")
    # upwards at 0°, a hollow corner; downwards at 63°, a sharp one
    assert not found["profile_radius"].holds
    assert found["profile_radius"].angle_deg == pytest.approx(63.0)
    assert not found["cutter_radius"].holds
    assert found["cutter_radius"].angle_deg in (0.0, 360.0)
    assert found["velocity_jump"].value == pytest.approx(v * OMEGA)


def test_a_gap_is_never_accepted():
    good = cam_of(law("cycloidal"), law("cycloidal"))
    curve = good.motion.curve
    poly = curve.poly.copy()
    poly[-1, 0] += 1e-5
    torn = Motion(good.motion.segments, Piecewise(curve.breaks, curve.origins, poly, curve.waves))
    found = {e.limit: e for e in certify(torn, good.machine, good.size, ALL)}
    assert not found["displacement_join"].holds
    assert found["displacement_join"].value == pytest.approx(1e-5)
    for name in ("velocity", "acceleration", "jerk"):
        assert found[name].evidence.startswith("displacement jumps by 1e-05 mm")
    assert judged(good)["displacement_join"].holds


@pytest.mark.parametrize("degree", [3, 4, 5])
def test_splines_keep_their_promises(degree):
    rng = np.random.default_rng(degree)
    breaks = np.linspace(0.0, 1.0, 42)
    bumps = 1e-4 * rng.standard_normal(len(breaks) - 1 + degree)
    control = spline(degree, breaks, bumps)
    found = judged(cam_of(control, control, FreeLaw(2, overshoot=False)))
    for name in ("displacement", "velocity", "acceleration"):
        assert found[f"{name}_join"].holds
    assert found["overshoot"].holds
    assert not {"velocity_jump", "acceleration_jump"} & found.keys()


def test_a_smoother_promise_is_checked_further():
    third = spline(4, np.linspace(0.0, 1.0, 12))  # s''' does not vanish at its ends
    found = judged(cam_of(third, third, FreeLaw(3, overshoot=False)))
    assert found["acceleration_join"].holds
    assert not found["jerk_join"].holds
    assert found["jerk_join"].angle_deg in (
        pytest.approx(0.0), pytest.approx(63.0), pytest.approx(103.0), pytest.approx(180.0),
        pytest.approx(360.0),
    )  # fmt: skip


@pytest.mark.parametrize("order", [0, 1, 2])
def test_a_promise_broken_by_a_millionth_is_found(order):
    good = cam_of(
        *(spline(3, np.linspace(0.0, 1.0, 12)) for _ in range(2)), FreeLaw(2, overshoot=True)
    )
    curve = good.motion.curve
    poly = curve.poly.copy()
    poly[5, order] += 1e-6 * LIFT / BETA**order / math.factorial(order)
    bent = Motion(good.motion.segments, Piecewise(curve.breaks, curve.origins, poly, curve.waves))
    found = {e.limit: e for e in certify(bent, good.machine, good.size, [])}
    name = ("displacement_join", "velocity_join", "acceleration_join")[order]
    assert not found[name].holds
    assert found[name].value == pytest.approx(1e-6 * LIFT / BETA**order * OMEGA**order, rel=1e-3)
    # the changed piece ends, or begins, at the joint
    assert found[name].angle_deg in (
        pytest.approx(63.0 * 5 / 11), pytest.approx(63.0 * 6 / 11),
    )  # fmt: skip


@pytest.mark.parametrize("degree", [3, 4])
def test_the_travel_backwards_is_enclosed(degree, monkeypatch):
    """Against samples, and coarser where intervals run out."""
    rng = np.random.default_rng(10 + degree)
    bumps = 3e-2 * rng.standard_normal(22 + degree)
    rises = spline(degree, np.linspace(0.0, 1.0, 23), bumps), spline(degree, np.linspace(0, 1, 23))
    motion = PiecewiseMotion(cam_of(*rises, FreeLaw(2, overshoot=False)).motion)
    pieces = motion.pieces_of([0, 2])
    least, most, count = motion_checks.backward_travel(motion, pieces)
    theta = np.linspace(0.0, BETA, 400_001)
    back = np.maximum(-motion.curve(theta, 1), 0.0)
    travelled = np.trapezoid(back, theta)
    assert travelled > 1e-3
    assert least[0] == pytest.approx(travelled, rel=1e-6)
    assert 0.0 <= most[0] - least[0] < 1e-10 * LIFT
    assert (least[2], most[2] < 1e-12 * LIFT) == (0.0, True)
    monkeypatch.setattr(motion_checks, "BACKWARD_BUDGET", Budget(levels=1, boxes=1000))
    also_least, also_most, fewer = motion_checks.backward_travel(motion, pieces)
    assert fewer == len(pieces) < count
    assert also_least[0] <= least[0] <= most[0] <= also_most[0]
    assert also_most[0] - also_least[0] > 1e-4 * travelled


def test_overshoot_is_measured():
    breaks = np.linspace(0.0, 1.0, 12)
    bumps = np.zeros(14)
    bumps[-4] = 0.05  # above the top, then back
    rise, back = spline(3, breaks, bumps), spline(3, breaks)
    allowed = judged(cam_of(rise, back, FreeLaw(2, overshoot=True)))
    assert "overshoot" not in allowed
    found = judged(cam_of(rise, back, FreeLaw(2, overshoot=False)))["overshoot"]
    assert not found.holds
    assert found.field == "program/0/law/overshoot"
    theta = np.linspace(0.0, 1.0, 200_001)
    fallen = -np.minimum(np.diff(rise(theta)), 0.0).sum() * LIFT
    assert found.value <= fallen * (1.0 + 1e-8)  # samples miss what lies about the top
    assert found.value + found.width >= fallen
    assert found.value > 0.5 * fallen


def test_numbers_that_are_none():
    good = cam_of(law("cycloidal"), law("cycloidal"))
    curve = good.motion.curve
    poly = curve.poly.copy()
    poly[1, 1] = np.nan
    torn = Motion(good.motion.segments, Piecewise(curve.breaks, curve.origins, poly, curve.waves))
    for found in (
        certify(torn, good.machine, good.size, ALL),
        certify(torn, good.machine, good.size, []),
        certify(good.motion, good.machine, (math.nan, 30.0), ALL),
        certify(good.motion, good.machine, (3.0, math.inf), []),
    ):
        assert found
        assert not any(extreme.holds for extreme in found)
        assert all("not a finite number" in extreme.evidence for extreme in found)
