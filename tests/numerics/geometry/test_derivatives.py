"""Reported derivatives of the motion are those of the reported positions."""

import numpy as np
import pytest
from hypothesis import given

from synthesis.numerics.geometry.plane import to_cam
from tests.numerics.geometry.agreement import agree
from tests.numerics.geometry.cams import Cam, cams, unspecial
from tests.numerics.geometry.slopes import slopes


@pytest.mark.parametrize("order", [0, 1, 2])
@given(cam=cams(), fraction=unspecial(0.2, 0.8))
def test_each_derivative_is_the_slope_of_the_one_before(order: int, cam: Cam, fraction: float):
    theta, width = cam.inside(fraction)
    reach = 0.15 * width
    slope, bend = slopes(lambda angle: cam.profile(angle).s[order], theta, reach)
    s = cam.profile(theta).s
    # rounding of a value, divided by the reach as differences do
    noise = 1e-13 * np.max(abs(s[order])) / reach
    name = "s" + (order + 1) * "'"
    agree(name, theta, s[order + 1], slope, noise + 1e-12 * abs(s[order + 1]))
    if order < 2:
        noise = 1e-12 * np.max(abs(s[order])) / reach**2
        agree(name + "'", theta, s[order + 2], bend, noise + 1e-11 * abs(s[order + 2]))


@given(cam=cams(), fraction=unspecial(0.2, 0.8))
def test_the_traced_point_s_derivatives_are_those_of_its_position(cam: Cam, fraction: float):
    theta, width = cam.inside(fraction)
    reported, reach = cam.traced(theta), 0.15 * width
    for order in range(3):
        (dx, dy), _ = slopes(lambda angle, k=order: cam.traced(angle)[k], theta, reach)
        noise = 1e-13 * max(np.max(abs(reported[order])), 1e-12 * cam.length) / reach
        x, y = reported[order + 1]
        agree(f"x, derivative {order + 1}", theta, x, dx, noise + 1e-12 * cam.length)
        agree(f"y, derivative {order + 1}", theta, y, dy, noise + 1e-12 * abs(y))


@given(unspecial(-7.0, 7.0), unspecial(-3.0, 3.0), unspecial(-3.0, 3.0))
def test_to_cam_turns_clockwise_by_the_cam_s_angle(theta: float, x: float, y: float):
    turned = complex(x, y) * np.exp(-1j * theta)
    np.testing.assert_allclose(to_cam(theta, x, y), (turned.real, turned.imag), atol=1e-14)


@given(cam=cams(), fraction=unspecial(0.2, 0.8))
def test_any_turn_gives_the_same_motion(cam: Cam, fraction: float):
    theta, _ = cam.inside(fraction)
    here = cam.motion.derivatives(theta)
    for turns in (-2, 1, 3):
        there = cam.motion.derivatives(theta + turns * 2.0 * np.pi)
        scale = np.max(abs(here), axis=1, keepdims=True)
        np.testing.assert_allclose(there / scale, here / scale, atol=1e-10)


@given(cam=cams())
def test_at_a_joint_each_side_gives_its_own_value(cam: Cam):
    segments = cam.motion.segments
    for i, after in enumerate(segments):
        before = segments[i - 1]
        at = np.array([after.start])
        left = cam.motion.derivatives(at, side="left").ravel()
        right = cam.motion.derivatives(at).ravel()
        for segment, x, side, found in ((before, 1.0, "left", left), (after, 0.0, "right", right)):
            want = [segment.law(x, k, side) * segment.lift / segment.angle**k for k in range(4)]
            want[0] += segment.s_start
            np.testing.assert_allclose(found, want, rtol=1e-8, atol=1e-9 * cam.length)
