"""A closed curve as one B-spline of degree 5, within a stated distance of the true curve.

The parameter is the arc length. Nodes lie on the curve, and every place where the curve's law
changes is one: there the spline has the curve's own point, tangent and curvature, and is as smooth
as the curve, no smoother. In between it has four continuous derivatives and one control point a
node. How far it departs from the curve, along the curve's normal, is measured at eleven places of
every piece and between them, by a polynomial through these; where that is too far nodes are added,
in proportion to the sixth root of the departure, where it is less than needed they are taken away.

A motion law of many knots makes a curve of many spans, and a spline with the curve's own curvature
at each of their ends needs three control points there. Where curvature is continuous and its first
and second derivative by the arc length jump by J and K, a spline of degree 5 that knows nothing of
it, with nodes every h, departs by some J h³/300 + K h⁴/1200: where that is far below the tolerance
the spans may as well be one. This is a guess at what pays; the departure is measured afterwards.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.legendre import leggauss, legint, legval, legvander
from scipy.interpolate import BSpline, make_interp_spline

from synthesis.errors import InputError
from synthesis.numerics.geometry.closed_curve import AIM, ClosedCurve, CurvePoints, Mesh
from synthesis.numerics.piecewise import Array, Indices, Mask

DEGREE = 5  # curvature continuous, its slope too
MOST_NODES = 20_000  # of one curve
MAX_ITERATIONS, PATIENCE = 40, 20  # tries, with every span by itself and with some of them joined
WIDEST = 1.0 / 24.0  # of the curve: spacing of nodes
MERGING = 4  # iterations in which pieces of a span may be merged too
SAME = 1e-8  # a step of the tangent [rad], or of the curvature against its size: rounding
ROUNDING = 2.0**-46  # of the curve's size: no tolerance is below it
JUMP_SHARES = 1.0 / 300.0, 1.0 / 1200.0  # of J h³ and K h⁴ in the departure
SLOPE_STEP = 1e-3  # of a span, over which the curvature's derivative is taken

GAUSS, WEIGHTS = leggauss(8)
GAUSS = 0.5 * (GAUSS + 1.0)
PROBES = 0.5 - 0.5 * np.cos(np.pi * (np.arange(11) + 0.5) / 11.0)
FINE = np.linspace(0.0, 1.0, 67)
BEYOND = 1.002  # what may lie between those


def _integrals(ends: Array) -> Array:
    """Weights of the values at GAUSS for the integrals from 0 to each of ``ends``."""
    lagrange = np.linalg.inv(legvander(2.0 * GAUSS - 1.0, len(GAUSS) - 1))
    antiderivatives = legint(lagrange, lbnd=-1.0, scl=0.5)
    return np.asarray(legval(2.0 * ends - 1.0, antiderivatives).T)


TO_PROBES = _integrals(PROBES)
TO_END = _integrals(np.ones(1))[0]
# values at the probes to values in between
BETWEEN = legvander(2.0 * FINE - 1.0, 10) @ np.linalg.inv(legvander(2.0 * PROBES - 1.0, 10))


@dataclass(frozen=True, eq=False)
class ClosedSpline:
    """A clamped B-spline of arc length whose last control point is its first [mm].

    ``error``: largest distance from the true curve, along its normal; ``nodes``: number of places
    where it lies on the true curve.
    """

    knots: Array
    points: Array
    error: float
    nodes: int
    degree: int = DEGREE

    @property
    def length(self) -> float:
        """Of the whole curve [mm]."""
        return float(self.knots[-1] - self.knots[0])

    @property
    def area(self) -> float:
        """Enclosed [mm²], whichever way round it runs."""
        breaks = np.unique(self.knots)
        where = breaks[:-1, None] + np.diff(breaks)[:, None] * GAUSS
        (x, y), (dx, dy) = self.at(where.ravel()).T, self.at(where.ravel(), 1).T
        swept = (x * dy - y * dx).reshape(where.shape) @ (0.5 * WEIGHTS)
        return abs(float(np.sum(swept * np.diff(breaks)))) / 2.0

    def at(self, parameter: Array, order: int = 0) -> Array:
        """Points (n, 2) [mm], or derivatives by the parameter."""
        return np.asarray(BSpline(self.knots, self.points, self.degree)(parameter, order))


def fit_closed_spline(curve: ClosedCurve, tolerance: float) -> ClosedSpline:
    """The B-spline of a closed curve; ``tolerance``: largest distance from it [mm].

    Raises:
        InputError: the tolerance is below what numbers of 16 digits can tell at this size.
    """
    merged = _merge(curve, tolerance)
    if merged is not curve:
        found = _fit(merged, tolerance, PATIENCE)
        if found.error <= tolerance:
            return found
    found = _fit(curve, tolerance, MAX_ITERATIONS)
    if found.error <= tolerance:
        return found
    size = float(np.max(np.abs(found.points)))
    raise InputError(
        "/tolerance_um",
        float(f"{tolerance * 1e3:.12g}"),
        f"The curve came as near as {found.error * 1e3:.3g} µm with {found.nodes} pieces; "
        f"rounding alone is {size * ROUNDING * 1e3:.1g} µm at this size.",
        "Allow a larger tolerance.",
    )


def _fit(curve: ClosedCurve, tolerance: float, iterations: int) -> ClosedSpline:
    """The first spline within the tolerance, or the last that was tried."""
    mesh = Mesh.initial(curve.span_sizes)
    for iteration in range(iterations):
        found, departures = _through(curve, mesh, tolerance)
        if (iteration and found.error <= tolerance) or len(mesh.span) > MOST_NODES:
            break
        mesh = mesh.equidistribute(departures / tolerance, DEGREE + 1, growing=iteration >= MERGING)
    return found


def _merge(curve: ClosedCurve, tolerance: float) -> ClosedCurve:
    """The curve with those spans merged whose junction is too smooth to matter."""
    mesh = Mesh.initial(curve.span_sizes)
    lengths, _ = _lengths(curve, mesh)
    _, departures = _through(curve, mesh, tolerance)
    pieces = np.clip(departures / (AIM * tolerance), 1e-9, None) ** (1.0 / (DEGREE + 1))
    spacing = np.full(len(curve.span_sizes), np.inf)
    np.minimum.at(spacing, mesh.span, lengths / pieces)
    spacing = np.minimum(spacing, WIDEST * float(np.sum(lengths)))
    return merge_smooth_spans(curve, spacing, tolerance)


def _through(curve: ClosedCurve, mesh: Mesh, tolerance: float) -> tuple[ClosedSpline, Array]:
    """The spline through a mesh's nodes, and the largest departure on every piece [mm]."""
    lengths, speeds = _lengths(curve, mesh)
    keep = lengths > 1e-3 * tolerance
    mesh = mesh.select(keep)
    lengths, speeds = lengths[keep], speeds[keep]
    ends = _ends(curve, mesh, tolerance)
    same = mesh.span[:-1] == mesh.span[1:]
    inner = same & (mesh.high[:-1] == mesh.low[1:])
    breaks = np.concatenate([[0.0], np.cumsum(lengths)])
    # continuous derivatives at the nodes: 4 inside of spans, 0 to 2 where the law changes
    first, second = np.all(ends[1:, 1, :-1] == ends[1:, 0, 1:], axis=2)
    smooth = np.where(inner, DEGREE - 1, np.where(first, np.where(second, 2, 1), 0))
    knots, points = interpolate(breaks, ends, smooth)
    points[-1] = points[0]
    made = ClosedSpline(knots, points, math.inf, len(lengths))
    departures = np.zeros(len(keep))
    departures[keep] = _departures(curve, mesh, made, breaks, speeds)
    rounding = ROUNDING * float(np.max(np.abs(points)))
    error = BEYOND * float(np.max(departures)) + rounding
    return ClosedSpline(knots, points, error, len(lengths)), departures


