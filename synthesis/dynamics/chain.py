"""A follower train as masses, springs and dampers, and its modes.

Units: mm, N, s; so a mass is in N s²/mm (1 kg is 1e-3 of them). Deflections y are measured from the
cam's motion s, each mass from where it would be were all springs rigid: M y'' + C y' + K y =
−M 1 s'' − c_g s' − k_g s, with c_g, k_g what holds the masses to the ground.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array

Complex = NDArray[np.complex128]
GROWS = 1e-9  # of the fastest rate: what rounding may make of an undamped mode


class StaticallyUnstable(ValueError):
    """Springs of negative stiffness that the others do not outweigh."""


@dataclass(frozen=True, eq=False)
class Chain:
    """n masses in a row, the first linked to the cam, every one perhaps held to the ground.

    Attributes:
        masses: (n,) [N s²/mm]. springs, dampers: (n,) of the link before each mass [N/mm, N s/mm].
        ground_springs, ground_dampers: (n,) between each mass and the ground.
        preload: force that holds the resting train on the cam at s = 0 [N].
    """

    masses: Array
    springs: Array
    dampers: Array
    ground_springs: Array
    ground_dampers: Array
    preload: float = 0.0

    @property
    def count(self) -> int:
        """n."""
        return len(self.masses)

    @cached_property
    def links(self) -> Array:
        """(n, n): y to the stretch of every link."""
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
        """Its modes.

        Raises:
            StaticallyUnstable: K is not positive definite.
        """
        return _modes(self)

    def root(self) -> Array:
        """R (n, n) upper triangular with R'R = M^(−½) K M^(−½).

        From the springs themselves: no digits of soft ones are lost to stiff ones.
        """
        scale = np.sqrt(self.masses)
        if np.any(self.ground_springs < 0.0):
            try:
                lower = np.linalg.cholesky(self.stiffness / np.outer(scale, scale))
            except np.linalg.LinAlgError as error:
                raise StaticallyUnstable from error
            return np.asarray(lower.T)
        rows = np.sqrt(self.springs)[:, None] * self.links
        held = np.diag(np.sqrt(self.ground_springs))
        return np.asarray(np.linalg.qr(np.vstack([rows, held]) / scale)[1])


@dataclass(frozen=True, eq=False)
class Modes:
    """ξ' = λ ξ + by_acceleration s'' + by_velocity s' + by_displacement s, y = Re(shapes ξ).

    In coordinates of energy, so that an undamped train's modes are orthogonal however different
    they are.

    Attributes:
        rates: (2n,) λ [1/s]. shapes, speeds: (n, 2n) of y and y'.
        by_acceleration, by_velocity, by_displacement: (2n,).
    """

    rates: Complex
    shapes: Complex
    speeds: Complex
    by_acceleration: Complex
    by_velocity: Complex
    by_displacement: Complex

    @cached_property
    def kept(self) -> NDArray[np.intp]:
        """One of every pair that swings, and all that do not, slowest first."""
        swings = self.rates.imag > GROWS * np.abs(self.rates)
        creeps = np.abs(self.rates.imag) <= GROWS * np.abs(self.rates)
        chosen = np.flatnonzero(swings | creeps)
        return chosen[np.argsort(np.abs(self.rates[chosen]), kind="stable")]

    @property
    def growing(self) -> complex | None:
        """The rate of a mode that grows by itself; None where there is none."""
        worst = self.rates[np.argmax(self.rates.real)]
        return complex(worst) if worst.real > GROWS * np.max(np.abs(self.rates)) else None

    def amplitudes(self, state: Complex) -> Array:
        """(n, kept) by how much every mass swings in every mode, of a free train at state ξ."""
        pairs = np.where(np.abs(self.rates[self.kept].imag) > 0.0, 2.0, 1.0)
        return np.asarray(pairs * np.abs(self.shapes[:, self.kept] * state[self.kept]))

    def at_rest(self, s: float) -> Complex:
        """The state of the train at rest while the cam rests at s [mm]."""
        return -self.by_displacement * s / self.rates


def _modes(chain: Chain) -> Modes:
    n, root, scale = chain.count, chain.root(), np.sqrt(chain.masses)
    system = np.zeros((2 * n, 2 * n))
    system[:n, n:], system[n:, :n] = root, -root.T
    system[n:, n:] = -chain.damping / np.outer(scale, scale)
    rates, vectors = np.linalg.eig(system)
    inverse = np.linalg.inv(vectors)
    rates = rates.astype(complex)
    quiet = np.abs(rates.real) <= GROWS * np.max(np.abs(rates))
    if not chain.damping.any():
        rates[quiet] = 1j * rates[quiet].imag
    pushes = inverse[:, n:]
    return Modes(
        rates,
        (np.linalg.solve(root, vectors[:n]) / scale[:, None]).astype(complex),
        (vectors[n:] / scale[:, None]).astype(complex),
        -(pushes @ scale).astype(complex),
        -(pushes @ (chain.ground_dampers / scale)).astype(complex),
        -(pushes @ (chain.ground_springs / scale)).astype(complex),
    )
