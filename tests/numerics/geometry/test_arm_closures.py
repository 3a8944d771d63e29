"""Rings, grooves and counter cams of a roller on an arm, by touch and by plain trigonometry."""

from dataclasses import dataclass

import numpy as np
import pytest

from synthesis.catalogue.followers import OscillatingRoller
from synthesis.catalogue.followers.closures import Force, Groove
from synthesis.catalogue.followers.conjugate import ConjugateArm
from synthesis.catalogue.followers.kinematics import Flank
from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.catalogue.profile import cam_profile
from synthesis.numerics.piecewise import Piecewise
from tests.numerics.geometry import touch

TURN, DEGREE = 2.0 * np.pi, np.pi / 180.0
ARM, PIVOT, DIRECTION = 83.7, 101.3, 27.9  # mm, mm, deg
START, SWING = 31.3, 17.9  # deg
COUNTER, BETWEEN = 71.9, 86.1  # mm, deg


@dataclass(frozen=True)
class Case:
    """A machine: sense of the arm, of the cam, and which dimension is left open."""

    sense: str
    rotation: str
    given: bool

    @property
    def z(self) -> tuple[float, ...]:
        if self.given:
            return (ARM * START * DEGREE,)
        return (PIVOT * np.cos(START * DEGREE), PIVOT * np.sin(START * DEGREE))

    def follower(self, closure, radius: float = 9.7) -> OscillatingRoller:
        return OscillatingRoller(
            arm_mm=ARM, centre_distance_mm=PIVOT if self.given else None, roller_radius_mm=radius,
            sense=self.sense, pivot_direction_deg=DIRECTION, closure=closure,
        )  # fmt: skip


CASES = [Case(a, b, c) for a in ("opposite", "same") for b in ("ccw", "cw") for c in (True, False)]


def motion() -> Motion:
    ends = np.array([0.0, 83.3, 121.1, 241.7, 360.0]) * DEGREE
    ends[-1] = TURN
    law, still = LAWS["polynomial_3_4_5"].curve("rise"), Piecewise.of([0.0, 1.0], [[0.0]])
    levels = np.array([0.0, 1.0, 1.0, 0.0, 0.0]) * ARM * SWING * DEGREE
    kinds = ("rise", "dwell", "return", "dwell")
    return Motion.of(
        [
            PlacedSegment(i, kinds[i], ends[i], ends[i + 1] - ends[i], levels[i], levels[i + 1],
                    still if kinds[i] == "dwell" else law)
            for i in range(4)
        ]
    )  # fmt: skip


MOTION = motion()
THETA = TURN * (np.arange(97) + 0.319) / 97


def centre(case: Case, length: float, angle: np.ndarray, side: float) -> np.ndarray:
    """A point at the pivot's distance ``length``, turned by ``angle`` from the line to the axis.

    ``side`` −1: clockwise as seen on a ccw cam, which mirrors with it.
    """
    sense = -1.0 if case.rotation == "cw" else 1.0
    pivot = PIVOT * np.array([np.cos(DIRECTION * DEGREE), np.sin(DIRECTION * DEGREE)])
    heading = (DIRECTION + 180.0) * DEGREE + side * angle
    x, y = pivot[0] + length * np.cos(heading), pivot[1] + length * np.sin(heading)
    return np.stack([sense * x, y], axis=1)


