"""A flat face's cam: what it reports agrees with what is measured on it, by touch and by slopes."""

from dataclasses import dataclass

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis.followers import TranslatingFlatFace
from synthesis.motion import Motion, Stretch
from synthesis.numerics.piecewise import Piecewise
from synthesis.profile import CamProfile, cam_profile
from tests.geometry import touch
from tests.geometry.agreement import agree
from tests.geometry.cams import TURN, motions, unspecial
from tests.geometry.slopes import slopes

FACE = TranslatingFlatFace()
POINTS = 4000


@dataclass(frozen=True)
class FlatCam:
    """A finished cam; ``sense``: +1 where it turns counter-clockwise."""

    motion: Motion
    Rb: float
    rotation: str

    @property
    def sense(self) -> float:
        return -1.0 if self.rotation == "cw" else 1.0

    @property
    def length(self) -> float:
        return self.Rb + max(max(s.s_start, s.s_end) for s in self.motion.stretches)

    def profile(self, theta: np.ndarray, side: str = "right") -> CamProfile:
        return cam_profile(self.motion, FACE, (self.Rb,), self.rotation, np.asarray(theta), side)

    def inside(self, fraction: float) -> tuple[np.ndarray, np.ndarray]:
        breaks = self.motion.curve.breaks
        width = np.diff(breaks)
        return breaks[:-1] + fraction * width, width


def sharpest(motion: Motion) -> float:
    """Largest −(s + s''), sampled on every piece, both ends included."""
    breaks = motion.curve.breaks
    step = np.linspace(1e-9, 1.0 - 1e-9, 200)
    s = motion.derivatives((breaks[:-1, None] + np.diff(breaks)[:, None] * step).ravel())
    return float(np.max(-s[0] - s[2]))


@st.composite
def flat_cams(draw: st.DrawFn) -> FlatCam:
    """Base radii 0.1 to 1000; the least radius of the profile 0.05 to 0.5 of the base radius."""
    motion = draw(motions(10.0 ** draw(unspecial(-1.0, 2.0)), only_gentle=True))
    least = max(sharpest(motion), 0.0)
    stroke = max(max(s.s_start, s.s_end) for s in motion.stretches)
    Rb = (least + 0.01 * stroke) / (1.0 - draw(unspecial(0.05, 0.5)))
    return FlatCam(motion, Rb, draw(st.sampled_from(["ccw", "cw"])))


@given(flat_cams())
def test_on_a_dwell_the_profile_is_the_circle_of_the_face_s_height(cam: FlatCam):
    for stretch in cam.motion.stretches:
        if stretch.kind == "dwell":
            p = cam.profile(stretch.start + stretch.angle * np.array([0.2, 0.5, 0.8]))
            radius = cam.Rb + stretch.s_start
            np.testing.assert_allclose(np.hypot(p.x, p.y), radius, rtol=4e-15)
            np.testing.assert_allclose(p.curvature, 1.0 / radius, rtol=4e-15)
            np.testing.assert_allclose(p.radius, radius, rtol=4e-15)


@given(flat_cams(), unspecial(0.2, 0.8))
def test_the_profile_s_tangent_is_the_face(cam: FlatCam, fraction: float):
    theta, width = cam.inside(fraction)

    def drawn(angle: np.ndarray) -> np.ndarray:
        p = cam.profile(angle)
        return np.array([p.x, p.y])

    (dx, dy), _ = slopes(drawn, theta, 0.1 * width)
    p = cam.profile(theta)
    across, along = dx * p.normal_x + dy * p.normal_y, dx * p.normal_y - dy * p.normal_x
    noise = 1e-11 * cam.length / width
    agree("slope across the face", theta, across, np.zeros(1), noise)
    # run clockwise on a ccw cam, at a speed that is the radius of curvature
    agree("slope along the face", theta, p.radius, cam.sense * along, noise + 1e-11 * cam.length)
    assert not np.any(p.pressure_angle)
    # the face is perpendicular to the slide: its normal is that of the machine's y axis
    turned = -cam.sense * theta
    np.testing.assert_allclose(p.normal_x, -np.sin(turned), atol=1e-14)
    np.testing.assert_allclose(p.normal_y, np.cos(turned), atol=1e-14)


@given(flat_cams(), unspecial(0.2, 0.8))
def test_the_traced_point_s_derivatives_are_those_of_its_position(cam: FlatCam, fraction: float):
    theta, width = cam.inside(fraction)

    def traced(angle: np.ndarray) -> np.ndarray:
        return np.array(FACE.traced_point(cam.motion.derivatives(angle), (cam.Rb,)))

    told = traced(theta)
    for order in range(2):
        slope, _ = slopes(lambda angle, k=order: traced(angle)[k], theta, 0.15 * width)
        noise = 1e-12 * (np.max(abs(told[order])) + cam.length) / width
        for name, mine, found in zip("xy", told[order + 1], slope, strict=True):
            agree(f"{name}, derivative {order + 1}", theta, mine, found, noise + 1e-11 * abs(mine))


