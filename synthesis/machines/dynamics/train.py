"""TrainSpec: a follower train on a cam and its speeds; request body of /v1/train-responses."""

from __future__ import annotations

from math import pi
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import CamSpeed, FiniteModel, Name
from synthesis.machines.dynamics.chain import Chain, StaticallyUnstable
from synthesis.machines.dynamics.response import resonance
from synthesis.spec.design_spec import DesignSpec
from synthesis.units import rad_per_s

KILOGRAM = 1e-3  # N s²/mm in 1 kg
MAX_MASSES, MAX_SPEEDS = 20, 100  # so that an answer takes seconds

Stiffness = Annotated[float, Field(ge=-1e15, le=1e15)]
Damping = Annotated[float, Field(ge=-1e9, le=1e9)]


class Mass(FiniteModel):
    """One mass of the train and its link to the mass before it, or to the cam."""

    mass_kg: float = Field(
        ge=1e-9, le=1e9, description="Mass, reduced to the follower's displacement."
    )
    stiffness_n_per_mm: float = Field(
        ge=1e-9, le=1e15, description="Stiffness of the link to the mass before it, or to the cam."
    )
    damping_n_s_per_mm: Damping = Field(0.0, description="Viscous damping of that link.")
    ground_stiffness_n_per_mm: Stiffness = Field(
        0.0, description="Stiffness between the mass and the frame: a return spring."
    )
    ground_damping_n_s_per_mm: Damping = Field(
        0.0, description="Viscous damping between the mass and the frame."
    )


class Train(FiniteModel):
    """Masses in a row, the first one next to the cam; the last one is the output."""

    masses: Annotated[list[Mass], Field(min_length=1, max_length=MAX_MASSES)]
    preload_n: float | None = Field(
        None,
        ge=0.0,
        le=1e15,
        description="Contact force of the train at rest at displacement 0. Left out: the cam "
        "is form-closed and holds its follower both ways (a groove, conjugate cams).",
    )

    def chain(self) -> Chain:
        """The train in mm, N and s."""
        rows = [list(mass.model_dump().values()) for mass in self.masses]
        masses, springs, dampers, ground_springs, ground_dampers = np.array(rows).T
        preload = self.preload_n or 0.0
        return Chain(KILOGRAM * masses, springs, dampers, ground_springs, ground_dampers, preload)


class TrainSpec(FiniteModel):
    """An elastic follower train on a cam, at one speed or several."""

    name: Name = Field("", description="Shown in reports and files.")
    cam: DesignSpec = Field(
        description="The cam; what it leaves free is designed first, as by `/v1/designs`."
    )
    train: Train = Field(description="The train that the cam drives.")
    speeds_rpm: list[CamSpeed] = Field(
        [],
        max_length=MAX_SPEEDS,
        description="Speeds of the cam; left out: that of the cam's own spec.",
    )
    turns: int = Field(
        0, ge=0, le=100, description="Turns from rest to compare with the periodic response."
    )

    @property
    def time_budget_s(self) -> float | None:
        """That of the cam."""
        return self.cam.time_budget_s

    @property
    def speeds(self) -> tuple[float, ...]:
        """The speeds [rpm]."""
        return tuple(self.speeds_rpm) or (self.cam.speed_rpm,)

    @model_validator(mode="after")
    def _check_stability(self) -> TrainSpec:
        try:
            modes = self.train.chain().modes
        except StaticallyUnstable:
            raise PydanticCustomError(
                "train_not_held",
                "The train is statically unstable: a negative ground_stiffness_n_per_mm outweighs "
                "the other springs. Make the other springs stiffer, or that one less negative.",
                {},
            ) from None
        unstable_rate = modes.unstable_rate
        if unstable_rate is not None:
            raise PydanticCustomError(
                "train_grows",
                "A mode of train at {frequency} Hz is unstable, with the rate {rate} 1/s: its "
                "damping ratio is {ratio}. Give positive damping.",
                {"frequency": _six_digits(abs(unstable_rate) / (2.0 * pi)),
                 "rate": _six_digits(unstable_rate.real),
                 "ratio": _six_digits(-unstable_rate.real / abs(unstable_rate))},
            )  # fmt: skip
        for position, speed in enumerate(self.speeds):
            resonant = resonance(modes, rad_per_s(speed))
            if resonant is not None:
                raise PydanticCustomError(
                    "train_resonates",
                    "At {speed} rpm the undamped mode of train at {frequency} Hz is in resonance "
                    "with harmonic {harmonic} of the cam: the response grows from turn to turn and "
                    "never becomes periodic. Give the train some damping, or another speed.",
                    {"speed": speed, "frequency": _six_digits(resonant[0]), "harmonic": resonant[1],
                     "position": position},
                )  # fmt: skip
        return self


def _six_digits(value: float) -> float:
    return float(f"{value:.6g}")
