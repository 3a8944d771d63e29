"""Where the roller touches: at its radius from its centre, along the true normal of the profile.

Tangents are differences of reported positions; nothing here knows how the product found a normal.
"""

import numpy as np
from hypothesis import given

from tests.numerics.geometry.agreement import agree
from tests.numerics.geometry.cams import Cam, cams, unspecial
from tests.numerics.geometry.slopes import slopes

INSIDE = unspecial(0.2, 0.8)


@given(cams(), INSIDE)
def test_the_roller_s_centre_is_its_radius_away_along_a_unit_normal(cam: Cam, fraction: float):
    p = cam.profile(cam.inside(fraction)[0])
    np.testing.assert_allclose(np.hypot(p.normal_x, p.normal_y), 1.0, rtol=1e-14)
    tolerance = 1e-12 * cam.length
    np.testing.assert_allclose(p.pitch_x - p.x, cam.Rr * p.normal_x, rtol=0, atol=tolerance)
    np.testing.assert_allclose(p.pitch_y - p.y, cam.Rr * p.normal_y, rtol=0, atol=tolerance)


@given(cams(), INSIDE)
def test_the_normal_is_perpendicular_to_the_profile_and_to_the_pitch_curve(
    cam: Cam, fraction: float
):
    theta, reach = cam.steps(fraction)
    p = cam.profile(theta)
    for points in (cam.outline, cam.pitch):
        (dx, dy), _ = slopes(points, theta, reach)
        along = (dx * p.normal_x + dy * p.normal_y) / cam.length
        # positions are rounded, and differences divide that by their reach
        agree("normal along tangent", theta, along, 0.0, np.maximum(1e-12, 2e-15 / reach))


@given(cams(), INSIDE)
def test_the_normal_points_away_from_the_cam(cam: Cam, fraction: float):
    # a small step along it leaves the pitch curve: seen from the axis, to a larger radius
    p = cam.profile(cam.inside(fraction)[0])
    outward = p.normal_x * p.pitch_x + p.normal_y * p.pitch_y
    assert np.all(outward > 0.0), f"inward at {np.degrees(p.theta[outward <= 0.0])}°"


@given(cams(), INSIDE)
def test_on_a_dwell_the_pitch_curve_is_a_circle(cam: Cam, fraction: float):
    p = cam.profile(cam.at_rest(0.5 * fraction, fraction, 0.999))
    radius = np.hypot(p.pitch_x, p.pitch_y)
    np.testing.assert_allclose(radius, np.hypot(cam.e, cam.s0 + p.s[0]), rtol=1e-13)
    np.testing.assert_allclose(p.curvature, 1.0 / radius, rtol=1e-12)
    np.testing.assert_allclose(p.radius, radius - cam.Rr, rtol=0, atol=1e-12 * cam.length)
    np.testing.assert_allclose(np.hypot(p.x, p.y), radius - cam.Rr, rtol=0, atol=1e-12 * cam.length)


@given(cams(), INSIDE)
def test_the_first_dwell_at_rest_has_the_prime_radius(cam: Cam, fraction: float):
    lowest = [s for s in cam.motion.segments if s.kind == "dwell" and s.s_start == 0.0]
    theta = np.array([s.start + fraction * s.angle for s in lowest])
    p = cam.profile(theta)
    np.testing.assert_allclose(np.hypot(p.pitch_x, p.pitch_y), cam.Rp, rtol=1e-13)


@given(cams())
def test_the_profile_closes(cam: Cam):
    first, last = cam.profile([0.0]), cam.profile([2.0 * np.pi], side="left")
    assert np.hypot(first.pitch_x - last.pitch_x, first.pitch_y - last.pitch_y) < 1e-12 * cam.length