def heights(points: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """How high a horizontal line comes to rest on the polygon, turned by each angle."""
    return np.array([touch.turned(points, angle)[:, 1].max() for angle in angles])


@settings(max_examples=40)
@given(flat_cams(), unspecial(0.1, 0.9))
def test_a_line_slid_down_onto_the_cam_follows_the_law(cam: FlatCam, fraction: float):
    turn = TURN * np.arange(POINTS) / POINTS
    # one-sided where a derivative jumps: both ends of the arc belong to the outline
    joints = cam.motion.curve.breaks[:-1]
    every = np.sort(np.concatenate([turn, joints]))
    p = cam.profile(every)
    points = np.stack([p.x, p.y], axis=1)
    theta = np.concatenate([TURN * (np.arange(23) + fraction) / 23, cam.inside(fraction)[0]])
    measured = heights(points, cam.sense * theta) - cam.Rb
    # a vertex lies less than half a step from the contact: below it by ρ step²/8 at most
    allowed = 2.0 * np.max(p.radius) * (TURN / POINTS) ** 2 / 8.0 + 1e-12 * cam.length
    law = cam.motion.curve(theta)
    assert allowed < 1e-2 * np.max(law)
    agree("displacement", theta, law, measured, np.array(allowed))


@settings(max_examples=15)
@given(flat_cams(), unspecial(0.2, 0.6))
def test_an_undercut_cam_says_so_and_lifts_the_face_too_far(cam: FlatCam, share: float):
    nose = sharpest(cam.motion)
    cam = FlatCam(cam.motion, max((1.0 - share) * nose, 1e-3 * cam.Rb), cam.rotation)
    if nose <= cam.Rb:
        return
    theta = TURN * (np.arange(POINTS) + 0.5) / POINTS
    p = cam.profile(theta)
    radius = cam.Rb + p.s[0] + p.s[2]
    np.testing.assert_allclose(p.radius, radius, rtol=1e-12, atol=1e-13 * cam.length)
    assert np.min(p.radius) < 0.0
    assert np.min(p.curvature) < 0.0
    lifted = heights(np.stack([p.x, p.y], axis=1), cam.sense * theta[::10]) - cam.Rb
    assert np.max(lifted - cam.motion.curve(theta[::10])) > 0.0


def test_at_a_cusp_the_radius_is_nothing():
    law = Piecewise.of([0.0, 1.0], [[0.0]])
    still = Motion.of([Stretch(0, "dwell", 0.0, TURN, 0.0, 0.0, law)])
    p = FlatCam(still, 0.0, "ccw").profile(np.array([0.7]))
    assert p.radius[0] == 0.0
    assert p.curvature[0] == np.inf
    assert p.normal_y[0] == np.cos(0.7)


@given(flat_cams(), unspecial(0.1, 0.9))
def test_clockwise_is_the_mirror_image(cam: FlatCam, fraction: float):
    theta, _ = cam.inside(fraction)
    here, there = (FlatCam(cam.motion, cam.Rb, sense).profile(theta) for sense in ("ccw", "cw"))
    for name, sign in {"x": -1.0, "y": 1.0, "normal_x": -1.0, "normal_y": 1.0, "radius": 1.0,
                       "curvature": 1.0, "pressure_angle": 1.0}.items():  # fmt: skip
        np.testing.assert_array_equal(getattr(there, name), sign * getattr(here, name), name)


@given(flat_cams())
def test_what_the_follower_tells_is_what_is_measured(cam: FlatCam):
    breaks = cam.motion.curve.breaks
    theta = np.unique(np.concatenate([TURN * np.arange(3600) / 3600, breaks[:-1]]))
    p = cam.profile(theta)
    out = FACE.outermost(cam.length - cam.Rb).value((cam.Rb,))
    np.testing.assert_allclose(out, np.max(np.hypot(p.x, p.y)), rtol=1e-9)
    (row,) = FACE.profile_radius_rows(0.0)
    told = -(np.array(row.coefficients) @ p.s + row.size[0] * cam.Rb - row.upper)
    np.testing.assert_allclose(told, p.radius, rtol=1e-12, atol=1e-13 * cam.length)
    # the face that contact needs, from where the profile touches the line
    along = p.x * np.cos(theta) - cam.sense * p.y * np.sin(theta)  # in the machine's frame
    wide = FACE.motion_dimensions(cam.motion, (cam.Rb,))
    largest, least = np.max(cam.sense * along), np.min(cam.sense * along)
    np.testing.assert_allclose(wide["face_right_mm"], largest, rtol=2e-3)
    np.testing.assert_allclose(wide["face_left_mm"], -least, rtol=2e-3)
    assert wide["face_width_mm"] == wide["face_left_mm"] + wide["face_right_mm"]
