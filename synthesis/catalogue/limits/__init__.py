"""Limits: what may not be exceeded. A new one is a class and its name in ``AnyLimit``.

A limit states the bounds that the certificate has to show, and the constraints that the optimiser
can use for them. Open ``base`` first: its head says how the forms of a limit agree. The conformance
tests ask for a scene in which the limit is reached.
"""

from __future__ import annotations

from typing import Annotated, get_args

from pydantic import Field

from synthesis.catalogue.limits.base import Claim, Limit, Machine
from synthesis.catalogue.limits.face_width import FaceWidth
from synthesis.catalogue.limits.forces import CamshaftTorque, ContactForce
from synthesis.catalogue.limits.hertz_pressure import HertzPressure
from synthesis.catalogue.limits.motion import Acceleration, Jerk, ResidualVibration, Velocity
from synthesis.catalogue.limits.pressure_angle import PressureAngle
from synthesis.catalogue.limits.radii import (
    CounterBaseRadius,
    CutterRadius,
    OuterRadius,
    ProfileRadius,
)

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
