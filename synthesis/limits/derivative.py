"""What the limits on velocity, acceleration and jerk have in common."""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.limits.base import Claim, Limit, Machine, times, where
from synthesis.motion import Stretch
from synthesis.terms import Row, derivative

Largest = Annotated[float, Field(gt=0.0, le=1e30)] | None


class DerivativeLimit(Limit, ABC):
    """|s^(order)| ω^order ≤ a limit, at every cam angle and on both sides of a jump.

    ``fields``: the two that may give it, by the unit of displacement; exactly one does.
    """

    order: ClassVar[int]
    fields: ClassVar[dict[str, str]]

    @model_validator(mode="after")
    def _given_once(self) -> Self:
        given = [unit for unit, name in self.fields.items() if getattr(self, name) is not None]
        if len(given) != 1:
            raise PydanticCustomError(
                "limit_unclear",
                "{kind} gives {number}. Give {slide} for a follower that slides, or {swing} for "
                "one on an arm.",
                {"kind": self.kind, "number": "two limits" if given else "no limit",
                 "slide": self.fields["mm"], "swing": self.fields["deg"]},
            )  # fmt: skip
        return self

    @property
    def travel_unit(self) -> str:
        return next(unit for unit, name in self.fields.items() if getattr(self, name) is not None)

    @property
    def field(self) -> str:
        """The field that gives it."""
        return self.fields[self.travel_unit]

    @property
    def largest(self) -> float:
        """The limit in the wire's unit."""
        return float(getattr(self, self.field))

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
