"""Half-planes of the size that every motion law keeps, whether its derivatives are capped or not.

Two theorems, of every law that is continuously differentiable, the second of those with an s'' that
can be integrated:

**How long a move takes.** Pressure angle and velocity limit how fast a follower may be at each
height: s' ≤ F(s; z), z the size. So a move from a to b takes a least angle

    T(z) = ∫ ds / F(s; z) over all heights between a and b,

and no cam has T(z) > β, the move's angle. For the law passes each height upwards at least once, be
it one that turns back, and the angles at which it rises come to ∫ s'/F(s) dθ ≥ T (area formula).
Where F ≤ 0 nothing passes, and T is infinite. Of a return −s rises.
The integral is bounded from below cell by cell: the mean of 1/F over a cell is no less than 1 over
the mean of F (Jensen), and that is at most the value in the middle and what F may bend up by. F is
the least of functions that are linear in z; so 1/F and that sum are convex, and where the sum is
above β at a size, all cams lie on one side of its tangent there: a half-plane of the size. Under an
arm whose pivot is given F is a function of s + z that rises, then falls; there
T' = 1/F(b + z) − 1/F(a + z), so that T falls, then rises, and one end of z is bounded.

**How it comes to rest.** Under a flat face the radius of curvature reads a s'' + b s ≥ c(z), c
linear. With ω² = b/a and the weight λ = sin ω(θ − θ0) ≥ 0 over a move of ωβ ≤ π, two integrations
by parts leave the motion's values at its ends alone:

    a [λ s' − λ' s] = ∫ λ (a s'' + b s) dθ ≥ c(z) ∫ λ dθ,

where s' counts at the far end, at which it is known: a half-plane. Mirrored, at the near one.
Under a face that swings the profile's support function h takes the place of s, and the angle of its
normal on the cam that of θ, which comes to β + σ Δφ over a move, whatever the law: a half-plane of
d cos ψ0 and d sin ψ0 (``catalogue/followers/swinging_face.py``).

Where nothing else binds, the least size on these half-planes is the infimum over all laws: laws
that run along F, or along the least radius, but for short ramps, come as near to it as one likes,
and none reaches it. (Cams of such laws: ``heuristics/extremal_laws.py``.)

A least distance of the pivot leaves the outside of a circle of d cos ψ0 and d sin ψ0. The base
radius, which is linear, is least there at a corner of the half-planes or where a line meets the
circle: inside a line's piece it falls to one end, and on the circle it has smaller values outside
beside every point but the lowest, below which there is the outside again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import cos, inf, pi, sin, sqrt

import numpy as np

from synthesis.catalogue.constraints import AffineNorm, NormBounds, Vector
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.semi_infinite import HalfPlanes, join
from synthesis.optimise.problem.boundary import boundary_states
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.closed_form import ImpliedHalfPlanes, closed_form_size

CELLS = 200
"""Of the heights of a move. The midpoint rule's error falls with the square of their width."""
LOOSENING = 1e-9  # relative: far above the rounding of a sum of as many terms
LONGER = 1e-7  # relative: a duration no longer than that beyond the move's angle is as long
HALVINGS = 40  # of an interval of sizes
ROUNDING = 1e-12  # relative: of the value of a closed form
EVERY_LAW = "every motion law, whatever its derivatives"  # what a bound from these holds for
STEP = 1e-20  # of a derivative along an imaginary step, which is exact to rounding


def least_size(problem: Problem, norm: AffineNorm | None = None) -> Vector | None:
    """The size of the least norm on these half-planes and on those of given laws; None: no size.

    ``norm``: what is least; None: the prime radius. No cam has a smaller one.
    """
    size = _least(problem, norm)
    if size is None or norm is not None or len(problem.machine.follower.radius_norm().matrix) > 1:
        return size
    # A least distance of the pivot is not convex: the least size outside its circle.
    lower = (replace(each, lower=each.lower * (1.0 - LOOSENING)) for each in problem.least_norms)
    broken = [each for each in lower if each.norm.value(size) < each.lower]
    if not broken:
        return size
    return _least(problem, None, broken) or size


