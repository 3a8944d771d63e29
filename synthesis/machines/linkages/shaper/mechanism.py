"""The six-bar shaper: motion of every link in closed form, by crank angle and by time.

The guide turns about the origin, the crank about (0, a) above it; the ram slides along y = H.
The crank's pin B runs in the guide; the coupler joins the guide's end C to the ram's pin D.

    ρ u(ψ) = (r cos φ, a + r sin φ)          u(ψ) = (cos ψ, sin ψ), n(ψ) = (−sin ψ, cos ψ)
    (x, H) = L u(ψ) + c u(γ)

Derivatives with respect to φ, from the loops differentiated (Norton, Design of Machinery, 6.7 and
7.3): along u and n the first loop reads

    ρ' = B'·u,  ρ ψ' = B'·n;    ρ'' − ρ ψ'² = B''·u,  ρ ψ'' + 2 ρ' ψ' = B''·n

and the second, whose matrix is the same for both orders, gives γ' and γ'' from its height and x'
and x'' along the ram's line. ``Drive`` turns derivatives by φ into those by time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from synthesis.errors import InputError
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

Value = Any  # an array, or Taylor models of the same
Narrowing = Callable[[Value], Value]
Rates = tuple[Value, Value, Value]  # a quantity and its two derivatives with respect to φ
Side = Literal["left", "right"]
SIGN: dict[Side, float] = {"left": -1.0, "right": 1.0}


@dataclass(frozen=True, eq=False)
class Motion:
    """Positions of the links and their derivatives by the crank angle [mm, rad]."""

    guide: tuple[Value, Value]  # cosine and sine of ψ
    coupler: tuple[Value, Value]  # cosine and sine of γ
    slide: Rates  # ρ, from the guide's pivot to the pin
    guide_turn: tuple[Value, Value]  # ψ', ψ''
    coupler_turn: tuple[Value, Value]  # γ', γ''
    ram: Rates  # x


@dataclass(frozen=True)
class Shaper:
    """A shaper with all its dimensions [mm]."""

    crank: float  # r
    guide: float  # L, pivot to its end
    coupler: float  # c
    pivot_distance: float  # a, of the crank's pivot above the guide's
    ram_line: float  # H, above the guide's pivot
    side: Side = "right"  # assembly branch: side of the guide's end on which the ram's pin is

    @property
    def guide_rotates(self) -> bool:
        """Whether the guide makes full turns: the crank is longer than the pivot distance."""
        return self.crank > self.pivot_distance

    @property
    def swing(self) -> float:
        """Half the swing of a rocking guide: β with sin β = r/a [rad]."""
        return math.asin(self.crank / self.pivot_distance)

    def guide_sine_range(self) -> tuple[float, float]:
        """Smallest and largest sine of the guide's angle over a turn."""
        return (-1.0 if self.guide_rotates else math.cos(self.swing)), 1.0

    def coupler_sine(self, sine: Value) -> Value:
        """sin γ of the coupler for sin ψ of the guide; beyond ±1 the coupler does not reach."""
        return (self.ram_line - self.guide * sine) / self.coupler

    def motion(self, phi: Value, narrow: Narrowing = lambda sine: sine) -> Motion:
        """The motion at crank angles φ [rad], counted from the x axis, counter-clockwise.

        ``narrow`` narrows sin γ by what is narrow of it, where lengths are models.
        """
        r, L, c = self.crank, self.guide, self.coupler
        cos, sin = np.cos(phi), np.sin(phi)
        bx, by = r * cos, self.pivot_distance + r * sin
        rho = np.sqrt(bx * bx + by * by)
        uc, us = bx / rho, by / rho
        # B' = r n(φ) and B'' = −r u(φ), resolved along u(ψ) and n(ψ).
        ahead, across = r * (us * cos - uc * sin), r * (uc * cos + us * sin)
        psi1 = across / rho
        rho2 = rho * psi1 * psi1 - across
        psi2 = (ahead - 2.0 * ahead * psi1) / rho
        # γ from the height of the second loop; its matrix is diag(c cos γ) for both orders.
        gs = narrow(self.coupler_sine(us))
        gc = SIGN[self.side] * np.sqrt(1.0 - gs * gs)
        gamma1 = -L * uc * psi1 / (c * gc)
        gamma2 = (L * (us * psi1 * psi1 - uc * psi2) + c * gs * gamma1 * gamma1) / (c * gc)
        x = L * uc + c * gc
        x1 = -L * us * psi1 - c * gs * gamma1
        turns = L * (us * psi2 + uc * psi1 * psi1), c * (gs * gamma2 + gc * gamma1 * gamma1)
        return Motion(
            (uc, us), (gc, gs), (rho, ahead, rho2), (psi1, psi2), (gamma1, gamma2),
            (x, x1, -turns[0] - turns[1]),
        )  # fmt: skip

    def crank_at(self, psi: float, outer: bool) -> float:
        """Crank angle φ [rad] with the guide at ψ, the pin at the farther or the nearer place.

        A rotating guide has the farther one only; a rocking guide both while ψ is within its swing.
        """
        height = self.pivot_distance * math.sin(psi)
        rest = max(self.crank**2 - (self.pivot_distance * math.cos(psi)) ** 2, 0.0)
        rho = height + (1.0 if outer else -1.0) * math.sqrt(rest)
        return math.atan2(rho * math.sin(psi) - self.pivot_distance, rho * math.cos(psi))


