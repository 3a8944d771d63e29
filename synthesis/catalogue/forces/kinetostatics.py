"""Rigid-body kinetostatics at one place: forces from motion and geometry, in any arithmetic.

Written for numbers, arrays and enclosures alike. N, mm, kg, s, MPa; see the package for symbols.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from synthesis.catalogue.followers.flank import Flank
from synthesis.catalogue.forces.reduced import MILLI, ReducedLoad


@dataclass(frozen=True, eq=False)
class ContactState:
    """Where the follower is, and how its contact stands.

    Attributes:
        load, omega: what loads it, at a cam speed [rad/s].
        s: s to s'' [mm, per rad]. process: P [N]. sense: of sliding, 1, 0 or −1.
        sine, cosine: of the pressure angle. lever: λ.
    """

    load: ReducedLoad
    omega: float
    s: tuple[Any, ...]
    process: Any
    sense: Any
    sine: Any
    cosine: Any
    lever: Any

    def drive(self) -> Any:
        """G = m a + c v + k s ± F0 + P + W [N], with v = s' ω and a = s'' ω²."""
        load, (s, v, a, *_) = self.load, self.s
        metres = v * (self.omega * MILLI), a * (self.omega * self.omega * MILLI)
        moved = metres[1] * load.mass + metres[0] * load.damping
        return moved + s * load.rate + (self.process + load.constant_force)

    def contact_force(self) -> Any:
        """N [N], positive where the flank of side σ is pressed: G = N (λ cos α − friction)."""
        resisted = self.load.friction_loss(self.sense, self.sine, self.s[0], np.absolute)
        return self.drive() / (self.lever * self.cosine - resisted)

    def torque(self) -> Any:
        """T [N m]: what the contact force gives along the slide, times s'; friction included."""
        if self.load.friction is None:
            return self.drive() * self.s[1] * MILLI
        return self.contact_force() * self.lever * self.cosine * self.s[1] * MILLI


def pressure_square(load: ReducedLoad, flank: Flank, force: Any, curvature: Any) -> Any:
    """p² of a roller on a flank [MPa²]; where it is not pressed, negative.

    The profile's curvature, 1/R2 = σκ/(1 − Dσκ), has the sign of the flank: hollow flanks fit the
    roller and lower the pressure. With R1 its radius p² = N (1/R1 + 1/R2)/B.

    Args:
        force: N [N], as ``contact_force`` says. curvature: κ of the traced curve [1/mm].
    """
    assert load.contact is not None
    bend = curvature * flank.side
    profile = bend / (1.0 - bend * flank.distance)
    return force * (flank.side / load.contact.stiffness) * (profile + 1.0 / flank.roller)


def face_pressure_square(load: ReducedLoad, force: Any, radius: Any) -> Any:
    """p² under a flat face [MPa²]: p² = N/(B ρ), ρ the profile's radius [mm]."""
    assert load.contact is not None
    return force / (radius * load.contact.stiffness)
