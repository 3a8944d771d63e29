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
from synthesis.limits.force import SMALL, loaded, pushing
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

    def drive(self, theta: Array) -> tuple[Array, Array]:
        load, flank = loaded(self.machine), self.flank
        way = flank.side * pushing(flank, self.machine)
        unit = way / (self.scale * flank.distance**2)
        by = np.array(load.coefficients(self.machine.omega)[:3])
        return by * unit, (self._process(theta, way) + load.constant) * unit

    def _process(self, theta: Array, way: int) -> Array:
        """The process force [N]; at a jump that side of it which presses harder."""
        load, stretch = loaded(self.machine), self.stretch
        inner = (stretch.start < theta) & (theta < stretch.end)
        after = load.process_on(stretch, theta)
        before = np.where(inner, load.process(theta, 0, "left"), after)
        return np.asarray(way * np.maximum(way * after, way * before))

    def grip(self, low: Array, high: Array, moving: Moving) -> tuple[Array, Array]:
        load, one = loaded(self.machine), np.ones(low.shape[1])
        if load.friction is None:
            return one, 0.0 * one
        ends = [load.friction.effective(s) + 0.0 * s for s in (moving.low[0], moving.high[0])]
        way = pushing(self.flank, self.machine) * load.sliding(self.stretch) * load.side
        slopes = np.stack([u / x for u in (low[1], high[1]) for x in (low[0], high[0])])
        flat, steep = np.min(slopes, axis=0), np.max(slopes, axis=0)
        if way > 0.0:  # φ = 1 − μ |tan α|, and |q| ≥ k q for |k| ≤ 1
            share = (flat + steep) / np.maximum(np.abs(flat) + np.abs(steep), SMALL)
            base, by = one, -np.maximum(np.minimum(*ends), 0.0) * share
        else:  # |q| lies below its chord
            width = np.maximum(steep - flat, SMALL)
            mixed = (flat < 0.0) & (steep > 0.0)
            share = np.where(mixed, (flat + steep) / width, np.sign(flat + steep))
            rest = np.where(mixed, -2.0 * flat * steep / width, 0.0)
            most = -way * np.maximum(*ends)
            base, by = one + most * rest, most * share
        least = np.minimum(base + by * flat, base + by * steep)
        largest = np.maximum(np.maximum(base + by * flat, base + by * steep), WEAKEST)
        held = least >= WEAKEST
        return np.where(held, base, largest), np.where(held, by, 0.0)
