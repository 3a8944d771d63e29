"""What a follower tells the formulations is what is measured on its cam."""

import numpy as np
from hypothesis import given

from tests.numerics.geometry.cams import TURN, Cam, cams, unspecial


def norm(form, z: tuple[float, ...]) -> float:
    return float(np.linalg.norm(np.array(form.matrix) @ np.array(z) + np.array(form.shift)))


@given(cams(), unspecial(0.05, 0.95), unspecial(0.1, 2.0))
def test_the_rows_hold_where_the_pressure_angle_keeps_its_limit(
    cam: Cam, fraction: float, slope: float
):
    p = cam.profile(cam.inside(fraction)[0])
    rows = cam.follower.pressure_angle_rows(slope)
    excess = [
        np.array(row.coefficients) @ p.s + np.dot(row.size, (cam.e, cam.s0)) - row.upper
        for row in rows
    ]
    # excess of the tangent, times the height X: both sides of the limit
    measured = np.tan(p.pressure_angle) * (cam.s0 + p.s[0])
    limit = slope * (cam.s0 + p.s[0])
    reported = np.max(excess, axis=0)
    scale = cam.length + abs(p.s[1])
    np.testing.assert_allclose(
        reported / scale, (abs(measured) - limit) / scale, rtol=0, atol=1e-12
    )


@given(cams())
def test_prime_and_outermost_radius_are_those_of_the_pitch_curve(cam: Cam):
    theta = np.concatenate([TURN * np.arange(360) / 360, cam.motion.curve.breaks[:-1]])
    p = cam.profile(theta)
    radius, z = np.hypot(p.pitch_x, p.pitch_y), (cam.e, cam.s0)
    np.testing.assert_allclose(norm(cam.follower.radius_norm(), z), np.min(radius), rtol=1e-9)
    highest = max(max(s.s_start, s.s_end) for s in cam.motion.segments)
    np.testing.assert_allclose(
        norm(cam.follower.outer_radius_norm(highest), z), np.max(radius), rtol=1e-9
    )


@given(cams(), unspecial(0.05, 0.95))
def test_the_follower_is_driven_along_the_path_of_its_roller(cam: Cam, fraction: float):
    theta, _ = cam.inside(fraction)
    s, z = cam.motion.derivatives(theta), (cam.e, cam.s0)
    (gx, gy), (hx, hy) = cam.follower.drive_direction(s, z)
    _, (dx, dy), _, _ = cam.follower.position(s, z)
    assert np.all(gx**2 + gy**2 == 1.0)
    assert np.all(gx * dy - gy * dx == 0.0)
    assert not np.any(hx)
    assert not np.any(hy)


@given(cams())
def test_the_dimensions_follow_from_the_size(cam: Cam):
    reported = cam.follower.dimensions((cam.e, cam.s0))
    want = {"prime_radius_mm": cam.Rp, "base_radius_mm": cam.Rp - cam.Rr, "offset_mm": cam.e,
            "roller_radius_mm": cam.Rr, "s0_mm": cam.s0}  # fmt: skip
    for name, value in want.items():
        np.testing.assert_allclose(reported[name], value, rtol=1e-14, atol=1e-14 * cam.Rp)
