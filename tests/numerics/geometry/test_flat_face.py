"""A flat face's cam: what it reports agrees with what is measured on it, by touch and by slopes."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis.catalogue.followers import TranslatingFlatFace
from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.numerics.piecewise import Piecewise
from tests.numerics.geometry import touch
from tests.numerics.geometry.agreement import agree
from tests.numerics.geometry.cams import TURN, AnyCam, all_along, motions, unspecial
from tests.numerics.geometry.slopes import slopes

POINTS = 4000


@dataclass(frozen=True)
class FlatCam(AnyCam):
    """A finished cam with a flat face on a slide."""

    motion: Motion
    Rb: float
    rotation: str
    follower: TranslatingFlatFace

    @property
    def tilt(self) -> float:
        return float(np.radians(self.follower.tilt_deg))

    @property
    def normal(self) -> np.ndarray:
        """The face's normal in the machine: up, turned by the tilt in the cam's sense."""
        return np.array([-self.turns * np.sin(self.tilt), np.cos(self.tilt)])

    @property
    def along(self) -> np.ndarray:
        """Along the face, to the right on a ccw cam and to the left on a cw cam."""
        return np.array([self.turns * np.cos(self.tilt), np.sin(self.tilt)])

    @property
    def size(self) -> tuple[float, ...]:
        return (self.Rb,)

    @property
    def length(self) -> float:
        return self.Rb + max(max(s.s_start, s.s_end) for s in self.motion.segments)


def sharpest(motion: Motion, tilt: float) -> float:
    """Largest −(s + s'') cos τ, sampled on every piece, both ends included."""
    s = all_along(motion)
    return float(np.max(-s[0] - s[2]) * np.cos(tilt))


@st.composite
def flat_cams(draw: st.DrawFn) -> FlatCam:
    """Base radii 0.1 to 1000; the least radius of the profile 0.05 to 0.5 of the base radius.

    One in three faces is perpendicular to its slide, on a line through the axis.
    """
    motion = draw(motions(10.0 ** draw(unspecial(-1.0, 2.0)), only_gentle=True))
    stroke = max(max(s.s_start, s.s_end) for s in motion.segments)
    tilt = draw(st.sampled_from([-1.0, 0.0, 1.0])) * draw(unspecial(1.0, 71.0))
    offset = stroke * np.sign(tilt) * draw(unspecial(-1.0, 1.0))
    face = TranslatingFlatFace(tilt_deg=tilt, offset_mm=offset)
    least = max(sharpest(motion, np.radians(tilt)), 0.0)
    Rb = (least + 0.01 * stroke) / (1.0 - draw(unspecial(0.05, 0.5)))
    return FlatCam(motion, Rb, draw(st.sampled_from(["ccw", "cw"])), face)


@given(flat_cams())
def test_on_a_dwell_the_profile_is_the_circle_of_the_face_s_height(cam: FlatCam):
    for segment in cam.motion.segments:
        if segment.kind == "dwell":
            p = cam.profile(segment.start + segment.angle * np.array([0.2, 0.5, 0.8]))
            radius = cam.Rb + segment.s_start * np.cos(cam.tilt)
            np.testing.assert_allclose(np.hypot(p.x, p.y), radius, rtol=4e-15)
            np.testing.assert_allclose(p.curvature, 1.0 / radius, rtol=4e-15)
            np.testing.assert_allclose(p.radius, radius, rtol=4e-15)


@given(flat_cams(), unspecial(0.2, 0.8))
def test_the_profile_s_tangent_is_the_face(cam: FlatCam, fraction: float):
    theta, width = cam.inside(fraction)
    (dx, dy), _ = slopes(cam.outline, theta, 0.1 * width)
    p = cam.profile(theta)
    across, along = dx * p.normal_x + dy * p.normal_y, dx * p.normal_y - dy * p.normal_x
    noise = 1e-11 * cam.length / width
    agree("slope across the face", theta, across, np.zeros(1), noise)
    # run clockwise on a ccw cam, at a speed that is the radius of curvature
    agree("slope along the face", theta, p.radius, cam.turns * along, noise + 1e-11 * cam.length)
    np.testing.assert_allclose(p.pressure_angle, cam.tilt, atol=1e-15)
    # the face keeps its direction in the machine: the cam sees it turn backwards
    turned = -cam.turns * theta
    nx, ny = cam.normal
    np.testing.assert_allclose(p.normal_x, nx * np.cos(turned) - ny * np.sin(turned), atol=1e-14)
    np.testing.assert_allclose(p.normal_y, nx * np.sin(turned) + ny * np.cos(turned), atol=1e-14)


@given(flat_cams(), unspecial(0.2, 0.8))
def test_the_pressure_angle_is_that_between_push_and_slide(cam: FlatCam, fraction: float):
    theta, _ = cam.inside(fraction)
    s = cam.motion.derivatives(theta)
    n, size = cam.normal, (cam.Rb,)
    # the cam's material under the contact and the slide have the same velocity along the normal
    x, y = (np.array(v) for v in cam.follower.position(s, size)[0])
    moves = np.array([-y, x]).T @ (n * [cam.turns, 1.0])
    np.testing.assert_allclose(moves, s[1] * n[1], rtol=1e-12, atol=1e-13 * cam.length)
    assert cam.profile(theta).pressure_angle == pytest.approx(np.arctan2(-cam.turns * n[0], n[1]))


@given(flat_cams(), unspecial(0.2, 0.8))
def test_the_traced_point_s_derivatives_are_those_of_its_position(cam: FlatCam, fraction: float):
    theta, width = cam.inside(fraction)
    reported = cam.traced(theta)
    for order in range(2):
        slope, _ = slopes(lambda angle, k=order: cam.traced(angle)[k], theta, 0.15 * width)
        noise = 1e-12 * (np.max(abs(reported[order])) + cam.length) / width
        for name, mine, found in zip("xy", reported[order + 1], slope, strict=True):
            agree(f"{name}, derivative {order + 1}", theta, mine, found, noise + 1e-11 * abs(mine))


def lifted(cam: FlatCam, points: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """How far the tilted line is lifted along its slide, resting on the turning polygon."""
    line = touch.Line(float(np.arctan2(cam.along[1], abs(cam.along[0])) * cam.turns))
    heights = touch.rests(points, cam.turns * theta, line)
    return heights - cam.Rb / np.cos(cam.tilt)


@settings(max_examples=12)
@given(flat_cams(), unspecial(0.1, 0.9))
def test_a_line_slid_down_onto_the_cam_follows_the_law(cam: FlatCam, fraction: float):
    turn = TURN * np.arange(POINTS) / POINTS
    # one-sided where a derivative jumps: both ends of the arc belong to the outline
    joints = cam.motion.curve.breaks[:-1]
    every = np.sort(np.concatenate([turn, joints]))
    p = cam.profile(every)
    points = np.stack([p.x, p.y], axis=1)
    theta = np.concatenate([TURN * (np.arange(23) + fraction) / 23, cam.inside(fraction)[0]])
    measured = lifted(cam, points, theta)
    # a vertex lies less than half a step from the contact: below it by ρ step²/8 at most
    allowed = 2.0 * np.max(p.radius) * (TURN / POINTS) ** 2 / 8.0 + 1e-12 * cam.length
    allowed /= np.cos(cam.tilt)
    law = cam.motion.curve(theta)
    assert allowed < 1e-2 * np.max(law)
    agree("displacement", theta, law, measured, np.array(allowed))


@settings(max_examples=5)
@given(flat_cams(), unspecial(0.2, 0.6))
def test_an_undercut_cam_says_so_and_lifts_the_face_too_far(cam: FlatCam, share: float):
    nose = sharpest(cam.motion, cam.tilt)
    cam = replace(cam, Rb=max((1.0 - share) * nose, 1e-3 * cam.Rb))
    if nose <= cam.Rb:
        return
    theta = TURN * (np.arange(POINTS) + 0.5) / POINTS
    p = cam.profile(theta)
    radius = cam.Rb + (p.s[0] + p.s[2]) * np.cos(cam.tilt)
    terms = cam.length + np.max(abs(p.s[2]))  # they cancel where the radius is small
    np.testing.assert_allclose(p.radius, radius, rtol=1e-12, atol=1e-12 * terms)
    assert np.min(p.radius) < 0.0
    assert np.min(p.curvature) < 0.0
    measured = lifted(cam, np.stack([p.x, p.y], axis=1), theta[::10])
    assert np.max(measured - cam.motion.curve(theta[::10])) > 0.0


def test_at_a_cusp_the_radius_is_nothing():
    law = Piecewise.of([0.0, 1.0], [[0.0]])
    still = Motion.of([PlacedSegment(0, "dwell", 0.0, TURN, 0.0, 0.0, law)])
    p = FlatCam(still, 0.0, "ccw", TranslatingFlatFace()).profile(np.array([0.7]))
    assert p.radius[0] == 0.0
    assert p.curvature[0] == np.inf
    assert p.normal_y[0] == np.cos(0.7)


@given(flat_cams(), unspecial(0.1, 0.9))
def test_clockwise_is_the_mirror_image(cam: FlatCam, fraction: float):
    theta, _ = cam.inside(fraction)
    here, there = (replace(cam, rotation=sense).profile(theta) for sense in ("ccw", "cw"))
    for name, sign in {"x": -1.0, "y": 1.0, "normal_x": -1.0, "normal_y": 1.0, "radius": 1.0,
                       "curvature": 1.0, "pressure_angle": 1.0}.items():  # fmt: skip
        np.testing.assert_array_equal(getattr(there, name), sign * getattr(here, name), name)


@given(flat_cams())
def test_what_the_follower_tells_is_what_is_measured(cam: FlatCam):
    breaks = cam.motion.curve.breaks
    theta = np.unique(np.concatenate([TURN * np.arange(3600) / 3600, breaks[:-1]]))
    p = cam.profile(theta)
    out = cam.follower.outer_radius_norm(cam.length - cam.Rb).value((cam.Rb,))
    np.testing.assert_allclose(out, np.max(np.hypot(p.x, p.y)), rtol=1e-9)
    (row,) = cam.follower.profile_radius_rows(0.0)
    reported = -(np.array(row.coefficients) @ p.s + row.size[0] * cam.Rb - row.upper)
    np.testing.assert_allclose(reported, p.radius, rtol=1e-12, atol=1e-13 * cam.length)
    # the face that contact needs, from where the profile touches the line: seen from the point of
    # the slide's line that moves with it
    cos, sin = np.cos(cam.turns * theta), np.sin(cam.turns * theta)
    touched = np.array([p.x * cos - p.y * sin, p.x * sin + p.y * cos])  # in the machine's frame
    c = cam.turns * cam.follower.offset_mm
    start = (cam.Rb - c * cam.normal[0]) / cam.normal[1]  # where the line crosses at s = 0
    reach = cam.along @ (touched - np.array([np.full(len(theta), c), start + p.s[0]]))
    wide = cam.follower.motion_dimensions(cam.motion, (cam.Rb,))
    near = 1e-3 * (cam.Rb + np.ptp(reach))
    np.testing.assert_allclose(wide["face_right_mm"], np.max(reach), atol=near)
    np.testing.assert_allclose(wide["face_left_mm"], -np.min(reach), atol=near)
    assert wide["face_width_mm"] == wide["face_left_mm"] + wide["face_right_mm"]
    (left,), (right,) = (cam.follower.contact_rows(end, 0.0) for end in ("left", "right"))
    noise = 1e-12 * (cam.length + abs(c)) / np.cos(cam.tilt) ** 2
    for row, sign in ((left, -1.0), (right, 1.0)):
        reported = np.array(row.coefficients) @ p.s + sum(row.size) * cam.Rb - row.upper
        np.testing.assert_allclose(reported, sign * reach, atol=noise)
