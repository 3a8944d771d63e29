"""Pressure angle of the rollers on a turret, as limits on motion and size together.

Symbols: C centre distance; ρ place on a roller, from the turret's axis; ψ a roller's angle from the
common perpendicular, ψ' its derivative by the cam angle; t = tan α_max. A cylindrical roller's
normal and way make the angle tan α = ρ|ψ'|/(C − ρ cos ψ); see ``geometry.swept_roller``. So
α ≤ α_max reads

    C ≥ ρ (cos ψ + |ψ'|/t),

for every roller that meets the cam and every ρ. The right side grows with ρ, so that the roller's
outer end decides, and with cos ψ, so that the roller nearest to the common perpendicular does. On a
crowned roller the contact at ρ has its foot at ρ + r r' and its normal leans by r' more:
1 + tan² α = (1 + r'²)(1 + tan² α_foot), which leaves a smaller t to every ρ; no end decides alone.

The displacement is the arc s = L ψ of the outer end. For a settled law the least C is the largest
right side. For a free one cos ψ is concave in ψ: its tangents give rows that keep every law safe,
its chords over what ψ can be give rows that refuse no law that is.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from math import pi
from typing import Any, ClassVar

import numpy as np

from synthesis.geometry.swept_roller import Roller
from synthesis.numerics.piecewise import Array
from synthesis.spatial.roller import steepest as roller_feet
from synthesis.terms import Curved, Cuts, Vector, Within

UPRIGHT = 0.5 * pi


@dataclass(frozen=True)
class Leverage(Curved):
    """A limit that leaves the less speed the smaller the cam; it bends one way in the motion."""

    order: ClassVar[int] = 1

    @abstractmethod
    def fastest(self, s: Array, size: float, sense: float) -> Array:
        """The largest speed [mm/rad] that it leaves at displacements s (n,) and a size [mm].

        Args:
            sense: +1 of motion towards growing s, −1 of the other.
        """

    @abstractmethod
    def made_safe(self) -> Leverage:
        """The same, its rows about a law excluding whatever breaks it."""


@dataclass(frozen=True)
class TurretPressure(Leverage):
    """C ≥ ρ cos ψ + |s'| b for all (ρ, b), in the chart z = (C,).

    Attributes:
        first: ψ of any roller at s = 0 [rad]. spacing: angle from roller to roller [rad].
        length: L, of the arc s [mm]. places: (ρ, b) with b = ρ/(L t) [mm, 1].
        safe: rows are to exclude what breaks the limit, by tangents, not merely to hold for all
            that keeps it, by chords.
    """

    first: float
    spacing: float
    length: float
    places: tuple[tuple[float, float], ...]
    safe: bool = False

    def nearest(self, s: Array) -> Array:
        """ψ of the roller nearest to the common perpendicular at displacements s [mm]."""
        psi = self.first + s / self.length
        return np.asarray(psi - self.spacing * np.round(psi / self.spacing))

    def fastest(self, s: Array, size: float, sense: float) -> Array:
        cosine = np.cos(self.nearest(s))
        return np.asarray(np.min([(size - rho * cosine) / b for rho, b in self.places], axis=0))

    def made_safe(self) -> TurretPressure:
        return replace(self, safe=True)

    def least(self, s: Array) -> Array:
        """The least C at s and s' (2 or more, n) [mm]."""
        cosine, speed = np.cos(self.nearest(s[0])), np.abs(s[1])
        return np.asarray(np.max([rho * cosine + b * speed for rho, b in self.places], axis=0))

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        return ((self.least(s) - z[0]) / self.length,)

    def half_planes(self, s: Array) -> tuple[Cuts, ...]:
        return (Cuts(np.zeros_like(s), -np.ones((1, s.shape[1])), -self.least(s)),)

    def cuts(self, within: Within, about: tuple[Array, Vector] | None) -> tuple[Cuts, ...]:
        if self.safe and about is not None:
            lines, place = self._tangents(about[0][0]), self._hardest
        else:
            lines, place = [self._chord(within)], max(self.places, key=lambda each: each[1])
        return tuple(
            self._rows(value, slope, place, sign)
            for value, slope in lines
            for sign, possible in ((1.0, within.fast > 0.0), (-1.0, within.slow < 0.0))
            if np.any(possible)
        )

    @property
    def _hardest(self) -> tuple[float, float]:
        """A place that asks for as much as any."""
        return max(rho for rho, _ in self.places), max(b for _, b in self.places)

    def _rows(self, value: Array, slope: Array, place: tuple[float, float], sign: float) -> Cuts:
        """ρ (value + slope s/L) + sign b s' ≤ C."""
        (rho, b), none = place, np.zeros_like(value)
        coefficients = np.stack([rho / self.length * slope, none + sign * b, none, none])
        return Cuts(coefficients, none[None, :] - 1.0, -rho * value)

    def _tangents(self, s: Array) -> list[tuple[Array, Array]]:
        """Cosines of the two nearest rollers about s (n,): value at s = 0, slope by s/L."""
        near = self.nearest(s)
        next_one = near - self.spacing * np.where(near > 0.0, 1.0, -1.0)
        lines = []
        for psi in (near, next_one):
            slope = -np.sin(psi)
            lines.append((np.cos(psi) - slope * s / self.length, slope))
        return lines

    def _chord(self, within: Within) -> tuple[Array, Array]:
        """The best line below the nearest roller's cosine wherever the motion is ``within``."""
        finite = np.isfinite(within.high) & np.isfinite(within.low)
        low, high = np.where(finite, within.low, 0.0), np.where(finite, within.high, 0.0)
        middle = 0.5 * (low + high)
        psi, half = self.nearest(middle), 0.5 * (high - low) / self.length
        known = finite & (np.abs(psi) + half <= UPRIGHT)  # only there the cosine is concave
        # cos(ψ ± δ) = cos ψ cos δ ∓ sin ψ sin δ
        half = np.where(known, half, 0.0)
        slope, height = -np.sin(psi) * np.sinc(half / pi), np.cos(psi) * np.cos(half)
        lowest = np.full_like(height, np.cos(0.5 * self.spacing))
        higher = known & (height > lowest)
        at_zero = height - slope * middle / self.length
        return np.where(higher, at_zero, lowest), np.where(higher, slope, 0.0)


def places(roller: Roller, length: float, slope: float) -> tuple[tuple[float, float], ...]:
    """(ρ, b) of a roller: of a cylindrical one its outer end alone.

    Args:
        roller: on the turret. length: L [mm]. slope: tan α_max; every r' is below it.
    """
    if roller.crown == 0.0:
        return ((roller.outer, roller.outer / (length * slope)),)
    pairs = roller_feet(roller, slope)
    return tuple((foot, foot / (length * left)) for foot, left in pairs)


def steepest(roller: Roller) -> float:
    """The largest |r'|: tan of the pressure angle that a roller has even at rest."""
    _, lean, _ = roller.profile(np.array([roller.inner, roller.outer]))
    return float(np.max(np.abs(lean)))
