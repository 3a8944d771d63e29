"""TrainSpec: a follower train on a cam, and how fast it runs. The body of /v1/train-responses."""

from __future__ import annotations

from math import pi
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.dynamics.chain import Chain, StaticallyUnstable
from synthesis.dynamics.response import resonance
from synthesis.fields import CamSpeed, Name
from synthesis.spec import DesignSpec
from synthesis.units import rad_per_s

KILOGRAM = 1e-3  # in N s²/mm
MOST_MASSES, MOST_SPEEDS = 20, 100
SETTLED = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Mass(BaseModel):
    """One mass of the train, with the link between it and the one before (or the cam)."""

    model_config = SETTLED

    mass_kg: Annotated[
        float, Field(ge=1e-9, le=1e9, description="Reduced to the follower's displacement.")
    ]
    stiffness_n_per_mm: Annotated[
        float, Field(ge=1e-9, le=1e15, description="Of the link to the mass before, or to the cam.")
    ]
    damping_n_s_per_mm: Annotated[
        float, Field(ge=-1e9, le=1e9, description="Of that link, viscous.")
    ] = 0.0
    ground_stiffness_n_per_mm: Annotated[
        float,
        Field(ge=-1e15, le=1e15, description="Between the mass and the frame: a return spring."),
    ] = 0.0
    ground_damping_n_s_per_mm: Annotated[
        float, Field(ge=-1e9, le=1e9, description="Between the mass and the frame, viscous.")
    ] = 0.0


class Train(BaseModel):
    """Masses in a row, the first one next to the cam; the last one is the output."""

    model_config = SETTLED

    masses: Annotated[list[Mass], Field(min_length=1, max_length=MOST_MASSES)]
    preload_n: Annotated[
        float | None,
        Field(
            ge=0.0,
            le=1e15,
            description="Force that holds the resting train on the cam at displacement 0. Left "
            "out, the cam holds its follower both ways (a groove, conjugate cams).",
        ),
    ] = None

    def chain(self) -> Chain:
        """The same in mm, N and s."""
        masses = self.masses
        return Chain(
            KILOGRAM * np.array([mass.mass_kg for mass in masses]),
            np.array([mass.stiffness_n_per_mm for mass in masses]),
            np.array([mass.damping_n_s_per_mm for mass in masses]),
            np.array([mass.ground_stiffness_n_per_mm for mass in masses]),
            np.array([mass.ground_damping_n_s_per_mm for mass in masses]),
            self.preload_n or 0.0,
        )


class TrainSpec(BaseModel):
    """What an elastic follower train does on a cam at one speed or at many."""

    model_config = SETTLED

    name: Annotated[Name, Field(description="Shown in reports and files.")] = ""
    cam: Annotated[
        DesignSpec,
        Field(description="The cam; what it leaves free is designed first, as `/v1/designs` does."),
    ]
    train: Annotated[Train, Field(description="What the cam drives.")]
    speeds_rpm: Annotated[
        list[CamSpeed],
        Field(
            max_length=MOST_SPEEDS,
            description="Speeds of the cam; left out, that of the cam's own spec.",
        ),
    ] = []
    turns: Annotated[
        int,
        Field(
            ge=0,
            le=100,
            description="Turns from rest whose distance from the periodic response is told.",
        ),
    ] = 0

    @property
    def time_budget_s(self) -> float | None:
        """That of the cam."""
        return self.cam.time_budget_s

    @property
    def speeds(self) -> tuple[float, ...]:
        """The speeds [rpm]."""
        return tuple(self.speeds_rpm) or (self.cam.speed_rpm,)

    @model_validator(mode="after")
    def _stands(self) -> TrainSpec:
        try:
            modes = self.train.chain().modes
        except StaticallyUnstable:
            raise PydanticCustomError(
                "train_not_held",
                "The springs of train push it away: with its negative ground_stiffness_n_per_mm "
                "the whole is not stable at rest. Make the other springs stiffer, or that one less "
                "negative.",
                {},
            ) from None
        growing = modes.growing
        if growing is not None:
            raise PydanticCustomError(
                "train_grows",
                "A mode of train at {frequency} Hz grows by itself, {rate} times a second: its "
                "damping is negative ({ratio} of critical). Give dampers that take energy out, not "
                "put it in.",
                {"frequency": _told(abs(growing) / (2.0 * pi)), "rate": _told(growing.real),
                 "ratio": _told(-growing.real / abs(growing))},
            )  # fmt: skip
        for position, speed in enumerate(self.speeds):
            met = resonance(modes, rad_per_s(speed))
            if met is not None:
                raise PydanticCustomError(
                    "train_resonates",
                    "At {speed} rpm the undamped mode of train at {frequency} Hz swings exactly "
                    "{harmonic} times in a turn: the response grows from turn to turn and never "
                    "becomes periodic. Give the train some damping, or another speed.",
                    {"speed": speed, "frequency": _told(met[0]), "harmonic": met[1],
                     "position": position},
                )  # fmt: skip
        return self


def _told(value: float) -> float:
    return float(f"{value:.6g}")
