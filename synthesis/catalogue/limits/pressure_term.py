"""The limit on a roller's Hertz pressure as a term in the bound on the pitch curvature.

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

from synthesis.catalogue.constraints import MotionBox, PressureTerm
from synthesis.catalogue.followers.flank import Flank
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.limits.force import SMALL, load_of, push_sign
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array

WEAKEST = 1e-3  # φ: a guide that leaves less is nearly locked by its friction


@dataclass(frozen=True, eq=False)
class RollerPressureTerm(PressureTerm):
    """Of one flank on one segment.

    ``scale``: B p_max² [N/mm], pressure squared times what makes a force of it.
    """

    flank: Flank
    segment: PlacedSegment
    machine: Machine
    scale: float

    def linear_form(self, theta: Array) -> tuple[Array, Array]:
        load, flank = load_of(self.machine), self.flank
        way = flank.side * push_sign(flank, self.machine)
        unit = way / (self.scale * flank.distance**2)
        by = np.array(load.coefficients(self.machine.omega)[:3])
        return by * unit, (self._process(theta, way) + load.constant_force) * unit

    def _process(self, theta: Array, way: int) -> Array:
        """The process force [N]; at a jump that side of it which presses harder."""
        load, segment = load_of(self.machine), self.segment
        inner = (segment.start < theta) & (theta < segment.end)
        after = load.process_on(segment, theta)
        before = np.where(inner, load.process(theta, 0, "left"), after)
        return np.asarray(way * np.maximum(way * after, way * before))

    def friction_bound(self, low: Array, high: Array, moving: MotionBox) -> tuple[Array, Array]:
        load, one = load_of(self.machine), np.ones(low.shape[1])
        if load.friction is None:
            return one, 0.0 * one
        ends = [load.friction.effective(s) + 0.0 * s for s in (moving.low[0], moving.high[0])]
        way = push_sign(self.flank, self.machine) * load.sliding_sense(self.segment) * load.side
        # Range of q = tan α = u/X over the box: monotone in u and in X > 0.
        slopes = np.stack([u / x for u in (low[1], high[1]) for x in (low[0], high[0])])
        flat, steep = np.min(slopes, axis=0), np.max(slopes, axis=0)
        # φ = 1 ∓ μ |q|. Where friction takes force, |q| ≥ k q for |k| ≤ 1 bounds φ above; where it
        # gives force, |q| lies below its chord over the range.
        if way > 0.0:
            share = (flat + steep) / np.maximum(np.abs(flat) + np.abs(steep), SMALL)
            base, by = one, -np.maximum(np.minimum(*ends), 0.0) * share
        else:
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
