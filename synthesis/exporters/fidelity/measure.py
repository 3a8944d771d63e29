"""How far a curve through written points is from the cam, and what that does to the follower."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.catalogue.followers.flat_face import flat_face
from synthesis.exporters.fidelity.readers import CUBIC, ReaderName, Reading, reading
from synthesis.exporters.fidelity.riding import Ridden, Touched, ride
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import Written, in_degrees
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

BETWEEN = np.array([0.0, 0.2, 0.4, 0.5, 0.6, 0.8, 1.0])  # of each interval, where it is measured
ROUNDS = 2  # of Newton's method
CORNER = (0.0, 0.5, 1.0)  # parts of the turn of the normal at a corner
SHARP = 1e12  # curvature of a corner [1/mm]


@dataclass(frozen=True)
class Worst:
    """A greatest deviation, in the unit of what deviates, and the cam angle where it is [deg]."""

    value: float
    angle_deg: float


@dataclass(frozen=True)
class Fidelity:
    """What a reader makes of the points.

    Attributes:
        reader: how it draws the curve.
        form: greatest distance of the curve from the true one, along its normal [mm].
        velocity, acceleration: greatest error of the follower's s' and s'' [mm per radian];
            infinite where the velocity jumps.
        corner: angle in which the curve's two ends meet, whose jerk is not counted [rad].
    """

    reader: ReaderName
    form: Worst
    velocity: Worst
    acceleration: Worst
    corner: float = 0.0


def fidelities(cam: Cam, written: Written, turn_deg: float, overlap: int) -> list[Fidelity]:
    """What every reader makes of the points.

    Args:
        cam: the cam and the curve. written: the points as they stand in the file.
        turn_deg: by how much they are turned from the cam's frame.
        overlap: how many are repeated past the first one's repetition.
    """
    theta, points = _clockwise(cam, written, turn_deg)
    probes = _between(theta)
    true = _true(cam, probes)
    curves = [reading(points, overlap, reader) for reader in CUBIC]
    return [_polyline(cam, reading(points, 0, "polyline"), theta, probes, true)] + [
        _measured(cam, curve, probes, true) for curve in curves
    ]


def straight_form(cam: Cam, written: Written, turn_deg: float) -> float:
    """Greatest distance of straight lines between the points from the curve [mm]."""
    theta, points = _clockwise(cam, written, turn_deg)
    probes = _between(theta)
    curve = reading(points, 0, "polyline")
    return _form(curve, _parameters(curve), probes, _true(cam, probes)).value


def _between(theta: Array) -> Array:
    after = np.append(theta[1:], theta[0] + FULL_TURN)
    return np.asarray((theta[:, None] + BETWEEN * (after - theta)[:, None]).ravel())


def _clockwise(cam: Cam, written: Written, turn_deg: float) -> tuple[Array, Array]:
    """Cam angles, increasing, and points in the frame of a ccw cam."""
    turn = -turn_deg * DEGREE
    x, y = written.points.T
    x, y = np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y
    points = np.column_stack([-x if cam.rotation == "cw" else x, y])
    theta = np.unwrap(written.theta)
    if theta[-1] < theta[0]:
        theta, points = np.roll(theta[::-1], 1), np.roll(points[::-1], 1, axis=0)
        theta = np.unwrap(theta)
    return theta, points


def _true(cam: Cam, theta: Array) -> Touched:
    at = cam.at(theta % FULL_TURN)
    x, y = cam.place(at)
    mirror = -1.0 if cam.rotation == "cw" else 1.0
    # the curve runs clockwise: its direction is the outward normal turned to the right
    return Touched(mirror * x, y, at.normal_y, -mirror * at.normal_x, at.curvature)


def _parameters(curve: Reading) -> Array:
    """Of the places where each interval is measured, in the order of the reader's own points."""
    return (curve.knots[:-1, None] + BETWEEN * np.diff(curve.knots)[:, None]).ravel()


