"""Objectives: what is minimised, one a file. A new one is a file and its name in ``AnyObjective``.

An objective states its value as a norm of the size, as linear inequalities with the epigraph
variable P, or as the mean square of a derivative; and how the value reads on the wire. Open
``base`` first. The conformance tests ask for a scene in which its proven bound is near its value.
"""

from __future__ import annotations

from typing import Annotated, get_args

from pydantic import Field

from synthesis.catalogue.objectives.base import Objective
from synthesis.catalogue.objectives.base_radius import BaseRadius
from synthesis.catalogue.objectives.derivatives import (
    PeakAcceleration,
    PeakJerk,
    RmsAcceleration,
    RmsJerk,
)
from synthesis.catalogue.objectives.peak_drive_force import PeakDriveForce
from synthesis.catalogue.objectives.peak_pressure_angle import PeakPressureAngle

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

OBJECTIVES: tuple[type[Objective], ...] = get_args(get_args(AnyObjective)[0])
"""The same as a tuple, in that order."""

__all__ = ["OBJECTIVES", "AnyObjective", "Objective"]
