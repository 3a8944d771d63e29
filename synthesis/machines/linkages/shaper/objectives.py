"""Objectives of sizing a shaper: each minimises the largest of a few functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from synthesis.machines.linkages.shaper.design_space import ShaperBatch, Span, similar
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

Value = Any
SAMPLES: Final = 24  # crank angles of a turn at which a bound takes the acceleration
# Crank angles at which points are compared; the finished linkage is measured by enclosures.
DENSE: Final = FULL_TURN * np.arange(240) / 240


@dataclass(frozen=True)
class ShaperObjective:
    """An objective: minimise the largest of a few functions.

    Attributes:
        name: name of its value on the wire, with its unit. parts: from shapers and a crank angle
        [rad] to the functions. wire: from their largest value and the crank speed ω [rad/s] to the
        wire. angles: whether the functions depend on the crank angle. floor: lower bounds of the
        parts, with the ram's line (range, mm) already minimised over; used
            for the bound instead of parts.
    """

    name: str
    parts: Callable[[ShaperBatch, Value], list[Value]]
    wire: Callable[[float, float], float]
    angles: bool = False
    floor: Callable[[ShaperBatch, Span], list[Value]] | None = None

    def least(self, one: ShaperBatch, phi: Sequence[float], guide_sine_range: Span) -> list[Value]:
        """Lower bounds of the objective, from its functions at some crank angles."""
        if self.floor is not None:
            return self.floor(one, guide_sine_range)
        return [part for angle in phi for part in self.parts(one, angle)]

    def over_turn(self, one: ShaperBatch) -> Array:
        """The functions at points, (functions, n, crank angles)."""
        columns = {name: each[:, None] for name, each in vars(one).items() if name != "known"}
        return np.stack(self.parts(ShaperBatch(**columns), DENSE if self.angles else DENSE[:1]))

    def values(self, one: ShaperBatch) -> Array:
        """The objective at points, (n,)."""
        return np.asarray(np.max(self.over_turn(one), axis=(0, 2)))


def _links(one: ShaperBatch, _: Value) -> list[Value]:
    return [
        one.guide,
        one.coupler,
        one.pivot_distance,
    ]  # the crank is shorter than the pivot distance


def _steep(one: ShaperBatch, _: Value) -> list[Value]:
    """|sin γ| at the middle and at the ends of the swing."""
    return [one.level, -one.level, one.level_at_ends, -one.level_at_ends]


def _least_steep(one: ShaperBatch, guide_sine_range: Span) -> list[Value]:
    """|sin γ| with the ram's line midway between the guide's extreme heights, or as near."""
    low, (lowest, highest) = one.guide * one.cosine, guide_sine_range
    rest = [0.5 * (one.guide - low), one.guide - highest, lowest - low]
    return [each / one.coupler for each in rest]


def _bend(one: ShaperBatch, phi: Value) -> list[Value]:
    """|x''| at a crank angle."""
    bend = one.coupler * similar(one).motion(phi, one.known).ram[2]
    return [bend, -bend]


def _coupler(one: ShaperBatch, _: Value) -> list[Value]:
    return [one.coupler]


OBJECTIVES: Mapping[str, ShaperObjective] = MappingProxyType(
    {
        "longest_link": ShaperObjective("longest_link_mm", _links, lambda value, _: value),
        "transmission_angle": ShaperObjective(
            "least_transmission_angle_deg",
            _steep,
            lambda value, _: 90.0 - math.asin(min(max(value, 0.0), 1.0)) / DEGREE,
            floor=_least_steep,
        ),
        "ram_acceleration": ShaperObjective(
            "ram_acceleration_mm_per_s2", _bend, lambda value, omega: value * omega**2, angles=True
        ),
    }
)
SHORTEST_COUPLER: Final = ShaperObjective("coupler_mm", _coupler, lambda value, _: value)