def _lengths(curve: ClosedCurve, mesh: Mesh) -> tuple[Array, Array]:
    """Arc length of each piece (n,), and per unit of the piece at GAUSS (n, 8) [mm]."""
    speeds = curve.at(*mesh.points_at(GAUSS)).speed.reshape(-1, len(GAUSS))
    speeds = speeds * (mesh.high - mesh.low)[:, None]
    return speeds @ TO_END, speeds


def _ends(curve: ClosedCurve, mesh: Mesh, tolerance: float) -> Array:
    """Points, tangents and curvature vectors at both ends of n pieces, neighbours agreeing.

    In a table (3, 2, n, 2): which of the three, beginning or end, piece, and component.
    """
    course = curve.at(*mesh.points_at(np.array([0.0, 1.0])))
    smooth = np.abs(course.curvature) * tolerance < 1.0  # a cusp has no curvature
    bend = np.where(smooth, course.curvature, 0.0)
    tx, ty = course.tangent.T
    bent = bend[:, None] * np.column_stack([-ty, tx])
    ends = np.stack([course.points, course.tangent, bent]).reshape(3, -1, 2, 2).swapaxes(1, 2)
    for each, near in zip(ends, (math.inf, SAME, SAME), strict=True):
        before, behind = each[1], np.roll(each[0], -1, axis=0)
        size = np.maximum(np.hypot(*before.T), np.hypot(*behind.T))
        agree = np.hypot(*(before - behind).T) <= near * size
        mean = np.where(agree[:, None], 0.5 * (before + behind), np.nan)
        each[1] = np.where(agree[:, None], mean, before)
        each[0] = np.where(np.roll(agree, 1)[:, None], np.roll(mean, 1, axis=0), each[0])
    return ends


