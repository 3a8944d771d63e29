"""Torques that hold the arm against the weights of its links and its load.

The parallelograms keep the elbow plate and the tool upright, so that the height of every part is
that of the shoulder, plus a distance p along the upper arm and w along the forearm [mm]:

    z_i = const + p_i cos θ2 − w_i sin θ3

The torque of an axis is the derivative of the potential energy V = g Σ m_i z_i by its angle
(virtual work): τ2 = −g Σ m p sin θ2, τ3 = −g Σ m w cos θ3. A load off the tool's axis changes
neither, as the tool does not rotate about a horizontal axis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

G: Final = 9.80665  # m/s², standard gravity
METRE: Final = 1e-3  # m per mm


@dataclass(frozen=True)
class Weight:
    """A mass [kg] and the distances p, w of its centre along upper arm and forearm [mm]."""

    mass: float
    along_upper: float
    along_fore: float


@dataclass(frozen=True)
class HoldingTorques:
    """Torques that axes 2 and 3 hold [N·m], positive along their angles."""

    upper: float
    fore: float


def holding_torques(weights: Sequence[Weight], upper: float, fore: float) -> HoldingTorques:
    """The torques at these arm angles [rad]."""
    first, second = moments(weights)
    return HoldingTorques(0.0 - first * math.sin(upper), 0.0 - second * math.cos(fore))


def moments(weights: Sequence[Weight]) -> tuple[float, float]:
    """g Σ m p and g Σ m w [N·m]: the torques with both arms horizontal."""
    first = math.fsum(each.mass * each.along_upper for each in weights)
    second = math.fsum(each.mass * each.along_fore for each in weights)
    return G * METRE * first, G * METRE * second
