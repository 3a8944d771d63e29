"""What the objectives on acceleration and jerk have in common: the power of the cam's speed."""

from __future__ import annotations

from abc import ABC
from typing import ClassVar

from synthesis.limits.base import Machine
from synthesis.objectives.base import Objective
from synthesis.terms import Row, derivative


class DerivativeObjective(Objective, ABC):
    """A value of s^(order) per radian; on the wire times ω^order."""

    order: ClassVar[int]

    def name_on_wire(self, machine: Machine) -> str:
        return f"{self.kind}_{machine.told(0)}_per_s{self.order}"

    def to_wire(self, value: float, machine: Machine) -> float:
        return value * machine.rate(self.order)

    def from_wire(self, value: float, machine: Machine) -> float:
        return value / machine.rate(self.order)


def peak_rows(order: int, source: str) -> tuple[Row, ...]:
    """|s^(order)| ≤ P."""
    up, down = derivative(order, 1.0), derivative(order, -1.0)
    return (
        Row(up, (), 0.0, level=-1.0, source=source),
        Row(down, (), 0.0, level=-1.0, source=source),
    )
