"""How round walls may bulge around a turret's cylindrical rollers, as a limit on motion and size.

Symbols as in ``leverage``: C centre distance; ρ place on a roller, ψ its angle from the common
perpendicular; B = C − ρ cos ψ. The axis of a roller sweeps a ruled surface of the turning cam with
(derivatives by the cam angle)

    W² = (ρψ')² + B²,   K = −(Cψ')²/W⁴,   2H = ± [(ρψ'' − B sin ψ) B − 2 (ρψ')² sin ψ]/W³.

Of its two principal curvatures one is positive, and on one of the two walls that one bulges. A wall
is nowhere rounder than m, and with m = 0 not undercut, where r = Rr + m leaves

    1 − 2|H| r + K r² ≥ 0.

The larger C, the more is left, but where the roller's axis is nearer to the cam's than r, which no
cam's core allows. Source: derived here; mathematics of ruled surfaces as in
Gonzalez-Palacios and Angeles, Cam Synthesis, 1993.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil
from typing import Any, ClassVar

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.spatial.leverage import Leverage
from synthesis.terms import Cuts, Vector, Within

COARSE, HALVINGS, NEWTON = 13, 4, 3  # steps: which asks for most, how much, and exactly
FARTHEST = 1e2  # lengths L: no C is looked for beyond
HARDEST = 2  # of all rollers and places, those whose rows are written
STEP = 1e-5  # of a variable's size: differences


@dataclass(frozen=True)
class TurretBulge(Leverage):
    """1 − 2|H| r + K r² ≥ 0 for every roller within its mesh, in the chart z = (C,).

    Attributes:
        first: ψ of any roller at s = 0 [rad]. spacing: angle from roller to roller [rad].
        length: L, of the arc s = Lψ [mm]. radius: r [mm]. places: ρ that are looked at [mm].
        mesh: how far from the common perpendicular a roller meets the cam [rad].
    """

    order: ClassVar[int] = 2
    first: float
    spacing: float
    length: float
    radius: float
    places: tuple[float, ...]
    mesh: float
    safe: bool = False

    def fastest(self, s: Array, size: float, sense: float) -> Array:
        return np.full(len(s), np.inf)

    def made_safe(self) -> TurretBulge:
        return replace(self, safe=True)

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        return (np.asarray(np.max(-self._left(self._met(s), np.asarray(z[0])), axis=0)),)

    def half_planes(self, s: Array) -> tuple[Cuts, ...]:
        least = np.max(self._least(self._hardest(s)), axis=0)
        return (Cuts(np.zeros_like(s), -np.ones((1, s.shape[1])), -least),)

    def cuts(self, within: Within, about: tuple[Array, Vector] | None) -> tuple[Cuts, ...]:
        if not self.safe or about is None or len(about[0]) < 3:
            return ()
        hardest = np.moveaxis(self._hardest(about[0]), 1, 0)
        return tuple(self._tangent(met, about[0]) for met in hardest)

    def _met(self, s: Array) -> Array:
        """ρ, ψ, ψ' and ψ'' of all rollers and places: (4, rollers × places, n).

        Beyond its mesh a roller is taken as at its end.
        """
        q, q1, q2 = s[0] / self.length, s[1] / self.length, s[2] / self.length
        psi = self.first + q
        psi = psi - self.spacing * np.round(psi / self.spacing)
        count = max(ceil(self.mesh / self.spacing - 0.5), 0)
        others = np.arange(-count, count + 1)[:, None] * self.spacing + psi
        others = np.clip(others, -self.mesh, self.mesh)
        rho = np.repeat(self.places, len(others))[:, None]
        psi = np.tile(others, (len(self.places), 1))
        return np.array(np.broadcast_arrays(rho, psi, q1, q2))

    def _left(self, met: Array, size: Array) -> Array:
        """1 − 2|H| r + K r²."""
        rho, psi, q1, q2 = met
        off = size - rho * np.cos(psi)
        speed = np.hypot(rho * q1, off)
        bend = (rho * q2 - off * np.sin(psi)) * off - 2.0 * (rho * q1) ** 2 * np.sin(psi)
        twist = self.radius * size * q1 / speed**2
        return np.asarray(1.0 - self.radius * np.abs(bend) / speed**3 - twist**2)

    def _least(self, met: Array) -> Array:
        """The C from which on enough is left, of every roller and place."""
        low = np.maximum(met[0] * np.cos(met[1]), 0.0) + self.radius
        low, high = self._halved(met, low, np.full_like(low, FARTHEST * self.length), COARSE)
        low, high = self._halved(met, low, high, HALVINGS)
        for _ in range(NEWTON):
            wide = STEP * high
            left = self._left(met, high)
            slope = (self._left(met, high + wide) - left) / wide
            high = np.clip(high - left / np.where(slope > 0.0, slope, np.inf), low, high + wide)
        return high

    def _halved(self, met: Array, low: Array, high: Array, times: int) -> tuple[Array, Array]:
        for _ in range(times):
            middle = np.sqrt(low * high)
            enough = self._left(met, middle) >= 0.0
            low, high = np.where(enough, low, middle), np.where(enough, middle, high)
        return low, high

    def _hardest(self, s: Array) -> Array:
        """Of all rollers and places those that ask for most at each s (3, n): (4, HARDEST, n)."""
        met = self._met(s)
        low = np.maximum(met[0] * np.cos(met[1]), 0.0) + self.radius
        low, _ = self._halved(met, low, np.full_like(low, FARTHEST * self.length), COARSE)
        rows = np.argpartition(-low, HARDEST, axis=0)[:HARDEST]
        return met[:, rows, np.arange(met.shape[2])]

    def _tangent(self, met: Array, s: Array) -> Cuts:
        """The least C as a linear function about a motion: rows of s, s', s'' and C."""
        least, slopes = self._least(met), []
        for row in (1, 2, 3):
            step = STEP * max(float(np.max(np.abs(met[row]))), 1.0)
            moved = met.copy()
            moved[row] += step
            slopes.append((self._least(moved) - least) / step / self.length)
        coefficients = np.stack([*slopes, 0.0 * least])
        upper = np.sum(coefficients[:3] * s[:3], axis=0) - least
        return Cuts(coefficients, np.full((1, len(least)), -1.0), upper)
