"""The smallest cam: minimise the base radius."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.catalogue.constraints import AffineNorm
from synthesis.catalogue.followers.base import base_gap
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.objectives.base import Objective


class BaseRadius(Objective):
    """Minimise Rb: the prime radius less Rr, plus Rr where the roller runs in a ring."""

    kind: Literal["base_radius"] = "base_radius"
    title: ClassVar[str] = "Base radius"
    quantity: ClassVar[str] = "prime_radius"
    wire_name: ClassVar[str] = "base_radius_mm"

    def norm(self, machine: Machine) -> AffineNorm:
        return machine.follower.radius_norm()

    def to_wire(self, value: float, machine: Machine) -> float:
        return machine.follower.radius_from_norm(value) - base_gap(machine.follower)

    def from_wire(self, value: float, machine: Machine) -> float:
        return machine.follower.norm_from_radius(value + base_gap(machine.follower))
