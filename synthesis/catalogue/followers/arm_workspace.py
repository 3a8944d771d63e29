"""Workspace of an arm on a pivot: which prime radii and swings are possible; refusals.

Symbols: l arm; d distance of the pivot from the cam's axis; ψ angle between the line to the axis
and the arm, ψ0 at the lowest position; Rp prime radius. A triangle needs |l − d| < Rp < l + d, and
the arm drives its roller outwards only while 0 < ψ < 180°.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from pydantic_core import PydanticCustomError
from scipy.optimize import brentq

from synthesis.catalogue.constraints import Ends
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.geometry.plane import enclosed_angle, third_side
from synthesis.units import DEGREE

SAME = 1e-9  # relative: two dimensions that give the same prime radius, but for rounding
LEAST_EXCESS = 1e-8  # relative: excess of the prime radius over its infimum, where no force drives
SAMPLES = 721  # per segment: a crossing is bracketed to a 720th of it


@dataclass(frozen=True)
class ArmGeometry:
    """Arm and pivot as far as they are given.

    ``length`` l, ends of ``distance`` d [mm] and of ``angle`` ψ0 [rad], open ones infinite;
    ``gap``: prime radius less base radius [mm].
    """

    length: float
    distance: Ends
    angle: Ends
    gap: float

    @property
    def pivot(self) -> float | None:
        """d where it is a number."""
        low, high = self.distance
        return low if low == high else None

    def angles(self, prime: Ends) -> Ends:
        """Ends of ψ0 for prime radii between two ends, d being a number [rad]."""
        low, high = (max(self.angle[0], 0.0), min(self.angle[1], math.pi))
        if low == high:
            return low, high
        assert self.pivot is not None
        least, most = (enclosed_angle(self.length, self.pivot, radius) for radius in prime)
        high = min(high, most)
        return min(max(low, least), high), high

    @property
    def least_angle(self) -> float:
        """ψ0 at which Rp is larger than at 0 by no more than rounding of a design shows [rad].

        At ψ0 = 0 the cam drives the arm nowhere: the least of all prime radii is not reached.
        """
        l, d = self.length, self.pivot or math.inf
        return math.sqrt(2.0 * LEAST_EXCESS * (l - d) ** 2 / (l * d)) if d < math.inf else 0.0

    @property
    def least_radius(self) -> float:
        """The least prime radius of all distances at which ψ0 is as large as asked [mm].

        For each distance it grows with ψ0. For each ψ0 it is least at d = l cosψ0, where the
        roller's radius is square to the line of centres, or at the end of d's range nearest to it.
        """
        angle = min(max(self.angle[0], 0.0), math.pi)
        nearest = max(self.distance[0], 0.0)
        foot = min(max(self.length * math.cos(angle), nearest), self.distance[1])
        return third_side(self.length, foot, angle)

    def prime_radii_for(self, prime: Ends, stroke: float) -> Ends:
        """The part of a range of prime radii at which the arm can swing by s = stroke [mm]."""
        if self.pivot is None:
            return prime
        low, high = self.angles(prime)
        high = min(high, math.pi - stroke / self.length)
        radii = (third_side(self.length, self.pivot, angle) for angle in (low, high))
        return tuple(  # to the last bit where it is the range that counts
            given if math.isclose(found, given, rel_tol=SAME) else found
            for found, given in zip(radii, prime, strict=True)
        )  # type: ignore[return-value]

    def check(self, prime: Ends, segments: Segments) -> None:
        """Refuse what no prime radius between two ends [mm] can serve."""
        low, high = self.distance
        if high <= 0.0 or low == high <= 0.0:
            raise PydanticCustomError(
                "centre_distance_positive",
                "centre_distance_mm = {value} leaves no positive distance. Give a positive one.",
                {"value": high},
            )
        self._check_triangle(prime, segments)
        self._check_angle(prime)
        self._check_swing(prime, segments)

    def _check_triangle(self, prime: Ends, segments: Segments) -> None:
        l, (d0, d1) = self.length, (max(self.distance[0], 0.0), self.distance[1])
        shortest = max(d0 - l, l - d1, 0.0)
        if prime[1] <= shortest or prime[0] >= l + d1:
            wrong = prime[1] if prime[1] <= shortest else prime[0]
            lowest = min(segments, key=lambda s: min(s.s_start, s.s_end))
            at = lowest.start if lowest.s_start <= lowest.s_end else lowest.end
            raise PydanticCustomError(
                "arm_does_not_reach",
                "at cam angle {at}° (program/{index}), at its lowest, arm_mm = {arm} cannot hold "
                "its roller on the prime radius {prime} mm (base radius plus roller radius): with "
                "the pivot at the distance given it reaches radii from {least} to {most} mm. "
                "Change arm_mm, centre_distance_mm or base_radius_mm.",
                {"arm": l, "prime": f"{wrong:.6g}", "least": f"{shortest:.6g}",
                 "most": f"{l + d1:.6g}" if math.isfinite(d1) else "∞",
                 "at": round(at / DEGREE % 360.0, 4), "index": lowest.index},
            )  # fmt: skip

    def _check_angle(self, prime: Ends) -> None:
        low, high = self.angle
        if high <= 0.0 or low >= math.pi:
            raise PydanticCustomError(
                "initial_angle_range",
                "initial_angle_deg = {value} leaves no angle between 0° and 180°. Give one in "
                "between, or leave it out: it follows from the base radius.",
                {"value": (high if high <= 0.0 else low) / DEGREE},
            )
        if self.pivot is None:
            return
        least, most = (
            third_side(self.length, self.pivot, min(max(angle, 0.0), math.pi))
            for angle in (low, high)
        )
        if least > prime[1] * (1.0 + SAME) or most < prime[0] * (1.0 - SAME):
            above = least > prime[1]
            angle, found, limit = (low, least, prime[1]) if above else (high, most, prime[0])
            raise PydanticCustomError(
                "initial_angle_contradicts",
                "initial_angle_deg = {angle} puts the roller on the prime radius {found} mm, "
                "not on that of base_radius_mm plus roller radius, {prime} mm. Leave out one "
                "of the two: either follows from the other.",
                {"angle": round(angle / DEGREE, 9), "found": f"{found:.6g}",
                 "prime": f"{limit:.6g}"},
            )  # fmt: skip

    def _check_swing(self, prime: Ends, segments: Segments) -> None:
        start = max(self.angle[0], 0.0) if self.pivot is None else self.angles(prime)[0]
        limit = self.length * (math.pi - start)
        if max(max(s.s_start, s.s_end) for s in segments) < limit:
            return
        segment = next(s for s in segments if max(s.s_start, s.s_end) >= limit)
        base = None if self.pivot is None else third_side(self.length, self.pivot, start)
        raise PydanticCustomError(
            "swing_too_large",
            "at cam angle {at}° (program/{index}) the arm has swung by {swing}° from {start}°"
            "{where}: at 180° it is stretched along the line of centres and can be driven no "
            "further. Make the lift smaller{way}.",
            {"swing": round(180.0 - start / DEGREE, 6), "index": segment.index,
             "at": round(_crossing(segment, limit) / DEGREE, 4), "start": round(start / DEGREE, 6),
             "where": "" if base is None else f" (base radius {base - self.gap:.6g} mm)",
             "way": "" if base is None else ", the base radius smaller, or the pivot farther"},
        )  # fmt: skip


def feasible_arm_lengths(requested: Ends, distance: Ends, prime: Ends) -> Ends:
    """The part of a range of lengths [mm] at which some triangle is possible; all if none is."""
    nearest, farthest = max(distance[0], 0.0), distance[1]
    low = max(requested[0], nearest - prime[1], prime[0] - farthest)
    high = min(requested[1], farthest + prime[1])
    return (low, high) if low < high else requested


def _crossing(segment: PlacedSegment, level: float) -> float:
    """Cam angle at which a segment first gets to a displacement; of a free law, its end [rad]."""
    if segment.law is None or segment.s_start >= level:
        return segment.start if segment.s_start >= level else segment.end
    curve = segment.placed()
    theta = np.linspace(segment.start, segment.end, SAMPLES)
    over = curve(theta) >= level
    if not over.any():
        return segment.end
    first = int(np.argmax(over))
    return float(brentq(lambda at: float(curve(at)) - level, theta[first - 1], theta[first]))
