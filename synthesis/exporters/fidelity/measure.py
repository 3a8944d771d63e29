"""How far a curve through written points is from the cam, and what that does to the follower.

CAD systems join the points of a file by straight lines or pass a cubic spline of two continuous
derivatives through them, with the length of the chords as its parameter (Creo names it in its file,
``arclength``; de Boor; Piegl and Tiller, The NURBS Book, 9.2.1). They differ in the end conditions:

    periodic     a closed curve has no ends
    not-a-knot   the third derivative is continuous across the second and the last but one point
    natural      the curve is straight at its ends: wrong, unless the cam is

At each sample Q of such a curve, with unit tangent T and curvature κ, the follower touches it. From
these alone follow, one after the other, in the frame of a ccw cam:

    cam angle θ and displacement s    the follower's point, turned into the cam, lies on the curve
    velocity s'                       its path on the cam runs along T
    acceleration s''                  and has the curvature κ

which is exact: no difference is taken of positions. A roller's centre runs along p = Q + g n, g the
gap between the curves, n the normal to the left of T, and p has the curvature κ / (1 + g κ). Where
1 + g κ is not positive the roller does not fit the hollow, knocks from one side of it to the other,
and the acceleration is infinite. Under a flat face θ, s and s' follow from point and normal
together, and the radius of curvature gives s''. The cam's own formulas are used in one direction
only, from motion to path (``position``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline

from synthesis.catalogue.followers.base import flat_face
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import Written, in_degrees
from synthesis.numerics.geometry.plane import to_cam
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

MAX_ITERATIONS = 12  # of Newton's method, from the neighbourhood of the answer
TOLERANCE = 1e-12  # of its last step, relative to the cam's size
STEP = 1e-6  # of its difference quotients, relative to the cam's size


class CurveSamples(NamedTuple):
    """A curve in the frame of a ccw cam, in the order of rising cam angle, clockwise; (n,) each.

    x, y: points [mm]. tx, ty: unit tangents. curvature: convex positive [1/mm].
    """

    x: Array
    y: Array
    tx: Array
    ty: Array
    curvature: Array


class FollowerMotion(NamedTuple):
    """The follower's motion, sample by sample: cam angle [rad], s, s', s'' [mm, per radian], (n,).

    s'' is infinite where the roller does not reach the curve.
    """

    theta: Array
    s: Array
    v: Array
    a: Array


def follower_motion(cam: Cam, curve: CurveSamples, near: Array) -> FollowerMotion:
    """The motion on a curve that nearly is the cam's; ``near``: (n,) cam angles nearby [rad]."""
    gap = cam.gap
    shrunk = 1.0 + gap * curve.curvature
    with np.errstate(divide="ignore", invalid="ignore"):
        curvature = np.where(shrunk > 0.0, curve.curvature / shrunk, np.nan)
    x, y = curve.x - gap * curve.ty, curve.y + gap * curve.tx
    path = CurveSamples(x, y, curve.tx, curve.ty, curvature)
    with_face = flat_face(cam.follower) is not None
    return (_face_motion if with_face else _roller_motion)(cam, path, near)


def _point(cam: Cam, s: Any, v: Any, a: Any) -> Any:
    """The traced point, its first and second derivative at motions s, s', s'' with s''' = 0."""
    zero = 0.0 * s
    return cam.flank.trace.position((s, v + zero, a + zero, zero), cam.size)


def _roller_motion(cam: Cam, path: CurveSamples, near: Array) -> FollowerMotion:
    theta, s = near, cam.motion.derivatives(near, 0)[0]
    # Newton's method in θ and s: R(−θ) of the path's point is the traced point p(s)
    for _ in range(MAX_ITERATIONS):
        x, y = to_cam(-theta, path.x, path.y)
        (px, py), (ax, ay), *_ = _point(cam, s, 1.0, 0.0)
        bx, by = py, -px  # J p
        det = bx * ay - by * ax
        rx, ry = x - px, y - py
        turn = (rx * ay - ry * ax) / det
        theta, s = theta + turn, s + (bx * ry - by * rx) / det
        if np.max(np.abs(turn)) < TOLERANCE:
            break
    tx, ty = to_cam(-theta, path.tx, path.ty)
    (px, py), (ax, ay), *_ = _point(cam, s, 1.0, 0.0)
    v = -(py * ty + px * tx) / (ax * ty - ay * tx)
    # The path's curvature is linear in s'': its values at 0 and 1 give the s'' of any other.
    at = []
    for a in (0.0, 1.0):
        (px, py), (dx, dy), (ax, ay), *_ = _point(cam, s, v, a)
        tx, ty = dx + py, dy - px
        sx, sy = ax + dy + ty, ay - dx - tx
        at.append((ty * sx - tx * sy) / np.hypot(tx, ty) ** 3)
    a = (path.curvature - at[0]) / (at[1] - at[0])
    return FollowerMotion(theta, s, v, np.where(np.isnan(path.curvature), np.inf, a))


