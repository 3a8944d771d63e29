"""Proven extremes over whole walls of cylindrical rollers: every cam angle, every place on them.

Boxes of cam angle and place on the roller's axis are cut and left as long as their best is worse
than what was found (branch and bound); what a quantity does on a box is a Taylor model in θ, with
the place ρ as an interval in it. The formulas are those of the surface P(θ, ρ) which the roller's
axis sweeps of the turning cam: a ruled one, P_ρ = u. With V = P_θ, n the normal, along u × V,

    tan²α = |n × w|² / (n·w)²,          w = dP/dq, the follower's way;
    W² = V² − (u·V)²,  F = u·V,  M = n·u_θ,  N = n·P_θθ,
    K = −M²/W²,  H = (N − 2FM)/(2W²),   (1 − Rr κ1)(1 − Rr κ2) = 1 − 2 Rr H + Rr² K,

so that the closed form and this judge share the definitions and no more. Derivatives are those the
cam sees, told in the machine's frame: with p' = dp/dq, J = χ e ×,

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

from synthesis.numerics.jets import Jets
from synthesis.numerics.piecewise import Array
from synthesis.numerics.taylor import Taylor
from synthesis.spatial.cam import SpatialCam
from synthesis.spatial.measuring.found import Found
from synthesis.spatial.measuring.patches import Patch

Vector = tuple[Any, Any, Any]
Splits = tuple[tuple[int, int], ...]
ANGLES, PLACES = 40, 16  # boxes to begin with, of a wall along it and across
# of a box in θ and ρ, in turn; models are quadratic in θ, intervals in ρ. Where a quantity is all
# but constant along an arc there are fewer boxes if they are cut less
QUICK: Splits = ((2, 8),)
SPARING: Splits = ((2, 4), (1, 4))
NEAR = 0.9  # of what a bound leaves over: a proof so far does
MOST_ROUNDS, MOST_BOXES = 30, 100_000
RELATIVE = 1e-9
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
    """The surface that a roller's axis sweeps, on boxes: all vectors in the machine's frame.

    Attributes:
        point: P from the cam's centre. u, w: the axis's direction, and dP/dq. v: P_θ.
        lead: u·w. carried: J(P), what the cam does there.
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
        """2H and K of the surface, as if its normal were the wall's."""
        bend, twist = self.bends()
        square = dot(self.normal, self.normal)  # W², as u is a unit vector
        f, m = dot(self.u, self.v), dot(self.normal, twist)
        mean = self.side * (dot(self.normal, bend) - 2.0 * f * m) / (square * square.sqrt())
        return mean, -(m * m) / (square * square)


def along(at: Swept, axis: Vector) -> Any:
    """Where the contact is along an axis through the origin [mm]."""
    square = dot(at.normal, at.normal)
    return dot(at.point, axis) + at.roller * at.side * dot(at.normal, axis) / square.sqrt()


def pressure(at: Swept) -> Any:
    """tan²α.

    n × w = (u·w) v − (v·w) u, and of v only what the cam adds to q'w leaves something of n·w: so
    written, nothing large cancels where the angle is small.
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
        of: what of the swept surface. sign: +1 where its largest counts, −1 where its least.
        into, back: from the quantity's value to that and from that to the value.
    """

    of: Callable[[Swept], Any]
    sign: float
    into: Callable[[float], float] = float
    back: Callable[[float], float] = float


PRESSURE = Proof(pressure, 1.0, lambda a: math.tan(a) ** 2, lambda t: math.atan(math.sqrt(t)))


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes: which patch (n,), its cam angles and its places on the roller's axis."""

    patch: NDArray[np.intp]
    low: Array
    high: Array
    inner: Array
    outer: Array

    def take(self, which: NDArray[np.intp]) -> Boxes:
        """Some of them."""
        return Boxes(*(part[which] for part in vars(self).values()))

    def split(self, counts: tuple[int, int]) -> Boxes:
        """Each cut both ways, in θ and in ρ."""
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
        # u × V is towards the side of growing q, or against it, as a contact of the cam says
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
        # a little wider, for the roundings of its ends
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
        """Boxes over all patches and the models there: one for all quantities to begin with."""
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


def proven(models: Models, proof: Proof, found: Found, allowed: float | None = None) -> Found:
    """What was found of a quantity, and how far it can go beyond that; as it was if that is open.

    Args:
        allowed: what the quantity may come to: where it is all but constant along an arc, a
            proof that it does not pass that is within reach, and one that it stays there is not.
    """
    sign = proof.sign
    best = sign * proof.into(found.value)
    enough = best + RELATIVE * max(abs(best), 1e-3)
    most = largest(models, proof, enough)
    if allowed is not None and most > sign * proof.into(allowed):
        room = NEAR * (sign * proof.into(allowed) - best)
        most = largest(models, proof, max(enough, best + room), SPARING)
    if not math.isfinite(most):
        return found
    return replace(found, limit=proof.back(sign * max(most, best)), evidence=EVIDENCE)


def largest(models: Models, proof: Proof, enough: float, splits: Splits = QUICK) -> float:
    """What a quantity, times its sign, does not pass anywhere; infinite if nothing is proven.

    Args:
        enough: boxes that do not pass this are not looked at more closely.
        splits: how the others are cut, in turn.
    """
    boxes, swept = models.first
    most, last = -math.inf, math.inf
    with np.errstate(all="ignore"):
        for number in range(MOST_ROUNDS):
            high, low = _range(proof.of(swept))
            above = np.where(
                _outside(models.cam, swept), -np.inf, high if proof.sign > 0.0 else -low
            )
            keep = above > enough
            most = max(most, float(above[~keep].max(initial=-np.inf)))
            boxes = boxes.take(np.flatnonzero(keep))
            split = splits[number % len(splits)]
            if not keep.any() or math.prod(split) * np.count_nonzero(keep) > MOST_BOXES:
                most = max(most, float(above[keep].max(initial=-np.inf)))
                break
            last = float(above[keep].max())
            boxes = boxes.split(split)
            swept = models.at(boxes)
        else:
            most = max(most, last)
    return most


def _range(model: Taylor) -> tuple[Array, Array]:
    """Largest and smallest value on each box, infinite where nothing is known."""
    high, low = model.range()
    high, low = high + model.rem, low - model.rem
    return np.where(np.isfinite(high), high, np.inf), np.where(np.isfinite(low), low, -np.inf)


def _outside(cam: SpatialCam, swept: Swept) -> Array:
    """Boxes that lie beyond the end faces as a whole."""
    if all(math.isinf(face) for face in cam.faces):
        return np.zeros(len(swept.side), dtype=bool)
    high, low = _range(along(swept, tuple(cam.swept.axis)))
    return np.asarray((high < cam.faces[0]) | (low > cam.faces[1]))


def _first(parts: Sequence[Patch], edges: Array) -> Boxes:
    """Boxes to begin with: as many angles of each patch as keep those of a wall to a number.

    Where the follower rests the cam sees the same at every angle: one box.
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
