"""What mirrors the cam, what only turns it, and what only makes it larger."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from synthesis.catalogue.followers import TranslatingRoller
from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.catalogue.profile import CamProfile
from tests.numerics.geometry.cams import TURN, Cam, cams, unspecial

INSIDE = unspecial(0.05, 0.95)


def vectors(p: CamProfile) -> np.ndarray:
    """Pitch point, profile point and normal: (3, 2, n), the lengths over the largest radius."""
    scale = np.max(np.hypot(p.pitch_x, p.pitch_y))
    return np.array(
        [(p.pitch_x / scale, p.pitch_y / scale), (p.x / scale, p.y / scale),
         (p.normal_x, p.normal_y)]
    )  # fmt: skip


def same(found: np.ndarray, wanted: np.ndarray, tolerance: float = 1e-12) -> None:
    np.testing.assert_allclose(found, wanted, rtol=tolerance, atol=tolerance)


def with_offset(cam: Cam, e: float) -> Cam:
    follower = TranslatingRoller(roller_radius_mm=cam.Rr, offset_mm=e)
    return replace(cam, e=e, follower=follower)


@given(cams(), INSIDE)
def test_a_clockwise_cam_is_the_mirror_image(cam: Cam, fraction: float):
    theta, _ = cam.inside(fraction)
    p, q = (replace(cam, rotation=sense).profile(theta) for sense in ("ccw", "cw"))
    mirrored = vectors(p)
    mirrored[:, 0] *= -1.0
    same(vectors(q), mirrored)
    for name in ("s", "curvature", "radius", "pressure_angle"):
        assert np.array_equal(getattr(p, name), getattr(q, name)), name


@given(cams(), INSIDE)
def test_the_motion_backwards_with_the_offset_on_the_other_side_is_the_mirror_image(
    cam: Cam, fraction: float
):
    theta, _ = cam.inside(fraction)
    back = replace(with_offset(cam, -cam.e), motion=Motion((), cam.motion.curve.mirror()))
    p, q = cam.profile(theta), back.profile(TURN - theta)
    mirrored = vectors(p)
    mirrored[:, 0] *= -1.0
    same(vectors(q), mirrored, 1e-10)
    same(q.pressure_angle, -p.pressure_angle, 1e-10)
    scale = np.max(abs(p.curvature))
    same(q.curvature / scale, p.curvature / scale, 1e-10)


@given(cams(), INSIDE)
def test_turning_the_other_way_with_the_offset_moved_along_is_the_same_follower_line(
    cam: Cam, fraction: float
):
    # offset +e on a cw cam and −e on a ccw cam: both follower lines lie at x = −e at cam angle 0
    for rotation, e in (("cw", cam.e), ("ccw", -cam.e)):
        p = replace(with_offset(cam, e), rotation=rotation).profile([0.0])
        same(p.pitch_x[0] / cam.length, -cam.e / cam.length)


@pytest.mark.parametrize("factor", [1e-4, 0.37, 25.4, 1e4])
@given(cam=cams(), fraction=INSIDE)
def test_a_cam_k_times_as_large_is_the_same_cam(factor: float, cam: Cam, fraction: float):
    theta, _ = cam.inside(fraction)
    e = factor * cam.e
    large = Cam(
        Motion((), cam.motion.curve.rescale(0.0, 1.0, 0.0, factor)),
        TranslatingRoller(roller_radius_mm=factor * cam.Rr, offset_mm=e),
        e,
        factor * cam.s0,
        cam.rotation,
    )
    p, q = cam.profile(theta), large.profile(theta)
    same(vectors(q), vectors(p))
    same(q.pressure_angle, p.pressure_angle)
    scale = np.max(abs(p.curvature))
    same(q.curvature * factor / scale, p.curvature / scale, 1e-11)


@given(cams(), INSIDE, unspecial(0.0, 1.0))
def test_beginning_the_program_elsewhere_only_turns_the_cam(
    cam: Cam, fraction: float, share: float
):
    segments = cam.motion.segments
    first = int(share * len(segments))
    by = segments[first].start
    moved = [
        PlacedSegment(i, s.kind, (s.start - by) % TURN, s.angle, s.s_start, s.s_end, s.law)
        for i, s in enumerate(segments[first:] + segments[:first])
    ]
    other = replace(cam, motion=Motion.of(moved))
    theta, _ = cam.inside(fraction)
    p, q = vectors(cam.profile(theta)), vectors(other.profile(theta - by))
    sense = -1.0 if cam.rotation == "cw" else 1.0
    # the same material point stands where the cam has turned `by` further
    turn = np.exp(sense * 1j * by)
    rotated = (p[:, 0] + 1j * p[:, 1]) * turn
    same(np.stack([rotated.real, rotated.imag], axis=1), q, 1e-10)


@given(cams(), INSIDE, unspecial(0.1, 2.0))
def test_a_larger_cam_without_offset_has_smaller_pressure_angles(
    cam: Cam, fraction: float, more: float
):
    theta, _ = cam.inside(fraction)
    central = with_offset(cam, 0.0)
    larger = replace(central, s0=central.s0 * (1.0 + more))
    small, large = (abs(c.profile(theta).pressure_angle) for c in (central, larger))
    moving = small > 1e-12
    assert np.all(large[moving] < small[moving])
    assert np.all(large[~moving] <= 1e-12)


@given(cams(knife_edge=False), INSIDE)
def test_the_roller_does_not_change_the_pitch_curve(cam: Cam, fraction: float):
    theta, _ = cam.inside(fraction)
    edge = replace(cam, follower=TranslatingRoller(roller_radius_mm=0.0, offset_mm=cam.e))
    p, q = cam.profile(theta), edge.profile(theta)
    for name in ("pitch_x", "pitch_y", "normal_x", "normal_y", "curvature", "pressure_angle"):
        assert np.array_equal(getattr(p, name), getattr(q, name)), name
    assert np.array_equal(q.x, q.pitch_x)
    assert np.array_equal(q.y, q.pitch_y)
