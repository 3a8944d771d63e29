"""A flat face on a pivot: its geometry against differences, velocities, reflections and touch."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis.catalogue.followers import OscillatingFlatFace
from synthesis.catalogue.motion import Motion
from synthesis.certify.quantities import QUANTITIES, TracedPoint
from tests.certify.cams import backwards
from tests.numerics.geometry import touch
from tests.numerics.geometry.agreement import agree
from tests.numerics.geometry.cams import TURN, AnyCam, all_along, motions, unspecial
from tests.numerics.geometry.slopes import slopes

POINTS = 4000
INSIDE = unspecial(0.2, 0.8)


@dataclass(frozen=True)
class FaceCam(AnyCam):
    """A finished cam; ``psi``: ψ0 [rad]."""

    motion: Motion
    d: float
    f: float
    psi: float
    reference: float
    sense: str
    pivot_deg: float
    rotation: str

    @property
    def follower(self) -> OscillatingFlatFace:
        fixed = self.d == self.reference
        return OscillatingFlatFace(
            centre_distance_mm=self.d if fixed else {"max": self.reference},
            face_offset_mm=self.f, sense=self.sense, pivot_direction_deg=self.pivot_deg,
        )  # fmt: skip

    @property
    def base(self) -> float:
        return self.d * np.sin(self.psi) - self.f

    @property
    def size(self) -> tuple[float, ...]:
        if self.d == self.reference:
            return (self.base,)
        return self.d * np.cos(self.psi), self.base

    @property
    def sigma(self) -> float:
        return 1.0 if self.sense == "opposite" else -1.0

    @property
    def pivot(self) -> np.ndarray:
        """In the machine frame, the clockwise one mirrored."""
        gamma = np.radians(self.pivot_deg)
        return self.d * np.array([self.turns * np.cos(gamma), np.sin(gamma)])

    @property
    def length(self) -> float:
        return self.d + abs(self.f)

    def in_machine(self, theta: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        angle = self.turns * theta
        return np.stack(
            [x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)]
        )


def bracket(s: np.ndarray, reference: float, sigma: float, psi: float) -> np.ndarray:
    """(ρ + f)/d: the part of the radius that the motion makes."""
    phi, v, a = s[:3] / reference
    w = 1.0 + sigma * v
    return np.sin(psi + phi) * (1.0 + 2.0 * sigma * v) / w**2 + np.cos(psi + phi) * a / w**3


@st.composite
def face_cams(draw: st.DrawFn, deepest: float = 0.05) -> FaceCam:
    """Any size; both senses and charts; faces on either side of the pivot; never undercut.

    The swing is never faster than 0.6 of the cam, the least radius at least ``deepest`` of d.
    """
    motion = draw(motions(10.0 ** draw(unspecial(-1.0, 2.0)), only_gentle=True))
    s = all_along(motion)
    reference = float(np.max(abs(s[1]))) / draw(unspecial(0.1, 0.6))
    sense = draw(st.sampled_from(["opposite", "same"]))
    room = 0.5 * np.pi - float(np.max(s[0])) / reference
    psi = room * draw(unspecial(0.2, 0.9))
    d = reference / draw(st.sampled_from([1.0, 1.37]))
    least = float(np.min(bracket(s, reference, 1.0 if sense == "opposite" else -1.0, psi)))
    f = d * (least - draw(unspecial(deepest, deepest + 0.3)))
    return FaceCam(
        motion, d, f, psi, reference, sense, draw(unspecial(-180.0, 180.0)),
        draw(st.sampled_from(["ccw", "cw"])),
    )  # fmt: skip


@given(face_cams())
def test_on_a_dwell_the_profile_is_the_circle_of_the_face_s_distance(cam: FaceCam):
    for segment in cam.motion.segments:
        if segment.kind == "dwell":
            p = cam.profile(segment.start + segment.angle * np.array([0.2, 0.5, 0.8]))
            radius = cam.d * np.sin(cam.psi + segment.s_start / cam.reference) - cam.f
            noise = 1e-14 * cam.length
            np.testing.assert_allclose(np.hypot(p.x, p.y), radius, rtol=1e-13, atol=noise)
            np.testing.assert_allclose(p.radius, radius, rtol=1e-13, atol=noise)


@given(face_cams(), INSIDE)
def test_the_profile_s_tangent_is_the_face(cam: FaceCam, fraction: float):
    theta, width = cam.inside(fraction)
    (dx, dy), _ = slopes(cam.outline, theta, 0.05 * width)
    p = cam.profile(theta)
    np.testing.assert_allclose(np.hypot(p.normal_x, p.normal_y), 1.0, rtol=1e-14)
    across, along = dx * p.normal_x + dy * p.normal_y, dx * p.normal_y - dy * p.normal_x
    noise = 1e-10 * cam.length / width
    agree("slope across the face", theta, across, np.zeros(1), noise)
    # run clockwise on a ccw cam, at a speed that is the radius times the turn of the normal
    turn = 1.0 + cam.sigma * p.s[1] / cam.reference
    agree("slope along the face", theta, p.radius * turn, cam.turns * along, noise)


@given(face_cams(), INSIDE)
def test_the_contact_normal_is_perpendicular_to_the_traced_tangent(cam: FaceCam, fraction: float):
    theta, _ = cam.inside(fraction)
    s, follower = cam.motion.derivatives(theta), cam.follower
    (px, py), (dx, dy), *_ = follower.position(s, cam.size)
    tx, ty = dx + py, dy - px
    nx, ny = follower.normal((tx, ty), s, cam.size)
    np.testing.assert_allclose(tx * nx + ty * ny, 0.0, atol=1e-12 * cam.length)


@given(face_cams(), INSIDE)
def test_the_traced_point_s_derivatives_are_those_of_its_position(cam: FaceCam, fraction: float):
    theta, width = cam.inside(fraction)
    reported = cam.traced(theta)
    for order in range(2):
        slope, _ = slopes(lambda angle, k=order: cam.traced(angle)[k], theta, 0.05 * width)
        noise = 1e-10 * (np.max(abs(reported[order])) + cam.length) / width
        for name, mine, found in zip("xy", reported[order + 1], slope, strict=True):
            agree(f"{name}, derivative {order + 1}", theta, mine, found, noise + 1e-10 * abs(mine))

    def driven(angle: np.ndarray) -> np.ndarray:
        return np.array(cam.follower.drive_direction(cam.motion.derivatives(angle), cam.size)[0])

    slope, _ = slopes(driven, theta, 0.05 * width)
    _, turning = cam.follower.drive_direction(cam.motion.derivatives(theta), cam.size)
    for name, mine, found in zip("xy", turning, slope, strict=True):
        agree(f"direction {name}", theta, mine, found, 1e-9 / width)


@given(face_cams(), INSIDE)
def test_the_pressure_angle_is_that_of_velocities(cam: FaceCam, fraction: float):
    theta, _ = cam.inside(fraction)
    p = cam.profile(theta)
    x, y = cam.in_machine(theta, p.x, p.y)
    nx, ny = cam.in_machine(theta, p.normal_x, p.normal_y)
    # the face's material at the contact turns about the pivot, the cam's about the axis
    swing = -cam.turns * cam.sigma * p.s[1] / cam.reference
    (rx, ry), lifting = np.stack([x, y]) - cam.pivot[:, None], -cam.turns * cam.sigma
    face, cams = swing * (nx * -ry + ny * rx), cam.turns * (nx * -y + ny * x)
    np.testing.assert_allclose(face, cams, atol=1e-12 * cam.length)
    drive = np.stack([-ry, rx]) * lifting
    cos = (drive[0] * nx + drive[1] * ny) / np.hypot(rx, ry)
    np.testing.assert_allclose(np.cos(p.pressure_angle), cos, rtol=1e-12)
    assert np.all(cos > 0.0)
    reach = cam.d * np.cos(cam.psi + p.s[0] / cam.reference)
    reach /= 1.0 + cam.sigma * p.s[1] / cam.reference
    np.testing.assert_allclose(abs(np.tan(p.pressure_angle)), abs(cam.f) / reach, rtol=1e-9)


def resting(cam: FaceCam, points: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Displacement of the edge when it rests on the turning polygon."""
    edge = touch.Hinged(tuple(cam.pivot), cam.f, cam.turns * cam.sigma)
    return (touch.rest_angles(points, cam.turns * theta, edge) - cam.psi) * cam.reference


