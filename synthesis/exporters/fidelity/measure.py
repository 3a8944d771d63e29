"""How far a curve through written points is from the cam, and what that does to the follower.

CAD systems join the points of a file by straight lines or pass a cubic spline of two continuous
derivatives through them, with the length of the chords as its parameter (Creo names it in its file,
``arclength``; de Boor; Piegl and Tiller, The NURBS Book, 9.2.1). They differ in the end conditions:

    periodic     a closed curve has no ends
    not-a-knot   the third derivative is continuous across the second and the last but one point
    natural      the curve is straight at its ends: wrong, unless the cam is

The motion of a follower on such a curve: `motion`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PPoly

from synthesis.catalogue.followers.base import flat_face
from synthesis.exporters.fidelity.motion import CurveSamples, FollowerMotion, follower_motion
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import Written, in_degrees
from synthesis.numerics.geometry.plane import to_cam
from synthesis.numerics.piecewise import Array, horner
from synthesis.units import DEGREE, FULL_TURN

Intervals = NDArray[np.intp]  # their numbers: each begins at the point of its number
ReaderName = Literal["polyline", "periodic", "not-a-knot", "natural"]
CUBIC: tuple[ReaderName, ...] = ("periodic", "not-a-knot", "natural")
# Fractions of an interval where it is measured. Of all of them first: at its point, where the
# second derivative of a cubic is greatest or least, and midway, where it is furthest from an even
# curve.
COARSE = np.array([0.0, 0.5])
# Then of the worst of them: where a joint of the motion lies within one, its errors are elsewhere.
FINE = np.array([0.0, 0.2, 0.4, 0.5, 0.6, 0.8, 1.0])
# Places of ``COARSE`` whose intervals are the worst, by each error: a joint, or the rounding of a
# point, spoils a few intervals beside it. In 190 files of worked examples none was missed.
WORST = 30
# Intervals from an end beyond which no end condition is seen: it changes the second derivatives by
# half as much at each further point, or by less, whatever their distances (the system for them is
# diagonally dominant by two), so that by then it is lost in rounding.
ENDS = 50
NEWTON_STEPS = 2  # from the same fraction of an interval to the foot of the normal
CORNER = (0.0, 0.5, 1.0)  # fractions of the rotation of the normal at a corner
SHARP = 1e12  # curvature of a corner [1/mm]


@dataclass(frozen=True)
class Deviation:
    """A greatest deviation, in the unit of what deviates, and the cam angle where it is [deg].

    None: where the velocity deviates most, as it jumps there.
    """

    value: float
    angle_deg: float | None

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
        acceleration: greatest error of the follower's s'' [mm per radian²]; infinite where the
            velocity jumps.
        find_velocity: finds that of its s' [mm per radian]; of straight lines it takes a while.
        corner: angle between the curve's two ends, whose jerk is not counted [rad].
    """

    reader: ReaderName
    form: Deviation
    acceleration: Deviation
    find_velocity: Callable[[], Deviation]
    corner: float = 0.0


@dataclass(frozen=True, eq=False)
class Interpolant:
    """One turn of the curve that a reader draws.

    Attributes:
        breaks: (m + 1,) the parameter, which is chord length, at all points that it goes through.
        polynomials: (d + 1, 2, m) between them, about the one before, highest power first.
        knots: (n + 1,) the parameter at the points, the first one's again at the end.
        first: index of the point it begins with: not 0 where some points are repeated.
    """

    breaks: Array
    polynomials: Array
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
        pieces = np.swapaxes(interpolate(knots, all_points, reader).c, 1, 2)
        return cls(knots, np.ascontiguousarray(pieces), used, first)

    def __call__(self, parameter: Array, highest: int = 0) -> Array:
        """The points and their derivatives up to this one, (highest + 1, 2, k), at parameters (k,).

        All at once: each would look for its pieces anew.
        """
        piece = np.searchsorted(self.breaks[1:-1], parameter, side="right")
        falling = self.polynomials.take(piece, axis=-1)
        return horner(falling, parameter - self.breaks[piece], highest)