def interpolate(breaks: Array, ends: Array, smooth: Indices) -> tuple[Array, Array]:
    """Knots and control points (m, k) of the spline of degree 5 through given nodes.

    Args:
        breaks: (n + 1,) increasing parameters of the nodes.
        ends: (3, 2, n, k) values, slopes and second derivatives at both ends of every piece; what
            it says of slopes at nodes with four continuous derivatives is not looked at.
        smooth: (n − 1,) continuous derivatives at each inner node: 0, 1, 2 or 4.
    """
    cuts = [0, *np.flatnonzero(smooth < DEGREE - 1) + 1, len(breaks) - 1]
    points = list[Array]()
    for start, first, stop in zip([0, *cuts], cuts, cuts[1:], strict=False):
        # 1. Between two nodes with given slopes the pieces are an interpolation by themselves.
        nodes = np.concatenate([ends[0, 0, first:stop], ends[0, 1, stop - 1 : stop]])
        slopes = [[(k, ends[k, end, i]) for k in (1, 2)] for end, i in ((0, first), (1, stop - 1))]
        run = make_interp_spline(breaks[first : stop + 1], nodes, k=DEGREE, bc_type=slopes)  # type: ignore[call-overload]
        # 2. Where it joins the run before, the curve is as smooth as the knots say: with c
        # continuous derivatives c + 1 of the six equal knots go. A control point is the blossom at
        # the knots inside its function's support (Ramshaw 1987), which is affine in each of them:
        # so the point between the runs lies on a line through two points of the left run.
        skipped = 0
        if points:
            order, left = int(smooth[first - 1]), points[-1]
            skipped = max(order, 1)
            points[-1] = left[: len(left) - order]
            if order == 2:
                before = breaks[max(start, first - 2)]
                share = (breaks[first + 1] - before) / (breaks[first] - before)
                points.append(left[-3:-2] + share * (left[-2:-1] - left[-3:-2]))
        points.append(run.c[skipped:])
    knots = np.repeat(breaks, [DEGREE + 1, *(DEGREE - smooth), DEGREE + 1])
    return knots, np.concatenate(points)


def _departures(
    curve: ClosedCurve, mesh: Mesh, made: ClosedSpline, breaks: Array, speeds: Array
) -> Array:
    """Largest distance of each piece from the true curve, along its normal (n,) [mm]."""
    true: CurvePoints = curve.at(*mesh.points_at(PROBES))
    where = np.clip(breaks[:-1, None] + speeds @ TO_PROBES.T, breaks[:-1, None], breaks[1:, None])
    off = made.at(where.ravel()) - true.points
    tx, ty = true.tangent.T
    along = off[:, 0] * tx + off[:, 1] * ty
    across = off[:, 1] * tx - off[:, 0] * ty
    # a point ahead by `along` is nearest to another place of the curve, which has bent away
    finite = np.where(np.isfinite(true.curvature), true.curvature, 0.0)
    across = (across - 0.5 * finite * along**2).reshape(-1, len(PROBES))
    between = across @ BETWEEN.T
    return np.asarray(np.maximum(np.max(np.abs(between), axis=1), np.max(np.abs(across), axis=1)))


