"""Kinematics and statics of the palletising arm: forward, inverse with all postures, torques.

Axis 1 turns the arm about the vertical z. Two parallelograms keep the wrist upright, so that both
arm angles are absolute: θ2 of the upper arm from the vertical, forwards, and θ3 of the forearm
below the horizontal. With q = θ2 − θ3, the distance from shoulder to wrist depends on q alone:

    R = a2 sin θ2 + a3 cos θ3         r = a1 + R + a4
    Z = a2 cos θ2 − a3 sin θ3         z = d1 + Z − tool
    R² + Z² = a2² + a3² + 2 a2 a3 sin q

The arms are in line, and the posture is singular, where cos q = 0. As elbow plate and tool do not
rotate about a horizontal axis, the height of every part is that of the shoulder plus a distance p
along the upper arm and w along the forearm, and virtual work gives the torques that hold it:

    z_i = const + p_i cos θ2 − w_i sin θ3     τ2 = −g Σ m p sin θ2     τ3 = −g Σ m w cos θ3
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np

from synthesis.units import FULL_TURN

Value = Any
Base = Literal["front", "over"]
Elbow = Literal["up", "down"]
STRETCHED: Final = 1e-14  # of the arms' product: a discriminant that rounding made negative
G: Final = 9.80665  # m/s², standard gravity
METRE: Final = 1e-3  # m per mm


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
    """Position of the tool [mm] and its angle about the vertical [rad]."""

    x: float
    y: float
    z: float
    yaw: float


@dataclass(frozen=True)
class Posture:
    """One posture that reaches a place.

    Attributes:
        base: `front`, the arm turned towards the place; `over`, turned away and reaching back.
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
        """Forward kinematics: the place of the tool."""
        r = float(self.radius(joints.upper, joints.fore))
        z = float(self.level(joints.upper, joints.fore))
        yaw = wrap_angle(joints.base + joints.tool)
        return Place(r * math.cos(joints.base), r * math.sin(joints.base), z, yaw)

    def postures(self, place: Place) -> Iterator[Posture]:
        """Inverse kinematics: every posture, limits aside; none where the place is out of reach."""
        distance, front = math.hypot(place.x, place.y), math.atan2(place.y, place.x)
        # The base turned towards the place, or away from it with the arm reaching back.
        bases: tuple[tuple[Base, float, float], ...] = (
            ("front", front, distance), ("over", front + math.pi, -distance),
        )  # fmt: skip
        for base, angle, r in bases:
            for elbow, upper, fore in self._arm_angles(r, place.z):
                joints = Joints(wrap_angle(angle), upper, fore, wrap_angle(place.yaw - angle))
                yield Posture(base, elbow, joints)

    def _arm_angles(self, r: float, z: float) -> Iterator[tuple[Elbow, float, float]]:
        """Both pairs of arm angles (elbow, θ2, θ3) for a radius and a height of the tool."""
        R, Z = r - self.shoulder - self.wrist, z - self.height + self.tool
        square, a, b = R * R + Z * Z, self.upper, self.fore
        sine = (square - a * a - b * b) / (2.0 * a * b)
        # (2 a b cos q)² as a product: accurate also where the arms are nearly in line.
        discriminant = ((a + b) ** 2 - square) * (square - (a - b) ** 2)
        if discriminant < -STRETCHED * (2.0 * a * b) ** 2 or square == 0.0:
            return
        cosine = math.sqrt(max(discriminant, 0.0)) / (2.0 * a * b)
        elbows: tuple[tuple[Elbow, float], ...] = (("up", cosine), ("down", -cosine))
        for elbow, cos in elbows[: 1 if cosine == 0.0 else 2]:
            # Z + i R = (m + i n) e^(i θ2), from both formulas with θ3 = θ2 − q.
            m, n = a + b * sine, b * cos
            upper = math.atan2(R * m - Z * n, R * n + Z * m)
            yield elbow, upper, upper - math.atan2(sine, cos)


def static_moments(parts: Iterable[tuple[float, float, float]]) -> tuple[float, float]:
    """g Σ m p and g Σ m w [N·m]: the torques with both arms horizontal.

    Args:
        parts: mass [kg] and the distances p, w of its centre along both arms [mm] of each part.
    """
    products = [(mass * p, mass * w) for mass, p, w in parts]
    upper, fore = (G * METRE * math.fsum(column) for column in zip(*products, strict=True))
    return upper, fore


def holding_torques(moments: tuple[float, float], upper: Value, fore: Value) -> tuple[Value, Value]:
    """Torques [N·m] of axes 2 and 3 at arm angles [rad], positive along their angles."""
    return 0.0 - moments[0] * np.sin(upper), 0.0 - moments[1] * np.cos(fore)


def wrap_angle(angle: float) -> float:
    """The same direction in (−π, π]."""
    wrapped = math.remainder(angle, FULL_TURN)
    return math.pi if wrapped == -math.pi else wrapped
