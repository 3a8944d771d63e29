"""Objectives: one file each. A new one is a file and its name in the two lists here."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from synthesis.objectives.base import Objective
from synthesis.objectives.base_radius import BaseRadius
from synthesis.objectives.peak_acceleration import PeakAcceleration
from synthesis.objectives.peak_drive_force import PeakDriveForce
from synthesis.objectives.peak_jerk import PeakJerk
from synthesis.objectives.peak_pressure_angle import PeakPressureAngle
from synthesis.objectives.rms_acceleration import RmsAcceleration
from synthesis.objectives.rms_jerk import RmsJerk

AnyObjective = Annotated[
    BaseRadius
    | PeakAcceleration
    | PeakJerk
    | RmsAcceleration
    | RmsJerk
    | PeakPressureAngle
    | PeakDriveForce,
    Field(discriminator="kind"),
]

OBJECTIVES: tuple[type[Objective], ...] = (
    BaseRadius, PeakAcceleration, PeakJerk, RmsAcceleration, RmsJerk, PeakPressureAngle,
    PeakDriveForce,
)  # fmt: skip

__all__ = ["OBJECTIVES", "AnyObjective", "Objective"]
