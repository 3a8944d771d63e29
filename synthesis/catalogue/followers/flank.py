"""The working curves of a cam: which of them a roller touches, on which side, how far away.

Notation: p(θ) a traced point, a roller's centre; its curve on the cam has the curvature κ, convex
positive, ρ = 1/κ, and the outward normal n. A flank at the distance D is the curve p − σ D n:

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

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Literal

from synthesis.catalogue.followers.kinematics import TracePoint


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


@dataclass(frozen=True)
class MeasuredBound:
    """lower ≤ quantity ≤ upper, in core units: what the certificate has to show.

    Attributes:
        quantity: a name that ``certify.quantities`` knows.
        lower, upper: the bounds; None where there is none.
        to_wire: monotone map to ``unit``; None where the wire has no value.
    """

    quantity: str
    lower: float | None
    upper: float | None
    to_wire: Callable[[float], float | None]
    unit: str = "mm"


def profile_radius_measure(flank: Flank, least: float, always_convex: bool) -> MeasuredBound | None:
    """Convex radius of a flank ≥ least [mm]; None where every curve satisfies it.

    Under a flat face, whose profile has no hollows, the radius itself is measured. Of a flank at
    the distance D from its traced curve it is the curvature, σκ ≤ 1/(D + least), which is free of
    division by what vanishes where the curve turns from convex to hollow.
    """
    if always_convex:
        return MeasuredBound("face_radius", least, None, float)
    return curvature_measure(flank, least, 1) if flank.distance + least > 0.0 else None


def curvature_measure(flank: Flank, least: float, sign: int) -> MeasuredBound:
    """Radius of a flank ≥ least [mm] where it is convex (sign +1) or hollow (−1).

    With c the sign that is c σκ ≤ 1/(least + c D), and the radius is 1/(c σκ) − c D.
    """
    side, distance = sign * flank.side, sign * flank.distance
    sharpest = side / (least + distance)

    def to_wire(curvature: float) -> float | None:
        bend = side * curvature
        return 1.0 / bend - distance if bend > 0.0 else None

    low, high = (None, sharpest) if side > 0 else (sharpest, None)
    return MeasuredBound("pitch_curvature", low, high, to_wire)
