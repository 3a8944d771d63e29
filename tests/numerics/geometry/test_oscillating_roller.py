"""The oscillating roller: its geometry against differences, velocities, reflections and touch."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from synthesis.catalogue.constraints import enlarged, enlarged_to, max_enlargement
from synthesis.catalogue.followers import OscillatingRoller
from synthesis.catalogue.followers.base import prime_radius
from synthesis.catalogue.motion import Motion
from tests.certify.cams import backwards
from tests.numerics.geometry import touch
from tests.numerics.geometry.agreement import agree
from tests.numerics.geometry.cams import TURN, AnyCam, motions, unspecial
from tests.numerics.geometry.slopes import slopes

POINTS = 3000
INSIDE = unspecial(0.2, 0.8)


@dataclass(frozen=True)
class ArmCam(AnyCam):
    """A finished cam; ``psi``: ψ0 [rad]."""

    motion: Motion
    arm: float
    d: float
    psi: float
    Rr: float
    sense: str
    pivot_deg: float
    rotation: str
    fixed: bool

    @property
    def follower(self) -> OscillatingRoller:
        return OscillatingRoller(
            arm_mm=self.arm, centre_distance_mm=self.d if self.fixed else None,
            roller_radius_mm=self.Rr, sense=self.sense, pivot_direction_deg=self.pivot_deg,
        )  # fmt: skip

    @property
    def size(self) -> tuple[float, ...]:
        if self.fixed:
            return (self.arm * self.psi,)
        return self.d * np.cos(self.psi), self.d * np.sin(self.psi)

    @property
    def sigma(self) -> float:
        return 1.0 if self.sense == "opposite" else -1.0

    @property
    def pivot(self) -> np.ndarray:
        """In the machine frame of a ccw cam."""
        gamma = np.radians(self.pivot_deg)
        return self.d * np.array([np.cos(gamma), np.sin(gamma)])

    @property
    def length(self) -> float:
        return self.d + self.arm

    def radius(self, s: np.ndarray) -> np.ndarray:
        """Of the roller's centre, by the law of cosines."""
        cos = np.cos(self.psi + s / self.arm)
        return np.sqrt(self.d**2 + self.arm**2 - 2.0 * self.d * self.arm * cos)

    def steps(self, fraction: float) -> tuple[np.ndarray, np.ndarray]:
        """Angles, and how far around each the curves may be read to differentiate them.

        Within the piece, and where neither the curve nor the arm changes direction much.
        """
        theta, width = self.inside(fraction)
        s = self.motion.derivatives(theta)
        N, W2 = self.follower.curvature_terms(s, self.size)
        bend = abs(N) / W2 + abs(s[1]) / self.arm + abs(s[2]) / np.sqrt(W2)
        return theta, np.minimum(0.15 * width, 0.1 / (1.0 + bend))


@st.composite
def arm_cams(draw: st.DrawFn, only_gentle: bool = False, swings=(0.15, 0.9)) -> ArmCam:
    """Distances 0.1 to 1000; arm 0.5 to 1.6 of it; both senses, both charts, any direction."""
    d = 10.0 ** draw(unspecial(-1.0, 3.0))
    arm, psi = d * draw(unspecial(0.5, 1.6)), draw(unspecial(0.6, 1.6))
    motion = draw(motions(arm * draw(unspecial(*swings)), only_gentle))
    prime = np.sqrt(d**2 + arm**2 - 2.0 * d * arm * np.cos(psi))
    roller = prime * draw(unspecial(0.05, 0.4)) * draw(st.sampled_from([0.0, 1.0, 1.0, 1.0]))
    return ArmCam(
        motion, arm, d, psi, roller, draw(st.sampled_from(["opposite", "same"])),
        draw(unspecial(-180.0, 180.0)), draw(st.sampled_from(["ccw", "cw"])), draw(st.booleans()),
    )  # fmt: skip


