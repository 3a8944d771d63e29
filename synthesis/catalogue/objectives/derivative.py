"""What the objectives on acceleration and jerk have in common: the power of the cam's speed."""

from __future__ import annotations

from abc import ABC
from typing import ClassVar

from synthesis.catalogue.constraints import LinearInequality, derivative
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.objectives.base import Objective


class DerivativeObjective(Objective, ABC):
    """A value of s^(order) per radian; on the wire times ω^order."""

    order: ClassVar[int]

    def name_on_wire(self, machine: Machine) -> str:
        return f"{self.kind}_{machine.follower.travel.field_suffix(self.order)}"

    def to_wire(self, value: float, machine: Machine) -> float:
        return value * machine.wire_factor(self.order)

    def from_wire(self, value: float, machine: Machine) -> float:
        return value / machine.wire_factor(self.order)


def peak_inequalities(order: int, source: str) -> tuple[LinearInequality, ...]:
    """|s^(order)| ≤ P."""
    up, down = derivative(order, 1.0), derivative(order, -1.0)
    return (
        LinearInequality(up, (), 0.0, level=-1.0, source=source),
        LinearInequality(down, (), 0.0, level=-1.0, source=source),
    )
