"""The smallest cam: minimise the base radius."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.limits.base import Machine
from synthesis.objectives.base import Objective
from synthesis.terms import Norm


class BaseRadius(Objective):
    """Minimise Rb: the prime radius less Rr, plus Rr where the roller runs in a ring."""

    kind: Literal["base_radius"] = "base_radius"
    title: ClassVar[str] = "Base radius"
    quantity: ClassVar[str] = "prime_radius"
    wire_name: ClassVar[str] = "base_radius_mm"

    def norm(self, machine: Machine) -> Norm:
        return machine.follower.prime_radius()

    def to_wire(self, value: float, machine: Machine) -> float:
        return machine.follower.radius_of(value) - machine.follower.base_gap

    def from_wire(self, value: float, machine: Machine) -> float:
        return machine.follower.value_of(value + machine.follower.base_gap)