def interpolate(knots: Array, values: Array, reader: ReaderName) -> PPoly:
    """A reader's interpolant of values (n,) or (n, d) at given parameters (n,)."""
    if reader == "polyline":
        slopes = (np.diff(values, axis=0).T / np.diff(knots)).T
        return PPoly(np.stack([slopes, values[:-1]]), knots)
    return CubicSpline(knots, values, bc_type=reader)


def fidelities(cam: Cam, written: Written, turn_deg: float, overlap: int) -> list[Fidelity]:
    """How true the curve of every reader of a file's points is.

    ``overlap``: how many are repeated past the first one's repetition.
    """
    theta, points = _clockwise(cam, written, turn_deg)
    every, turn = np.arange(len(points)), _round(theta)

    def errors_in(curves: Sequence[Interpolant], own: Intervals, fractions: Array) -> list[Errors]:
        """Of curves in some intervals, by the numbers that these have for them."""
        intervals = (own + curves[0].first) % len(points)
        near, number = _within(turn, intervals, fractions), np.repeat(intervals, len(fractions))
        true = _true(cam, near)
        return [
            _errors(cam, each, _within(each.knots, own, fractions), near, true, number)
            for each in curves
        ]

    # Everywhere at a few fractions; then in the worst intervals.
    closed = Interpolant.through(points, overlap, "periodic")
    (coarse,) = errors_in([closed], every, COARSE)
    worst = np.unique(np.concatenate([_worst(each) for each in coarse[:3]]))
    whole = coarse.with_others(*errors_in([closed], worst, FINE))
    found = [_polyline(cam, points, theta), _smooth("periodic", closed, whole)]
    # Away from their ends the others are the closed curve: see ENDS. They may begin elsewhere.
    others = [Interpolant.through(points, overlap, reader) for reader in CUBIC[1:]]
    ends = np.unique(np.concatenate([every[:ENDS], every[-ENDS:]]))
    at_ends = errors_in(others, ends, FINE)
    away = whole.outside((ends + others[0].first) % len(points))
    for reader, curve, own in zip(CUBIC[1:], others, at_ends, strict=True):
        found.append(_smooth(reader, curve, away.with_others(own)))
    return found


def polyline_form(cam: Cam, written: Written, turn_deg: float) -> float:
    """Greatest distance of straight lines between the points from the curve [mm]."""
    theta, points = _clockwise(cam, written, turn_deg)
    return _chords(cam, points, theta).value


def _chords(cam: Cam, points: Array, theta: Array) -> Deviation:
    """Where straight lines between the points are furthest from the curve."""
    curve, turn = Interpolant.through(points, 0, "polyline"), _round(theta)

    def form_in(intervals: Intervals, fractions: Array) -> tuple[Array, Array]:
        near = _within(turn, intervals, fractions)
        return _form(curve, _within(curve.knots, intervals, fractions), _true(cam, near)), near

    coarse = form_in(np.arange(len(points)), COARSE)
    fine = form_in(_worst(coarse[0]), FINE)
    return Deviation.of(*(np.concatenate(each) for each in zip(coarse, fine, strict=True)))


def _round(theta: Array) -> Array:
    """Cam angles (n + 1,) of a ring's points [rad], the first one's again after a turn."""
    return np.append(theta, theta[0] + FULL_TURN)


def _within(ends: Array, intervals: Intervals, fractions: Array) -> Array:
    """Values (k m,) at m fractions of k intervals between neighbours of (n + 1,) values."""
    begin = ends[intervals]
    return np.asarray((begin[:, None] + fractions * (ends[intervals + 1] - begin)[:, None]).ravel())


