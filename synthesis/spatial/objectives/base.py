"""What every objective of a spatial cam promises."""

from __future__ import annotations

from abc import ABC
from typing import ClassVar

from synthesis.limits.base import Machine
from synthesis.objectives.base import Objective
from synthesis.terms import Norm


class SpatialObjective(Objective, ABC):
    """Make one dimension of the machine small.

    Attributes:
        wire_name: its field.
    """

    quantity: ClassVar[str] = "size"

    def norm(self, machine: Machine) -> Norm:
        return machine.follower.prime_radius()

    def to_wire(self, value: float, machine: Machine) -> float:
        return value

    def from_wire(self, value: float, machine: Machine) -> float:
        return value
