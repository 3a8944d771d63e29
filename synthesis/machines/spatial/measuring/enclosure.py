"""Proven extrema over whole walls of cylindrical rollers: every cam angle, every place on them.

Branch and bound over boxes of cam angle θ and place ρ on the roller's axis: on a box a quantity is
a Taylor model in θ with ρ as an interval, and boxes whose bound is no worse than the extremum found
by samples are pruned. The formulas are those of the surface P(θ, ρ) that the roller's axis sweeps
in the turning cam: a ruled surface, P_ρ = u. With V = P_θ and n the normal, along u × V,

    tan²α = |n × w|² / (n·w)²,          w = dP/dq;
    W² = V² − (u·V)²,  F = u·V,  M = n·u_θ,  N = n·P_θθ,
    K = −M²/W²,  H = (N − 2FM)/(2W²),   (1 − Rr κ1)(1 − Rr κ2) = 1 − 2 Rr H + Rr² K,

so that samples (``numerics.geometry.swept_roller``) and proof share definitions but no formulas.
Derivatives are relative to the cam, in the machine's frame: with p' = dp/dq, J = χ e ×,

    P_θ = q'p' − J(p − c),   P_θθ = q''p' + q'²p'' − 2q'Jp' + JJ(p − c),   u_θ = q'u' − Ju.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, partial, reduce
from operator import add, neg
from typing import Any

import numpy as np

from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.measuring.patches import Extremum, Patch
from synthesis.numerics.box_search import BoxSearch, Budget
from synthesis.numerics.piecewise import Array, Mask
from synthesis.numerics.taylor import Jets, Taylor

Vector = tuple[Any, Any, Any]
Prover = Callable[["Models", Extremum, float | None], Extremum]
"""From an extremum by samples and its bound to one with a proven limit, if that succeeds."""
Enclosed = Callable[["SweptAxis"], Any]
"""From the swept surface on boxes to a quantity to be maximised."""
Splits = tuple[tuple[int, int], ...]
ANGLES, PLACES = 40, 16  # boxes of the first level, of a wall in θ and in ρ
# Parts of a split box in θ and ρ, in turn. Models are quadratic in θ but only intervals in ρ, so
# that cutting ρ pays more; where a quantity is nearly constant along an arc, fewer parts make fewer
# boxes.
QUICK: Splits = ((2, 8),)
SPARING: Splits = ((2, 4), (1, 4))
NEAR = 0.9  # of the margin: a proof up to here is good enough
CLAIMS = 1e-6, 1e-4, 1e-2  # relative: by how much less than was found a radius is claimed, in turn
MAX_LEVELS, MAX_BOXES = 30, 100_000  # of a proof; after that the open boxes' bounds count
RELATIVE = 1e-9  # width of a proof that is good enough
EVIDENCE = "enclosed: every cam angle and every place on the roller"


def dot(a: Vector, b: Vector) -> Any:
    """a·b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _sum(*terms: tuple[Any, Vector]) -> Vector:
    """Σ factor · vector."""
    x, y, z = (reduce(add, (factor * v[i] for factor, v in terms)) for i in range(3))
    return x, y, z


def _split(boxes: Array, keep: Mask, counts: tuple[int, int]) -> Array:
    """Each box (5, n) to ``keep`` (n,) cut into so many parts in θ and in ρ."""
    patch, low, high, inner, outer = boxes[:, keep]
    theta, rho = _cut(low, high, counts[0]), _cut(inner, outer, counts[1])
    parts = (patch[:, None, None], theta[:, :-1, None], theta[:, 1:, None],
             rho[:, None, :-1], rho[:, None, 1:])  # fmt: skip
    return np.stack([np.broadcast_to(part, (len(low), *counts)).ravel() for part in parts])


def _cut(low: Array, high: Array, count: int) -> Array:
    """Intervals (n,) cut into equal parts: their ends (n, count + 1)."""
    ends = low[:, None] + (high - low)[:, None] * np.arange(count + 1) / count
    ends[:, -1] = high
    return ends


