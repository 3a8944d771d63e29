"""The crank's motion over one turn, at constant speed or constant angular acceleration."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from synthesis.errors import InputError
from synthesis.units import FULL_TURN

Value = Any  # an array, or Taylor models of the same


@dataclass(frozen=True)
class Drive:
    """The crank's motion over the analysed turn.

    Attributes:
        start: φ at its start [rad]. sense: +1 counter-clockwise, −1 clockwise.
        speed: angular speed ω there [rad/s], positive.
        acceleration: α in the sense of rotation [rad/s²].
    """

    start: float
    sense: float
    speed: float
    acceleration: float = 0.0

    def __post_init__(self) -> None:
        if self.speed**2 + 2.0 * self.acceleration * FULL_TURN <= 0.0:
            turn = math.degrees(self.speed**2 / (-2.0 * self.acceleration))
            least = -(self.speed**2) / (2.0 * FULL_TURN)
            raise InputError(
                "/acceleration_rad_per_s2", self.acceleration,
                f"The crank stops after {turn:.6g}°, before it completes the turn.",
                f"Give more than {least:.6g} rad/s², or a higher speed_rpm.",
            )  # fmt: skip

    def phi(self, turned: Value) -> Value:
        """Crank angle φ after an angle turned, both in rad."""
        return self.start + self.sense * turned

    def turned(self, phi: float) -> float:
        """Angle that the crank turns until it is first at φ, in [0, 2π)."""
        return (self.sense * (phi - self.start)) % FULL_TURN

    def rate(self, turned: Value) -> Value:
        """Angular speed there [rad/s], positive: ω² = ω0² + 2 α Δφ."""
        if self.acceleration == 0.0:
            return self.speed + 0.0 * turned
        return np.sqrt(self.speed**2 + 2.0 * self.acceleration * turned)

    def time(self, turned: Value) -> Value:
        """Time since the start of the turn [s]: Δφ over the mean of the two speeds."""
        return 2.0 * turned / (self.speed + self.rate(turned))

    def first(self, rate: Value, turned: Value) -> Value:
        """Time derivative, from the derivative with respect to φ."""
        return self.sense * (rate * self.rate(turned))

    def second(self, rate: Value, bend: Value, turned: Value) -> Value:
        """Second time derivative, from both derivatives with respect to φ."""
        square = self.speed**2 + 2.0 * self.acceleration * turned
        return bend * square + (self.sense * self.acceleration) * rate
