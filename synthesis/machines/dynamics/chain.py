"""A follower train as a chain of masses, springs and dampers, and its modes.

Units: mm, N, s, so that masses are in N s²/mm (1 kg is 1e-3 of them). The deflection y of a mass is
its displacement minus the cam's motion s:

    M y'' + C y' + K y = −M 1 s'' − c_g s' − k_g s,

with c_g, k_g the dampers and springs between the masses and the ground.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array

Complex = NDArray[np.complex128]
RATE_ROUNDING = 1e-9  # of the fastest rate: smaller positive real parts are rounding


class StaticallyUnstable(ValueError):
    """K is not positive definite: springs of negative stiffness outweigh the others."""


@dataclass(frozen=True, eq=False)
class Chain:
    """n masses in a row, the first linked to the cam, each with or without a link to the ground."""

    masses: Array  # (n,) [N s²/mm]
    springs: Array  # (n,) of the link before each mass [N/mm]
    dampers: Array  # (n,) of that link [N s/mm]
    ground_springs: Array  # (n,) between each mass and the ground
    ground_dampers: Array
    preload: float = 0.0  # contact force of the train at rest at s = 0 [N]

    @property
    def count(self) -> int:
        """n."""
        return len(self.masses)

    def contact_force(self, y: Array, speed: Array) -> Array:
        """Force of the cam on the first link [N], at y and y' of the first mass."""
        return np.asarray(self.preload - (self.springs[0] * y + self.dampers[0] * speed))

    @cached_property
    def links(self) -> Array:
        """(n, n): from y to the elongation of every link."""
        return np.eye(self.count) - np.eye(self.count, k=-1)

    @cached_property
    def stiffness(self) -> Array:
        """K (n, n) [N/mm]."""
        return self.links.T @ (self.springs[:, None] * self.links) + np.diag(self.ground_springs)

    @cached_property
    def damping(self) -> Array:
        """C (n, n) [N s/mm]."""
        return self.links.T @ (self.dampers[:, None] * self.links) + np.diag(self.ground_dampers)

    @cached_property
    def modes(self) -> Modes:
        """The modes of the state equations.

        Raises:
            StaticallyUnstable: K is not positive definite.
        """
        n, root, scale = self.count, self.root(), np.sqrt(self.masses)
        system = np.zeros((2 * n, 2 * n))
        system[:n, n:], system[n:, :n] = root, -root.T
        system[n:, n:] = -self.damping / np.outer(scale, scale)
        # The state in energy coordinates (R M^½ y, M^½ y'): without dampers its matrix is skew.
        rates, vectors = np.linalg.eig(system)
        inverse = np.linalg.inv(vectors)
        rates = rates.astype(complex) if self.damping.any() else 1j * rates.imag
        input_ = inverse[:, n:]
        return Modes(
            rates,
            (np.linalg.solve(root, vectors[:n]) / scale[:, None]).astype(complex),
            (vectors[n:] / scale[:, None]).astype(complex),
            -(input_ @ scale).astype(complex),
            -(input_ @ (self.ground_dampers / scale)).astype(complex),
            -(input_ @ (self.ground_springs / scale)).astype(complex),
        )

    def root(self) -> Array:
        """R (n, n) upper triangular with R'R = M^(−½) K M^(−½).

        By QR of the springs themselves, so that soft springs lose no digits to stiff ones.
        """
        scale = np.sqrt(self.masses)
        if np.any(self.ground_springs < 0.0):
            try:
                lower = np.linalg.cholesky(self.stiffness / np.outer(scale, scale))
            except np.linalg.LinAlgError as error:
                raise StaticallyUnstable from error
            return np.asarray(lower.T)
        rows = np.sqrt(self.springs)[:, None] * self.links
        ground = np.diag(np.sqrt(self.ground_springs))
        return np.asarray(np.linalg.qr(np.vstack([rows, ground]) / scale)[1])


@dataclass(frozen=True, eq=False)
class Modes:
    """ξ' = λ ξ + by_acceleration s'' + by_velocity s' + by_displacement s, y = Re(shapes ξ).

    From energy coordinates, in which an undamped train's modes are orthogonal.
    """

    rates: Complex  # (2n,) λ [1/s]
    shapes: Complex  # (n, 2n) of y
    speeds: Complex  # (n, 2n) of y'
    by_acceleration: Complex  # (2n,), as the two below
    by_velocity: Complex
    by_displacement: Complex

    @cached_property
    def independent(self) -> NDArray[np.intp]:
        """One mode of every conjugate pair, and all real ones, slowest first."""
        chosen = np.flatnonzero(self.rates.imag >= 0.0)
        return chosen[np.argsort(np.abs(self.rates[chosen]), kind="stable")]

    @property
    def unstable_rate(self) -> complex | None:
        """The rate λ of a mode with positive real part; None where there is none."""
        worst = self.rates[np.argmax(self.rates.real)]
        return complex(worst) if worst.real > RATE_ROUNDING * np.max(np.abs(self.rates)) else None

    def amplitudes(self, state: Complex) -> Array:
        """(n, independent) amplitudes of the masses in every mode, of a free train at state ξ."""
        pairs = np.where(np.abs(self.rates[self.independent].imag) > 0.0, 2.0, 1.0)
        return np.asarray(
            pairs * np.abs(self.shapes[:, self.independent] * state[self.independent])
        )

    def rest_state(self, s: float) -> Complex:
        """The state of equilibrium while the cam dwells at s [mm]."""
        return -self.by_displacement * s / self.rates