def _face_motion(cam: Cam, path: CurveSamples, near: Array) -> FollowerMotion:
    trace, z = cam.flank.trace, cam.size
    size = float(np.max(np.hypot(path.x, path.y)))
    motion = np.stack([near, *cam.motion.derivatives(near, 1)])

    def residual(motion: Array) -> Array:
        """(3, n) how far contact and normal lie from the curve's, all as the machine sees it."""
        theta, s, v = motion
        (px, py), *_ = _point(cam, s, v, 0.0)
        nx, ny = trace.normal((path.tx, path.ty), (s, v, 0.0 * s, 0.0 * s), z)
        (x, y), (tx, ty) = to_cam(-theta, path.x, path.y), to_cam(-theta, path.tx, path.ty)
        return np.stack([px - x, py - y, size * (nx * tx + ny * ty)])

    # Newton's method in θ, s and s', its Jacobian by difference quotients
    scales = np.array([1.0, size, size])
    steps = STEP * np.diag(scales)[:, :, None]
    for _ in range(MAX_ITERATIONS):
        at = residual(motion)
        jacobian = np.stack([residual(motion + step) - at for step in steps], axis=1)
        solved = np.linalg.solve(np.moveaxis(jacobian, -1, 0), at.T[:, :, None])[:, :, 0].T
        turn = scales[:, None] * STEP * solved
        motion = motion - turn
        if np.max(np.abs(turn) / scales[:, None]) < TOLERANCE:
            break
    theta, s, v = motion
    (tx, ty), zero = to_cam(-theta, path.tx, path.ty), 0.0 * s
    face = flat_face(trace)
    assert face is not None
    # The contact runs along the curve at the rate of its normal over κ, which is linear in s''.
    wx, wy = face.face_normal_rate((s, v, zero, zero), z)
    along = []
    for a in (0.0, 1.0):
        (px, py), (dx, dy), *_ = _point(cam, s, v, a)
        along.append((dx + py) * tx + (dy - px) * ty)
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.where(path.curvature > 0.0, (wx * tx + wy * ty) / path.curvature, np.inf)
    return FollowerMotion(theta, s, v, (rate - along[0]) / (along[1] - along[0]))


ReaderName = Literal["polyline", "periodic", "not-a-knot", "natural"]
CUBIC: tuple[ReaderName, ...] = ("periodic", "not-a-knot", "natural")
BETWEEN = np.array([0.0, 0.2, 0.4, 0.5, 0.6, 0.8, 1.0])  # of each interval, where it is measured
NEWTON_STEPS = 2  # from the same fraction of an interval to the foot of the normal
CORNER = (0.0, 0.5, 1.0)  # fractions of the rotation of the normal at a corner
SHARP = 1e12  # curvature of a corner [1/mm]


@dataclass(frozen=True)
class Deviation:
    """A greatest deviation, in the unit of what deviates, and the cam angle where it is [deg]."""

    value: float
    angle_deg: float

    @classmethod
    def of(cls, error: Array, theta: Array) -> Deviation:
        """The greatest of errors (n,) at cam angles (n,) [rad]."""
        at = int(np.argmax(np.abs(error)))
        return cls(float(np.abs(error[at])), float(in_degrees(theta[at] % FULL_TURN)))


