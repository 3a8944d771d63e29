"""What the limits on forces have in common: the load, and forces as smooth functions of motion."""

from __future__ import annotations

from abc import ABC
from typing import Any, ClassVar

import numpy as np
from pydantic_core import PydanticCustomError

from synthesis.catalogue.followers.flank import Flank
from synthesis.catalogue.followers.kinematics import TracePoint, pressure_angle_sine_cosine
from synthesis.catalogue.forces import ReducedLoad
from synthesis.catalogue.limits.base import Limit, Machine
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.piecewise import Array

SMALL = 1e-300  # keeps a quotient finite where its denominator may be 0


class ForceLimit(Limit, ABC):
    """A limit on a force: a spec with such a limit must give the load on the follower."""

    needs_load: ClassVar[bool] = True

    def check_load(self, segments: Segments, machine: Machine, position: int) -> None:
        if machine.load is None:
            raise PydanticCustomError(
                "limit_needs_load",
                "limits/{position} is {limit}, but the spec gives no load on the follower. "
                "Give load, or remove the limit.",
                {"position": position, "limit": self.kind},
            )


def load_of(machine: Machine) -> ReducedLoad:
    """The load on the follower, which ``check_load`` has found to be given."""
    assert machine.load is not None
    return machine.load


def drive(segment: PlacedSegment, machine: Machine, theta: Array, s: Any) -> Any:
    """Drive force G [N] on a segment, from columns of s to s''' that may be symbols."""
    load, angles = load_of(machine), np.asarray(theta, dtype=float)
    process = load.process_on(segment, angles.ravel()).reshape(angles.shape)
    # 0·θ gives the sum the shape of θ: CasADi would take a NumPy vector for a row.
    return load.drive(s, 0.0 * theta + process, machine.omega)


def push_sign(flank: Flank, machine: Machine) -> int:
    """+1 on the main roller's flanks, −1 on a counter roller's: it pushes against growing s."""
    return -1 if flank.path in machine.follower.active_closure.counter_paths else 1


def transmission(path: TracePoint, segment: PlacedSegment, machine: Machine, s: Any, z: Any) -> Any:
    """G/N: λ cos α less the share of the contact force that friction in the guide takes."""
    load = load_of(machine)
    sine, cosine = pressure_angle_sine_cosine(path, s, z)
    resisted = load.friction_loss(load.sliding_sense(segment), sine, s[0], _absolute)
    return cosine * path.lever(s, z) - resisted


def _absolute(value: Any) -> Any:
    """|·| smoothed to a finite slope at 0, for numbers and for symbols."""
    return (value * value + 1e-18) ** 0.5
