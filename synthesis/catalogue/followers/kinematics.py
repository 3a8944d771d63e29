"""Kinematics of a trace point: the curve that it draws on the turning cam, and its constraints.

Symbols: s to s''' displacement and its derivatives per radian of cam angle; z size variables;
Rp prime radius; α pressure angle; κ curvature of the traced curve (of a roller: the pitch curve),
convex positive. Vectors are in the machine frame: origin on the cam's axis, y along an upward
follower, the cam turning counter-clockwise (a clockwise cam is the mirror image). Lengths are in
the unit of s.

``Link`` is the output link as a bare mechanism, positions at displacement 0 and nothing else, so
that a reader can derive all the rest without a formula of the family's own. A ``Flank`` is a
working curve of a cam. A roller's centre traces p(θ), whose curve has the curvature κ, ρ = 1/κ, and
the outward normal n. A flank at the distance D is the curve p − σ D n:

    σ = +1  the cam lies within the traced curve and is touched from outside
    σ = −1  the cam lies around it, as a ring does, and is touched from inside

The centre of curvature of p is p − ρ n for either sign of κ. It is the flank's too, so the
flank's signed radius along n is ρ − σ D. As the cam's material sees it (convex where a chord runs
in the material, which lies to the side −σ n) that is σ (ρ − σ D) = σ ρ − D: with κ_m = σ κ every
rule of a cam touched from outside holds for both.

    convex       κ_m > 0, of radius 1/κ_m − D; undercut where 1/κ_m < D
    hollow       κ_m < 0, of radius 1/|κ_m| + D, which a cutter of radius Rg must fit
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal

from synthesis.catalogue.box_bounds import BoxBounds
from synthesis.catalogue.constraints import AffineNorm, LinearInequality, PressureTerm

Vector2 = tuple[Any, Any]


class TracePoint(ABC):
    """A point of the machine that draws a curve on the cam; every follower is one."""

    @abstractmethod
    def position(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        """The trace point (a roller's centre, a face's contact point) and its θ-derivatives.

        s to s''' are of any arithmetic type (arrays, intervals). Pairs (x, y) of the point and at
        least its first two derivatives come out.
        """

    def drive_direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        """Unit vector along which the follower is driven, and its θ-derivative: up, on a slide."""
        zero = 0.0 * s[0]
        return (zero, zero + 1.0), (zero, zero)

    def lever(self, s: Any, z: Any) -> Any:
        """λ: how far the follower's material at the contact moves along g, per unit of s.

        By virtual work a force N along the unit normal n does N (n · g) λ per unit of s. Negative
        where the follower moves against the direction of drive as s grows.
        """
        return 1.0

    def normal(self, tangent: Vector2, s: Any, z: Any) -> Vector2:
        """Outward common normal, of any length: of the traced curve, or of a face that has one.

        ``tangent`` is that of the traced curve, which runs clockwise round the cam.
        """
        tx, ty = tangent
        return -ty, tx

    @abstractmethod
    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        """Numerator N and squared speed W² of the traced curve: κ = N / W³."""

    def curvature_bounds(
        self, side: int, most: float, thrust: PressureTerm | None = None
    ) -> BoxBounds:
        """side · κ ≤ most, most > 0, with its linear relaxation over boxes; () where none is known.

        ``thrust``: a limit on the contact pressure, which leaves less curvature.
        """
        return ()

    def pressure_angle_rows(self, slope: float) -> tuple[LinearInequality, ...]:
        """|tan α| ≤ slope, linear in s, s' and z; () where it is not."""
        return ()

    def radius_rows(self, least: float) -> tuple[LinearInequality, ...]:
        """Distance of the traced curve from the axis ≥ least; () where the size implies it."""
        return ()

    def outer_radius_norm(self, s_max: float) -> AffineNorm | None:
        """Largest radius of the traced curve, at displacement ``s_max``, as a norm of z.

        Or a norm that grows with that radius, as ``radius_norm`` does; None where there is none:
        then ``outer_radius_constraints`` state it.
        """
        return None

    def norm_from_radius(self, radius: float) -> float:
        """``radius_norm`` at a prime radius: the inverse of ``radius_from_norm``."""
        return radius

    def nearest_displacement(self, s_max: float) -> float:
        """Displacement between 0 and ``s_max`` at which the traced curve is nearest to the axis."""
        return 0.0


def pressure_angle_sine_cosine(path: TracePoint, s: Any, z: Any) -> tuple[Any, Any]:
    """Sine and cosine of the pressure angle on a traced curve; s, z as for ``position``."""
    (px, py), (dx, dy), *_ = path.position(s, z)
    nx, ny = path.normal((dx + py, dy - px), s, z)
    (gx, gy), _ = path.drive_direction(s, z)
    length = (nx * nx + ny * ny) ** 0.5
    return (gx * ny - gy * nx) / length, (gx * nx + gy * ny) / length


@dataclass(frozen=True)
class Tip:
    """A roller's centre or a knife edge on the link, and the name of the curve that it traces.

    ``outward``: +1 where its cam drives the link the way displacement grows, −1 the other way.
    """

    path: str
    at: Vector2
    outward: int = 1


@dataclass(frozen=True)
class Face:
    """A flat face on the link: the point from which its reach is measured, and unit vectors.

    ``along`` points in the sense of positive reach, ``normal`` away from the cam.
    """

    at: Vector2
    along: Vector2
    normal: Vector2


@dataclass(frozen=True)
class Link:
    """The output link at displacement 0, in the machine frame of a ccw cam [mm].

    Attributes:
        slide: unit vector along which it moves by s [mm]; None where it turns.
        pivot: about which it turns by φ [rad]; None where it slides.
        turn: +1 where it turns counter-clockwise as φ grows, −1 where clockwise.
        tips, face: what meets the cam.
    """

    tips: tuple[Tip, ...] = ()
    face: Face | None = None
    slide: Vector2 | None = None
    pivot: Vector2 | None = None
    turn: int = 1


@dataclass(frozen=True)
class Flank:
    """One curve that the cam is made of.

    Attributes:
        name: inner, outer, main, counter; "" where the cam has one flank only.
        side: σ, which side of the traced curve the cam lies on.
        distance: D [mm], of the flank from the traced curve.
        path: name of the traced curve; "" where there is only one.
        trace: the point that draws it.
        rim: material behind a flank that is touched from inside [mm].
        slack: what D is longer than the roller's radius [mm]: half of a groove's clearance.
    """

    name: str
    side: Literal[1, -1]
    distance: float
    path: str
    trace: TracePoint
    rim: float = 0.0
    slack: float = 0.0

    @property
    def roller(self) -> float:
        """Radius of the roller that touches it [mm]; 0 for an edge and for a face."""
        return self.distance - self.slack

    def roller_spin(self, s: Any, z: Any) -> tuple[Any, Any]:
        """How fast the roller turns on its pin over the cam's speed, and its θ-derivative.

        ``s``: s to s''' at n places. Without slip the centre runs at |T|, T = p' + J p, per radian
        on the cam, about the point of contact at the roller's radius from it: there the roller
        turns by σ |T|/Rr. The cam turns by one and, on an arm, the pin by φ' with the link.
        """
        (px, py), (dx, dy), (ax, ay), *_ = self.trace.position(s, z)
        tx, ty, share = dx + py, dy - px, self.side / self.roller
        length = (tx * tx + ty * ty) ** 0.5
        # (|T|)' = T · T'/|T| with T' = p'' + J p'
        change = (tx * (ax + dy) + ty * (ay - dx)) / length
        turns = []
        # the direction of drive turns with the link, at a rate in proportion to s': put with s''
        # in its place, it is the derivative of that rate
        for rate in (s[1], s[2]):
            (gx, gy), (hx, hy) = self.trace.drive_direction((s[0], rate), z)
            turns.append(gx * hy - gy * hx)
        return share * length - 1.0 + turns[0], share * change + turns[1]

    def scaled(self, by: float) -> Flank:
        """The same with its own lengths so many times as large; those of its trace stay."""
        return replace(self, distance=by * self.distance, rim=by * self.rim, slack=by * self.slack)


def edge_offset(flanks: Iterable[Flank], path: str) -> float:
    """What the cam's edge lacks to a traced curve [mm]: negative where the edge is outside."""
    mine = (flank for flank in flanks if flank.path == path)
    return min(flank.side * flank.distance - flank.rim for flank in mine)


def labelled(claim: str, label: str) -> str:
    """Name of a claim about one of several flanks or paths."""
    return f"{claim}_{label}" if label else claim