def least_along(problem: Problem, row: Vector, circle: NormBounds) -> float:
    """What row · z is no less than on all sizes that fit the laws and lie outside a circle.

    Args:
        row: of a problem with two size variables. circle: a norm of two rows, no less than its
            lower end.

    Returns:
        that value; −∞ where none is known.
    """
    lower = replace(circle, lower=circle.lower * (1.0 - LOOSENING))
    corner = _least(problem, AffineNorm((row,), (0.0,)), [lower])
    return -inf if corner is None else sum(a * b for a, b in zip(row, corner, strict=True))


def _least(
    problem: Problem, norm: AffineNorm | None, outside: Sequence[NormBounds] = ()
) -> Vector | None:
    """The size of the least norm on the half-planes of all laws, outside of these circles."""
    # laws that are known, but neither chosen by a search nor smoothed from a table
    known = (s for s in problem.segments if s.law is not None)
    given = tuple(s for s in known if s.free is None and s.table is None)
    return closed_form_size(
        replace(problem, segments=given), norm=norm, slack=LOOSENING * problem.length,
        implied=half_planes_of_free_laws(problem), outside=outside,
    )  # fmt: skip


def size_conflict(problem: Problem) -> str:
    """Why no size fits all laws, whatever the free ones are; empty where one may.

    Every limit on a known motion is a half-plane of the size, or several, and so is the least
    duration of a move. If these have no common point, or none within a cone of the size, no law
    mends it: the nearest point to the cone's axis lies outside. They are moved out by more than
    rounding. Ends of the search alone are no limits: the cones of a size that is open above, and
    the ranges of an open pivot.
    """
    if problem.machine.follower.fixable_dimension() is not None and problem.open_above:
        return ""
    which = "the motion, whatever the free laws are," if problem.free else "the given laws"
    if least_size(problem) is None:
        return f"proven: no size fits {which} under these limits"
    for cone in problem.norm_bounds if not problem.open_above else ():
        rows, columns = np.shape(cone.norm.matrix)
        if rows > 1 and (rows != columns or np.linalg.matrix_rank(cone.norm.matrix) < rows):
            continue  # nearest in such a norm is no corner of the polygon
        nearest = least_size(problem, cone.norm)
        if nearest is None or cone.norm.value(nearest) > cone.upper + LOOSENING * problem.length:
            name = cone.source.replace("_", " ")
            return f"proven: no size fits {which} and {name} together"
    return ""


def half_planes_of_free_laws(problem: Problem) -> ImpliedHalfPlanes:
    """Those that the free laws of a problem imply, as a function of the size about which they are.

    At their ends too, where velocities are known.
    """
    grids = [uniform_grid(segment, 1) for segment in problem.free]
    states, _ = boundary_states(problem.segments, grids)
    fixed = list[HalfPlanes]()
    for segment, state in zip(problem.free, states, strict=True):
        rate = segment.scale / segment.angle
        ends = [known[1] * rate if len(known) > 1 else None for known in (state.start, state.end)]
        for height, speed in zip((segment.s_start, segment.s_end), ends, strict=True):
            if speed is not None:
                fixed += _at_state(problem, segment, np.array([height, speed, 0.0, 0.0]))
        fixed += _at_rest(problem, segment, ends)
    return partial(_half_planes, problem, fixed)


def _half_planes(problem: Problem, fixed: list[HalfPlanes], z: Vector) -> HalfPlanes:
    """All of them, with what a size exceeds each by."""
    size = np.array(z)
    moves = [plane for segment in problem.free for plane in _half_plane(problem, segment, size)]
    every = join([*fixed, *moves], len(z))
    return every._replace(excess=every.normals @ size - every.offsets)


