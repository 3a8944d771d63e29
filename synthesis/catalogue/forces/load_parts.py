"""What a load is made of on the wire: process force, spring, line contact and bearing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Any

from pydantic import Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import FiniteModel, Number, Range, ends
from synthesis.numerics.piecewise import Piecewise
from synthesis.units import DEGREE, FULL_TURN

STEEL_MPA, STEEL_POISSON = 206e3, 0.3  # textbook values of steel
RATE = "A number fixes it; {min, max} leaves it free in between; left out, it is free from 0 on."
Value = Annotated[float, Field(ge=-1e12, le=1e12, description="Positive against the rise.")]
Point = tuple[float, float]  # cam angle [deg] and process force or moment


class Material(FiniteModel):
    """An elastic material; steel where nothing is said."""

    elastic_modulus_mpa: float = Field(
        STEEL_MPA, gt=0.0, le=1e7, description="Modulus of elasticity E."
    )
    poisson_ratio: float = Field(STEEL_POISSON, ge=0.0, le=0.5, description="Poisson's ratio.")

    @property
    def compliance(self) -> float:
        """(1 − ν²)/E [1/MPa]."""
        return (1.0 - self.poisson_ratio**2) / self.elastic_modulus_mpa


class Contact(FiniteModel):
    """The line contact between cam and follower, for the Hertz pressure."""

    width_mm: float = Field(
        gt=0.0, le=1e6, description="Length of the line contact along the shaft."
    )
    cam: Material = Field(Material(), description="Material of the cam.")
    follower: Material = Field(Material(), description="Material of the roller or face.")

    @property
    def stiffness(self) -> float:
        """π b [(1 − ν1²)/E1 + (1 − ν2²)/E2] [mm/MPa].

        Of two cylinders pressed together with N, p² = N (1/R1 + 1/R2) over this (Hertz; Norton
        ch. 12): force over it is pressure squared times a length.
        """
        return math.pi * self.width_mm * (self.cam.compliance + self.follower.compliance)


class RollerBearing(FiniteModel):
    """A roller's bearing as the catalogue has it."""

    dynamic_rating_n: float = Field(gt=0.0, le=1e12, description="Basic dynamic load rating C.")
    life_exponent: float = Field(
        10.0 / 3.0, ge=1.0, le=10.0, description="p of L10 = (C/P)^p: 10/3 of rollers, 3 of balls."
    )


class Spring(FiniteModel):
    """A closing spring, its rate and preload given or chosen between two ends."""

    @field_validator("*")
    @classmethod
    def _presses(cls, value: Any, info: ValidationInfo) -> Any:
        low, _ = ends(value)
        if -math.inf < low < 0.0:
            raise PydanticCustomError(
                "spring_negative",
                "{what} = {value} is negative: such a spring pulls the follower off its cam. "
                "Give 0 or more, or leave the spring out.",
                {"what": info.field_name, "value": low},
            )
        return value

    @property
    def requested(self) -> dict[str, float | Range | None]:
        """Requested rate and preload, by field, in this order."""
        names = (n for n in type(self).model_fields if n.startswith(("rate_", "preload_")))
        return {name: getattr(self, name) for name in names}

    @property
    def ranges(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Ends of rate and preload [wire], open ends at 0 and infinity."""
        rate, preload = ((max(low, 0.0), high) for low, high in map(ends, self.requested.values()))
        return rate, preload


class SlideSpring(Spring):
    """A spring that presses a slide on its cam."""

    rate_n_per_mm: Number | Range | None = Field(None, description=f"Spring rate. {RATE}")
    preload_n: Number | Range | None = Field(
        None, description=f"Force with which it presses at the lowest position. {RATE}"
    )
    solid_mm: float | None = Field(
        None,
        gt=0.0,
        le=1e6,
        description="Compression from its free length at which its coils touch: a warning says "
        "where the cam comes near it.",
    )


class ArmSpring(Spring):
    """A spring that turns an arm against its cam."""

    rate_n_m_per_rad: Number | Range | None = Field(
        None, description=f"Rate about the pivot. {RATE}"
    )
    preload_n_m: Number | Range | None = Field(
        None, description=f"Moment with which it presses at the lowest position. {RATE}"
    )


class ProcessPoint(FiniteModel):
    """What the machine's task asks of the follower at one cam angle: its only other field."""

    angle_deg: float = Field(ge=0.0, le=360.0, description="Cam angle.")

    @property
    def as_pair(self) -> Point:
        """Cam angle, and force or moment in the wire's unit."""
        angle, value = (value for _, value in self)
        return angle, value


class ForcePoint(ProcessPoint):
    """The force at one cam angle; straight lines join the points."""

    force_n: Value


class MomentPoint(ProcessPoint):
    """The moment at one cam angle; straight lines join the points."""

    moment_n_m: Value


def check_order(points: Sequence[ProcessPoint]) -> None:
    """Refuse points of which one lies before its predecessor, or three at one angle."""
    angles = [point.angle_deg for point in points]
    for before, after in pairwise(angles):
        if after < before:
            raise PydanticCustomError(
                "process_out_of_order",
                "process goes back from {before}° to {after}°. Give the points in the order of "
                "the cam angle; two at the same angle make a jump.",
                {"before": before, "after": after},
            )
    for first, last in zip(angles, angles[2:], strict=False):
        if first == last:
            raise PydanticCustomError(
                "process_thrice",
                "process gives three values at {angle}°. Two make a jump; leave one out.",
                {"angle": first},
            )


def force_course(points: Sequence[Point], unit: float) -> Piecewise:
    """The force over one turn as straight pieces [N over rad]; ``unit``: N in one of the value's.

    Between the last point and the first one of the next turn it runs straight, too; of no point it
    is 0, of one it is constant.
    """
    if not points:
        return Piecewise.of([0.0, FULL_TURN], [[0.0]])
    known = [(angle * DEGREE, value * unit) for angle, value in points]
    (first, value), (last, before) = known[0], known[-1]
    gap = first + FULL_TURN - last  # without points
    share = (FULL_TURN - last) / gap if gap > 0.0 else 0.0
    seam = before + share * (value - before)
    known = [(0.0, seam)] * (first > 0.0) + known + [(FULL_TURN, seam)] * (last < FULL_TURN)
    pieces = [(one, other) for one, other in pairwise(known) if other[0] > one[0]]
    breaks = [one[0] for one, _ in pieces] + [FULL_TURN]
    rows = [[a, (b - a) / (end - start)] for (start, a), (end, b) in pieces]
    return Piecewise.of(breaks, rows)
