"""Rings, grooves and counter cams: every flank by touch, by differences, and on its dwells.

The flanks are given to `touch` as polygons of reported points. It knows no offset, no side, no
curvature: circles and polygons alone say whether a roller fits and touches.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings

from synthesis.catalogue.followers import TranslatingRoller
from synthesis.catalogue.followers.closures import Force, Groove
from synthesis.catalogue.followers.conjugate import ConjugateSlide
from synthesis.catalogue.followers.kinematics import Flank
from synthesis.catalogue.profile import CamProfile, cam_profile
from tests.numerics.geometry import touch
from tests.numerics.geometry.agreement import agree
from tests.numerics.geometry.cams import TURN, Cam, cams, unspecial
from tests.numerics.geometry.slopes import slopes

POINTS = 3000
INSIDE = unspecial(0.2, 0.8)
RING = Force(contact="inside")


def closed(cam: Cam, closure) -> Cam:
    follower = TranslatingRoller(roller_radius_mm=cam.Rr, offset_mm=cam.e, closure=closure)
    return replace(cam, follower=follower)


def conjugate(cam: Cam, share: float) -> Cam:
    """With a counter roller of unspecial size, below the axis at every displacement."""
    highest = max(max(s.s_start, s.s_end) for s in cam.motion.segments)
    distance = cam.s0 + highest + (0.4 + share) * cam.Rp
    own = ConjugateSlide(
        roller_radius_mm=0.37 * cam.Rr, offset_mm=0.23 * share * cam.Rp, distance_mm=distance
    )
    return closed(cam, own)


def on(cam: Cam, flank: Flank, theta, side: str = "right") -> CamProfile:
    z = (cam.e, cam.s0)
    return cam_profile(
        cam.motion, cam.follower, z, cam.rotation, np.asarray(theta, float), side, flank
    )


def outline(cam: Cam, flank: Flank, count: int = POINTS) -> np.ndarray:
    p = on(cam, flank, TURN * np.arange(count) / count)
    return np.stack([p.x, p.y], axis=1)


def sense_of(cam: Cam) -> float:
    return -1.0 if cam.rotation == "cw" else 1.0


def bends(cam: Cam) -> np.ndarray:
    """Curvature of the pitch curve from circles through its points, convex positive."""
    p = cam.profile(TURN * np.arange(POINTS) / POINTS)
    points = np.stack([p.pitch_x, p.pitch_y], axis=1)
    side = np.roll(points, -1, axis=0) - points
    after = np.roll(side, -1, axis=0)
    turn = side[:, 0] * after[:, 1] - side[:, 1] * after[:, 0]
    across = np.hypot(*(side + after).T)
    return -sense_of(cam) * 2.0 * turn / (np.hypot(*side.T) * np.hypot(*after.T) * across)


def gentle_roller(cam: Cam) -> Cam:
    """With a roller for which neither flank of a groove is undercut."""
    tight = 1.0 / np.max(abs(bends(cam)))
    return replace(
        cam, follower=TranslatingRoller(roller_radius_mm=min(cam.Rr, 0.7 * tight), offset_mm=cam.e)
    )


def clearances(cam: Cam, flank: Flank, theta: np.ndarray, line: float, heights: np.ndarray):
    """Distance of a roller's centre from one flank while the cam turns, and the polygon's error."""
    points, sense = outline(cam, flank), sense_of(cam)
    found = touch.clearances(points, sense * theta, sense * line, heights)
    return found, touch.coarseness(points) + 1e-12 * cam.length


# --- by touch -----------------------------------------------------------------------------------


@settings(max_examples=9)
@given(cams(only_gentle=True, knife_edge=False), unspecial(0.1, 0.9))
def test_a_roller_in_a_groove_touches_both_flanks_and_penetrates_none(cam: Cam, fraction: float):
    cam = closed(gentle_roller(cam), Groove())
    theta = TURN * (np.arange(181) + fraction) / 181
    heights = cam.s0 + cam.motion.curve(theta)
    for flank in cam.follower.flanks:
        distance, coarse = clearances(cam, flank, theta, cam.e, heights)
        worst = np.degrees(theta[np.argmax(abs(distance - cam.Rr))])
        assert np.max(abs(distance - cam.Rr)) <= coarse, f"{flank.name} flank at {worst}°"


@settings(max_examples=5)
@given(cams(only_gentle=True, knife_edge=False), unspecial(0.01, 0.1))
def test_half_of_the_clearance_lies_on_either_side(cam: Cam, share: float):
    cam = gentle_roller(cam)
    cam = closed(cam, Groove(clearance_mm=share * cam.Rr))
    theta = TURN * (np.arange(91) + share) / 91
    heights = cam.s0 + cam.motion.curve(theta)
    for flank in cam.follower.flanks:
        distance, coarse = clearances(cam, flank, theta, cam.e, heights)
        assert np.max(abs(distance - (1.0 + 0.5 * share) * cam.Rr)) <= coarse, flank.name
    width = cam.follower.dimensions((cam.e, cam.s0))["groove_width_mm"]
    assert width == pytest.approx((2.0 + share) * cam.Rr, rel=1e-14)


@settings(max_examples=6)
@given(cams(only_gentle=True), unspecial(0.1, 0.9))
def test_a_roller_lifted_inside_a_ring_follows_the_law(cam: Cam, fraction: float):
    cam = closed(gentle_roller(cam), RING)
    (flank,) = cam.follower.flanks
    points, sense = outline(cam, flank), sense_of(cam)
    coarse = touch.coarseness(points)
    theta = TURN * (np.arange(41) + fraction) / 41

    def run(radius: float) -> np.ndarray:
        roller = touch.Roller(sense * cam.e, radius)
        return touch.ceilings(points, sense * theta, roller, 0.3 * cam.s0) - cam.s0

    measured = run(cam.Rr)
    allowed = 2.0 * (measured - run(cam.Rr + coarse)) + 1e-12 * cam.length
    law = cam.motion.curve(theta)
    assert np.max(allowed) < 0.01 * np.max(law), "the polygon is too coarse to tell anything"
    agree("displacement", theta, law, measured, allowed)


# few cams are hollow enough
@settings(max_examples=6, suppress_health_check=[HealthCheck.filter_too_much])
@given(cams(only_gentle=True, knife_edge=False, lifts=(0.6, 1.4)), unspecial(0.2, 0.9))
def test_a_roller_larger_than_the_pitch_curve_s_hollow_cuts_the_outer_flank(cam: Cam, share: float):
    hollow = -1.0 / np.min(bends(cam))
    assume(0.0 < hollow < 0.3 * cam.Rp)
    radius = hollow * (1.5 + share)
    follower = TranslatingRoller(roller_radius_mm=radius, offset_mm=cam.e, closure=RING)
    cam = replace(cam, follower=follower)
    (flank,) = cam.follower.flanks
    theta = TURN * np.arange(1200) / 1200
    p = on(cam, flank, theta)
    assert np.any((p.curvature < 0.0) & (p.radius < 0.0)), "undercut is not told"
    distance, _ = clearances(cam, flank, theta, cam.e, cam.s0 + cam.motion.curve(theta))
    assert np.min(distance) < radius * (1.0 - 1e-3), "an undercut flank lets the roller pass"


@settings(max_examples=7)
@given(cams(only_gentle=True, knife_edge=False), unspecial(0.1, 0.9))
def test_both_rollers_of_conjugate_cams_touch_at_every_angle(cam: Cam, share: float):
    cam = conjugate(gentle_roller(cam), share)
    main, counter = cam.follower.flanks
    own = cam.follower.closure
    theta = TURN * (np.arange(121) + share) / 121
    heights = cam.s0 + cam.motion.curve(theta)
    below = heights - own.distance_mm  # one rigid follower
    assume(np.max(1.0 / own.roller_radius_mm - 1.5 * sharpest(cam, counter)) > 0.0)
    for flank, line, where, radius in (
        (main, cam.e, heights, cam.Rr),
        (counter, own.offset_mm, below, own.roller_radius_mm),
    ):
        distance, coarse = clearances(cam, flank, theta, line, where)
        assert np.max(abs(distance - radius)) <= coarse, flank.name


def sharpest(cam: Cam, flank: Flank) -> float:
    return float(np.max(on(cam, flank, TURN * np.arange(720) / 720).curvature))


# --- by differences -----------------------------------------------------------------------------


def each_flank(cam: Cam, share: float):
    for closed_cam in (closed(cam, RING), closed(cam, Groove(clearance_mm=0.1 * share * cam.Rr)),
                       conjugate(cam, share)):  # fmt: skip
        for flank in closed_cam.follower.flanks:
            yield closed_cam, flank


@given(cams(knife_edge=False), INSIDE)
def test_every_flank_lies_at_its_distance_along_its_own_normal(cam: Cam, fraction: float):
    theta, reach = cam.steps(fraction)
    for closed_cam, flank in each_flank(cam, fraction):
        p = on(closed_cam, flank, theta)
        gap = np.hypot(p.x - p.pitch_x, p.y - p.pitch_y)
        np.testing.assert_allclose(gap, flank.distance, rtol=1e-11)
        outward = (p.x - p.pitch_x) * p.normal_x + (p.y - p.pitch_y) * p.normal_y
        assert np.all(outward * flank.side < 0.0), flank.name
        (dx, dy), _ = slopes(
            lambda t, c=closed_cam, f=flank: np.stack([(q := on(c, f, t)).x, q.y]), theta, reach
        )
        along = (dx * p.normal_x + dy * p.normal_y) / cam.length
        agree("normal along tangent", theta, along, 0.0, np.maximum(1e-11, 4e-15 / reach))


@given(cams(knife_edge=False), INSIDE)
def test_every_flank_s_radius_is_that_of_its_points_as_the_material_sees_it(
    cam: Cam, fraction: float
):
    theta, reach = cam.steps(fraction)
    for closed_cam, flank in each_flank(cam, fraction):
        p = on(closed_cam, flank, theta)
        (px, py, dx, dy), (*_, ax, ay) = slopes(
            lambda t, c=closed_cam, f=flank: np.stack(
                [(q := on(c, f, t)).pitch_x, q.pitch_y, q.x, q.y]
            ),
            theta, reach,
        )  # fmt: skip
        # passed clockwise on a ccw cam: turning right is convex to the axis' side; the sense of
        # travel is the pitch curve's, so that an undercut loop counts negative
        speed = (dx * px + dy * py) / np.hypot(px, py)
        bend = -sense_of(cam) * (dx * ay - dy * ax) / speed**3
        clear = abs(speed) > 1e-3 * np.hypot(px, py)
        measured = flank.side / bend
        noise = 1e-11 * cam.length / reach**2 * (measured / cam.length) ** 2
        allowed = 1e-8 * abs(measured) + noise * (np.hypot(px, py) / speed) ** 2
        reported = np.where(clear, p.radius, measured)
        agree(f"radius of {flank.name or 'ring'}", theta, reported, measured, allowed)


@given(cams(knife_edge=False), INSIDE)
def test_the_counter_roller_s_pressure_angle_is_that_of_its_velocities(cam: Cam, fraction: float):
    cam = conjugate(cam, fraction)
    flank = cam.follower.flanks[1]
    theta, reach = cam.steps(fraction)
    (dx, dy), _ = slopes(
        lambda t: np.stack([(q := on(cam, flank, t)).pitch_x, q.pitch_y]), theta, reach
    )
    p, sense = on(cam, flank, theta), sense_of(cam)
    nx, ny = -sense * dy / np.hypot(dx, dy), sense * dx / np.hypot(dx, dy)
    cos, sin = np.cos(sense * theta), np.sin(sense * theta)
    nx, ny = nx * cos - ny * sin, nx * sin + ny * cos
    # from the slide's line, downwards, positive to the side it has on the upturned machine
    agree("pressure angle, rad", theta, p.pressure_angle, np.arctan2(sense * nx, -ny), 1e-10)


@given(cams(knife_edge=False), INSIDE)
def test_the_counter_roller_s_closed_forms_are_those_of_its_path(cam: Cam, fraction: float):
    cam = conjugate(cam, fraction)
    flank, z = cam.follower.flanks[1], (cam.e, cam.s0)
    p = on(cam, flank, cam.inside(fraction)[0])
    N, W2 = flank.trace.curvature_terms(p.s, z)
    scale = (cam.length**2 + p.s[1] ** 2 + cam.length * abs(p.s[2])) / W2**1.5
    agree("curvature", p.theta, p.curvature, N / W2**1.5, 1e-12 * scale)
    slope = 0.2 + fraction
    height = cam.follower.closure.distance_mm - cam.s0 - p.s[0]
    reported = np.max(
        [
            np.array(row.coefficients) @ p.s + np.dot(row.size, z) - row.upper
            for row in flank.trace.pressure_angle_rows(slope)
        ],
        axis=0,
    )
    wanted = (abs(np.tan(p.pressure_angle)) - slope) * height
    agree("rows", p.theta, reported, wanted, 1e-12 * (cam.length + abs(p.s[1])) * (1.0 + slope))


# --- invariants ---------------------------------------------------------------------------------


@given(cams(knife_edge=False), INSIDE)
def test_on_a_dwell_every_flank_is_a_circle(cam: Cam, fraction: float):
    rests = [s for s in cam.motion.segments if s.kind == "dwell"]
    theta = np.array([s.start + f * s.angle for s in rests for f in (0.5 * fraction, fraction)])
    for closed_cam, flank in each_flank(cam, fraction):
        p = on(closed_cam, flank, theta)
        radius = np.hypot(p.pitch_x, p.pitch_y)
        wanted = radius - flank.side * flank.distance
        np.testing.assert_allclose(np.hypot(p.x, p.y), wanted, rtol=0, atol=1e-12 * cam.length)
        np.testing.assert_allclose(p.curvature, 1.0 / radius, rtol=1e-11)
        material = flank.side * radius - flank.distance
        np.testing.assert_allclose(p.radius, material, rtol=0, atol=1e-11 * cam.length)


@given(cams(knife_edge=False), INSIDE)
def test_a_mirrored_machine_has_mirrored_flanks(cam: Cam, fraction: float):
    other = {"ccw": "cw", "cw": "ccw"}[cam.rotation]
    for closed_cam, flank in each_flank(cam, fraction):
        here = on(closed_cam, flank, cam.inside(fraction)[0])
        there = on(replace(closed_cam, rotation=other), flank, cam.inside(fraction)[0])
        assert np.all(there.x == -here.x)
        assert np.all(there.y == here.y)
        assert np.all(there.radius == here.radius)


@given(cams(), unspecial(0.1, 0.9))
def test_radii_are_those_of_the_flanks(cam: Cam, share: float):
    theta = np.concatenate([TURN * np.arange(360) / 360, cam.motion.curve.breaks[:-1]])
    highest = max(max(s.s_start, s.s_end) for s in cam.motion.segments)
    z = (cam.e, cam.s0)
    for closed_cam, flank in each_flank(cam, share):
        p = on(closed_cam, flank, theta)
        largest = flank.trace.outer_radius_norm(highest).value(z)
        np.testing.assert_allclose(np.max(np.hypot(p.pitch_x, p.pitch_y)), largest, rtol=1e-9)
        if flank is closed_cam.follower.flanks[0]:
            reported = closed_cam.follower.dimensions(z)["base_radius_mm"]
            np.testing.assert_allclose(np.min(np.hypot(p.x, p.y)), reported, rtol=1e-9, atol=1e-12)
    reported = closed_cam.follower.motion_dimensions(cam.motion, z)["counter_base_radius_mm"]
    np.testing.assert_allclose(np.min(np.hypot(p.x, p.y)), reported, rtol=1e-9, atol=1e-12)


# --- the instrument itself ----------------------------------------------------------------------

SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@pytest.mark.parametrize(
    ("angle", "line", "radius", "height"),
    [
        (0.0, 0.3, 0.5, 0.5),  # under a side
        (np.pi / 4, 0.0, 0.5, np.sqrt(2.0) - 0.5 * np.sqrt(2.0)),  # in the corner: two sides
        (np.pi / 4, 0.3, 0.0, np.sqrt(2.0) - 0.3),  # a point under a slope
    ],
)
def test_the_instrument_measures_the_inside_of_a_square(angle, line, radius, height):
    found = touch.ceiling(touch.turned(SQUARE, angle), touch.Roller(line, radius), 0.0)
    assert found == pytest.approx(height, abs=1e-14)
