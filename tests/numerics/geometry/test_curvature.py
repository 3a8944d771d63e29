"""Curvature is signed: against differences, the closed form, three-point circles, and undercut."""

import numpy as np
from hypothesis import assume, given

from synthesis.catalogue.followers import TranslatingRoller
from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.numerics.piecewise import Piecewise
from tests.numerics.geometry.agreement import agree
from tests.numerics.geometry.cams import Cam, cams, unspecial
from tests.numerics.geometry.slopes import slopes

DEGREE = np.pi / 180.0


def sense_of(cam: Cam) -> float:
    return -1.0 if cam.rotation == "cw" else 1.0


def circle_through(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """Signed curvature of the circle through three points, positive where it turns left."""
    (ux, uy), (vx, vy), (wx, wy) = b - a, c - b, c - a
    return 2.0 * (ux * vy - uy * vx) / (np.hypot(ux, uy) * np.hypot(vx, vy) * np.hypot(wx, wy))


@given(cams(), unspecial(0.2, 0.8))
def test_it_matches_differences_of_the_reported_pitch_curve(cam: Cam, fraction: float):
    theta, reach = cam.steps(fraction)
    (dx, dy), (ax, ay) = slopes(
        lambda t: np.stack([(p := cam.profile(t)).pitch_x, p.pitch_y]), theta, reach
    )
    # a ccw cam is passed clockwise: turning right is convex
    found = -sense_of(cam) * (dx * ay - dy * ax) / np.hypot(dx, dy) ** 3
    noise = 1e-12 / (reach**2 * np.hypot(dx, dy) / cam.length)
    answer = cam.profile(theta).curvature
    agree("curvature", theta, answer, found, 1e-11 * abs(found) + noise / cam.length)


@given(cams(), unspecial(0.02, 0.98))
def test_it_matches_the_closed_form(cam: Cam, fraction: float):
    theta, _ = cam.inside(fraction)
    p = cam.profile(theta)
    N, W2 = cam.follower.curvature_terms(p.s, (cam.e, cam.s0))
    scale = (cam.length**2 + p.s[1] ** 2 + cam.length * abs(p.s[2])) / W2**1.5
    agree("curvature by its closed form", theta, p.curvature, N / W2**1.5, 1e-13 * scale)


@given(cams(), unspecial(0.02, 0.98))
def test_the_profile_s_radius_is_the_pitch_curve_s_less_the_roller_s(cam: Cam, fraction: float):
    p = cam.profile(cam.inside(fraction)[0])
    np.testing.assert_allclose((p.radius + cam.Rr) * p.curvature, 1.0, rtol=1e-12)


@given(cams(knife_edge=False), unspecial(0.2, 0.8))
def test_the_profile_runs_backwards_where_it_is_undercut_and_only_there(cam: Cam, fraction: float):
    # dP = (1 − Rr κ) dp: an abs() anywhere in κ or ρ breaks this on hollow or undercut flanks
    theta, reach = cam.steps(fraction)
    (px, py, x, y), _ = slopes(
        lambda t: np.stack([(p := cam.profile(t)).pitch_x, p.pitch_y, p.x, p.y]), theta, reach
    )
    p = cam.profile(theta)
    advance = (x * px + y * py) / (px**2 + py**2)
    np.testing.assert_allclose(advance, p.radius * p.curvature, rtol=0, atol=1e-11 / min(reach))
    undercut = (p.curvature > 0.0) & (p.radius < 0.0)
    clear = abs(advance) > 1e-6
    wrong = clear & ((advance < 0.0) != undercut)
    assert not np.any(wrong), f"undercut or not, told wrongly at {np.degrees(theta[wrong])}°"


def cam_of(lift: float, degrees: tuple, e: float, Rp: float, Rr: float, rotation: str) -> Cam:
    """Rise, dwell, return, dwell with cycloidal moves."""
    wave = (-0.5 / np.pi, 2.0 * np.pi, 0.0)
    law = Piecewise.of([0.0, 1.0], [[0.0, 1.0]], [[wave]])
    still = Piecewise.of([0.0, 1.0], [[0.0]])
    ends = np.cumsum([0.0, *degrees]) * DEGREE
    levels = [0.0, lift, lift, 0.0, 0.0]
    kinds = ("rise", "dwell", "return", "dwell")
    segments = [
        PlacedSegment(i, kinds[i], ends[i], ends[i + 1] - ends[i], levels[i], levels[i + 1],
                still if kinds[i] == "dwell" else law)
        for i in range(4)
    ]  # fmt: skip
    follower = TranslatingRoller(roller_radius_mm=Rr, offset_mm=e)
    return Cam(Motion.of(segments), follower, e, float(np.sqrt(Rp**2 - e**2)), rotation)


def measured_curvature(cam: Cam, theta: float, step: float = 1e-4) -> float:
    """Of the reported profile, from three of its points; convex positive."""
    p = cam.profile([theta - step, theta, theta + step])
    points = np.stack([p.x, p.y], axis=1)
    along = np.array([p.pitch_x[2] - p.pitch_x[0], p.pitch_y[2] - p.pitch_y[0]])
    forward = np.sign(along @ (points[2] - points[0]))
    return -sense_of(cam) * forward * circle_through(*points)


def test_a_hollow_flank_has_a_negative_radius():
    for rotation in ("ccw", "cw"):
        cam = cam_of(31.7, (47.3, 31.1, 58.9, 222.7), 4.9, 33.3, 7.7, rotation)
        theta = 11.9 * DEGREE
        p = cam.profile([theta])
        assert p.curvature[0] < 0.0
        assert p.radius[0] < -cam.Rr  # |ρ| of the pitch curve plus the roller's radius
        np.testing.assert_allclose(1.0 / measured_curvature(cam, theta), p.radius[0], rtol=1e-5)


def test_an_undercut_nose_has_a_negative_radius_on_a_convex_pitch_curve():
    for rotation in ("ccw", "cw"):
        cam = cam_of(31.7, (47.3, 31.1, 58.9, 222.7), 4.9, 33.3, 17.7, rotation)
        theta = 38.2 * DEGREE
        p = cam.profile([theta])
        assert 0.0 < 1.0 / p.curvature[0] < cam.Rr
        assert p.radius[0] == 1.0 / p.curvature[0] - cam.Rr < 0.0
        # the three-point circle of the loop bends the other way round, at the same size
        np.testing.assert_allclose(1.0 / measured_curvature(cam, theta), p.radius[0], rtol=1e-4)


def test_a_nose_that_is_only_sharp_keeps_a_positive_radius():
    cam = cam_of(31.7, (47.3, 31.1, 58.9, 222.7), 4.9, 33.3, 5.3, "ccw")
    theta = 38.2 * DEGREE
    radius = cam.profile([theta]).radius[0]
    assert 0.0 < radius < 12.0
    np.testing.assert_allclose(1.0 / measured_curvature(cam, theta), radius, rtol=1e-5)


@given(cams(knife_edge=False))
def test_every_random_cam_that_turns_hollow_says_so(cam: Cam):
    # s'' > X + (u² + s' u)/X is hollow: reached on the steepest beginnings of moves
    theta = np.linspace(0.0, 2.0 * np.pi, 721)[:-1] + 1e-4
    p = cam.profile(theta)
    X, u = cam.s0 + p.s[0], p.s[1] - cam.e
    hollow = p.s[2] * X > X**2 + u * (u + p.s[1]) + 1e-9 * cam.length**2
    assume(np.any(hollow))
    wrong = hollow & ((p.curvature >= 0.0) | (p.radius >= 0.0))
    assert not np.any(wrong), f"hollow, but reported convex at {np.degrees(theta[wrong])}°"
