"""The geometry that every family owes, in every closure and sense: one table, one set of checks.

Followers stand where ``machine`` puts them, by plain trigonometry from their dimensions; flanks are
the points that the profile reports. The families' own tests in ``tests/numerics/geometry`` go
through random sizes; here nothing can be left out, because the cases are those of the registry.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from synthesis.catalogue.followers.kinematics import Flank
from synthesis.catalogue.profile import CamProfile, cam_profile
from synthesis.pipeline.assembly import Cam
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.analyse import given_cam
from tests.catalogue.followers.samples import CASES, Body, bodies, spec
from tests.numerics.geometry.agreement import agree
from tests.numerics.geometry.slopes import slopes

TURN = 2.0 * np.pi
family = pytest.mark.parametrize(("kind", "sample"), CASES)
STARTS = np.radians(np.cumsum([0.0, 97.3, 41.2, 118.9, 102.6]))
DWELLS = ((1, (0.13, 0.51, 0.87)), (3, (0.17, 0.43, 0.91)))


@dataclass(frozen=True)
class Made:
    """One flank of a finished cam."""

    question: DesignSpec
    cam: Cam
    flank: Flank

    def profile(self, theta: np.ndarray, rotation: str = "ccw") -> CamProfile:
        return cam_profile(
            self.cam.motion, self.question.follower, self.cam.size, rotation, theta, "right",
            self.flank,
        )  # fmt: skip

    def body(self, theta: np.ndarray) -> Body:
        reported = self.question.follower.dimensions(self.cam.size)
        return bodies(self.question, reported, self.cam.motion.curve(theta))[self.flank.path]


def flanks(kind: str, sample: int) -> Iterator[Made]:
    question = spec(kind, sample)
    for flank in question.follower.flanks:
        yield Made(question, given_cam(question), flank)


def angles(count: int, share: float) -> np.ndarray:
    """Angles all round the turn, none of them where a segment begins."""
    return TURN * (np.arange(count) + share) / count


def turned(x: np.ndarray, y: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Vectors of the cam in the machine, when the cam has turned counter-clockwise."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([x * cos - y * sin, x * sin + y * cos])


@family
def test_dwells_are_circles_about_the_axis(kind: str, sample: int) -> None:
    for made in flanks(kind, sample):
        for segment, shares in DWELLS:
            start, end = STARTS[segment : segment + 2]
            p = made.profile(start + (end - start) * np.array(shares))
            for x, y in ((p.x, p.y), (p.pitch_x, p.pitch_y)):
                radius = np.hypot(x, y)
                np.testing.assert_allclose(radius, radius[0], rtol=1e-13)
            np.testing.assert_allclose(p.radius, made.flank.side * np.hypot(p.x, p.y), rtol=1e-12)
            bend = made.flank.side * (p.radius + made.flank.distance)
            np.testing.assert_allclose(p.curvature * bend, 1.0, rtol=1e-12)


@family
def test_the_body_touches_where_the_profile_says_along_its_normal(kind: str, sample: int) -> None:
    theta = angles(61, 0.31)
    for made in flanks(kind, sample):
        p, body = made.profile(theta), made.body(theta)
        point, normal = turned(p.x, p.y, theta), turned(p.normal_x, p.normal_y, theta)
        length = np.max(np.hypot(*point)) + np.max(np.hypot(*body.place))
        np.testing.assert_allclose(np.hypot(*normal), 1.0, rtol=1e-14)
        if body.outward is None:
            away = body.place - point
            gap = made.flank.side * made.flank.distance
            np.testing.assert_allclose(away, gap * normal, rtol=0, atol=1e-12 * length)
        else:
            np.testing.assert_allclose(normal, body.outward, rtol=0, atol=1e-12)
            height = np.sum(normal * (body.place - point), axis=0)
            np.testing.assert_allclose(height, 0.0, atol=1e-12 * length)


@family
def test_the_normal_is_perpendicular_to_the_curve_that_is_drawn(kind: str, sample: int) -> None:
    theta = angles(37, 0.31)
    nearest = np.min(abs(np.append(STARTS, 0.0)[:, None] - theta), axis=0)
    reach = np.minimum(0.02, 0.5 * nearest)
    for made in flanks(kind, sample):
        p = made.profile(theta)
        length = np.max(np.hypot(p.x, p.y))

        def drawn(at: np.ndarray, made: Made = made) -> np.ndarray:
            q = made.profile(at)
            return np.stack([q.x, q.y])

        (dx, dy), _ = slopes(drawn, theta, reach)
        along = (dx * p.normal_x + dy * p.normal_y) / length
        # positions are rounded, and differences divide that by their reach
        agree("normal along tangent", theta, along, 0.0 * theta, np.maximum(1e-12, 4e-15 / reach))


def coarseness(made: Made, points: np.ndarray, radius: np.ndarray, roller: float) -> float:
    """How far a body in contact may be from the nearest of the flank's points [mm]."""
    step = float(np.max(np.hypot(*np.diff(points, axis=1, append=points[:, :1]))))
    if made.flank.distance == 0.0 and made.body(np.zeros(1)).outward is None:
        return 0.51 * step  # a knife edge rests between two of them
    # the flank leaves the body by step²/8ρ, with both curvatures; twice that is allowed
    bend = 1.0 / np.min(abs(radius)) + (1.0 / roller if roller else 0.0)
    return 0.25 * step**2 * float(bend)


