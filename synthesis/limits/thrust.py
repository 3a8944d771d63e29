"""What presses a roller against its cam under a limit on the Hertz pressure, for implied rows.

With D the flank's distance from the roller's centre, R1 the roller's radius, ℓ = ±G/(B p_max²) [mm]
and φ = 1 − friction/cos α the limit reads ℓ [(1 − Dσκ)/R1 + σκ] ≤ φ cos α (1 − Dσκ). Without a
slack D = R1, and it is

    ℓ/D² ≤ φ cos α (1/D − σκ)

A slack D − R1 > 0 presses harder, so that this follows from the limit there too. The right side is
not negative, so that a φ that is too large asks for less.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.followers.flank import Flank
from synthesis.limits.base import Machine
from synthesis.limits.force import loaded, pushing
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.terms import Moving, Thrust

WEAKEST = 1e-3  # φ: below, nothing more is said of a guide that is nearly locked by its friction


@dataclass(frozen=True, eq=False)
class RollerThrust(Thrust):
    """Of one flank on one stretch.

    ``scale``: B p_max² [N/mm], pressure squared times what makes a force of it.
    """

    flank: Flank
    stretch: Stretch
    machine: Machine
    scale: float

    def least(self, low: Array, high: Array, moving: Moving) -> tuple[Array, Array]:
        load, flank = loaded(self.machine), self.flank
        way = flank.side * pushing(flank, self.machine)
        unit = way / (self.scale * flank.distance**2 * self._grip(low, high, moving))
        by = np.array(load.coefficients(self.machine.omega)[:3])
        return by[:, None] * unit, (self._process(moving.theta, way) + load.constant) * unit

    def _process(self, theta: Array, way: int) -> Array:
        """The process force [N]; at a jump that side of it which presses harder."""
        load, stretch = loaded(self.machine), self.stretch
        inner = (stretch.start < theta) & (theta < stretch.end)
        after = load.process_on(stretch, theta)
        before = np.where(inner, load.process(theta, 0, "left"), after)
        return np.asarray(way * np.maximum(way * after, way * before))

    def _grip(self, low: Array, high: Array, moving: Moving) -> Array:
        """φ at most: (n,)."""
        load, pushed = loaded(self.machine), pushing(self.flank, self.machine)
        if load.friction is None:
            return np.ones(low.shape[1])
        sense = pushed * load.sliding(self.stretch) * load.side
        speed = np.maximum(np.abs(low[1]), np.abs(high[1])), _nearest(low[1], high[1])
        steep, flat = speed[0] / low[0], speed[1] / high[0]
        ends = np.stack([load.friction.effective(s) + 0.0 * s for s in (moving.low[0], moving.high[0])])
        taken = np.min(ends, axis=0) * flat if sense > 0.0 else np.max(ends, axis=0) * steep
        return np.asarray(np.maximum(1.0 - sense * np.maximum(taken, 0.0), WEAKEST))


def _nearest(low: Array, high: Array) -> Array:
    """The least |u| between two ends."""
    return np.maximum(np.maximum(low, -high), 0.0)
