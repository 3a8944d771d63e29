"""Quantities that the certificate measures on the finished cam for a follower."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from synthesis.catalogue.followers.flank import Flank


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
    side, distance, smallest = flank.side, flank.distance, flank.distance + least
    if smallest <= 0.0:
        return None

    def to_wire(curvature: float) -> float | None:
        convex = side * curvature
        return 1.0 / convex - distance if convex > 0.0 else None

    sharpest = side / smallest
    low, high = (None, sharpest) if side > 0 else (sharpest, None)
    return MeasuredBound("pitch_curvature", low, high, to_wire)
