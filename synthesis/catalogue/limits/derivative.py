"""What the limits on velocity, acceleration and jerk have in common."""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from typing import ClassVar

from synthesis.catalogue.constraints import LinearInequality, derivative
from synthesis.catalogue.limits.base import Claim, Machine, scaling, segment_indices
from synthesis.catalogue.limits.travel import TravelLimit
from synthesis.catalogue.motion import PlacedSegment


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

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        upper = self.largest / machine.wire_factor(self.order)
        up, down = derivative(self.order, 1.0), derivative(self.order, -1.0)
        return LinearInequality(up, (), upper, source=self.kind), LinearInequality(
            down, (), upper, source=self.kind
        )

    def claims(self, segments: Sequence[PlacedSegment], machine: Machine) -> tuple[Claim, ...]:
        to_wire = machine.wire_factor(self.order)
        largest, path = self.largest / to_wire, f"{self.kind}/{self.field}"
        claim = Claim(
            self.kind, self.kind, segment_indices(segments), -largest, largest,
            machine.derivative_unit(self.order), scaling(to_wire), path,
        )  # fmt: skip
        return (claim,)