@dataclass(frozen=True)
class Fidelity:
    """How true a reader's curve is.

    Attributes:
        reader: how it draws the curve.
        form: greatest distance of the curve from the true one, along its normal [mm].
        velocity, acceleration: greatest error of the follower's s' and s'' [mm per radian];
            infinite where the velocity jumps.
        corner: angle between the curve's two ends, whose jerk is not counted [rad].
    """

    reader: ReaderName
    form: Deviation
    velocity: Deviation
    acceleration: Deviation
    corner: float = 0.0


@dataclass(frozen=True, eq=False)
class Interpolant:
    """One turn of the curve that a reader draws.

    Attributes:
        spline: chord length to points and their derivatives.
        knots: (n + 1,) the parameter at the points, the first one's again at the end.
        first: index of the point it begins with: not 0 where some points are repeated.
    """

    spline: CubicSpline | BSpline
    knots: Array
    first: int

    @classmethod
    def through(cls, points: Array, repeated: int, reader: ReaderName) -> Interpolant:
        """The curve through points (n, 2) of a ring [mm].

        ``repeated``: how many more there are past the first point's repetition. A curve that is not
        closed is used from the middle of these on: its ends are away from both sides.
        """
        if reader == "periodic":
            repeated = 0
        all_points = np.vstack([points, points[: repeated + 1]])
        steps = np.hypot(*np.diff(all_points, axis=0).T)
        knots = np.concatenate([[0.0], np.cumsum(steps)])
        first = repeated // 2
        used = knots[first : first + len(points) + 1]
        return cls(interpolate(knots, all_points, reader), used, first)

    def __call__(self, parameter: Array, order: int = 0) -> Array:
        """The points (2, k), or a derivative of them, at parameters (k,)."""
        return np.asarray(self.spline(parameter, order), dtype=float).T

    @property
    def probes(self) -> Array:
        """Parameters at which each interval is measured, from its first point on."""
        return (self.knots[:-1, None] + BETWEEN * np.diff(self.knots)[:, None]).ravel()


def interpolate(knots: Array, values: Array, reader: ReaderName) -> CubicSpline | BSpline:
    """A reader's interpolant of values (n,) or (n, d) at given parameters (n,)."""
    if reader == "polyline":
        return make_interp_spline(knots, values, k=1)
    return CubicSpline(knots, values, bc_type=reader)


def fidelities(cam: Cam, written: Written, turn_deg: float, overlap: int) -> list[Fidelity]:
    """How true the curve of every reader of a file's points is.

    ``overlap``: how many are repeated past the first one's repetition.
    """
    theta, points = _clockwise(cam, written, turn_deg)
    probes = _between(theta)
    true = _true(cam, probes)
    curves = [(reader, Interpolant.through(points, overlap, reader)) for reader in CUBIC]
    return [
        _polyline(cam, Interpolant.through(points, 0, "polyline"), theta, probes, true),
        *(_smooth(cam, reader, curve, probes, true) for reader, curve in curves),
    ]


def polyline_form(cam: Cam, written: Written, turn_deg: float) -> float:
    """Greatest distance of straight lines between the points from the curve [mm]."""
    theta, points = _clockwise(cam, written, turn_deg)
    probes = _between(theta)
    curve = Interpolant.through(points, 0, "polyline")
    return _form(curve, curve.probes, probes, _true(cam, probes)).value


def _between(theta: Array) -> Array:
    after = np.append(theta[1:], theta[0] + FULL_TURN)
    return np.asarray((theta[:, None] + BETWEEN * (after - theta)[:, None]).ravel())


def _clockwise(cam: Cam, written: Written, turn_deg: float) -> tuple[Array, Array]:
    """Cam angles, increasing, and points in the frame of a ccw cam."""
    x, y = to_cam(np.asarray(turn_deg * DEGREE), *written.points.T)
    points = np.column_stack([-x if cam.rotation == "cw" else x, y])
    theta = np.unwrap(written.theta)
    if theta[-1] < theta[0]:
        theta, points = np.roll(theta[::-1], 1), np.roll(points[::-1], 1, axis=0)
        theta = np.unwrap(theta)
    return theta, points


def _true(cam: Cam, theta: Array) -> CurveSamples:
    at = cam.at(theta % FULL_TURN)
    x, y = cam.place(at)
    mirror = -1.0 if cam.rotation == "cw" else 1.0
    # the curve runs clockwise: its direction is the outward normal turned to the right
    return CurveSamples(mirror * x, y, at.normal_y, -mirror * at.normal_x, at.curvature)