def _at_state(problem: Problem, segment: PlacedSegment, s: Array) -> Iterator[HalfPlanes]:
    """What limits say of the size where motion and velocity are known: (4,) s to s'''."""
    for row in problem.limit_rows(segment):
        if any(row.size) and row.interval is None and set(row.orders) <= {0, 1}:
            yield _scaled(np.array([row.size]), np.array([row.upper - np.dot(row.coefficients, s)]))
    for curve in problem.curved_limits_on(segment):
        if curve.order <= 1:
            for planes in curve.half_planes(s[:, None]):
                yield _scaled(planes.size.T, planes.upper)


def _at_rest(
    problem: Problem, segment: PlacedSegment, speeds: Sequence[float | None]
) -> Iterator[HalfPlanes]:
    """Half-planes that a radius of curvature under a flat face leaves over a whole move.

    Of rows c s'' + d s + size · z ≤ upper, c and d negative; of faces that swing by a theorem of
    their own. ``speeds``: at its ends [length/rad], where known.
    """
    start, end = (
        np.array([height, np.nan if speed is None else speed])
        for height, speed in zip((segment.s_start, segment.s_end), speeds, strict=True)
    )
    for curve in problem.curved_limits_on(segment):
        for planes in curve.half_planes_over_move(segment.angle, start, end):
            slack = LOOSENING * (np.abs(planes.upper) + problem.length)
            yield _scaled(planes.size.T, planes.upper + slack)
    for row in problem.limit_rows(segment):
        (d, c), by_size = row.coefficients[:3:2], np.array(row.size)
        if row.interval is not None or set(row.orders) != {0, 2} or max(c, d) >= 0.0:
            continue
        omega = sqrt(d / c)
        sine, cosine = sin(omega * segment.angle), cos(omega * segment.angle)
        if omega * segment.angle > pi or not any(row.size):
            continue
        integral = (1.0 - cosine) / omega  # of the weight, over the move
        for far, near, speed in (
            (segment.s_end, segment.s_start, speeds[1]),
            (segment.s_start, segment.s_end, None if speeds[0] is None else -speeds[0]),
        ):
            if speed is not None:
                terms = -c * (sine * speed - omega * (cosine * far - near))  # of the ends
                upper = row.upper * integral + terms
                loose = LOOSENING * (abs(row.upper) * integral + abs(c) * problem.length)
                yield _scaled(integral * by_size[None], np.array([upper + loose]))


def _half_plane(problem: Problem, segment: PlacedSegment, size: Array) -> Iterator[HalfPlanes]:
    """What the least duration of a move says about a size; nothing where it is infinite there."""
    duration, gradient = _least_duration(problem, segment, size)
    if not segment.angle * (1.0 + LONGER) < duration < inf or not np.any(gradient):
        return
    if len(size) > 1:
        # The tangent: T(z0) + ∇T · (z − z0) ≤ T(z) ≤ β.
        loose = LOOSENING * (segment.angle + duration + np.abs(gradient) @ np.abs(size))
        yield _scaled(
            gradient[None], np.array([segment.angle - duration + gradient @ size + loose])
        )
        return
    # One size: T falls, then rises. As long as T > β falls towards one side, all sizes on the other
    # side are excluded; where it rises again above β, all: two half-planes without a common point.
    side, (low, high) = -_sense_of_duration(problem, segment, size), problem.sizing.bounds[0]
    if not side:
        return
    excluded, unknown, rises = float(size[0]), low if side < 0.0 else high, False
    for _ in range(HALVINGS):
        middle = 0.5 * (excluded + unknown)
        here = np.array([middle])
        exceeds = _least_duration(problem, segment, here)[0] > segment.angle * (1.0 + LOOSENING)
        falls = _sense_of_duration(problem, segment, here) * side < 0.0
        excluded, unknown = (middle, unknown) if exceeds and falls else (excluded, middle)
        rises = rises if exceeds and falls else exceeds
    yield HalfPlanes(np.array([[-side]]), np.array([-side * excluded]), np.zeros(1))
    if rises:
        yield HalfPlanes(np.array([[side]]), np.array([side * excluded - 1.0]), np.zeros(1))