@settings(max_examples=12)
@given(face_cams(), unspecial(0.1, 0.9))
def test_an_edge_swung_down_onto_the_cam_follows_the_law(cam: FaceCam, fraction: float):
    every = np.sort(
        np.concatenate([TURN * np.arange(POINTS) / POINTS, cam.motion.curve.breaks[:-1]])
    )
    p = cam.profile(every)
    theta = np.concatenate([TURN * (np.arange(23) + fraction) / 23, cam.inside(fraction)[0]])
    measured = resting(cam, np.stack([p.x, p.y], axis=1), theta)
    # a vertex lies less than half a step of the normal from the contact, at the contact's reach
    reach = cam.follower.motion_dimensions(cam.motion, cam.size)["face_near_mm"]
    step = 1.6 * TURN / POINTS
    allowed = np.max(p.radius) * step**2 / 8.0 / reach * cam.reference + 1e-11 * cam.length
    agree("displacement", theta, cam.motion.curve(theta), measured, np.array(2.0 * allowed))


@settings(max_examples=5)
@given(face_cams(deepest=-0.4))
def test_an_undercut_cam_says_so_and_lifts_the_face_too_far(cam: FaceCam):
    theta = TURN * (np.arange(POINTS) + 0.5) / POINTS
    p = cam.profile(theta)
    radius = cam.d * bracket(p.s, cam.reference, cam.sigma, cam.psi) - cam.f
    np.testing.assert_allclose(p.radius, radius, rtol=1e-9, atol=1e-9 * cam.length)
    if np.min(radius) >= -0.01 * cam.d:
        return
    measured = resting(cam, np.stack([p.x, p.y], axis=1), theta[::10])
    assert np.max(measured - cam.motion.curve(theta[::10])) > 0.0


