"""Proven extrema over whole walls of cylindrical rollers: every cam angle, every place on them.

Branch and bound over boxes of cam angle θ and place ρ on the roller's axis: on a box a quantity is
a Taylor model in θ with ρ as an interval, and boxes whose bound is no worse than the extremum found
by samples are pruned. The formulas are those of the surface P(θ, ρ) that the roller's axis sweeps
in the
turning cam: a ruled surface, P_ρ = u. With V = P_θ and n the normal, along u × V,

    tan²α = |n × w|² / (n·w)²,          w = dP/dq, the follower's way;
    W² = V² − (u·V)²,  F = u·V,  M = n·u_θ,  N = n·P_θθ,
    K = −M²/W²,  H = (N − 2FM)/(2W²),   (1 − Rr κ1)(1 − Rr κ2) = 1 − 2 Rr H + Rr² K,

so that the samples (``numerics.geometry.swept_roller``) and this proof share definitions but no
formulas. Derivatives are relative to the cam, in the machine's frame: with p' = dp/dq, J = χ e ×,

    P_θ = q'p' − J(p − c),   P_θθ = q''p' + q'²p'' − 2q'Jp' + JJ(p − c),   u_θ = q'u' − Ju.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.measuring.extremum import Extremum
from synthesis.machines.spatial.measuring.patches import Patch
from synthesis.numerics.box_search import BoxSearch, Budget
from synthesis.numerics.jets import Jets
from synthesis.numerics.piecewise import Array
from synthesis.numerics.taylor import Taylor

Vector = tuple[Any, Any, Any]
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
    x, y, z = (sum((f * v[i] for f, v in terms[1:]), start=terms[0][0] * terms[0][1][i])
               for i in range(3))  # fmt: skip
    return x, y, z


@dataclass(frozen=True, eq=False)
class Swept:
    """The surface that a roller's axis sweeps, on boxes; vectors in the machine's frame.

    Attributes:
        point: P from the cam's centre. u, w: the axis's direction, and dP/dq. v: P_θ.
        lead: u·w. carried: J(P), the velocity of the cam there.
        normal: u × v, not of unit length.
        bends: makes P_θθ and u_θ, which not every quantity needs. roller: its radius.
        side: (n,) whether the wall's normal is along ``normal`` or against it.
    """

    point: Vector
    u: Vector
    w: Vector
    v: Vector
    lead: Any
    carried: Vector
    normal: Vector
    bends: Callable[[], tuple[Vector, Vector]]
    roller: float
    side: Array

    @cached_property
    def curved(self) -> tuple[Any, Any]:
        """2H and K of the surface, with the wall's normal."""
        bend, twist = self.bends()
        square = dot(self.normal, self.normal)  # W², as u is a unit vector
        f, m = dot(self.u, self.v), dot(self.normal, twist)
        mean = self.side * (dot(self.normal, bend) - 2.0 * f * m) / (square * square.sqrt())
        return mean, -(m * m) / (square * square)


def along(at: Swept, axis: Vector) -> Any:
    """Position of the contact along an axis through the cam's centre [mm]."""
    square = dot(at.normal, at.normal)
    return dot(at.point, axis) + at.roller * at.side * dot(at.normal, axis) / square.sqrt()


def pressure(at: Swept) -> Any:
    """tan²α.

    n × w = (u·w) v − (v·w) u, and of v only the cam's part contributes to n·w: written so, nothing
    large cancels where the angle is small.
    """
    across, along = dot(at.v, at.w), dot(cross(at.u, at.carried), at.w)
    away = at.lead * at.lead * dot(at.v, at.v) - 2.0 * (at.lead * across) * dot(at.u, at.v)
    return (across * across + away) / (along * along)


def undercut(radius: float) -> Callable[[Swept], Any]:
    """(1 − R κ1)(1 − R κ2) for a roller of this radius R on the same axis."""

    def of(at: Swept) -> Any:
        twice_mean, gauss = at.curved
        return 1.0 - radius * twice_mean + radius**2 * gauss

    return of