def _worst(errors: Array) -> Intervals:
    """The intervals of the greatest of errors at ``COARSE`` fractions of all."""
    among = min(WORST, len(errors)) - 1
    return np.unique(np.argpartition(-np.abs(errors), among)[: among + 1] // len(COARSE))


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


class Errors(NamedTuple):
    """Errors of a curve at some places, (n,) each.

    theta: cam angle of the follower there [rad]. near: that of the point of the true curve.
    interval: which one of the closed curve the place is in.
    """

    form: Array
    velocity: Array
    acceleration: Array
    theta: Array
    near: Array
    interval: Intervals

    def with_others(self, others: Errors) -> Errors:
        """These and others."""
        return Errors._make(np.concatenate(each) for each in zip(self, others, strict=True))

    def outside(self, intervals: Intervals) -> Errors:
        """Those that are in none of some intervals."""
        away = np.full(1 + int(np.max(self.interval)), True)
        away[intervals] = False
        chosen = away[self.interval]
        return Errors._make(each[chosen] for each in self)


def _errors(
    cam: Cam, curve: Interpolant, parameter: Array, near: Array, true: CurveSamples,
    interval: Intervals,
) -> Errors:  # fmt: skip
    """Of a spline: tangents and curvatures give the motion on it.

    Args:
        parameter: where. near: cam angles there, or close to them [rad], and the ``true`` curve
            at these. interval: see ``Errors``.
    """
    jet = curve(parameter, 2)
    (x, y), (dx, dy), (sx, sy) = jet
    speed = np.hypot(dx, dy)
    curvature = (dy * sx - dx * sy) / speed**3
    samples = CurveSamples(x, y, dx / speed, dy / speed, curvature)
    form = _form(curve, parameter, true, jet[:2])
    motion = _motion(cam, follower_motion(cam, samples, near))
    return Errors(form, *motion, near, interval)


def _smooth(reader: ReaderName, curve: Interpolant, errors: Errors) -> Fidelity:
    """The greatest errors of a spline."""
    (ax, bx), (ay, by) = curve(curve.knots[[0, -1]], 1)[1]
    corner = float(abs(np.arctan2(ax * by - ay * bx, ax * bx + ay * by)))
    corner = 0.0 if reader == "periodic" else corner
    form = Deviation.of(errors.form, errors.near)
    acceleration = Deviation.of(errors.acceleration, errors.theta)
    velocity = partial(Deviation.of, errors.velocity, errors.theta)
    return Fidelity(reader, form, acceleration, velocity, corner)


def _form(
    curve: Interpolant, parameter: Array, true: CurveSamples, jet: Array | None = None
) -> Array:
    """Distances along the true normals: Newton's method finds where these meet the curve.

    ``jet``: points and derivatives at the parameters, where they are known.
    """
    for step in range(NEWTON_STEPS):
        known = jet if step == 0 else None
        (x, y), (dx, dy) = curve(parameter, 1) if known is None else known
        ahead = (x - true.x) * true.tx + (y - true.y) * true.ty
        parameter = parameter - ahead / (dx * true.tx + dy * true.ty)
    ((x, y),) = curve(parameter)
    return np.asarray((y - true.y) * true.tx - (x - true.x) * true.ty)


def _motion(cam: Cam, on_curve: FollowerMotion) -> tuple[Array, Array, Array]:
    """Errors of velocity and acceleration, and the cam angles where they are.

    Where the true velocity jumps the latter is infinite.
    """
    theta = on_curve.theta
    true = cam.motion.derivatives(theta % FULL_TURN, 2)
    jumps = len(cam.joints.breaking(1)) > 0
    with np.errstate(invalid="ignore"):
        error = np.where(np.isfinite(on_curve.a), np.abs(on_curve.a - true[2]), np.inf)
    return on_curve.v - true[1], np.full_like(error, np.inf) if jumps else error, theta


def _polyline(cam: Cam, points: Array, theta: Array) -> Fidelity:
    """A roller rolls along each line and round each corner that stands out.

    In a corner that does not stand out, as under a flat face and of a path, the velocity jumps.
    """
    form = _chords(cam, points, theta)
    points = points.T
    step, after = np.roll(points, -1, axis=1) - points, _round(theta)[1:]
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

    def deviations() -> tuple[Deviation, Deviation]:
        *errors, at = _motion(cam, follower_motion(cam, samples, near))
        velocity, acceleration = (Deviation.of(each, at) for each in errors)
        return velocity, acceleration

    if rounds:
        velocity, acceleration = deviations()
        return Fidelity("polyline", form, acceleration, lambda: velocity)
    knock = Deviation(float("inf"), None)
    return Fidelity("polyline", form, knock, lambda: deviations()[0])