@given(face_cams(), unspecial(0.1, 0.9))
def test_clockwise_is_the_mirror_image(cam: FaceCam, fraction: float):
    theta, _ = cam.inside(fraction)
    here, there = (replace(cam, rotation=turn).profile(theta) for turn in ("ccw", "cw"))
    for name, sign in {"x": -1.0, "y": 1.0, "normal_x": -1.0, "normal_y": 1.0, "radius": 1.0,
                       "curvature": 1.0, "pressure_angle": 1.0}.items():  # fmt: skip
        np.testing.assert_array_equal(getattr(there, name), sign * getattr(here, name), name)


@given(face_cams(), unspecial(0.1, 0.9))
def test_the_other_sense_is_the_motion_run_backwards_in_a_mirror(cam: FaceCam, fraction: float):
    other = replace(
        cam, motion=backwards(cam.motion), pivot_deg=-cam.pivot_deg,
        sense={"opposite": "same", "same": "opposite"}[cam.sense],
    )  # fmt: skip
    theta, _ = cam.inside(fraction)
    here, there = cam.profile(theta), other.profile(TURN - theta, "left")
    noise = {"rtol": 1e-9, "atol": 1e-11 * cam.length}
    for name, sign in {"x": 1.0, "y": -1.0, "radius": 1.0}.items():
        np.testing.assert_allclose(getattr(there, name), sign * getattr(here, name), **noise)


