"""What the limits on velocity, acceleration and jerk have in common."""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from typing import ClassVar

from synthesis.limits.base import Claim, Machine, times, where
from synthesis.limits.travel import TravelLimit
from synthesis.motion import Stretch
from synthesis.terms import Row, derivative


class DerivativeLimit(TravelLimit, ABC):
    """|s^(order)| ω^order ≤ a limit, at every cam angle and on both sides of a jump."""

    order: ClassVar[int]
    upper: ClassVar[bool] = True  # ``bound`` is a largest value

    @property
    def quantity(self) -> str:
        """What is measured for it."""
        return self.kind

    @property
    def bound(self) -> float:
        """The limit in the wire's unit."""
        return self.largest

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        upper = self.largest / machine.rate(self.order)
        up, down = derivative(self.order, 1.0), derivative(self.order, -1.0)
        return Row(up, (), upper, source=self.kind), Row(down, (), upper, source=self.kind)

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        to_wire = machine.rate(self.order)
        largest, path = self.largest / to_wire, f"{self.kind}/{self.field}"
        claim = Claim(
            self.kind, self.kind, where(stretches), -largest, largest, machine.told(self.order),
            times(to_wire), path,
        )  # fmt: skip
        return (claim,)