def _measured(cam: Cam, curve: Reading, probes: Array, true: Touched) -> Fidelity:
    shift = -curve.first * len(BETWEEN)
    near = np.roll(probes, shift)
    parameter = _parameters(curve)
    (x, y), (dx, dy), (sx, sy) = (curve(parameter, order) for order in range(3))
    speed = np.hypot(dx, dy)
    bend = (dy * sx - dx * sy) / speed**3
    ridden = ride(cam, Touched(x, y, dx / speed, dy / speed, bend), near)
    form = _form(curve, parameter, near, _rolled(true, shift))
    return Fidelity(curve.reader, form, *_motion(cam, ridden), _corner(curve))


def _corner(curve: Reading) -> float:
    (ax, bx), (ay, by) = curve(curve.knots[[0, -1]], 1)
    return float(abs(np.arctan2(ax * by - ay * bx, ax * bx + ay * by)))


def _rolled(true: Touched, shift: int) -> Touched:
    each = (true.x, true.y, true.tx, true.ty, true.bend)
    return Touched(*(np.roll(values, shift) for values in each))


def _form(curve: Reading, parameter: Array, theta: Array, true: Touched) -> Worst:
    """Where the normals of the true curve meet the reader's."""
    for _ in range(ROUNDS):
        (x, y), (dx, dy) = curve(parameter), curve(parameter, 1)
        ahead = (x - true.x) * true.tx + (y - true.y) * true.ty
        parameter = parameter - ahead / (dx * true.tx + dy * true.ty)
    x, y = curve(parameter)
    return _worst((y - true.y) * true.tx - (x - true.x) * true.ty, theta)


def _motion(cam: Cam, ridden: Ridden) -> tuple[Worst, Worst]:
    true = cam.motion.derivatives(ridden.theta % FULL_TURN, 2)
    jumps = len(cam.joints.breaking(1)) > 0
    with np.errstate(invalid="ignore"):
        error = np.where(np.isfinite(ridden.a), np.abs(ridden.a - true[2]), np.inf)
    acceleration = _worst(np.full_like(error, np.inf) if jumps else error, ridden.theta)
    return _worst(ridden.v - true[1], ridden.theta), acceleration


def _worst(error: Array, theta: Array) -> Worst:
    at = int(np.argmax(np.abs(error)))
    return Worst(float(np.abs(error[at])), float(in_degrees(theta[at] % FULL_TURN)))


def _polyline(cam: Cam, curve: Reading, theta: Array, probes: Array, true: Touched) -> Fidelity:
    """A roller rolls along each line and round each corner that stands out.

    In a corner that does not stand out, as under a flat face and of a path, the velocity jumps.
    """
    form = _form(curve, _parameters(curve), probes, true)
    points, step = curve(curve.knots[:-1]), np.diff(curve(curve.knots), axis=1)
    after = np.append(theta[1:], theta[0] + FULL_TURN)
    direction = step / np.hypot(*step)
    before = np.roll(direction, 1, axis=1)
    sharp = np.arctan2(
        direction[0] * before[1] - direction[1] * before[0], np.sum(direction * before, axis=0)
    )  # to the right, where the corner stands out
    straight = np.zeros(len(theta))
    lines = [(points, direction, straight, theta), (points + step, direction, straight, after)]
    rounds = cam.gap > 0.0 and flat_face(cam.follower) is None and bool(np.all(sharp >= 0.0))
    if rounds:
        corner = np.full(len(theta), SHARP)
        lines += [(points, _turned(before, part * sharp), corner, theta) for part in CORNER]
    ridden = [
        ride(cam, Touched(at[0], at[1], along[0], along[1], bend), near)
        for at, along, bend, near in lines
    ]
    velocity, acceleration = _motion(cam, _joined(ridden))
    if not rounds:
        acceleration = Worst(float("inf"), velocity.angle_deg)
    return Fidelity("polyline", form, velocity, acceleration)


def _turned(direction: Array, angle: Array) -> Array:
    """Unit vectors (2, n) turned to the right."""
    (x, y), cos, sin = direction, np.cos(angle), np.sin(angle)
    return np.stack([x * cos + y * sin, y * cos - x * sin])


def _joined(ridden: list[Ridden]) -> Ridden:
    parts = zip(*((r.theta, r.s, r.v, r.a) for r in ridden), strict=True)
    return Ridden(*(np.concatenate(values) for values in parts))
