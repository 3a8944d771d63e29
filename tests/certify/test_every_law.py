"""Every named law and random splines: no sample ever exceeds what was proven."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given

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
from synthesis.units import DEGREE
from tests.certify.cams import Cam, cams, motion_of, sampled, samples

POINTS = 1_000  # on every piece


def limits_of(cam: Cam, hollow: float) -> list:
    """One limit of every kind, on every segment."""
    return [
        PressureAngle(rise_deg=40.0, return_deg=40.0, dwell_deg=40.0),
        ProfileRadius(min_mm=0.1 * cam.s0),
        CutterRadius(radius_mm=cam.roller + hollow),
        Velocity(max_mm_per_s=1.0),
        Acceleration(max_mm_per_s2=1.0),
        Jerk(max_mm_per_s3=1.0),
        OuterRadius(max_mm=cam.s0),
    ]


def check(cam: Cam) -> None:
    """Every proven extreme bounds the samples, and none is far above them."""
    omega, turn = cam.omega, cam.segments()
    readings = {
        "pressure_angle_rise": ("pressure_angle", cam.segments("rise"), 1.0 / DEGREE),
        "pressure_angle_return": ("pressure_angle", cam.segments("return"), 1.0 / DEGREE),
        "pressure_angle_dwell": ("pressure_angle", cam.segments("dwell"), 1.0 / DEGREE),
        "velocity": ("velocity", turn, omega),
        "acceleration": ("acceleration", turn, omega**2),
        "jerk": ("jerk", turn, omega**3),
    }
    found = {e.limit: e for e in certify(cam.motion, cam.machine, cam.size, limits_of(cam, 9.0))}
    for name, (quantity, where, to_wire) in readings.items():
        extreme = found[name]
        if extreme.value is None:
            continue
        *_, values = samples(cam, quantity, where, POINTS)
        highest = np.abs(values).max() * to_wire
        assert highest <= (abs(extreme.value) + extreme.width) * (1.0 + 1e-12)
        best = max(sampled(cam, quantity, where, sign, 2_000)[0] for sign in (-1, 1)) * to_wire
        assert abs(extreme.value) <= best + 1e-6 * abs(best)
        assert extreme.width <= 1e-9 * max(abs(extreme.value), abs(extreme.bound or 0.0), 10.0)
    curvature(cam, found)


def curvature(cam: Cam, found: dict) -> None:
    """Both curvature claims, back in the core's unit."""
    *_, values = samples(cam, "pitch_curvature", cam.segments(), POINTS)
    convex, hollow = found["profile_radius"], found["cutter_radius"]
    if convex.value is not None:
        proven = 1.0 / (convex.value - convex.width + cam.roller)
        assert values.max() <= proven * (1.0 + 1e-10)
        assert 1.0 / (convex.value + cam.roller) <= values.max() * (1.0 + 1e-4)
    if hollow.value is not None:
        proven = -1.0 / (hollow.value - hollow.width - cam.roller)
        assert values.min() >= proven * (1.0 + 1e-10)
    elif hollow.holds:
        assert values.min() >= 0.0


@pytest.mark.parametrize("kind", sorted(LAWS))
@pytest.mark.parametrize(("e", "s0"), [(7.7, 41.3), (-13.1, 29.9)])
def test_named_laws(kind, e, s0):
    rise, back = LAWS[kind].curve("rise"), LAWS[kind].curve("return")
    segments = [
        ("rise", 71.3, 23.7, rise), ("dwell", 31.9, 0.0, None),
        ("return", 83.1, 23.7, back), ("dwell", 173.7, 0.0, None),
    ]  # fmt: skip
    check(Cam(motion_of(segments), 5.3, e, s0, omega=7.1))


@given(cams())
def test_random_cams(cam):
    check(cam)


@given(cams())
def test_objectives_are_enclosed(cam):
    x = cam.motion.curve.breaks
    nodes, weights = np.polynomial.legendre.leggauss(40)
    for name, order in (("rms_acceleration", 2), ("rms_jerk", 3)):
        total = 0.0
        for piece in range(cam.motion.curve.count):
            for low, high in pairwise(np.linspace(x[piece], x[piece + 1], 5)):
                at = 0.5 * (low + high) + 0.5 * (high - low) * nodes
                s = cam.motion.curve.at(at, np.full(len(at), piece), order)
                total += 0.5 * (high - low) * float(weights @ s**2)
        found = measure_objective(name, cam.motion, cam.machine, cam.size)
        value = math.sqrt(total / (2.0 * math.pi))
        assert found.lower * (1.0 - 1e-12) <= value <= found.upper * (1.0 + 1e-12)
        assert found.width <= 1e-9 * found.value
    found = measure_objective("pressure_slope", cam.motion, cam.machine, cam.size)
    moving = cam.segments("rise", "return")
    best = max(sampled(cam, "pressure_angle", moving, sign, 2_000)[0] for sign in (-1, 1))
    assert math.tan(best) <= found.upper * (1.0 + 1e-12)
    assert found.value <= math.tan(best) * (1.0 + 1e-6)
