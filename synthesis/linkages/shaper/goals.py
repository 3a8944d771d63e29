"""What may be best about a shaper: each goal as the largest of a few functions to be made small."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from synthesis.linkages.shaper.family import Sized, Span, similar
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

Value = Any
SAMPLES: Final = 24  # crank angles of a turn at which a bound looks at the acceleration
# at which points are weighed; the finished linkage is measured by enclosures
DENSE: Final = FULL_TURN * np.arange(240) / 240


@dataclass(frozen=True)
class Goal:
    """Something to be made small: the largest of a few functions.

    Attributes:
        name: of its value on the wire, with its unit.
        parts: shapers and a crank angle [rad] to the functions.
        wire: their largest value, at crank speed ω [rad/s], to the value on the wire.
        angles: whether the crank's angle counts.
        floor: the same as parts or less, with the ram's line (both ends, mm) already chosen best:
            for the bound.
    """

    name: str
    parts: Callable[[Sized, Value], list[Value]]
    wire: Callable[[float, float], float]
    angles: bool = False
    floor: Callable[[Sized, Span], list[Value]] | None = None

    def least(self, one: Sized, phi: Sequence[float], heights: Span) -> list[Value]:
        """What the goal is not below, from its functions at some crank angles."""
        if self.floor is not None:
            return self.floor(one, heights)
        return [part for angle in phi for part in self.parts(one, angle)]

    def over_turn(self, one: Sized) -> Array:
        """The functions at points, (functions, n, crank angles)."""
        columns = {name: each[:, None] for name, each in vars(one).items() if name != "known"}
        return np.stack(self.parts(Sized(**columns), DENSE if self.angles else DENSE[:1]))

    def values(self, one: Sized) -> Array:
        """The goal at points, (n,)."""
        return np.asarray(np.max(self.over_turn(one), axis=(0, 2)))


def _links(one: Sized, _: Value) -> list[Value]:
    return [one.guide, one.coupler, one.pivot_distance]  # the crank is shorter than the last


def _steep(one: Sized, _: Value) -> list[Value]:
    """|sin γ| at the middle and at the ends of the swing."""
    return [one.level, -one.level, one.level_at_ends, -one.level_at_ends]


def _least_steep(one: Sized, heights: Span) -> list[Value]:
    """|sin γ| where the ram's line is midway between the guide's heights, or as near as it may."""
    low, (lowest, highest) = one.guide * one.cosine, heights
    rest = [0.5 * (one.guide - low), one.guide - highest, lowest - low]
    return [each / one.coupler for each in rest]


def _bend(one: Sized, phi: Value) -> list[Value]:
    """|x''| at a crank angle."""
    bend = one.coupler * similar(one).motion(phi, one.known).ram[2]
    return [bend, -bend]


def _coupler(one: Sized, _: Value) -> list[Value]:
    return [one.coupler]


GOALS: Mapping[str, Goal] = MappingProxyType(
    {
        "longest_link": Goal("longest_link_mm", _links, lambda value, _: value),
        "transmission_angle": Goal(
            "least_transmission_angle_deg",
            _steep,
            lambda value, _: 90.0 - math.asin(min(max(value, 0.0), 1.0)) / DEGREE,
            floor=_least_steep,
        ),
        "ram_acceleration": Goal(
            "ram_acceleration_mm_per_s2", _bend, lambda value, omega: value * omega**2, angles=True
        ),
    }
)
SHORTEST_COUPLER: Final = Goal("coupler_mm", _coupler, lambda value, _: value)