@given(face_cams())
def test_what_the_follower_tells_is_what_is_measured(cam: FaceCam):
    s, follower, size = all_along(cam.motion), cam.follower, cam.size
    reported = {**follower.dimensions(size), **follower.motion_dimensions(cam.motion, size)}
    assert reported["centre_distance_mm"] == pytest.approx(cam.d, rel=1e-12)
    assert reported["initial_angle_deg"] == pytest.approx(np.degrees(cam.psi), rel=1e-9)
    breaks = cam.motion.curve.breaks
    theta = np.unique(np.concatenate([TURN * np.arange(3600) / 3600, breaks[:-1]]))
    p = cam.profile(theta)
    touched = cam.in_machine(theta, p.x, p.y) - cam.pivot[:, None]
    reach = np.sqrt(np.sum(touched**2, axis=0) - cam.f**2)  # from the foot of the pivot
    assert reported["face_near_mm"] == pytest.approx(np.min(reach), abs=2e-3 * cam.d)
    assert reported["face_far_mm"] == pytest.approx(np.max(reach), abs=2e-3 * cam.d)
    # every limit, asked at what is measured, is met there and nowhere exceeded
    radius = cam.d * bracket(s, cam.reference, cam.sigma, cam.psi) - cam.f
    along = cam.d * np.cos(cam.psi + s[0] / cam.reference)
    along = along / (1.0 + cam.sigma * s[1] / cam.reference)
    outer = float(np.max(np.hypot(p.x, p.y)))
    for curves, worst in (
        (follower.profile_radius_constraints(float(np.min(radius))), 0.0),
        (follower.contact_constraints("near", float(np.min(along))), 0.0),
        (follower.contact_constraints("far", float(np.max(along))), 0.0),
        (follower.pressure_angle_constraints(abs(cam.f) / float(np.min(along))), 0.0),
        (follower.outer_radius_constraints(outer), 0.0),
    ):
        excess = max(float(np.max(v)) for curve in curves for v in curve.excess(s, size))
        assert excess == pytest.approx(worst, abs=1e-6)


@given(face_cams())
def test_the_certificate_s_quantities_are_those_of_the_closed_forms(cam: FaceCam):
    s = all_along(cam.motion)
    radius = cam.d * bracket(s, cam.reference, cam.sigma, cam.psi) - cam.f
    reach = cam.d * np.cos(cam.psi + s[0] / cam.reference)
    reach = reach / (1.0 + cam.sigma * s[1] / cam.reference)
    for name, reported in (("face_radius", radius), ("contact", reach)):
        found = QUANTITIES[name].formula(TracedPoint(cam.follower, cam.size, tuple(s)))
        np.testing.assert_allclose(found, reported, rtol=1e-9, atol=1e-9 * cam.length, err_msg=name)


@given(face_cams(), unspecial(0.5, 1.5), unspecial(0.3, 1.2))
def test_half_planes_say_the_same_as_the_limit(cam: FaceCam, larger: float, share: float):
    """At any size the half-planes of a motion are broken where the limit is."""
    s, follower = all_along(cam.motion), cam.follower
    least, reach = share * 0.3 * cam.d, share * cam.d
    curves = [
        *follower.profile_radius_constraints(least),
        *follower.contact_constraints("near", 0.4 * reach),
        *follower.contact_constraints("far", reach),
        *follower.outer_radius_constraints(1.3 * reach),
        *follower.pressure_angle_constraints(share),
    ]  # fmt: skip
    top = min(larger * (cam.base + cam.f), 0.999 * cam.d)
    size = (*cam.size[:-1], top - cam.f)
    for curve in curves:
        (excess,) = curve.excess(s, size)
        planes = [np.array(size) @ cuts.size - cuts.upper for cuts in curve.half_planes(s)]
        broken = np.max(np.stack(planes), axis=0)
        clear = abs(excess) > 1e-9
        if cam.f >= 0.0:
            np.testing.assert_array_equal((broken > 0.0)[clear], (excess > 0.0)[clear])
        else:  # where two ranges of the size are left, nothing is said
            assert not np.any((broken > 0.0)[clear] & (excess < 0.0)[clear])