def centres(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Main and counter roller in the machine at THETA, from the angles of the two arms."""
    side = -1.0 if case.sense == "opposite" else 1.0
    psi = START * DEGREE + MOTION.curve(THETA) / ARM
    return centre(case, ARM, psi, side), centre(case, COUNTER, BETWEEN * DEGREE - psi, -side)


def outline(case: Case, follower: OscillatingRoller, flank: Flank) -> np.ndarray:
    theta = TURN * np.arange(4000) / 4000
    p = cam_profile(MOTION, follower, case.z, case.rotation, theta, "right", flank)
    return np.stack([p.x, p.y], axis=1)


def gaps(case: Case, follower: OscillatingRoller, flank: Flank, where: np.ndarray) -> np.ndarray:
    points = outline(case, follower, flank)
    sense = -1.0 if case.rotation == "cw" else 1.0
    assert touch.coarseness(points) < 1e-3
    found = [
        touch.clearance(touch.turned(points, sense * angle), tuple(point))
        for angle, point in zip(THETA, where, strict=True)
    ]
    return np.array(found)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_a_roller_on_an_arm_touches_every_flank(case: Case) -> None:
    main, _ = centres(case)
    for closure in (Force(), Force(contact="inside"), Groove(clearance_mm=0.3)):
        follower = case.follower(closure)
        for flank in follower.flanks:
            found = gaps(case, follower, flank, main)
            np.testing.assert_allclose(found, flank.distance, rtol=0, atol=1e-3)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_both_rollers_of_a_lever_touch_their_cams(case: Case) -> None:
    follower = case.follower(ConjugateArm(roller_radius_mm=7.3, arm_mm=COUNTER, angle_deg=BETWEEN))
    for flank, where in zip(follower.flanks, centres(case), strict=True):
        found = gaps(case, follower, flank, where)
        np.testing.assert_allclose(found, flank.distance, rtol=0, atol=1e-3)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_the_lever_is_rigid_and_its_forms_are_those_of_the_path(case: Case) -> None:
    follower = case.follower(ConjugateArm(roller_radius_mm=7.3, arm_mm=COUNTER, angle_deg=BETWEEN))
    s, z = MOTION.derivatives(THETA), case.z
    main, counter = (np.array(flank.trace.position(s, z)[0]) for flank in follower.flanks)
    apart = np.hypot(*(main - counter))
    across = ARM**2 + COUNTER**2 - 2.0 * ARM * COUNTER * np.cos(BETWEEN * DEGREE)
    np.testing.assert_allclose(apart, np.sqrt(across), rtol=1e-13)
    flank = follower.flanks[1]
    p = cam_profile(MOTION, follower, z, case.rotation, THETA, "right", flank)
    N, W2 = flank.trace.curvature_terms(s, z)
    np.testing.assert_allclose(p.curvature, N / W2**1.5, rtol=1e-11)
    radius, most = np.hypot(*counter), ARM * SWING * DEGREE
    assert flank.trace.nearest_displacement(most) == most
    if not case.given:
        assert flank.trace.outer_radius_norm(most).value(z) == pytest.approx(
            np.max(radius), rel=1e-9
        )
    reported = follower.motion_dimensions(MOTION, z)["counter_prime_radius_mm"]
    assert reported == pytest.approx(np.min(radius), rel=1e-9)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_the_counter_arm_s_pressure_angle_is_that_of_its_velocities(case: Case) -> None:
    follower = case.follower(ConjugateArm(roller_radius_mm=7.3, arm_mm=COUNTER, angle_deg=BETWEEN))
    flank, step = follower.flanks[1], 1e-5
    theta = THETA[(MOTION.derivatives(THETA)[2] != 0.0)]
    at = [
        cam_profile(MOTION, follower, case.z, case.rotation, theta + d, "right", flank)
        for d in (-step, 0.0, step)
    ]
    sense = -1.0 if case.rotation == "cw" else 1.0
    dx, dy = at[2].pitch_x - at[0].pitch_x, at[2].pitch_y - at[0].pitch_y
    x, y = at[1].pitch_x, at[1].pitch_y
    # its own path in the machine is a circle about the pivot
    cos, sin = np.cos(sense * theta), np.sin(sense * theta)
    nx, ny = -sense * dy, sense * dx
    (nx, ny), (x, y) = ((u * cos - v * sin, u * sin + v * cos) for u, v in ((nx, ny), (x, y)))
    px, py = sense * PIVOT * np.cos(DIRECTION * DEGREE), PIVOT * np.sin(DIRECTION * DEGREE)
    ux, uy = x - px, y - py
    cosine = abs(nx * -uy + ny * ux) / (np.hypot(nx, ny) * np.hypot(ux, uy))
    np.testing.assert_allclose(np.cos(at[1].pressure_angle), cosine, rtol=0, atol=1e-7)