@family
def test_a_sweep_finds_contact_everywhere_and_no_penetration(kind: str, sample: int) -> None:
    outline, theta = angles(7200, 0.0), angles(181, 0.37)
    for made in flanks(kind, sample):
        p = made.profile(outline)
        points = np.stack([p.x, p.y])
        noise = 1e-11 * np.max(abs(points))
        for angle in theta:
            body = made.body(np.array([angle]))
            play = made.flank.distance - body.radius  # half a groove's clearance
            apart = body.apart(turned(points[0], points[1], angle))
            least = float(np.min(apart)) - play
            allowed = coarseness(made, points, p.radius, body.radius) + noise
            where = f"{made.flank.name} flank at {np.degrees(angle):.3f}°: {least} mm"
            assert -noise <= least <= allowed, where


@family
def test_clockwise_is_the_mirror_image(kind: str, sample: int) -> None:
    theta = angles(37, 0.31)
    for made in flanks(kind, sample):
        here, there = made.profile(theta), made.profile(theta, "cw")
        for name in ("x", "pitch_x", "normal_x"):
            np.testing.assert_array_equal(getattr(there, name), -getattr(here, name))
        for name in ("y", "pitch_y", "normal_y", "radius", "curvature", "pressure_angle"):
            np.testing.assert_array_equal(getattr(there, name), getattr(here, name))


@family
def test_the_pressure_angle_is_that_of_normal_and_velocity(kind: str, sample: int) -> None:
    theta = angles(61, 0.31)
    for made in flanks(kind, sample):
        p, body = made.profile(theta), made.body(theta)
        normal = turned(p.normal_x, p.normal_y, theta)
        moved = body.place if body.outward is None else turned(p.x, p.y, theta)
        # a lift lowers the counter roller: its cam pushes the other way
        gx, gy = body.velocity(moved) * (-1.0 if made.flank.name == "counter" else 1.0)
        (nx, ny) = normal
        wanted = np.arctan2(gx * ny - gy * nx, gx * nx + gy * ny)
        np.testing.assert_allclose(p.pressure_angle, wanted, atol=1e-12)


@family
def test_the_drive_turns_as_its_direction_does(kind: str, sample: int) -> None:
    theta = angles(37, 0.31)
    nearest = np.min(abs(np.append(STARTS, 0.0)[:, None] - theta), axis=0)
    for made in flanks(kind, sample):

        def driven(at: np.ndarray, made: Made = made) -> np.ndarray:
            s, trace = made.cam.motion.derivatives(at), made.flank.trace
            return np.stack(trace.drive_direction(s, made.cam.size)[0])

        slope, _ = slopes(driven, theta, np.minimum(0.02, 0.5 * nearest))
        s = made.cam.motion.derivatives(theta)
        _, reported = made.flank.trace.drive_direction(s, made.cam.size)
        for name, mine, found in zip("xy", reported, slope, strict=True):
            agree(f"turn of the drive, {name}", theta, mine, found, np.array(1e-8))


@family
def test_cam_and_follower_keep_touching(kind: str, sample: int) -> None:
    """Along the normal both move equally fast, the cam's point turning about the axis."""
    theta = angles(61, 0.31)
    for made in flanks(kind, sample):
        p, body = made.profile(theta), made.body(theta)
        (nx, ny), (x, y) = turned(p.normal_x, p.normal_y, theta), turned(p.x, p.y, theta)
        moved = body.place if body.outward is None else np.stack([x, y])
        unit = 1.0
        if body.pivot is not None:  # s is the arc of the arm, or of the centre distance
            reported = made.question.follower.model_dump()
            unit = reported.get("arm_mm", reported["centre_distance_mm"])
        vx, vy = body.velocity(moved) * p.s[1] / unit
        length = np.max(np.hypot(x, y)) + np.max(np.hypot(*body.place))
        np.testing.assert_allclose(x * ny - y * nx, vx * nx + vy * ny, atol=1e-12 * length)
