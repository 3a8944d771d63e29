"""Limits: one file each. A new one is a file and its name in ``AnyLimit``."""

from __future__ import annotations

from typing import Annotated, get_args

from pydantic import Field

from synthesis.limits.acceleration import Acceleration
from synthesis.limits.base import Claim, Limit, Machine
from synthesis.limits.camshaft_torque import CamshaftTorque
from synthesis.limits.contact_force import ContactForce
from synthesis.limits.counter_base_radius import CounterBaseRadius
from synthesis.limits.cutter_radius import CutterRadius
from synthesis.limits.face_width import FaceWidth
from synthesis.limits.hertz_pressure import HertzPressure
from synthesis.limits.jerk import Jerk
from synthesis.limits.outer_radius import OuterRadius
from synthesis.limits.pressure_angle import PressureAngle
from synthesis.limits.profile_radius import ProfileRadius
from synthesis.limits.residual_vibration import ResidualVibration
from synthesis.limits.velocity import Velocity

AnyLimit = Annotated[
    PressureAngle
    | ProfileRadius
    | CutterRadius
    | Velocity
    | Acceleration
    | Jerk
    | OuterRadius
    | FaceWidth
    | CounterBaseRadius
    | ContactForce
    | HertzPressure
    | CamshaftTorque
    | ResidualVibration,
    Field(discriminator="kind"),
]

LIMITS: tuple[type[Limit], ...] = get_args(get_args(AnyLimit)[0])
"""The same as a tuple, in that order."""

__all__ = ["LIMITS", "AnyLimit", "Claim", "Limit", "Machine"]
