"""Pressure angle: between the common normal and the follower's motion, from velocities alone."""

import numpy as np
from hypothesis import given

from tests.numerics.geometry.agreement import agree
from tests.numerics.geometry.cams import Cam, cams, unspecial
from tests.numerics.geometry.slopes import slopes


def turned(x: np.ndarray, y: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vectors turned counter-clockwise."""
    return x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)


def contact(cam: Cam, fraction: float):
    """Common normal and contact point in the machine frame, the sense of turning, s and s'.

    The normal is perpendicular to the difference quotient of reported profile positions.
    """
    theta, reach = cam.steps(fraction)
    sense = -1.0 if cam.rotation == "cw" else 1.0
    (dx, dy), _ = slopes(
        lambda t: np.stack([(p := cam.profile(t)).pitch_x, p.pitch_y]), theta, reach
    )
    p = cam.profile(theta)
    # the pitch curve runs against the cam's turning: outward is to its left when the cam is ccw
    nx, ny = -sense * dy / np.hypot(dx, dy), sense * dx / np.hypot(dx, dy)
    return turned(nx, ny, sense * theta), turned(p.x, p.y, sense * theta), sense, p


@given(cams(), unspecial(0.2, 0.8))
def test_it_is_the_angle_between_normal_and_follower(cam: Cam, fraction: float):
    (nx, ny), _, sense, p = contact(cam, fraction)
    alpha = np.arctan2(-sense * nx, ny)  # from the follower's line, x = const, upwards
    agree("pressure angle, rad", p.theta, p.pressure_angle, alpha, 1e-11)
    formula = np.arctan((p.s[1] - cam.e) / (cam.s0 + p.s[0]))
    agree("pressure angle, rad, by its formula", p.theta, p.pressure_angle, formula, 1e-13)


@given(cams(), unspecial(0.2, 0.8))
def test_cam_and_follower_neither_part_nor_penetrate(cam: Cam, fraction: float):
    # at the contact point both move equally fast along the common normal
    (nx, ny), (x, y), sense, p = contact(cam, fraction)
    cam_speed = sense * (-y * nx + x * ny)
    follower_speed = p.s[1] * ny
    allowed = 1e-12 * (cam.length + abs(p.s[1]))
    agree("speed along the normal", p.theta, cam_speed, follower_speed, allowed)


@given(cams(), unspecial(0.2, 0.8))
def test_the_follower_s_line_lies_at_the_offset(cam: Cam, fraction: float):
    # to the right of an upward follower on a ccw cam, to the left on a cw cam
    theta, _ = cam.inside(fraction)
    p = cam.profile(theta)
    sense = -1.0 if cam.rotation == "cw" else 1.0
    x, y = turned(p.pitch_x, p.pitch_y, sense * theta)
    agree("the roller's distance from the axis", theta, x, sense * cam.e, 1e-13 * cam.length)
    agree("the roller's height", theta, y, cam.s0 + p.s[0], 1e-13 * cam.length)


@given(cams(), unspecial(0.2, 0.8))
def test_a_positive_offset_lowers_it_on_a_rise_and_raises_it_on_a_return(cam: Cam, fraction: float):
    theta, _ = cam.inside(fraction)
    left = Cam(cam.motion, cam.follower, -abs(cam.e), cam.s0, cam.rotation)
    right = Cam(cam.motion, cam.follower, abs(cam.e), cam.s0, cam.rotation)
    lower = right.profile(theta).pressure_angle < left.profile(theta).pressure_angle
    assert np.all(lower), f"not so at {np.degrees(theta[~lower])}°"
