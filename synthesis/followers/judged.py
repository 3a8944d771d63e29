"""What judges ask of a follower: which bounds to measure on the finished cam, and what it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from synthesis.followers.flank import Flank
from synthesis.followers.link import Link


@dataclass(frozen=True)
class Measure:
    """What the certificate has to measure for a bound: lower ≤ quantity ≤ upper [core units].

    ``to_wire``: monotone map to the wire's ``unit``; None where the wire has no value.
    """

    quantity: str
    lower: float | None
    upper: float | None
    to_wire: Callable[[float], float | None]
    unit: str = "mm"


class Judged:
    """A follower as something that is measured."""

    def link(self, z: Any, degree: Any) -> Link | None:
        """The output link at displacement 0, in the arithmetic of z; None: not told yet.

        ``degree``: π/180 in that arithmetic.
        """
        return None

    def displacement_measure(self, z: tuple[float, ...]) -> Measure | None:
        """Between which displacements the follower can stand; None where all of them do."""
        return None

    def profile_radius_measure(self, flank: Flank, least: float) -> Measure | None:
        """Convex radius of a flank ≥ least on the finished cam; None where it cannot fail.

        Of a curve at the distance D: σκ ≤ 1/(D + least), free of division by what may vanish on
        the way from convex to hollow.
        """
        side, distance, smallest = flank.side, flank.distance, flank.distance + least
        if smallest <= 0.0:
            return None

        def to_wire(curvature: float) -> float | None:
            bend = side * curvature
            return 1.0 / bend - distance if bend > 0.0 else None

        sharpest = side / smallest
        low, high = (None, sharpest) if side > 0 else (sharpest, None)
        return Measure("pitch_curvature", low, high, to_wire)
