"""Textbook formulas of the offset translating roller cam with cycloidal motion, in forty digits.

Typed from the literature and not from the product: cycloidal motion, s = h (x − sin 2πx / 2π); the
pitch curve by reversed motion, x = (s0 + s) sin θ + e cos θ, y = (s0 + s) cos θ − e sin θ; the
profile on that curve's normal, towards the axis; curvature of a curve given by a parameter.
"""

from dataclasses import dataclass
from decimal import Decimal

from tests.forty_digits import PI, cos, sin


@dataclass(frozen=True)
class OffsetRoller:
    """Rise, dwell, return like the rise, dwell; lengths in mm, angles in degrees, ω in rad/s."""

    h: Decimal
    rise: Decimal
    dwell: Decimal
    prime: Decimal
    e: Decimal
    Rr: Decimal
    omega: Decimal

    def __post_init__(self):
        for name, value in vars(self).items():
            object.__setattr__(self, name, Decimal(value))

    def motion(self, degrees: Decimal) -> tuple[Decimal, Decimal, Decimal]:
        """s, ds/dθ, d²s/dθ²."""
        top, down, low = self.rise, self.rise + self.dwell, 2 * self.rise + self.dwell
        if degrees >= low:
            return Decimal(0), Decimal(0), Decimal(0)
        if top <= degrees <= down:
            return self.h, Decimal(0), Decimal(0)
        x = (degrees if degrees < top else degrees - down) / self.rise
        beta = self.rise * PI / 180
        s = self.h * (x - sin(2 * PI * x) / (2 * PI))
        v = self.h / beta * (1 - cos(2 * PI * x))
        a = 2 * PI * self.h / beta**2 * sin(2 * PI * x)
        return (s, v, a) if degrees < top else (self.h - s, -v, -a)

    def at(self, degrees: Decimal) -> dict[str, Decimal]:
        """Everything at one cam angle of a cam that turns counter-clockwise."""
        s, v, a = self.motion(degrees)
        theta, e = degrees * PI / 180, self.e
        c, n = cos(theta), sin(theta)
        height = (self.prime**2 - e**2).sqrt() + s
        x, y = height * n + e * c, height * c - e * n
        dx, dy = (v - e) * n + height * c, (v - e) * c - height * n
        ddx = a * n + 2 * v * c - height * n - e * c
        ddy = a * c - 2 * v * n - height * c + e * n
        speed = (dx**2 + dy**2).sqrt()
        return {
            "s": s,
            "v": v * self.omega,
            "a": a * self.omega**2,
            "pitch x": x,
            "pitch y": y,
            "profile x": x + self.Rr * dy / speed,
            "profile y": y - self.Rr * dx / speed,
            "tan of pressure angle": (v - e) / height,
            "curvature": (dy * ddx - dx * ddy) / speed**3,
        }
