"""What a line contact is made of, and what a roller's bearing bears."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

STEEL_MPA, STEEL_POISSON = 206e3, 0.3


class Material(BaseModel):
    """An elastic material; steel where nothing is said."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    elastic_modulus_mpa: Annotated[
        float, Field(gt=0.0, le=1e7, description="Modulus of elasticity E.")
    ] = STEEL_MPA
    poisson_ratio: Annotated[float, Field(ge=0.0, le=0.5, description="Poisson's ratio.")] = (
        STEEL_POISSON
    )

    @property
    def compliance(self) -> float:
        """(1 − ν²)/E [1/MPa]."""
        return (1.0 - self.poisson_ratio**2) / self.elastic_modulus_mpa


class Contact(BaseModel):
    """The line contact between cam and follower, for the Hertz pressure."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    width_mm: Annotated[
        float, Field(gt=0.0, le=1e6, description="Length of the line contact along the shaft.")
    ]
    cam: Annotated[Material, Field(description="Material of the cam.")] = Material()
    follower: Annotated[Material, Field(description="Material of the roller or face.")] = Material()

    @property
    def stiffness(self) -> float:
        """π b [(1 − ν1²)/E1 + (1 − ν2²)/E2] [mm/MPa].

        Of two cylinders pressed together with N, p² = N (1/R1 + 1/R2) over this (Hertz; Norton
        ch. 12): force over it is pressure squared times a length.
        """
        return math.pi * self.width_mm * (self.cam.compliance + self.follower.compliance)


class RollerBearing(BaseModel):
    """A roller's bearing as the catalogue has it."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    dynamic_rating_n: Annotated[
        float, Field(gt=0.0, le=1e12, description="Basic dynamic load rating C.")
    ]
    life_exponent: Annotated[
        float,
        Field(ge=1.0, le=10.0, description="p of L10 = (C/P)^p: 10/3 of rollers, 3 of balls."),
    ] = 10.0 / 3.0
