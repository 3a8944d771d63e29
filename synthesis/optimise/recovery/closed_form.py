"""The smallest cam for given laws, in closed form: the point of a polygon nearest to the axis.

With the laws given, every row is a half-plane of the size variables, one or two; its worst cam
angle is known. For pressure angle alone this is the apex of two half-planes, of
rise and return, or a point on one of them where another side binds. A curved limit has a half-plane
at every cam angle: those that the answer breaks are added until there is none.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from synthesis.catalogue.constraints import AffineNorm, NormBounds
from synthesis.numerics.double_double import round_mantissa
from synthesis.numerics.maxima import maximise
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.semi_infinite import HalfPlanes, join, most_violated
from synthesis.optimise.problem.problem import Problem

Vector = tuple[float, ...]
ImpliedHalfPlanes = Callable[[Vector], HalfPlanes]
"""Half-planes that stand out at a size, and by how much it breaks each [length]."""
EXCHANGES = 40  # of half-planes at most; each adds those that the last size violates
FEW = 48  # half-planes of which all corners are looked at
ADDED = 8  # half-planes that join them at a time
FAR = 1e9  # lengths of the problem: where a polygon ends that is open there
OUTSIDE = 1e-12  # of the norm: how far a size may lie outside a half-plane


def half_planes(problem: Problem) -> tuple[Array, Array]:
    """normals · z ≤ offsets for every row and bound, on given segments: (k, n), (k,).

    Ends of the size that come from our own end of an open base radius are no half-planes.
    """
    bounding = [
        (row.size, row.upper - maximise(segment.placed(), row.coefficients)[0])
        for segment in problem.segments
        for row in problem.rows_on(segment, 0.0)
        if row.size and not row.level
    ]
    low, high = np.array(problem.sizing.bounds).T
    unit = np.eye(len(low))
    normals = np.array([size for size, _ in bounding]).reshape(-1, len(low))
    scale, slack = np.abs(normals).max(axis=1), np.array([slack for _, slack in bounding])
    # of size 1, and without their last digits, as ``row_on_given_law`` states them
    normals, offsets = round_mantissa(normals / scale[:, None]), round_mantissa(slack / scale)
    box, ends = np.vstack([unit, -unit]), np.concatenate([high, -low])
    if problem.open_above:
        kept = ends < problem.base_radius_range[1]
        box, ends = box[kept], ends[kept]
    return np.vstack([normals, box]), np.concatenate([offsets, ends])


def closed_form_size(
    problem: Problem, clear: float = 0.0, *, least: float = 0.0, norm: AffineNorm | None = None,
    slack: float = 0.0, implied: ImpliedHalfPlanes | None = None,
    outside: Sequence[NormBounds] = (),
) -> Vector | None:  # fmt: skip
    """The size of least prime radius on all half-planes; None where they have no common point.

    Cones and limits that are not convex are not looked at, but for those outside of which it lies.

    Args:
        clear: share of the norm by which the half-planes of curved limits are drawn in.
        least: norm of the smallest size that is sought, as far as half-planes say it.
        norm: what is least; None: the prime radius.
        slack: by how much every half-plane is moved out [length].
        implied: half-planes that free laws imply, in addition to those of given ones.
        outside: norms of two rows that are no less than their lower ends, where the prime radius
            is linear.
    """
    radius = problem.machine.follower.radius_norm()
    norm = norm or radius
    normals, offsets = half_planes(problem)
    offsets = offsets + slack
    if least > 0.0 and len(radius.matrix) == 1:
        normals = np.vstack([normals, -np.array(radius.matrix)])
        offsets = np.append(offsets, radius.shift[0] - least)
    size = _nearest_size(problem, norm, normals, offsets, outside)
    for _ in range(EXCHANGES if problem.has_curved_limits or implied else 0):
        if size is None:
            return None
        each = [most_violated(problem, size), *([implied(size)] if implied else [])]
        violated = join(each, len(size))
        prime = radius.value(size)
        scale = max(prime, *(abs(value) for value in size), 1e-6 * problem.length)
        more = violated.excess > (OUTSIDE - clear) * scale
        if not np.any(more):
            break
        normals = np.vstack([normals, violated.normals[more]])
        offsets = np.concatenate([offsets, violated.offsets[more] - clear * scale + slack])
        size = _nearest_size(problem, norm, normals, offsets, outside)
    return size


def _nearest_size(
    problem: Problem, norm: AffineNorm, normals: Array, offsets: Array,
    outside: Sequence[NormBounds] = (),
) -> Vector | None:  # fmt: skip
    """The same for given half-planes."""
    matrix, shift = np.array(norm.matrix), np.array(norm.shift)
    tolerance = 1e-12 * problem.length
    if len(matrix) < matrix.shape[1]:
        # a variable of which the norm does not speak: the corner where the norm is least, and of
        # several that of least p. Outside of circles it may be where a line meets one: along a line
        # the norm falls up to there, and on a circle itself it is nowhere least.
        def lowest_corner(a: Array, b: Array) -> Array | None:
            found = [_corners(a, b), *(_meetings(a, b, circle) for circle in outside)]
            corners = _within(np.concatenate(found), a, b, tolerance, 1e-12)
            for circle in outside:
                across = np.array(circle.norm.matrix), np.array(circle.norm.shift)
                reach = np.linalg.norm(corners @ across[0].T + across[1], axis=1)
                corners = corners[reach >= circle.lower - tolerance - 1e-12 * reach]
            if not len(corners):
                return None
            height = corners @ matrix[0]
            lowest = corners[height <= np.min(height) + tolerance]
            return np.asarray(lowest[np.argmin(lowest[:, 0])])

        length = np.sqrt((normals * normals).sum(axis=1))
        a, b = normals / length[:, None], offsets / length
        if len(b) > FEW:  # ends far away, so that some of the half-planes have a corner as well
            box = np.vstack([np.eye(2), -np.eye(2)])
            a, b = np.vstack([a, box]), np.append(b, np.full(4, FAR * problem.length))
        corner = _exchange(a, b, lowest_corner, tolerance, 1e-12)
        return None if corner is None else tuple(corner.tolist())

    # in y = M z + m the point nearest to the origin: that itself, its foot on a line, or a corner
    def nearest_point(a: Array, b: Array) -> Array | None:
        candidates = np.concatenate([np.zeros((1, a.shape[1])), a * b[:, None], _corners(a, b)])
        points = _within(candidates, a, b, tolerance, 1e-13)
        return points[(points * points).sum(axis=1).argmin()] if len(points) else None

    inverse = inverse_matrix(norm.matrix)
    a = normals @ inverse
    b = offsets + a @ shift
    length = np.sqrt((a * a).sum(axis=1))
    nearest = _exchange(a / length[:, None], b / length, nearest_point, tolerance, 1e-13)
    return None if nearest is None else tuple((inverse @ (nearest - shift)).tolist())


def _exchange(
    a: Array, b: Array, best: Callable[[Array, Array], Array | None], tolerance: float,
    relative: float,
) -> Array | None:  # fmt: skip
    """The best point of all half-planes a · y ≤ b: that of few of them, and of those it violates.

    The corners of n half-planes are n²/2 points to be compared with n half-planes. What is best
    under some of them and violates none is best under all; where some have no point, all have none.
    """
    chosen = np.arange(max(len(b) - FEW, 0), len(b))
    while True:
        point = best(a[chosen], b[chosen])
        if point is None or len(chosen) == len(b):
            return point
        excess = a @ point - b - tolerance - relative * np.abs(point).max()
        excess[chosen] = 0.0
        worst = np.argsort(excess)[-ADDED:]
        worst = worst[excess[worst] > 0.0]
        if not len(worst):
            return point
        chosen = np.append(chosen, worst)


def _within(points: Array, a: Array, b: Array, tolerance: float, relative: float) -> Array:
    """Those of the points (k, n) that lie in all half-planes a · y ≤ b, but for rounding."""
    reach = tolerance + relative * np.abs(points).max(axis=1)
    return np.asarray(points[(points @ a.T <= b + reach[:, None]).all(axis=1)])


def _meetings(a: Array, b: Array, circle: NormBounds) -> Array:
    """Where lines a · y = b, |a| = 1, meet ‖M y + m‖ = lower: (k, 2)."""
    matrix, shift = np.array(circle.norm.matrix), np.array(circle.norm.shift)
    along = np.stack([-a[:, 1], a[:, 0]], axis=1)
    across, at = along @ matrix.T, (a * b[:, None]) @ matrix.T + shift
    square, half = (across**2).sum(axis=1), (across * at).sum(axis=1)
    left = half**2 - square * ((at**2).sum(axis=1) - circle.lower**2)
    meets = left >= 0.0
    root, square, half = np.sqrt(left[meets]), square[meets], half[meets]
    steps = np.stack([root - half, -root - half]) / square
    return np.concatenate([a[meets] * b[meets, None] + t[:, None] * along[meets] for t in steps])


@lru_cache(maxsize=64)
def inverse_matrix(matrix: tuple[tuple[float, ...], ...]) -> Array:
    """The inverse of a norm's matrix; there are a few of them, of two rows, far from singular."""
    return np.asarray(np.linalg.inv(np.array(matrix)), dtype=float)


def _corners(a: Array, b: Array) -> Array:
    """Where two lines of the plane meet; one size variable has none."""
    if a.shape[1] == 1:
        return np.zeros((0, 1))
    first, second = np.triu_indices(len(b), 1)
    cross = a[first, 0] * a[second, 1] - a[first, 1] * a[second, 0]
    meeting = np.abs(cross) > 1e-12
    i, j, d = first[meeting], second[meeting], cross[meeting]
    result = np.empty((len(d), 2))
    result[:, 0] = (b[i] * a[j, 1] - b[j] * a[i, 1]) / d
    result[:, 1] = (a[i, 0] * b[j] - a[j, 0] * b[i]) / d
    return result
