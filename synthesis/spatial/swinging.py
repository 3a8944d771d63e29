"""Pressure angle of rollers on an arm across a cylindrical cam, as limits on motion and size.

Symbols: R radius of the cylinder; ρ distance from its axis along a roller; ψ angle of a roller's
arm from the line square to the cam's axis; s = lψ arc of the roller at the arm's length l;
t = tan α_max; χ = +1 where the cam turns about its axis z, −1 about −z, the arm swinging about −x.
The cam's surface passes the roller at χρ across z, and the roller's way leans from z by ψ. So
tan α = |s' − χρ sin ψ|/(ρ cos ψ), and α ≤ α_max reads

    s' ≤ ρ (t cos ψ + χ sin ψ)   and   −s' ≤ ρ (t cos ψ − χ sin ψ)

at every ρ; that of a cylindrical roller's inner end decides. For a settled law the least R is
known at every cam angle. For a free one rows are linear about the last law, and the laws' own
least R says what they are worth; no rows are known that refuse no law.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.spatial.leverage import Leverage
from synthesis.terms import Cuts, Vector, Within

NEVER = 1e9  # arms: no cylinder serves a roller that leans too much even at rest
LEANING = 1e-9  # what t cos ψ ± χ sin ψ is at least where one may


@dataclass(frozen=True)
class SwingPressure(Leverage):
    """R ≥ depth + speed over what the swing leaves of tan α, in the chart z = (R,).

    Attributes:
        starts: ψ of the rollers at s = 0 [rad]. arm: l [mm]. hand: χ.
        places: (depth below the cylinder [mm], t left there).
    """

    starts: tuple[float, ...]
    arm: float
    hand: int
    places: tuple[tuple[float, float], ...]
    safe: bool = False

    def made_safe(self) -> SwingPressure:
        return self  # its rows are about a law in any case

    def fastest(self, s: Array, size: float, sense: float) -> Array:
        psi = self._angles(s)
        found = np.full(len(s), np.inf)
        for depth, left in self.places:
            speed = (size - depth) * (left * np.cos(psi) + sense * self.hand * np.sin(psi))
            found = np.minimum(found, np.min(speed, axis=0))
        return found

    def least(self, s: Array) -> Array:
        """The least R at s and s' (2 or more, n) [mm]."""
        return np.asarray(np.max([self._least(s, *place) for place in self.places], axis=0))

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        return ((self.least(s) - z[0]) / self.arm,)

    def half_planes(self, s: Array) -> tuple[Cuts, ...]:
        return (Cuts(np.zeros_like(s), -np.ones((1, s.shape[1])), -self.least(s)),)

    def cuts(self, within: Within, about: tuple[Array, Vector] | None) -> tuple[Cuts, ...]:
        if about is None:
            return ()
        s, step = about[0], 1e-6 * self.arm
        value, slopes = self.least(s), []
        for order in (0, 1):
            moved = np.array(s)
            moved[order] += step
            slopes.append((self.least(moved) - value) / step)
        none = np.zeros_like(value)
        upper = slopes[0] * s[0] + slopes[1] * s[1] - value
        return (Cuts(np.stack([*slopes, none, none]), none[None, :] - 1.0, upper),)

    def _angles(self, s: Array) -> Array:
        """ψ of every roller at displacements s (n,): (rollers, n)."""
        return np.asarray(np.array(self.starts)[:, None] + s / self.arm)

    def _least(self, s: Array, depth: float, left: float) -> Array:
        psi = self._angles(s[0])
        found = np.zeros(s.shape[1])
        for sign in (1.0, -1.0):
            room = left * np.cos(psi) + sign * self.hand * np.sin(psi)
            needed = np.where(
                room > LEANING, sign * s[1] / np.maximum(room, LEANING), NEVER * self.arm
            )
            found = np.maximum(found, np.max(needed, axis=0))
        return np.asarray(depth + found)