@dataclass(frozen=True, eq=False)
class Proof:
    """How a quantity is enclosed.

    Attributes:
        of: the enclosed function of the swept surface. sign: +1 for its maximum, −1 for its
            minimum.
        into, back: from the quantity's value to the function's, and the inverse.
    """

    of: Callable[[Swept], Any]
    sign: float
    into: Callable[[float], float] = float
    back: Callable[[float], float] = float


PRESSURE = Proof(pressure, 1.0, lambda a: math.tan(a) ** 2, lambda t: math.atan(math.sqrt(t)))


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes (n,): the patch, its cam angles and its places on the roller's axis."""

    patch: NDArray[np.intp]
    low: Array
    high: Array
    inner: Array
    outer: Array

    def take(self, which: NDArray[np.intp]) -> Boxes:
        """Some of the boxes."""
        return Boxes(*(part[which] for part in vars(self).values()))

    def split(self, counts: tuple[int, int]) -> Boxes:
        """Each box cut into so many parts in θ and in ρ."""
        theta = _cut(self.low, self.high, counts[0])
        rho = _cut(self.inner, self.outer, counts[1])
        wide = (len(self.low), *counts)
        cut = (theta[:, :-1, None], theta[:, 1:, None], rho[:, None, :-1], rho[:, None, 1:])
        patch = np.repeat(self.patch, counts[0] * counts[1])
        return Boxes(patch, *(np.broadcast_to(part, wide).ravel() for part in cut))


def _cut(low: Array, high: Array, count: int) -> Array:
    """Intervals (n,) cut into equal parts: their ends (n, count + 1)."""
    ends = low[:, None] + (high - low)[:, None] * np.arange(count + 1) / count
    ends[:, -1] = high
    return ends


class Models:
    """The swept surface of every patch on boxes."""

    def __init__(self, cam: SpatialCam, parts: Sequence[Patch]) -> None:
        swept = cam.swept
        self.cam, self.parts = cam, parts
        self._jets = Jets(cam.motion.curve)
        self._roller = swept.roller.radius
        self._piece = np.array([part.piece for part in parts])
        self._start = np.array([part.wall.seat.start for part in parts])
        self._side = np.array([part.wall.side for part in parts])
        self._origin = swept.joint.harmonics(swept.origin)
        self._along = swept.joint.harmonics(swept.along, turning=True)
        self._centre, self._hand = swept.centre, swept.hand
        e = swept.axis
        self._turn = swept.hand * np.array(
            [[0.0, -e[2], e[1]], [e[2], 0.0, -e[0]], [-e[1], e[0], 0.0]]
        )
        # Whether u × V points towards the side of growing q is decided by one contact.
        patch, at = parts[0], np.array([0.5 * (parts[0].low + parts[0].high)])
        rho = np.array([swept.roller.middle])
        normal = patch.contacts(at, rho).normal[:, 0, 0]
        box = Boxes(*(np.array([x]) for x in (0, at[0], at[0], rho[0], rho[0])))
        alike = dot(self.at(box).normal, tuple(normal.tolist()))
        self._side = self._side * patch.wall.side * (1 if float(alike.c0[0]) > 0.0 else -1)

    def at(self, boxes: Boxes) -> Swept:
        """Models on boxes."""
        piece = self._piece[boxes.patch]
        q, q1, q2 = self._jets.models(piece, boxes.low, boxes.high, 2)
        q = q + self._start[boxes.patch]
        none = np.zeros(len(piece))
        # A little wider, for the rounding of its ends.
        half = (0.5 + 1e-15) * (boxes.outer - boxes.inner)
        rho = Taylor.of(0.5 * (boxes.inner + boxes.outer), none, none, half)
        cos, sin = q.cos(), q.sin()
        u, u1, u2 = self._moving(self._along, q, cos, sin)
        o, o1, o2 = self._moving(self._origin, q, cos, sin)
        p = _sum((1.0, o), (rho, u), (-1.0, tuple(self._centre)))
        w, turned = _sum((1.0, o1), (rho, u1)), self._turned(p)
        v = _sum((q1, w), (-1.0, turned))

        def bends() -> tuple[Vector, Vector]:
            w1, again = _sum((1.0, o2), (rho, u2)), self._turned(turned)
            bend = _sum((q2, w), (q1 * q1, w1), (-2.0 * q1, self._turned(w)), (1.0, again))
            return bend, _sum((q1, u1), (-1.0, self._turned(u)))

        lead = dot(u, o1)  # u·u' is 0
        return Swept(
            p, u, w, v, lead, turned, cross(u, v), bends, self._roller, self._side[boxes.patch]
        )

    @cached_property
    def first(self) -> tuple[Boxes, Swept]:
        """The first level's boxes over all patches and their models, shared by all quantities."""
        roller = self.cam.swept.roller
        boxes = _first(self.parts, np.linspace(roller.inner, roller.outer, PLACES + 1))
        with np.errstate(all="ignore"):
            return boxes, self.at(boxes)

    def _moving(self, table: Array, q: Taylor, cos: Taylor, sin: Taylor) -> Sequence[Vector]:
        """A point or direction of the follower and its derivatives by q."""
        a, b, c, d = table
        here = tuple(a[i] + b[i] * cos + c[i] * sin + d[i] * q for i in range(3))
        first = tuple(c[i] * cos - b[i] * sin + d[i] for i in range(3))
        second = tuple(-b[i] * cos - c[i] * sin for i in range(3))
        return here, first, second

    def _turned(self, vector: Vector) -> Vector:
        """J of a vector."""
        x, y, z = (dot(tuple(row), vector) for row in self._turn)
        return x, y, z