def _sense_of_duration(problem: Problem, segment: PlacedSegment, size: Array) -> float:
    """The sign of T' = 1/F(b + z) − 1/F(a + z), of one size; 0 where a speed is not positive."""
    heights = np.sort([segment.s_start, segment.s_end])
    found = _fastest(problem, segment, heights, float(np.sign(segment.lift)), size)
    low, high = np.min([speed for speed, _, _ in found], axis=0)
    return float(np.sign(low - high)) if min(low, high) > 0.0 else 0.0


def _least_duration(problem: Problem, segment: PlacedSegment, size: Array) -> tuple[float, Array]:
    """T from below at a size, and its gradient; infinite where a height cannot be passed."""
    width, sense = abs(segment.lift) / CELLS, np.sign(segment.lift)
    edges = np.linspace(segment.s_start, segment.s_end, CELLS + 1)
    fastest = list(_fastest(problem, segment, 0.5 * (edges[1:] + edges[:-1]), sense, size))
    if not fastest or not segment.lift:
        return 0.0, np.zeros(len(size))
    means = [speed + width**2 / 24.0 * curvature for speed, _, curvature in fastest]
    speeds = np.array(means)  # of each limit over a cell, at most
    slopes = np.array([slope for _, slope, _ in fastest])
    lowest, cell = np.argmin(speeds, axis=0), np.arange(CELLS)
    speed, slope = speeds[lowest, cell], slopes[lowest, :, cell]
    if np.any(speed <= 0.0):
        return inf, np.zeros(len(size))
    return float(np.sum(width / speed)), -width * (1.0 / speed**2) @ slope


def _fastest(
    problem: Problem, segment: PlacedSegment, heights: Array, sense: float, size: Array
) -> Iterator[tuple[Array, Array, float]]:
    """The largest speed F that each limit allows at heights: (n,), ∂F/∂z (d, n), most ∂²F/∂s²."""
    for row in problem.limit_rows(segment):
        of_height, of_speed = row.coefficients[:2]
        if row.interval is not None or not set(row.orders) <= {0, 1} or sense * of_speed <= 0.0:
            continue
        by_size = np.array(row.size or (0.0,) * len(size))
        left = row.upper - of_height * heights - by_size @ size
        slope = np.repeat(-by_size[:, None] / abs(of_speed), len(heights), axis=1)
        yield left / abs(of_speed), slope, 0.0
    for curve in problem.curved_limits_on(segment):
        if not curve.speed_curvatures:
            continue
        # affine in s': the difference of two values is its factor
        still, moving = (np.stack([heights, x + 0.0 * heights]) for x in (0.0, 1.0))
        at_rest = curve.excess(still, tuple(size))
        factors = [b - a for a, b in zip(at_rest, curve.excess(moving, tuple(size)), strict=True)]
        changes = [
            np.imag(curve.excess(still, tuple(size + 1j * STEP * unit))) / STEP
            for unit in np.eye(len(size))
        ]
        each = zip(at_rest, factors, curve.speed_curvatures, strict=True)
        for k, (value, factor, curvature) in enumerate(each):
            if np.all(sense * factor > 0.0):
                slope = np.array([one[k] for one in changes])
                yield -value / np.abs(factor), -slope / np.abs(factor), curvature


def _scaled(normals: Array, offsets: Array) -> HalfPlanes:
    """Half-planes with normals of length one; those without a normal are left out."""
    length = np.linalg.norm(normals, axis=1)
    known = length > 0.0
    normals, offsets = normals[known] / length[known, None], offsets[known] / length[known]
    return HalfPlanes(normals, offsets, np.zeros(len(offsets)))