class Models:
    """What the swept surfaces of all patches of a cam share."""

    def __init__(self, cam: SpatialCam, parts: Sequence[Patch]) -> None:
        swept = cam.swept
        self.cam, self.parts, self.jets = cam, parts, Jets(cam.motion.curve)
        self.piece = np.array([part.piece for part in parts])
        self.start = np.array([part.wall.seat.start for part in parts])
        self.side = np.array([part.wall.side for part in parts])
        self.origin = swept.joint.harmonics(swept.origin)
        self.along = swept.joint.harmonics(swept.along, turning=True)
        x, y, z = swept.axis
        self.turn = swept.hand * np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        # Whether u × V points towards the side of growing q is decided by one contact.
        patch, rho = parts[0], np.array([swept.roller.middle])
        at = np.array([0.5 * (patch.low + patch.high)])
        normal = patch.at(at, rho).contacts.normal[:, 0, 0]
        swept_axis = SweptAxis(self, np.stack([0.0 * at, at, at, rho, rho]))
        alike = dot(swept_axis.normal, tuple(normal.tolist()))
        self.side = self.side * patch.wall.side * (1 if float(alike.c0[0]) > 0.0 else -1)

    @cached_property
    def first(self) -> tuple[Array, SweptAxis]:
        """The first level's boxes and their models, shared by all quantities.

        Each patch has its share of ``ANGLES`` boxes a wall in θ. Where the follower dwells the
        contact is the same at every angle relative to the cam: one box.
        """
        parts, roller = self.parts, self.cam.swept.roller
        whole = np.array([(i, part.low, part.high, roller.inner, roller.outer)
                          for i, part in enumerate(parts)]).T  # fmt: skip
        rests = np.array([part.rests for part in parts])
        angles = max(1, ANGLES * len({part.wall for part in parts}) // len(parts))
        still, moving = _split(whole, rests, (1, PLACES)), _split(whole, ~rests, (angles, PLACES))
        boxes = np.hstack([still, moving])
        with np.errstate(all="ignore"):
            return boxes, SweptAxis(self, boxes)


class SweptAxis:
    """The surface that a roller's axis sweeps, on boxes; vectors in the machine's frame.

    A box is a column: number of its patch, ends of its cam angles, ends of its places ρ.

    Attributes:
        p: P from the cam's centre. u, w: the axis's direction, and dP/dq. v: P_θ.
        lead: u·w. carried: J(P), the velocity of the cam there.
        normal: u × v, not of unit length.
        side: (n,) whether the wall's normal is along ``normal`` or against it.
    """

    def __init__(self, models: Models, boxes: Array) -> None:
        patch, (_, low, high, inner, outer) = boxes[0].astype(int), boxes
        self._models, self.side = models, models.side[patch]
        # q and its derivatives as Taylor models in θ, ρ as an interval.
        piece = models.piece[patch]
        q, self._q1, self._q2 = models.jets.models(piece, low, high, 2)
        q = q + models.start[patch]
        # A little wider, for the rounding of its ends.
        half = (0.5 + 1e-15) * (outer - inner)
        none = np.zeros(len(piece))
        self._rho = rho = Taylor.of(0.5 * (inner + outer), none, none, half)
        # u, o and their derivatives by q; then P, w = P_q and P_θ by the module's formulas.
        cos, sin = q.cos(), q.sin()
        self.u, self._u1, self._u2 = _moving(models.along, q, cos, sin)
        origin, o1, self._o2 = _moving(models.origin, q, cos, sin)
        self.p = _sum((1.0, origin), (rho, self.u), (-1.0, tuple(models.cam.swept.centre)))
        self.w, self.carried = _sum((1.0, o1), (rho, self._u1)), self._cross_axis(self.p)
        self.v = _sum((self._q1, self.w), (-1.0, self.carried))
        self.lead = dot(self.u, o1)  # u·u' is 0
        self.normal = cross(self.u, self.v)

    @cached_property
    def curved(self) -> tuple[Any, Any]:
        """2H and K of the surface, with the wall's normal."""
        q1, w1 = self._q1, _sum((1.0, self._o2), (self._rho, self._u2))
        bend = _sum((self._q2, self.w), (q1 * q1, w1), (-2.0 * q1, self._cross_axis(self.w)),
                    (1.0, self._cross_axis(self.carried)))  # fmt: skip
        twist = _sum((q1, self._u1), (-1.0, self._cross_axis(self.u)))
        square = dot(self.normal, self.normal)  # W², as u is a unit vector
        f, m = dot(self.u, self.v), dot(self.normal, twist)
        mean = self.side * (dot(self.normal, bend) - 2.0 * f * m) / (square * square.sqrt())
        return mean, -(m * m) / (square * square)

    def _cross_axis(self, vector: Vector) -> Vector:
        """J of a vector."""
        x, y, z = (dot(tuple(row), vector) for row in self._models.turn)
        return x, y, z

    def along(self, axis: Vector) -> Any:
        """Position of the contact along an axis through the cam's centre [mm]."""
        square, radius = dot(self.normal, self.normal), self._models.cam.swept.roller.radius
        return dot(self.p, axis) + radius * self.side * dot(self.normal, axis) / square.sqrt()


def _moving(table: Array, q: Taylor, cos: Taylor, sin: Taylor) -> Sequence[Vector]:
    """A point or direction of the follower and its two derivatives by q, from its harmonics."""
    a, b, c, d = table
    here = tuple(a[i] + b[i] * cos + c[i] * sin + d[i] * q for i in range(3))
    first = tuple(c[i] * cos - b[i] * sin + d[i] for i in range(3))
    return here, first, tuple(-b[i] * cos - c[i] * sin for i in range(3))


def pressure(at: SweptAxis) -> Any:
    """tan²α.

    n × w = (u·w) v − (v·w) u, and of v only the cam's part contributes to n·w: written so, nothing
    large cancels where the angle is small.
    """
    across, along = dot(at.v, at.w), dot(cross(at.u, at.carried), at.w)
    away = at.lead * at.lead * dot(at.v, at.v) - 2.0 * (at.lead * across) * dot(at.u, at.v)
    return (across * across + away) / (along * along)


def undercut(radius: float) -> Enclosed:
    """−(1 − R κ1)(1 − R κ2) for a roller of this radius R on the same axis: positive: undercut."""

    def of(at: SweptAxis) -> Any:
        twice_mean, gauss = at.curved
        return radius * twice_mean - 1.0 - radius**2 * gauss

    return of


def prove_pressure_angle(models: Models, sampled: Extremum, allowed: float | None) -> Extremum:
    """The largest pressure angle [rad], enclosed as tan²α."""
    return _prove_maximum(models, sampled, allowed, pressure,
                          lambda angle: math.tan(angle) ** 2,
                          lambda square: math.atan(math.sqrt(square)))  # fmt: skip


def prove_regular(models: Models, sampled: Extremum, allowed: float | None) -> Extremum:
    """The least ratio of areas, wall to swept surface."""
    of = undercut(models.cam.swept.roller.radius)
    return _prove_maximum(models, sampled, allowed, of, neg, neg)


def _prove_maximum(
    models: Models, sampled: Extremum, allowed: float | None,
    of: Enclosed, rising: Callable[[float], float], inverse: Callable[[float], float],
) -> Extremum:  # fmt: skip
    """What was found by samples with a proven limit, if that succeeds.

    Args:
        allowed: bound. Where a quantity is nearly constant along an arc, a proof that it keeps the
            bound needs far fewer boxes than one that it stays at what was found.
        of: what is enclosed, to be maximised. rising: from the measured value to it; inverse: back.
    """
    best = rising(sampled.value)
    enough = best + RELATIVE * max(abs(best), 1e-3)
    most = upper_bound(models, of, enough)
    if allowed is not None and most > (goal := rising(allowed)):
        most = upper_bound(models, of, max(enough, best + NEAR * (goal - best)), SPARING)
    if not math.isfinite(most):
        return sampled
    return replace(sampled, limit=inverse(max(most, best)), evidence=EVIDENCE)


def upper_bound(models: Models, of: Enclosed, enough: float, splits: Splits = QUICK) -> float:
    """A proven upper bound of a quantity; infinite if nothing is proven.

    Args:
        enough: boxes with a bound up to this are not split. splits: of the others, in turn.
    """
    search = _WallSearch(models, of, enough, splits)
    with np.errstate(all="ignore"):
        search.run(models.first[0], Budget(MAX_LEVELS, MAX_BOXES, total=False))
    return float(search.proven)


class _WallSearch(BoxSearch[Array]):
    """Branch and bound of one quantity over boxes of cam angle and place on the roller."""

    def __init__(self, models: Models, of: Enclosed, enough: float, splits: Splits) -> None:
        self.models, self.of, self.enough, self.splits = models, of, enough, splits
        self.level = 0

    def bound(self, boxes: Array) -> Array:
        # The first level is the same for all quantities, and its models are made once.
        swept = self.models.first[1] if self.level == 0 else SweptAxis(self.models, boxes)
        self.parts = self.splits[self.level % len(self.splits)]
        self.children, self.level = math.prod(self.parts), self.level + 1
        high, _ = _range(self.of(swept))
        cam = self.models.cam
        if all(math.isinf(face) for face in cam.faces):
            return high
        # Boxes that lie wholly beyond the end faces are of no interest.
        most, least = _range(swept.along(tuple(cam.swept.axis)))
        return np.where((most < cam.faces[0]) | (least > cam.faces[1]), -np.inf, high)

    def threshold(self) -> float:
        return self.enough

    def split(self, boxes: Array, keep: Mask) -> Array:
        return _split(boxes, keep, self.parts)


def _range(model: Taylor) -> tuple[Array, Array]:
    """Largest and smallest value on each box, infinite where nothing is known."""
    high, low = model.range()
    high, low = high + model.rem, low - model.rem
    return np.where(np.isfinite(high), high, np.inf), np.where(np.isfinite(low), low, -np.inf)


def _prove_radius(
    models: Models, sampled: Extremum, allowed: float | None, sign: float
) -> Extremum:
    """The least convex (sign +1) or concave (−1) radius, with a proof that none is smaller.

    With κ1 ≥ 0 ≥ κ2 the curvatures of the swept surface (a ruled surface has no others), a wall is
    convex with the radius 1/κ1 − Rr and concave with 1/|κ2| + Rr. No convex radius is below r where
    a roller of radius R = Rr + r would not undercut: (1 − R κ1)(1 − R κ2) > 0 everywhere, which
    has no root and no division. For concave radii R = Rr − r; if negative, on the other side.
    ``sampled`` and ``allowed`` are negated curvatures [1/mm].
    """
    if sampled.value >= 0.0:
        return sampled
    radius, roller = -1.0 / sampled.value, models.cam.swept.roller.radius
    least = -math.inf if allowed is None else radius - NEAR * (radius + 1.0 / allowed)
    for claim in (max(radius * (1.0 - less), min(least, radius)) for less in CLAIMS):
        if upper_bound(models, undercut(roller + sign * claim), 0.0) <= 0.0:
            return replace(sampled, limit=-1.0 / claim, evidence=EVIDENCE)
    return sampled


prove_convex_radius: Prover = partial(_prove_radius, sign=1.0)
prove_hollow_radius: Prover = partial(_prove_radius, sign=-1.0)
