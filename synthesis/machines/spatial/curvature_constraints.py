"""Least radius of convex walls around a turret's cylindrical rollers, on motion and size together.

Symbols as in ``pressure_angle_constraints``: C centre distance; ρ place on a roller, ψ its angle
from the common perpendicular; B = C − ρ cos ψ. Seen from the turning cam, a roller's axis sweeps a
ruled surface with the first and second fundamental forms (derivatives by the cam angle)

    W² = (ρψ')² + B²,   K = −(Cψ')²/W⁴,   2H = ± [(ρψ'' − B sin ψ) B − 2 (ρψ')² sin ψ]/W³.

The walls are its offset surfaces at ±Rr. K ≤ 0, so that one principal curvature is positive, and on
one of the two walls that one is convex. A wall's convex radius is at least m, and with m = 0 the
wall is not undercut, where an offset by r = Rr + m is regular:

    1 − 2|H| r + K r² ≥ 0.

The left side grows with C except where the roller's axis is nearer to the cam's than r, which the
cam's core excludes. Derived here; ruled surfaces of indexing cams as in Gonzalez-Palacios and
Angeles, Cam Synthesis, 1993.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Any, ClassVar

import numpy as np

from synthesis.catalogue.constraints import MotionSizeBox, PointInequalities, Vector
from synthesis.machines.spatial.pressure_angle_constraints import SizeConstraint
from synthesis.numerics.piecewise import Array

FARTHEST = 1e2  # lengths L: upper end of the interval that is searched for the least C
COARSE = 13  # halvings that rank the rollers and places: 2^−13 of the logarithmic interval
HALVINGS, NEWTON = 4, 3  # further halvings into Newton's region, and steps to rounding
HARDEST = 2  # of all rollers and places, those that get rows; others follow as the motion changes
STEP = 1e-5  # relative: forward differences


@dataclass(frozen=True)
class TurretWallRadius(SizeConstraint):
    """1 − 2|H| r + K r² ≥ 0 for every roller in mesh; z = (C,).

    Attributes:
        first: ψ of any roller at s = 0 [rad]. spacing: angle from roller to roller [rad].
        length: L, of the arc s = Lψ [mm]. radius: r [mm]. places: ρ that are checked [mm].
        mesh: largest angle from the common perpendicular at which a roller meshes [rad].
    """

    order: ClassVar[int] = 2
    first: float
    spacing: float
    length: float
    radius: float
    places: tuple[float, ...]
    mesh: float

    @property
    def scale(self) -> float:
        return self.length

    def max_speed(self, s: Array, size: float, sense: float) -> Array:
        return np.full(len(s), np.inf)  # it bounds the acceleration, at any speed

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        return (np.asarray(np.max(-self._regularity(self._states(s), np.asarray(z[0])), axis=0)),)

    def least_size(self, s: Array) -> Array:
        return np.asarray(np.max(self._least(self._hardest(s)), axis=0))

    def relax(
        self, box: MotionSizeBox, about: tuple[Array, Vector] | None
    ) -> tuple[PointInequalities, ...]:
        if not self.inner or about is None or len(about[0]) < 3:
            return ()
        hardest = np.moveaxis(self._hardest(about[0]), 1, 0)
        return tuple(self._tangent(states, about[0]) for states in hardest)

    def _states(self, s: Array) -> Array:
        """ρ, ψ, ψ' and ψ'' of all rollers and places: (4, rollers × places, n).

        A roller outside its mesh is taken at the end of it.
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

    def _regularity(self, states: Array, size: Array) -> Array:
        """1 − 2|H| r + K r²."""
        rho, psi, q1, q2 = states
        off = size - rho * np.cos(psi)
        speed = np.hypot(rho * q1, off)
        bend = (rho * q2 - off * np.sin(psi)) * off - 2.0 * (rho * q1) ** 2 * np.sin(psi)
        twist = self.radius * size * q1 / speed**2
        return np.asarray(1.0 - self.radius * np.abs(bend) / speed**3 - twist**2)

    def _least(self, states: Array) -> Array:
        """The C from which on the offset is regular, of every roller and place."""
        # Bisection on log C brackets the root, Newton's method within the bracket refines it.
        low, high = self._bisect(states, *self._interval(states), COARSE)
        low, high = self._bisect(states, low, high, HALVINGS)
        for _ in range(NEWTON):
            wide = STEP * high
            left = self._regularity(states, high)
            slope = (self._regularity(states, high + wide) - left) / wide
            high = np.clip(high - left / np.where(slope > 0.0, slope, np.inf), low, high + wide)
        return high

    def _interval(self, states: Array) -> tuple[Array, Array]:
        """C between the roller's axis at a distance r from the cam's, and ``FARTHEST``."""
        low = np.maximum(states[0] * np.cos(states[1]), 0.0) + self.radius
        return low, np.full_like(low, FARTHEST * self.length)

    def _bisect(self, states: Array, low: Array, high: Array, times: int) -> tuple[Array, Array]:
        for _ in range(times):
            middle = np.sqrt(low * high)
            enough = self._regularity(states, middle) >= 0.0
            low, high = np.where(enough, low, middle), np.where(enough, middle, high)
        return low, high

    def _hardest(self, s: Array) -> Array:
        """Of all rollers and places those with the largest least C: (4, HARDEST, n)."""
        states = self._states(s)
        low, _ = self._bisect(states, *self._interval(states), COARSE)
        rows = np.argpartition(-low, HARDEST, axis=0)[:HARDEST]
        return states[:, rows, np.arange(states.shape[2])]

    def _tangent(self, states: Array, s: Array) -> PointInequalities:
        """Linear approximation of the least C about a motion, as rows in s, s', s'' and C."""
        least, slopes = self._least(states), []
        for row in (1, 2, 3):
            step = STEP * max(float(np.max(np.abs(states[row]))), 1.0)
            moved = states.copy()
            moved[row] += step
            slopes.append((self._least(moved) - least) / step / self.length)
        coefficients = np.stack([*slopes, 0.0 * least])
        upper = np.sum(coefficients[:3] * s[:3], axis=0) - least
        return PointInequalities(coefficients, np.full((1, len(least)), -1.0), upper)
