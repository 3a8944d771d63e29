"""Torques that hold the arm still against the weights of its links and its load.

Both parallelograms keep the tilting frame and the tool upright, so that every part moves with the
shoulder, along the upper arm by a share p and along the forearm by a share w [mm]:

    z_i = const + p_i cos θ2 − w_i sin θ3

The torque that an axis has to hold is the derivative of the potential energy V = g Σ m_i z_i by
its angle (virtual work): τ2 = −g Σ m p sin θ2, τ3 = −g Σ m w cos θ3. A load beside the tool's axis
changes neither: the tool does not turn about a horizontal axis, so its weight does the same work.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

G: Final = 9.80665  # m/s², standard gravity
METRE: Final = 1e-3  # of a mm


@dataclass(frozen=True)
class Weight:
    """A mass [kg] and how far its centre lies along the upper arm and along the forearm [mm]."""

    mass: float
    along_upper: float
    along_fore: float


@dataclass(frozen=True)
class Holding:
    """Torques that axes 2 and 3 hold [N·m], positive along their angles."""

    upper: float
    fore: float


def holding(weights: Sequence[Weight], upper: float, fore: float) -> Holding:
    """The torques at these arm angles [rad]."""
    first, second = moments(weights)
    return Holding(0.0 - first * math.sin(upper), 0.0 - second * math.cos(fore))


def moments(weights: Sequence[Weight]) -> tuple[float, float]:
    """g Σ m p and g Σ m w [N·m]: the torques with upper arm and forearm horizontal."""
    first = math.fsum(each.mass * each.along_upper for each in weights)
    second = math.fsum(each.mass * each.along_fore for each in weights)
    return G * METRE * first, G * METRE * second
