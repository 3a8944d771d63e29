"""The finished cam is run by touch, and its follower must do what the law says.

The cam is given as a polygon of reported profile points; `touch` turns it and lets the roller down.
How far the polygon is from the curve is measured on the polygon (`coarseness`), and what that is
worth in lift by running a roller that is thicker by so much: no formula of the geometry is used to
judge it.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings

from synthesis.catalogue.followers import TranslatingRoller
from tests.numerics.geometry import touch
from tests.numerics.geometry.agreement import agree
from tests.numerics.geometry.cams import TURN, Cam, cams, unspecial

POINTS = 3000


def outline(cam: Cam, count: int = POINTS) -> tuple[np.ndarray, np.ndarray]:
    """Cam angles, and the profile's points there."""
    theta = TURN * np.arange(count) / count
    p = cam.profile(theta)
    return theta, np.stack([p.x, p.y], axis=1)


def sense_of(cam: Cam) -> float:
    return -1.0 if cam.rotation == "cw" else 1.0


def with_roller(cam: Cam, radius: float) -> Cam:
    return replace(cam, follower=TranslatingRoller(roller_radius_mm=radius, offset_mm=cam.e))


def sharpest(cam: Cam) -> float:
    """Smallest convex radius of the pitch curve, from circles through neighbouring points."""
    _, points = outline(with_roller(cam, 0.0))
    side = np.roll(points, -1, axis=0) - points
    after = np.roll(side, -1, axis=0)
    turn = side[:, 0] * after[:, 1] - side[:, 1] * after[:, 0]
    across = np.hypot(*(side + after).T)
    bend = -sense_of(cam) * 2.0 * turn
    return float(1.0 / np.max(bend / (np.hypot(*side.T) * np.hypot(*after.T) * across)))


def run(cam: Cam, theta: np.ndarray, points: np.ndarray, thicker: float = 0.0) -> np.ndarray:
    """Measured displacement: the offset lies right of the follower on a ccw cam, left on a cw."""
    sense = sense_of(cam)
    roller = touch.Roller(sense * cam.e, cam.Rr + thicker)
    return touch.lifts(points, sense * theta, roller) - cam.s0


def angles_between(cam: Cam, fraction: float) -> np.ndarray:
    """Cam angles all round that are no vertices, and some in every piece of the motion."""
    return np.concatenate([TURN * (np.arange(23) + fraction) / 23, cam.inside(fraction)[0]])


@settings(max_examples=12)
@given(cams(only_gentle=True), unspecial(0.1, 0.9))
def test_a_sound_cam_drives_the_follower_by_the_law(cam: Cam, fraction: float):
    cam = with_roller(cam, min(cam.Rr, 0.8 * sharpest(cam)))
    _, points = outline(cam)
    theta = angles_between(cam, fraction)
    measured = run(cam, theta, points)
    coarse = touch.coarseness(points)
    allowed = 2.0 * (run(cam, theta, points, thicker=coarse) - measured) + 1e-12 * cam.length
    law = cam.motion.curve(theta)
    stroke = np.max(law)
    assert np.max(allowed) < 0.01 * stroke, "the polygon is too coarse to tell anything"
    agree("displacement", theta, law, measured, allowed)


@settings(max_examples=9)
@given(cams(only_gentle=True), unspecial(0.1, 0.9))
def test_on_a_sound_cam_the_roller_touches_and_never_penetrates(cam: Cam, fraction: float):
    cam = with_roller(cam, min(cam.Rr, 0.8 * sharpest(cam)))
    _, points = outline(cam)
    coarse = touch.coarseness(points) + 1e-12 * cam.length
    theta = TURN * (np.arange(181) + fraction) / 181
    sense = sense_of(cam)
    heights = cam.s0 + cam.motion.curve(theta)
    gap = touch.clearances(points, sense * theta, sense * cam.e, heights) - cam.Rr
    assert np.min(gap) >= -coarse, f"penetrates by {-np.min(gap)} at {theta[np.argmin(gap)]} rad"
    assert np.max(gap) <= coarse, f"hangs {np.max(gap)} above at {theta[np.argmax(gap)]} rad"


@settings(max_examples=7)
@given(cams(only_gentle=True, knife_edge=False, lifts=(0.8, 2.0)), unspecial(0.5, 1.0))
def test_an_undercut_cam_fails_both_ways(cam: Cam, share: float):
    nose, largest = sharpest(cam), 0.8 * cam.Rp
    assume(nose < 0.7 * largest)
    cam = with_roller(cam, nose + share * (largest - nose))
    theta, points = outline(cam, 1000)
    sense = sense_of(cam)
    line, heights = sense * cam.e, cam.s0 + cam.motion.curve(theta)
    some = slice(None, None, 9)
    law = cam.motion.curve(theta[some])
    # as reported, the loop of the profile stands in the roller's way ...
    gap = touch.clearances(points, sense * theta[some], line, heights[some]) - cam.Rr
    assert np.min(gap) < -2e-3 * cam.Rr, "an undercut profile lets the roller pass"
    assert np.max(run(cam, theta[some], points) - law) > 2e-3 * cam.Rr, "it does not lift it"
    # ... and once the cutter has taken the loop away, the follower falls short of the law
    finished = touch.cut(points, sense * theta, line, heights, cam.Rr)
    assert len(finished) < len(points)
    fallen = law - run(cam, theta[some], finished)
    assert np.max(fallen) > 2e-3 * cam.Rr, "the follower reaches its lift on an undercut cam"


# --- the instrument itself, on shapes that need no cam -----------------------------------------

SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@pytest.mark.parametrize(
    ("angle", "line", "radius", "height"),
    [
        (0.0, 0.3, 0.5, 1.5),  # on a side
        (0.0, 1.3, 0.5, 1.4),  # on a corner: 0.3, 0.4, 0.5
        (0.0, 0.3, 0.0, 1.0),  # a point on a side
        (np.pi / 4, 0.0, 0.7, np.sqrt(2.0) + 0.7),  # upright on a corner
        (np.pi / 4, 0.8, 0.1, np.sqrt(2.0) - 0.8 + 0.1 * np.sqrt(2.0)),  # on a slope
        (0.0, 1.6, 0.5, -np.inf),  # beside the square
    ],
)
def test_the_instrument_measures_a_square(angle, line, radius, height):
    found = touch.rest_height(touch.turned(SQUARE, angle), touch.Roller(line, radius))
    assert found == pytest.approx(height, abs=1e-15)


def test_the_instrument_measures_distances():
    assert touch.clearance(SQUARE, (0.3, 1.5)) == pytest.approx(0.5)
    assert touch.clearance(SQUARE, (1.3, 1.4)) == pytest.approx(0.5)
    assert touch.clearance(SQUARE, (0.2, 0.1)) == pytest.approx(0.8)


def test_the_instrument_knows_how_coarse_a_circle_is():
    angle = TURN * np.arange(400) / 400
    circle = 7.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rise = 7.0 * (1.0 - np.cos(TURN / 800))
    for points in (circle, circle[::-1]):
        assert rise < touch.coarseness(points) < 3.0 * rise