def prove_extremum(
    models: Models, proof: Proof, found: Extremum, allowed: float | None = None
) -> Extremum:
    """A found extremum with a proven limit; as it was where nothing could be proven.

    Args:
        models: of the patches. proof: how the quantity is enclosed. found: its extremum by samples.
        allowed: bound of the quantity. Where the quantity is nearly constant along an arc, a proof
            that it keeps the bound needs far fewer boxes than one that it stays at what was found.
    """
    sign = proof.sign
    best = sign * proof.into(found.value)
    enough = best + RELATIVE * max(abs(best), 1e-3)
    most = upper_bound(models, proof, enough)
    if allowed is not None and most > sign * proof.into(allowed):
        room = NEAR * (sign * proof.into(allowed) - best)
        most = upper_bound(models, proof, max(enough, best + room), SPARING)
    if not math.isfinite(most):
        return found
    return replace(found, limit=proof.back(sign * max(most, best)), evidence=EVIDENCE)


def upper_bound(models: Models, proof: Proof, enough: float, splits: Splits = QUICK) -> float:
    """A proven upper bound of a quantity times its sign; infinite if nothing is proven.

    Args:
        enough: boxes with a bound up to this are not split. splits: of the others, in turn.
    """
    search = _WallSearch(models, proof, enough, splits)
    with np.errstate(all="ignore"):
        search.run(models.first[0], Budget(MAX_LEVELS, MAX_BOXES, total=False))
    return float(search.proven)


