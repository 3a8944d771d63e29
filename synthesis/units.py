"""Conversions between the wire (deg, rpm) and the core (rad, rad/s); lengths are mm in both."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

DEGREE = math.pi / 180.0
FULL_TURN = 2.0 * math.pi


def rad_per_s(speed_rpm: float) -> float:
    """Angular speed ω in rad/s of a shaft turning at ``speed_rpm``."""
    return speed_rpm * FULL_TURN / 60.0


@dataclass(frozen=True)
class Travel:
    """How a follower's displacement is told: a length, or the angle of its arm.

    Inside the core every displacement is a length: of an arm, the arc of the roller's centre.

    Attributes:
        unit: on the wire. per_unit: the core's mm in one of them.
    """

    unit: Literal["mm", "deg"] = "mm"
    per_unit: float = 1.0

    def told(self, order: int) -> str:
        """The unit of the ``order``-th time derivative, as in ``mm/s²``."""
        return self.unit + ("", "/s", "/s²", "/s³", "/s⁴")[order]

    def rate(self, order: int, omega: float) -> float:
        """Factor from s^(order) per radian to the time derivative on the wire, at ω [rad/s]."""
        return float(omega**order / self.per_unit)


SLIDE = Travel()


@dataclass(frozen=True)
class Pace:
    """What turns displacements and rates of the wire into the core's mm and mm per radian.

    Attributes:
        travel: how the follower's displacement is told. omega: cam speed ω [rad/s].
    """

    travel: Travel = SLIDE
    omega: float = 1.0

    def core(self, value: float, order: int = 0) -> float:
        """s^(order) per radian [mm/rad^order] of a time derivative on the wire."""
        return value / self.travel.rate(order, self.omega)

    def wire(self, value: float, order: int = 0) -> float:
        """The time derivative on the wire of s^(order) per radian."""
        return value * self.travel.rate(order, self.omega)


AS_IS = Pace()
"""Displacements in mm, rates per radian."""
