"""From measured points to the follower's path: a smooth outline, and contact with it.

The outline is a smooth closed curve through the points, clockwise around the cam's axis. Each of
its points C with outward normal n belongs to one posture of the follower, in which it touches the
cam there: the traced point is at C + Rr n. So the outline gives a curve (θ, position). Where the
roller fits everywhere, θ grows along it. In a hollow too narrow for the roller θ runs back and
forth, and the follower takes the upper envelope of the curve: what lies below is never touched.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from synthesis.catalogue.followers.base import Follower, InverseKinematics
from synthesis.errors import InputError
from synthesis.numerics.periodic_spline import fit_smoothing
from synthesis.numerics.piecewise import Array, Indices, Mask
from synthesis.studies.measured.bodies import MeasuredCam, UnreachedHollow
from synthesis.units import DEGREE, FULL_TURN

MIN_POINTS: Final = 24  # fewer positions give no spline of a turn
WIDEST_GAP: Final = 6.0  # next largest steps: a wider gap means that the curve is not closed
MAX_INTERVALS: Final = 1800  # of the spline: more take long and smooth no better
SAMPLES_PER_INTERVAL: Final = 12  # of the outline
REPEATED: Final = 1e-9  # of the size: nearer points are one
BLOCK: Final = 48  # sides of the polygon that share a bounding box
FIELD: Final = "/points_mm"


@dataclass(frozen=True, eq=False)
class Outline:
    """The outline at many places: points (2, n), outward normals and signed curvature (n,).

    In the frame of a ccw cam, convex positive. ``points``: number of measured points; ``rms``,
    ``largest``: of their residuals [mm].
    """

    point: Array
    normal: Array
    bend: Array
    points: int
    rms: float
    largest: float


def outline(points: Array, tolerance: float) -> Outline:
    """The smoothest periodic spline within a tolerance of every point (n, 2) [mm].

    They are in order round the cam, in either direction, in the frame of a ccw cam.

    Raises:
        InputError: too few points, a gap, a curve that crosses itself or misses the axis, or
            points that scatter more than the tolerance.
    """
    ring = _checked_ring(points)
    # Parameter: the length of the polygon through the points, about that of the curve.
    steps = np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    intervals = int(min(max(len(ring) // 2, MIN_POINTS), MAX_INTERVALS))
    curve, residual = fit_smoothing(intervals, float(along[-1]), along[:-1], ring, tolerance)
    off = np.hypot(*residual.T)
    if np.max(off) > tolerance:
        worst = int(np.argmax(off))
        raise InputError(
            "/tolerance_mm", tolerance,
            f"The points scatter by {np.max(off):.3g} mm about a smooth curve, most at "
            f"x = {ring[worst, 0]:.6g}, y = {ring[worst, 1]:.6g} mm.",
            "Increase tolerance_mm, remove outliers, or measure more points where the curve bends.",
        )  # fmt: skip
    count = SAMPLES_PER_INTERVAL * intervals
    u = curve.period * np.arange(count) / count
    point, (tx, ty), (sx, sy) = (curve(u, order).T for order in range(3))
    speed = np.hypot(tx, ty)
    normal, bend = np.stack([-ty, tx]) / speed, (ty * sx - tx * sy) / speed**3
    rms, largest = float(np.sqrt(np.mean(off**2))), float(np.max(off))
    return Outline(point, normal, bend, len(off), rms, largest)


def _checked_ring(points: Array) -> Array:
    """The points as a clockwise ring without repetitions, checked."""
    steps = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    distinct = steps > REPEATED * float(np.max(np.abs(points)))
    ring = points[distinct]
    if len(ring) < MIN_POINTS:
        raise InputError(
            FIELD, len(ring), f"There are fewer than {MIN_POINTS} different points.",
            "Measure more points; a few hundred give a good result.",
        )  # fmt: skip
    following = np.roll(ring, -1, axis=0)
    # A gap: one step much longer than all others.
    steps = np.hypot(*(following - ring).T)
    widest, second = int(np.argmax(steps)), float(np.partition(steps, -2)[-2])
    if steps[widest] > WIDEST_GAP * second:
        ends = (*ring[widest], *following[widest])
        raise InputError(
            FIELD, round(float(steps[widest]), 6),
            "The curve is not closed: between ({:.6g}, {:.6g}) and ({:.6g}, {:.6g}) mm there is "
            "a gap this wide, and the next widest step is {:.3g} mm.".format(*ends, second),
            "Measure the whole profile.",
        )  # fmt: skip
    place = first_crossing(ring)
    if place is not None:
        raise InputError(
            FIELD, [round(float(c), 6) for c in place],
            "The curve through the points crosses itself here.",
            "Give the points in order along the profile, without overlap at the ends.",
        )  # fmt: skip
    # The winding number about the axis; its sign is the direction of the points.
    angles = np.arctan2(_cross(ring, following), np.sum(ring * following, axis=1))
    turn = float(np.sum(angles))
    if abs(turn) < np.pi:
        raise InputError(
            FIELD, [0.0, 0.0], "The cam's axis, x = y = 0, is not inside the curve.",
            "Shift the points so that the cam's axis is the origin.",
        )  # fmt: skip
    return np.asarray(ring[::-1] if turn > 0.0 else ring)


def first_crossing(ring: Array) -> tuple[float, float] | None:
    """A point where two sides of a closed polygon (n, 2) cross; None where none do.

    Blocks of sides are compared by their bounding boxes first, so that long rings are cheap.
    """
    n, ends = len(ring), np.roll(ring, -1, axis=0)
    sides = ends - ring
    firsts = np.arange(0, n, BLOCK)
    low = np.minimum.reduceat(np.minimum(ring, ends), firsts)
    high = np.maximum.reduceat(np.maximum(ring, ends), firsts)
    meet = np.all((low[:, None] <= high) & (low <= high[:, None]), axis=2)
    for a, b in np.argwhere(np.triu(meet)):
        i, j = (np.arange(k * BLOCK, min((k + 1) * BLOCK, n)) for k in (a, b))
        # p + t r = q + w s, for every side i and every side j that is not its neighbour.
        p, r = ring[i][:, None], sides[i][:, None]
        s, to = sides[j][None], ring[j][None] - p
        across = _cross(r, s)
        separation = (j[None] - i[:, None]) % n
        proper = (separation > 1) & (separation < n - 1) & (across != 0.0)
        safe = np.where(proper, across, 1.0)
        t, w = _cross(to, s) / safe, _cross(to, r) / safe
        hits = np.argwhere(proper & (t >= 0.0) & (t <= 1.0) & (w >= 0.0) & (w <= 1.0))
        if len(hits):
            k, m = hits[0]
            x, y = p[k, 0] + t[k, m] * r[k, 0]
            return float(x), float(y)
    return None


def _cross(a: Array, b: Array) -> Array:
    """z component of the cross product of vectors (…, 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


@dataclass(frozen=True, eq=False)
class FollowerPath:
    """Positions (n,) of the follower on the outline [mm], by increasing cam angle (n,) [rad].

    ``hollows``: those whose bottom it does not touch, in the order of their angles.
    """

    theta: Array
    position: Array
    hollows: list[UnreachedHollow]


def follow_outline(outline: Outline, cam: MeasuredCam) -> FollowerPath:
    """Move the follower over the outline.

    Gaps up to the cam's tolerance are ignored: they may come from the measurement.

    Raises:
        InputError: the follower does not reach the cam, or its inverse kinematics are not known.
    """
    follower = cam.follower
    if not isinstance(follower, InverseKinematics):
        raise InputError(
            "/follower/kind", follower.kind, "Profiles are not read back for this follower.",
            "Take a translating follower, or a roller on an arm.",
        )  # fmt: skip
    centre = outline.point + follower.roller_radius_mm * outline.normal
    theta, position = follower.pose(centre, outline.normal)
    lost = ~np.isfinite(theta + position)
    if lost.any():
        raise _unreachable(outline, follower, theta, lost)
    theta = np.unwrap(theta)
    if round(float(theta[-1] - theta[0]) / FULL_TURN) != 1:
        raise InputError(
            "/follower", follower.kind,
            "Along the profile the cam angle does not make one turn: a follower with this arm or "
            "offset cannot follow it.",
            "Check the follower's dimensions and the sense of rotation.",
        )  # fmt: skip
    below = _covered(theta, position)
    found = (_hollow(run, outline, theta, position, cam) for run in cyclic_runs(below))
    hollows = [hollow for hollow in found if hollow.gap_mm > cam.tolerance_mm]
    wrapped, height = np.mod(theta[~below], FULL_TURN), position[~below]
    order = np.argsort(wrapped, kind="stable")
    in_order = sorted(hollows, key=lambda hollow: hollow.angle_deg)
    return FollowerPath(wrapped[order], height[order], in_order)


def _unreachable(outline: Outline, follower: Follower, theta: Array, lost: Mask) -> InputError:
    """The error that names the cam angles at which the follower does not reach the profile."""
    x, y = outline.point[:, int(np.argmax(lost))]
    where = "at no cam angle does it touch the profile"
    if not lost.all():
        run = max(cyclic_runs(lost), key=len)
        ends = theta[[run[0] - 1, (run[-1] + 1) % len(theta)]]
        first, last = np.degrees(np.mod(ends, FULL_TURN))
        x, y = outline.point[:, run[len(run) // 2]]
        where = f"between cam angles {first:.4g}° and {last:.4g}° the profile is out of its reach"
    return InputError(
        "/follower", follower.kind,
        f"The follower does not reach the cam: {where}. It cannot touch x = {x:.6g}, "
        f"y = {y:.6g} mm.",
        "Check its dimensions, and that the points' origin is the cam's axis.",
    )  # fmt: skip


def _covered(theta: Array, position: Array) -> Mask:
    """(n,) which postures are below the upper envelope: another part of the cam prevents them."""
    # stretches of the closed curve (θ, position) along which θ runs one way, at the points' angles
    angle, height = np.append(theta, theta[0] + FULL_TURN), np.append(position, position[0])
    back = np.diff(angle) < 0.0
    highest = np.full(len(theta), -np.inf)
    for first, last in pairwise([0, *np.flatnonzero(back[1:] != back[:-1]) + 1, len(theta)]):
        way = -1 if back[first] else 1
        stretch = angle[first : last + 1][::way], height[first : last + 1][::way]
        for turn in (-FULL_TURN, 0.0, FULL_TURN):
            there = np.interp(theta + turn, *stretch, left=-np.inf, right=-np.inf)
            highest = np.maximum(highest, there)
    return np.asarray(highest > position)


def cyclic_runs(mask: Mask) -> list[Indices]:
    """Indices of each cyclic run of True."""
    if mask.all():
        return [np.arange(len(mask))]
    starts = np.flatnonzero(mask & ~np.roll(mask, 1)).tolist()
    lengths = [int(np.argmin(np.roll(mask, -start))) for start in starts]
    return [(a + np.arange(n)) % len(mask) for a, n in zip(starts, lengths, strict=True)]


def _hollow(
    run: Indices, outline: Outline, theta: Array, position: Array, cam: MeasuredCam
) -> UnreachedHollow:
    """The hollow between two points of contact, at the indices of a run.

    The follower touches both sides of it at the intersection of the tangents to the two branches,
    between the last points touched.
    """
    n, follower = len(theta), cam.follower
    one, two = (run[0] - 1) % n, (run[-1] + 1) % n
    before, after = (one - 1) % n, (two + 1) % n
    gap = math.remainder(float(theta[two] - theta[one]), FULL_TURN)
    back, on = _step(theta[one] - theta[before]), _step(theta[after] - theta[two])
    rising = (position[one] - position[before]) / back
    falling = (position[after] - position[two]) / on
    share = 0.5 * gap
    if rising != falling:
        share = (position[two] - position[one] - falling * gap) / (rising - falling)
    share = min(max(share, 0.0), gap)
    angle = float(theta[one] + share)
    # The centre of the follower there, along the tangent of its path.
    centres = outline.point + follower.roller_radius_mm * outline.normal
    last, previous = centres[:, one], centres[:, before]
    centre = last + share * (last - previous) / back
    up = np.array([math.sin(angle), math.cos(angle)])
    assert isinstance(follower, InverseKinematics)
    inward = follower.clearance(outline.point[:, run] - centre[:, None], up)
    deepest = int(np.argmax(inward))
    bend = float(np.min(outline.bend[run]))
    x, y = outline.point[:, run[deepest]]
    return UnreachedHollow(
        angle_deg=angle % FULL_TURN / DEGREE,
        hollow_radius_mm=-1.0 / bend if bend < 0.0 else None,
        roller_radius_mm=follower.roller_radius_mm,
        gap_mm=float(inward[deepest]),
        x_mm=cam.mirror * float(x),
        y_mm=float(y),
    )


def _step(angle: float) -> float:
    """The angle between neighbouring points, within ±180° and not zero."""
    return math.remainder(angle, FULL_TURN) or 1e-300