def turned(x: np.ndarray, y: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vectors turned counter-clockwise."""
    return x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)


# --- where the roller is ------------------------------------------------------------------------


@given(arm_cams(), INSIDE)
def test_the_centre_hangs_on_its_arm_and_swings_by_the_law(cam: ArmCam, fraction: float):
    theta, _ = cam.inside(fraction)
    p = cam.profile(theta)
    x, y = turned(p.pitch_x, p.pitch_y, cam.turns * theta)
    x = cam.turns * x  # a cw cam is the mirror image
    px, py = cam.pivot
    agree("length of the arm", theta, np.hypot(x - px, y - py), cam.arm, 1e-14 * cam.length)
    agree("radius", theta, np.hypot(x, y), cam.radius(p.s[0]), 1e-13 * cam.length)
    # ψ from the line to the axis, turned by −σψ
    angle = -cam.sigma * np.arctan2(-px * (y - py) + py * (x - px), -px * (x - px) - py * (y - py))
    agree("angle at the pivot", theta, angle, cam.psi + p.s[0] / cam.arm, 1e-12)


@given(arm_cams(), INSIDE)
def test_the_traced_point_s_derivatives_are_those_of_its_position(cam: ArmCam, fraction: float):
    theta, reach = cam.steps(fraction)
    reported = cam.traced(theta)
    for order in range(3):
        slope, _ = slopes(lambda angle, k=order: cam.traced(angle)[k], theta, reach)
        noise = 1e-13 * (np.max(abs(reported[order])) + cam.length) / reach
        for name, mine, found in zip("xy", reported[order + 1], slope, strict=True):
            agree(f"{name}, derivative {order + 1}", theta, mine, found, noise + 1e-11 * abs(mine))


@given(arm_cams(), INSIDE)
def test_it_is_driven_along_its_path(cam: ArmCam, fraction: float):
    theta, reach = cam.steps(fraction)
    s = cam.motion.derivatives(theta)
    (gx, gy), (hx, hy) = cam.follower.drive_direction(s, cam.size)
    _, (dx, dy), *_ = cam.follower.position(s, cam.size)
    np.testing.assert_allclose(np.hypot(gx, gy), 1.0, rtol=1e-14)
    np.testing.assert_allclose(s[1] * gx, dx, rtol=0, atol=1e-14 * np.max(abs(s[1])))
    np.testing.assert_allclose(s[1] * gy, dy, rtol=0, atol=1e-14 * np.max(abs(s[1])))
    (sx, sy), _ = slopes(
        lambda at: np.array(cam.follower.drive_direction(cam.motion.derivatives(at), cam.size)[0]),
        theta, reach,
    )  # fmt: skip
    agree("g', x", theta, hx, sx, 1e-13 / reach)
    agree("g', y", theta, hy, sy, 1e-13 / reach)


# --- the profile --------------------------------------------------------------------------------


@given(arm_cams(), INSIDE)
def test_on_a_dwell_the_pitch_curve_is_a_circle(cam: ArmCam, fraction: float):
    p = cam.profile(cam.at_rest(0.5 * fraction, fraction, 0.999))
    radius = cam.radius(p.s[0])
    lost = cam.length / np.min(radius)  # digits, in a radius that is a small difference
    np.testing.assert_allclose(np.hypot(p.pitch_x, p.pitch_y), radius, rtol=1e-14 * lost)
    np.testing.assert_allclose(p.curvature, 1.0 / radius, rtol=1e-13 * lost)
    np.testing.assert_allclose(np.hypot(p.x, p.y), radius - cam.Rr, rtol=0, atol=1e-13 * cam.length)
    np.testing.assert_allclose(p.radius, radius - cam.Rr, rtol=0, atol=1e-12 * cam.length)


@given(arm_cams(), INSIDE)
def test_the_roller_touches_along_the_normal_at_its_radius(cam: ArmCam, fraction: float):
    theta, reach = cam.steps(fraction)
    p = cam.profile(theta)
    np.testing.assert_allclose(np.hypot(p.normal_x, p.normal_y), 1.0, rtol=1e-14)
    tolerance = 1e-12 * cam.length
    np.testing.assert_allclose(p.pitch_x - p.x, cam.Rr * p.normal_x, rtol=0, atol=tolerance)
    np.testing.assert_allclose(p.pitch_y - p.y, cam.Rr * p.normal_y, rtol=0, atol=tolerance)
    for points in (cam.outline, cam.pitch):
        (dx, dy), _ = slopes(points, theta, reach)
        along = (dx * p.normal_x + dy * p.normal_y) / cam.length
        agree("normal along tangent", theta, along, 0.0, np.maximum(1e-12, 4e-15 / reach))


@given(arm_cams(), INSIDE)
def test_the_curvature_is_that_of_the_reported_curve_and_of_the_closed_form(
    cam: ArmCam, fraction: float
):
    theta, reach = cam.steps(fraction)
    (dx, dy), (ax, ay) = slopes(cam.pitch, theta, reach)
    speed = np.hypot(dx, dy)
    found = -cam.turns * (dx * ay - dy * ax) / speed**3  # a ccw cam is passed clockwise
    p = cam.profile(theta)
    noise = 1e-12 * cam.length / (reach**2 * speed**2)
    agree("curvature", theta, p.curvature, found, noise + 1e-10 * abs(found))
    N, W2 = cam.follower.curvature_terms(p.s, cam.size)
    scale = (W2 + cam.length * (abs(p.s[2]) + abs(p.s[1]) + cam.length)) / W2**1.5
    agree("by its closed form", theta, p.curvature, N / W2**1.5, 1e-12 * scale)
    np.testing.assert_allclose((p.radius + cam.Rr) * p.curvature, 1.0, rtol=1e-11)


# --- forces and speeds --------------------------------------------------------------------------


@given(arm_cams(), INSIDE)
def test_the_pressure_angle_is_that_of_normal_and_velocity(cam: ArmCam, fraction: float):
    theta, reach = cam.steps(fraction)
    cam = replace(cam, rotation="ccw")
    (dx, dy), _ = slopes(cam.pitch, theta, reach)
    nx, ny = turned(-dy, dx, theta)
    p = cam.profile(theta)
    x, y = turned(p.pitch_x, p.pitch_y, theta)
    # a lifting arm moves its end across itself, away from the line of the pivots
    ux, uy = (x - cam.pivot[0]) / cam.arm, (y - cam.pivot[1]) / cam.arm
    gx, gy = cam.sigma * uy, -cam.sigma * ux
    alpha = np.arctan2(gx * ny - gy * nx, gx * nx + gy * ny)
    agree("pressure angle", theta, p.pressure_angle, alpha, 1e-11 + 4e-15 / reach)
    psi = cam.psi + p.s[0] / cam.arm
    reported = abs(cam.arm * (1.0 + cam.sigma * p.s[1] / cam.arm) - cam.d * np.cos(psi))
    formula = np.arctan2(reported, cam.d * np.sin(psi))
    agree("its formula", theta, abs(p.pressure_angle), formula, 1e-12)


@given(arm_cams(), INSIDE)
def test_cam_and_follower_neither_part_nor_penetrate(cam: ArmCam, fraction: float):
    # at the contact point both move equally fast along the common normal
    theta, reach = cam.steps(fraction)
    (dx, dy), _ = slopes(cam.pitch, theta, reach)
    length = np.hypot(dx, dy)
    p = cam.profile(theta)
    nx, ny = turned(-cam.turns * dy / length, cam.turns * dx / length, cam.turns * theta)
    x, y = turned(p.x, p.y, cam.turns * theta)
    cam_speed = cam.turns * (-y * nx + x * ny)

    def centre(at: np.ndarray) -> np.ndarray:
        q = cam.profile(at)
        return np.stack(turned(q.pitch_x, q.pitch_y, cam.turns * at))

    (vx, vy), _ = slopes(centre, theta, reach)
    noise = 1e-13 * cam.length * (1.0 + 1.0 / reach) * (1.0 + cam.length / length)
    agree("speed along the normal", theta, cam_speed, vx * nx + vy * ny, noise)


# --- reflections --------------------------------------------------------------------------------


@given(arm_cams(), unspecial(0.1, 0.9))
def test_clockwise_is_the_mirror_image(cam: ArmCam, fraction: float):
    theta, _ = cam.inside(fraction)
    here, there = (replace(cam, rotation=turns).profile(theta) for turns in ("ccw", "cw"))
    for name, sign in {"x": -1.0, "y": 1.0, "normal_x": -1.0, "normal_y": 1.0, "radius": 1.0,
                       "curvature": 1.0, "pressure_angle": 1.0}.items():  # fmt: skip
        np.testing.assert_array_equal(getattr(there, name), sign * getattr(here, name), name)


@given(arm_cams(), unspecial(0.1, 0.9))
def test_the_other_sense_is_the_mirror_image_run_backwards(cam: ArmCam, fraction: float):
    theta, _ = cam.inside(fraction)
    other = replace(
        cam, motion=backwards(cam.motion), pivot_deg=180.0 - cam.pivot_deg,
        sense="same" if cam.sense == "opposite" else "opposite",
    )  # fmt: skip
    here, there = cam.profile(theta), other.profile(TURN - theta)
    tolerance = 1e-11 * cam.length * (1.0 + np.max(abs(here.s[1])) / cam.length)
    for name, sign in {"x": -1.0, "y": 1.0, "pitch_x": -1.0, "pitch_y": 1.0}.items():
        agree(name, theta, getattr(there, name), sign * getattr(here, name), tolerance)
    agree("pressure angle", theta, there.pressure_angle, -here.pressure_angle, 1e-10)


@given(arm_cams(), unspecial(0.1, 0.9))
def test_both_charts_of_the_size_are_one_cam(cam: ArmCam, fraction: float):
    theta, _ = cam.inside(fraction)
    fixed, free = replace(cam, fixed=True), replace(cam, fixed=False)
    here, there = fixed.profile(theta), free.profile(theta)
    for name in ("x", "y", "pitch_x", "pitch_y"):
        agree(name, theta, getattr(there, name), getattr(here, name), 1e-12 * cam.length)
    reported, also = (c.follower.dimensions(c.size) for c in (fixed, free))
    for name, value in reported.items():
        assert also[name] == pytest.approx(value, rel=1e-12), name
    reported, also = (c.follower.motion_dimensions(c.motion, c.size) for c in (fixed, free))
    for name, value in reported.items():
        assert also[name] == pytest.approx(value, rel=1e-12, abs=1e-12 * cam.length), name


# --- what the follower tells ----------------------------------------------------------------------


@given(arm_cams())
def test_what_the_follower_tells_is_what_is_measured(cam: ArmCam):
    breaks = cam.motion.curve.breaks
    p = cam.profile(np.unique(np.concatenate([TURN * np.arange(3600) / 3600, breaks[:-1]])))
    reported = cam.follower.dimensions(cam.size)
    radius = np.hypot(p.pitch_x, p.pitch_y)
    assert prime_radius(cam.follower, cam.size) == pytest.approx(np.min(radius), rel=1e-7)
    assert reported["prime_radius_mm"] == pytest.approx(np.min(radius), rel=1e-7)
    assert reported["base_radius_mm"] == pytest.approx(
        reported["prime_radius_mm"] - cam.Rr, rel=1e-14
    )
    assert reported["centre_distance_mm"] == pytest.approx(cam.d, rel=1e-14)
    assert reported["initial_angle_deg"] == pytest.approx(np.degrees(cam.psi), rel=1e-14)
    more = cam.follower.motion_dimensions(cam.motion, cam.size)
    outer = np.max(np.hypot(p.pitch_x, p.pitch_y)) - cam.Rr
    assert more["outer_radius_mm"] == pytest.approx(outer, rel=1e-5)
    assert more["pivot_clearance_mm"] == pytest.approx(cam.d - outer, abs=1e-5 * cam.length)
    if not cam.fixed:
        highest = np.max(cam.motion.curve(breaks[:-1]))
        norm = cam.follower.outer_radius_norm(highest)
        assert norm.value(cam.size) == pytest.approx(np.max(radius), rel=1e-5)


@given(arm_cams(), unspecial(0.1, 2.0))
def test_a_size_is_raised_to_a_radius_and_within_its_cones(cam: ArmCam, factor: float):
    follower, wanted = cam.follower, factor * prime_radius(cam.follower, cam.size)
    if not cam.fixed:
        raised = enlarged_to(cam.size, follower.radius_norm(), wanted)
        reached = max(wanted, prime_radius(follower, cam.size))
        assert prime_radius(follower, raised) == pytest.approx(reached, rel=1e-9)
    sizing = follower.size_domain((1e-3 * cam.d, 3.0 * cam.length))
    room = max_enlargement(cam.size, sizing.bounds, sizing.norm_bounds)
    most = enlarged(cam.size, room)
    assert most[-1] <= sizing.bounds[-1][1] * (1.0 + 1e-12)
    beyond = enlarged(cam.size, room * (1.0 + 1e-9) + 1e-9 * cam.d)
    inside = [c.norm.value(most) - c.upper for c in sizing.norm_bounds]
    assert all(excess <= 1e-9 * cam.length for excess in inside)
    out = [c.norm.value(beyond) > c.upper for c in sizing.norm_bounds]
    assert any(out) or beyond[-1] > sizing.bounds[-1][1]


@given(arm_cams(), unspecial(0.5, 1.5))
def test_an_outer_radius_is_kept_just_where_its_norm_says_so(cam: ArmCam, share: float):
    highest = np.max(cam.motion.curve(cam.motion.curve.breaks[:-1]))
    outer = float(cam.radius(highest))
    norm, most = (
        cam.follower.outer_radius_norm(highest),
        cam.follower.norm_from_radius(share * outer),
    )
    if abs(share - 1.0) > 1e-6:
        assert (norm.value(cam.size) <= most) == (share > 1.0)


@given(arm_cams())
def test_a_given_size_leaves_nothing_open(cam: ArmCam):
    fixed = replace(cam, fixed=True)
    base = prime_radius(fixed.follower, fixed.size) - cam.Rr
    ((low, high),) = fixed.follower.size_domain((base, base)).bounds
    assert low == high == pytest.approx(fixed.size[0], rel=1e-9)
    named = fixed.follower.model_copy(update={"initial_angle_deg": np.degrees(cam.psi)})
    ((low, high),) = named.size_domain((1e-3 * base, 1e3 * base)).bounds
    assert low == high == pytest.approx(fixed.size[0], rel=1e-14)


# --- the finished cam is run by touch -----------------------------------------------------------


def outline(cam: ArmCam) -> np.ndarray:
    return cam.outline(TURN * np.arange(POINTS) / POINTS).T


def swing_of(cam: ArmCam, thicker: float = 0.0) -> touch.Swing:
    """A cw cam's machine is the mirror image: so is its pivot, and which way the arm comes down."""
    x, y = cam.pivot
    return touch.Swing((cam.turns * x, y), cam.arm, cam.Rr + thicker, cam.turns * cam.sigma)


def sharpest(cam: ArmCam) -> float:
    """Smallest convex radius of the pitch curve, sampled."""
    theta = TURN * (np.arange(POINTS) + 0.5) / POINTS
    bend = max(np.max(replace(cam, Rr=0.0).profile(theta).curvature), 1e-9 / cam.length)
    return float(1.0 / bend)


def sound(cam: ArmCam) -> ArmCam:
    """The same with a roller that is not undercut, where nothing overhangs."""
    theta = TURN * np.arange(720) / 720
    assume(np.max(abs(cam.profile(theta).pressure_angle)) < np.radians(60.0))
    return replace(cam, Rr=min(cam.Rr, 0.8 * sharpest(cam)))


@settings(max_examples=12)
@given(arm_cams(only_gentle=True), unspecial(0.1, 0.9))
def test_a_sound_cam_swings_the_arm_by_the_law(cam: ArmCam, fraction: float):
    cam = sound(cam)
    points = outline(cam)
    theta = np.concatenate([TURN * (np.arange(23) + fraction) / 23, cam.inside(fraction)[0]])
    measured, thicker = (
        touch.swings(points, cam.turns * theta, swing_of(cam, more)) - cam.psi
        for more in (0.0, touch.coarseness(points))
    )
    allowed = 2.0 * (thicker - measured) + 1e-12
    law = cam.motion.curve(theta) / cam.arm
    assert np.max(allowed) < 0.02 * np.max(law), "the polygon is too coarse to tell anything"
    agree("swing", theta, law, measured, allowed)


@settings(max_examples=9)
@given(arm_cams(only_gentle=True), unspecial(0.1, 0.9))
def test_on_a_sound_cam_the_roller_touches_and_never_penetrates(cam: ArmCam, fraction: float):
    cam = sound(cam)
    points, swing = outline(cam), swing_of(cam)
    coarse = touch.coarseness(points) + 1e-12 * cam.length
    theta = TURN * (np.arange(181) + fraction) / 181
    psi = cam.psi + cam.motion.curve(theta) / cam.arm
    gap = [
        touch.clearance(touch.turned(points, cam.turns * at), swing.centre(angle)) - cam.Rr
        for at, angle in zip(theta, psi, strict=True)
    ]
    assert np.min(gap) >= -coarse, f"penetrates by {-np.min(gap)} at {theta[np.argmin(gap)]} rad"
    assert np.max(gap) <= coarse, f"hangs {np.max(gap)} above at {theta[np.argmax(gap)]} rad"


@settings(max_examples=5)
@given(arm_cams(only_gentle=True, swings=(0.5, 0.9)), unspecial(0.3, 0.9))
def test_an_undercut_cam_does_not_swing_the_arm_by_the_law(cam: ArmCam, share: float):
    nose, prime = sharpest(cam), prime_radius(cam.follower, cam.size)
    assume(nose < 0.6 * prime)
    cam = replace(cam, Rr=nose + share * (0.9 * prime - nose))
    theta = TURN * np.arange(0, POINTS, 30) / POINTS
    measured = touch.swings(outline(cam), cam.turns * theta, swing_of(cam)) - cam.psi
    # the loop of the profile, as reported, stands in the roller's way
    assert np.max(measured - cam.motion.curve(theta) / cam.arm) > 1e-3


SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@pytest.mark.parametrize("down", [1.0, -1.0])
@pytest.mark.parametrize(("radius", "height"), [(0.0, 1.0), (0.3, 1.3)])
def test_the_instrument_lets_an_arm_down_on_a_square(down: float, radius: float, height: float):
    # a pivot to the right, its arm comes down on the upper or lower side
    swing = touch.Swing((3.0, 0.0), 3.2, radius, down)
    found = touch.rest_angle(SQUARE, swing)
    assert np.sin(found) * 3.2 == pytest.approx(height, abs=1e-14)
    assert swing.centre(found) == pytest.approx(
        (3.0 - 3.2 * np.cos(found), down * height), abs=1e-14
    )


def test_the_instrument_lets_an_arm_down_on_a_corner():
    found = touch.rest_angle(SQUARE, touch.Swing((3.0, 0.0), 1.9, 0.4, 1.0))
    x, y = 3.0 - 1.9 * np.cos(found), 1.9 * np.sin(found)
    assert np.hypot(x - 1.0, y - 1.0) == pytest.approx(0.4, abs=1e-14)