def angle(pair: tuple[Value, Value]) -> Array:
    """The angle of a cosine and a sine [rad], continuous along the rows."""
    return np.unwrap(np.arctan2(pair[1], pair[0]))


@dataclass(frozen=True)
class Drive:
    """The crank's motion over the analysed turn.

    Its methods take the travel: the angle turned since the start [rad], a number or a model.
    """

    start: float  # φ there [rad]
    sense: float  # +1 counter-clockwise, −1 clockwise
    speed: float  # ω at the start [rad/s], positive
    acceleration: float = 0.0  # α in the sense of rotation [rad/s²]

    def __post_init__(self) -> None:
        if self.speed**2 + 2.0 * self.acceleration * FULL_TURN <= 0.0:
            turn = math.degrees(self.speed**2 / (-2.0 * self.acceleration))
            least = -(self.speed**2) / (2.0 * FULL_TURN)
            raise InputError(
                "/acceleration_rad_per_s2", self.acceleration,
                f"The crank stops after {turn:.6g}°, before it completes the turn.",
                f"Give more than {least:.6g} rad/s², or a higher speed_rpm.",
            )  # fmt: skip

    def phi(self, travel: Value) -> Value:
        """Crank angle φ [rad]."""
        return self.start + self.sense * travel

    def travel_to(self, phi: float) -> float:
        """Angle that the crank turns until it is first at φ, in [0, 2π)."""
        return (self.sense * (phi - self.start)) % FULL_TURN

    def rate(self, travel: Value) -> Value:
        """Angular speed there [rad/s], positive: ω² = ω0² + 2 α Δφ."""
        if self.acceleration == 0.0:
            return self.speed + 0.0 * travel
        return np.sqrt(self.speed**2 + 2.0 * self.acceleration * travel)

    def time(self, travel: Value) -> Value:
        """Time since the start of the turn [s]: Δφ over the mean of the two speeds."""
        return 2.0 * travel / (self.speed + self.rate(travel))

    def first(self, rate: Value, travel: Value) -> Value:
        """Time derivative, from the derivative with respect to φ."""
        return self.sense * (rate * self.rate(travel))

    def second(self, rate: Value, bend: Value, travel: Value) -> Value:
        """Second time derivative, from both derivatives with respect to φ."""
        square = self.speed**2 + 2.0 * self.acceleration * travel
        return bend * square + (self.sense * self.acceleration) * rate
