"""The palletising arm: forward and inverse kinematics, every posture named.

Axis 1 turns the arm about the upright z. Two parallelograms keep the wrist upright, so that both
arm angles are absolute: θ2 of the upper arm from the upright, forwards, and θ3 of the forearm
below the horizontal. With q = θ2 − θ3, the shoulder's distance to the wrist depends on q alone:

    R = a2 sin θ2 + a3 cos θ3         r = a1 + R + a4
    Z = a2 cos θ2 − a3 sin θ3         z = d1 + Z − tool
    R² + Z² = a2² + a3² + 2 a2 a3 sin q

The wrist moves along one line only, the arms being in line, where cos q = 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np

from synthesis.units import FULL_TURN

Value = Any
Base = Literal["front", "over"]
Elbow = Literal["up", "down"]
FLAT: Final = 1e-14  # of the arms' product: a root that rounding made negative


@dataclass(frozen=True)
class Joints:
    """The four driven angles [rad]: base, upper arm, forearm, tool."""

    base: float
    upper: float
    fore: float
    tool: float

    @property
    def opening(self) -> float:
        """q = θ2 − θ3: the arms are in line at ±90°."""
        return self.upper - self.fore


@dataclass(frozen=True)
class Place:
    """Where the tool is: (x, y, z) [mm], and how it is turned about the upright [rad]."""

    x: float
    y: float
    z: float
    yaw: float


@dataclass(frozen=True)
class Posture:
    """One way of reaching a place.

    Attributes:
        base: `front` with the arm towards the place, `over` turned away and reaching back over.
        elbow: `up` while q lies between −90° and 90°, `down` beyond.
        joints: the angles; those of the base and the tool in (−π, π].
    """

    base: Base
    elbow: Elbow
    joints: Joints


@dataclass(frozen=True)
class Arm:
    """Lengths of the arm [mm].

    Attributes:
        height: d1, of the shoulder. shoulder: a1, from axis 1. upper: a2. fore: a3.
        wrist: a4, from the forearm's end to the tool's axis. tool: below it.
    """

    height: float
    shoulder: float
    upper: float
    fore: float
    wrist: float
    tool: float

    def radius(self, upper: Value, fore: Value) -> Value:
        """r, of the tool from axis 1, negative behind it [mm]."""
        return self.shoulder + self.wrist + self.upper * np.sin(upper) + self.fore * np.cos(fore)

    def level(self, upper: Value, fore: Value) -> Value:
        """z of the tool [mm]."""
        return self.height - self.tool + self.upper * np.cos(upper) - self.fore * np.sin(fore)

    def place(self, joints: Joints) -> Place:
        """Where the tool is."""
        r = float(self.radius(joints.upper, joints.fore))
        z = float(self.level(joints.upper, joints.fore))
        yaw = within(joints.base + joints.tool)
        return Place(r * math.cos(joints.base), r * math.sin(joints.base), z, yaw)

    def postures(self, place: Place) -> Iterator[Posture]:
        """Every way of reaching a place, whatever the limits; none where it is out of reach."""
        distance, towards = math.hypot(place.x, place.y), math.atan2(place.y, place.x)
        bases: tuple[tuple[Base, float], ...] = (("front", towards), ("over", towards + math.pi))
        for base, turned in bases:
            r = distance if base == "front" else -distance
            for elbow, upper, fore in self._arms(r, place.z):
                joints = Joints(within(turned), upper, fore, within(place.yaw - turned))
                yield Posture(base, elbow, joints)

    def _arms(self, r: float, z: float) -> Iterator[tuple[Elbow, float, float]]:
        """Both angles of the arms for a radius and a level."""
        R, Z = r - self.shoulder - self.wrist, z - self.height + self.tool
        square, a, b = R * R + Z * Z, self.upper, self.fore
        sine = (square - a * a - b * b) / (2.0 * a * b)
        # (2 a b cos q)², as a product: no digits are lost where the arms are nearly in line
        spare = ((a + b) ** 2 - square) * (square - (a - b) ** 2)
        if spare < -FLAT * (2.0 * a * b) ** 2 or square == 0.0:
            return
        cosine = math.sqrt(max(spare, 0.0)) / (2.0 * a * b)
        elbows: tuple[tuple[Elbow, float], ...] = (("up", cosine), ("down", -cosine))
        for elbow, cos in elbows[: 1 if cosine == 0.0 else 2]:
            m, n = a + b * sine, b * cos
            upper = math.atan2(R * m - Z * n, R * n + Z * m)
            yield elbow, upper, upper - math.atan2(sine, cos)


def within(angle: float) -> float:
    """The same direction in (−π, π]."""
    turned = math.remainder(angle, FULL_TURN)
    return math.pi if turned == -math.pi else turned