class _WallSearch(BoxSearch[Boxes]):
    """Branch and bound of one quantity over boxes of cam angle and place on the roller."""

    def __init__(self, models: Models, proof: Proof, enough: float, splits: Splits) -> None:
        self.models, self.proof, self.enough, self.splits = models, proof, enough, splits
        self.level = 0

    @property
    def children(self) -> int:  # type: ignore[override]
        return math.prod(self.splits[(self.level - 1) % len(self.splits)])

    def bound(self, boxes: Boxes) -> Array:
        # The first level is the same for all quantities, and its models are made once.
        swept = self.models.first[1] if self.level == 0 else self.models.at(boxes)
        self.level += 1
        high, low = _range(self.proof.of(swept))
        bounds = high if self.proof.sign > 0.0 else -low
        return np.where(_outside(self.models.cam, swept), -np.inf, bounds)

    def threshold(self) -> float:
        return self.enough

    def split(self, boxes: Boxes, keep: NDArray[np.bool_]) -> Boxes:
        counts = self.splits[(self.level - 1) % len(self.splits)]
        return boxes.take(np.flatnonzero(keep)).split(counts)


def _range(model: Taylor) -> tuple[Array, Array]:
    """Largest and smallest value on each box, infinite where nothing is known."""
    high, low = model.range()
    high, low = high + model.rem, low - model.rem
    return np.where(np.isfinite(high), high, np.inf), np.where(np.isfinite(low), low, -np.inf)


def _outside(cam: SpatialCam, swept: Swept) -> Array:
    """Boxes that lie wholly beyond the end faces."""
    if all(math.isinf(face) for face in cam.faces):
        return np.zeros(len(swept.side), dtype=bool)
    high, low = _range(along(swept, tuple(cam.swept.axis)))
    return np.asarray((high < cam.faces[0]) | (low > cam.faces[1]))


def _first(parts: Sequence[Patch], edges: Array) -> Boxes:
    """The first level: on each patch its share of ``ANGLES`` boxes a wall in θ.

    Where the follower dwells the contact is the same at every angle relative to the cam: one box.
    """
    angles = max(1, ANGLES * len({part.wall for part in parts}) // len(parts))
    counts = np.array([1 if part.rests else angles for part in parts])
    patch = np.repeat(np.arange(len(parts)), counts)
    nth = np.arange(len(patch)) - np.repeat(np.cumsum(counts) - counts, counts)
    start, end = np.array([(part.low, part.high) for part in parts]).T[:, patch]
    step, last = (end - start) / counts[patch], nth + 1 == counts[patch]
    low, high = start + nth * step, np.where(last, end, start + (nth + 1) * step)
    cut = (patch[:, None], low[:, None], high[:, None], edges[:-1], edges[1:])
    return Boxes(*(part.ravel() for part in np.broadcast_arrays(*cut)))


def prove_convex_radius(models: Models, found: Extremum, allowed: float | None) -> Extremum:
    """The least convex radius, with a proof that none is smaller.

    With κ1 ≥ 0 ≥ κ2 the curvatures of the swept surface (a ruled surface has no others), a wall is
    convex with the radius 1/κ1 − Rr and concave with 1/|κ2| + Rr. No convex radius is below r where
    a roller of radius R = Rr + r would not undercut: (1 − R κ1)(1 − R κ2) > 0 everywhere, which
    has no root and no division.
    """
    return _claim_radius(models, found, allowed, 1.0)


def prove_hollow_radius(models: Models, found: Extremum, allowed: float | None) -> Extremum:
    """The least concave radius, with a proof that none is smaller.

    As for convex radii with R = Rr − r, a negative radius being one on the other side.
    """
    return _claim_radius(models, found, allowed, -1.0)


def _claim_radius(models: Models, found: Extremum, allowed: float | None, sign: float) -> Extremum:
    """``found`` and ``allowed`` are negated curvatures [1/mm]; unchanged if nothing is proven."""
    if found.value >= 0.0:
        return found
    radius, roller = -1.0 / found.value, models.cam.swept.roller.radius
    least = -math.inf if allowed is None else radius - NEAR * (radius + 1.0 / allowed)
    for claim in (max(radius * (1.0 - less), min(least, radius)) for less in CLAIMS):
        proof = Proof(undercut(roller + sign * claim), -1.0)
        if upper_bound(models, proof, 0.0) <= 0.0:
            return replace(found, limit=-1.0 / claim, evidence=EVIDENCE)
    return found