class MergedSpans(ClosedCurve):
    """A curve with some of its spans made one: they run on in proportion to their sizes.

    ``starts``: (m,) numbers of the spans that begin one of the new ones, the first among them.
    """

    def __init__(self, curve: ClosedCurve, starts: Indices) -> None:
        self.curve, self.starts = curve, starts
        self.ends = np.concatenate([[0.0], np.cumsum(curve.span_sizes)])
        self.last = np.append(starts[1:], len(curve.span_sizes)) - 1

    @property
    def span_sizes(self) -> Array:
        return np.asarray(self.ends[self.last + 1] - self.ends[self.starts])

    def at(self, span: Indices, fraction: Array) -> CurvePoints:
        first, last, size = self.starts[span], self.last[span], self.span_sizes[span]
        place = self.ends[first] + size * fraction
        own = np.clip(np.searchsorted(self.ends, place, side="right") - 1, first, last)
        own = np.where(fraction == 1.0, last, own)
        part = self.ends[own + 1] - self.ends[own]
        inside = np.where(fraction == 1.0, 1.0, np.clip((place - self.ends[own]) / part, 0.0, 1.0))
        found = self.curve.at(own, inside)
        return replace(found, speed=found.speed * (size / part))


def merge_smooth_spans(curve: ClosedCurve, spacing: Array, tolerance: float) -> ClosedCurve:
    """The curve with the spans joined between which nothing happens that a spline would see.

    ``spacing``: (m,) of nodes along each span that its smoothness asks for; ``tolerance``: largest
    departure [mm].
    """
    count = len(curve.span_sizes)
    near = np.minimum(spacing, np.roll(spacing, 1))
    jumps = _jumps(curve)
    seen = JUMP_SHARES[0] * jumps[0] * near**3 + JUMP_SHARES[1] * jumps[1] * near**4
    smooth_enough = seen < 0.1 * tolerance
    smooth_enough[0] = False
    if not smooth_enough.any():
        return curve
    return MergedSpans(curve, np.arange(count)[~smooth_enough])


def _jumps(curve: ClosedCurve) -> Array:
    """(2, m) jumps of the curvature's derivatives where each span begins; ∞ where more jumps."""
    span = np.arange(len(curve.span_sizes))
    begins = [curve.at(span, np.full(len(span), SLOPE_STEP * k)) for k in range(4)]
    ends = [curve.at(span, np.full(len(span), 1.0 - SLOPE_STEP * k)) for k in range(4)]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        (first, second), (first_before, second_before) = _slopes(begins), _slopes(ends)
        # the derivatives before a joint are taken backwards: the first has the other sign
        jumps = np.stack([first + np.roll(first_before, 1), second - np.roll(second_before, 1)])
    known = _smooth(begins[0], ends[0]) & np.all(np.isfinite(jumps), axis=0)
    return np.where(known, np.abs(jumps), np.inf)


def _slopes(courses: list[CurvePoints]) -> tuple[Array, Array]:
    """dκ/dσ and d²κ/dσ² at the first of four places that follow one another from a span's end."""
    a, b, c, d = (course.curvature for course in courses)
    step = SLOPE_STEP * courses[0].speed
    first = (18.0 * b - 11.0 * a - 9.0 * c + 2.0 * d) / (6.0 * step)
    return first, (2.0 * a - 5.0 * b + 4.0 * c - d) / step**2


def _smooth(begins: CurvePoints, ends: CurvePoints) -> Mask:
    """(m,) whether point, tangent and curvature go on where each span begins."""
    bend, before = begins.curvature, np.roll(ends.curvature, 1)
    size = np.maximum(np.abs(bend), np.abs(before))
    turned = np.hypot(*(begins.tangent - np.roll(ends.tangent, 1, axis=0)).T)
    moved = np.hypot(*(begins.points - np.roll(ends.points, 1, axis=0)).T)
    extent = np.max(np.abs(begins.points))
    same = np.abs(bend - before) <= SAME * size
    return np.asarray(same & (turned <= SAME) & (moved <= SAME * extent))
