"""Violations that no sampling would find: over a ten-thousandth of a radian only."""

import numpy as np
import pytest
from scipy.interpolate import insert

from synthesis.catalogue.limits import (
    Acceleration,
    CutterRadius,
    Jerk,
    PressureAngle,
    ProfileRadius,
    Velocity,
)
from synthesis.catalogue.motion import FreeLaw
from synthesis.certify import certify
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Piecewise
from synthesis.units import DEGREE
from tests.certify.cams import Cam, motion_of, samples

BETA = 61.7  # degrees of rise
WIDTH = 1e-4 / (BETA * DEGREE)  # 1e-4 rad of cam angle, in parts of the rise
SPACE = SplineSpace(3, np.linspace(0.0, 1.0, 19))
GREVILLE = np.array([SPACE.knots[i + 1 : i + 4].mean() for i in range(SPACE.size)])
CONTROL = GREVILLE**3 * (10.0 - 15.0 * GREVILLE + 6.0 * GREVILLE**2)
CONTROL[:3], CONTROL[-3:] = 0.0, 1.0


def cam_of(rise: Piecewise) -> Cam:
    segments = [
        ("rise", BETA, 23.9, rise), ("dwell", 33.3, 0.0, None),
        ("return", 91.9, 23.9, SPACE.curve(CONTROL)), ("dwell", 173.1, 0.0, None),
    ]  # fmt: skip
    return Cam(motion_of(segments, FreeLaw(2, overshoot=True)), 6.1, 3.3, 39.7, omega=3.3)


QUIET = cam_of(SPACE.curve(CONTROL))


def spiked(at: float, bump: float) -> Cam:
    """The quiet law with a bump in the one control point that lives between at and at + WIDTH."""
    extra = at + WIDTH * np.linspace(0.0, 1.0, 5)
    knots, control = SPACE.knots, np.append(CONTROL, np.zeros(4))
    for knot in extra:
        knots, control, _ = insert(knot, (knots, control, 3))
    control[int(np.searchsorted(knots, at))] += bump
    breaks = knots[3:-3]
    return cam_of(SplineSpace(3, breaks).curve(control[: len(breaks) + 2]))


def judged(cam: Cam, limit):
    return certify(cam.motion, cam.machine, cam.size, [limit])[0]


# name, the limit at a value, derivative that the spike disturbs, its size in the quiet law
CASES = [
    ("velocity", lambda v: Velocity(max_mm_per_s=v), 1, 1.9),
    ("acceleration", lambda v: Acceleration(max_mm_per_s2=v), 2, 5.8),
    ("jerk", lambda v: Jerk(max_mm_per_s3=v), 3, 50.0),
    ("pressure_angle", lambda v: PressureAngle(rise_deg=v), 1, 1.9),
    ("profile_radius", lambda v: ProfileRadius(min_mm=v), 2, 5.8),
    ("cutter_radius", lambda v: CutterRadius(radius_mm=v), 2, 5.8),
]


@pytest.mark.parametrize(("name", "limit_at", "order", "size"), CASES)
def test_a_spike_is_found(name, limit_at, order, size):
    any_value = 7.0
    before = judged(QUIET, limit_at(any_value))
    assert before.angle_deg < BETA
    at = before.angle_deg / BETA + 3.7e-4
    bump = 0.02 * size * (WIDTH / 4.0) ** order
    after = judged(spiked(at, bump), limit_at(any_value))
    assert after.margin < before.margin - 1e-3 * abs(before.value)
    between = limit_at(0.5 * (abs(before.value) + abs(after.value)))
    held, broken = judged(QUIET, between), judged(spiked(at, bump), between)
    assert held.holds
    assert not broken.holds
    assert 0.0 <= broken.angle_deg / BETA - at <= WIDTH


def test_sampling_would_not_have_found_it():
    at = judged(QUIET, Velocity(max_mm_per_s=1.0)).angle_deg / BETA + 3.7e-4
    cam = spiked(at, 0.02 * 1.9 * WIDTH / 4.0)
    found = judged(cam, Velocity(max_mm_per_s=1.0))
    theta = np.linspace(0.0, 2.0 * np.pi, 1_000)
    coarse = np.abs(cam.motion.derivatives(theta, 1)[1]).max() * cam.omega
    assert coarse < abs(found.value) * (1.0 - 1e-3)
    *_, values = samples(cam, "velocity", cam.segments(), 1_000)
    assert np.abs(values).max() * cam.omega == pytest.approx(abs(found.value), rel=1e-5)