def _smooth(
    cam: Cam, reader: ReaderName, curve: Interpolant, probes: Array, true: CurveSamples
) -> Fidelity:
    """Of a spline: its tangents and curvatures give the follower's motion on it."""
    shift = -curve.first * len(BETWEEN)
    near, parameter = np.roll(probes, shift), curve.probes
    (x, y), (dx, dy), (sx, sy) = (curve(parameter, order) for order in range(3))
    speed = np.hypot(dx, dy)
    curvature = (dy * sx - dx * sy) / speed**3
    samples = CurveSamples(x, y, dx / speed, dy / speed, curvature)
    rolled = CurveSamples(*np.roll(true, shift, axis=1))
    form = _form(curve, parameter, near, rolled)
    (ax, bx), (ay, by) = curve(curve.knots[[0, -1]], 1)
    corner = float(abs(np.arctan2(ax * by - ay * bx, ax * bx + ay * by)))
    return Fidelity(reader, form, *_motion(cam, follower_motion(cam, samples, near)), corner)


def _form(curve: Interpolant, parameter: Array, theta: Array, true: CurveSamples) -> Deviation:
    """Distances along the true normals: Newton's method finds where these meet the curve."""
    for _ in range(NEWTON_STEPS):
        (x, y), (dx, dy) = curve(parameter), curve(parameter, 1)
        ahead = (x - true.x) * true.tx + (y - true.y) * true.ty
        parameter = parameter - ahead / (dx * true.tx + dy * true.ty)
    x, y = curve(parameter)
    return Deviation.of((y - true.y) * true.tx - (x - true.x) * true.ty, theta)


def _motion(cam: Cam, on_curve: FollowerMotion) -> tuple[Deviation, Deviation]:
    """Errors of velocity and acceleration; where the true velocity jumps the latter is infinite."""
    theta = on_curve.theta
    true = cam.motion.derivatives(theta % FULL_TURN, 2)
    jumps = len(cam.joints.breaking(1)) > 0
    with np.errstate(invalid="ignore"):
        error = np.where(np.isfinite(on_curve.a), np.abs(on_curve.a - true[2]), np.inf)
    acceleration = Deviation.of(np.full_like(error, np.inf) if jumps else error, theta)
    return Deviation.of(on_curve.v - true[1], theta), acceleration


def _polyline(
    cam: Cam, curve: Interpolant, theta: Array, probes: Array, true: CurveSamples
) -> Fidelity:
    """A roller rolls along each line and round each corner that stands out.

    In a corner that does not stand out, as under a flat face and of a path, the velocity jumps.
    """
    form = _form(curve, curve.probes, probes, true)
    points, step = curve(curve.knots[:-1]), np.diff(curve(curve.knots), axis=1)
    after = np.append(theta[1:], theta[0] + FULL_TURN)
    direction = step / np.hypot(*step)
    before = np.roll(direction, 1, axis=1)
    sharp = np.arctan2(
        direction[0] * before[1] - direction[1] * before[0], np.sum(direction * before, axis=0)
    )  # to the right, where the corner stands out
    straight = np.zeros(len(theta))
    # samples: both ends of every line, and round corners a vertex with its tangent turning
    parts = [(points, direction, straight, theta), (points + step, direction, straight, after)]
    rounds = cam.gap > 0.0 and flat_face(cam.follower) is None and bool(np.all(sharp >= 0.0))
    if rounds:
        corner = np.full(len(theta), SHARP)
        # a direction is turned to the right as into a cam
        turned = (np.stack(to_cam(part * sharp, *before)) for part in CORNER)
        parts += [(points, tangent, corner, theta) for tangent in turned]
    (x, y), (tx, ty), curvature, near = (
        np.concatenate(each, axis=-1) for each in zip(*parts, strict=True)
    )
    samples = CurveSamples(x, y, tx, ty, curvature)
    velocity, acceleration = _motion(cam, follower_motion(cam, samples, near))
    if not rounds:
        acceleration = Deviation(float("inf"), velocity.angle_deg)
    return Fidelity("polyline", form, velocity, acceleration)
