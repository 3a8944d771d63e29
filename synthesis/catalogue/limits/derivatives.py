"""Limits in the unit of the follower's displacement: velocity, acceleration and jerk."""

from __future__ import annotations

from abc import ABC
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality, derivative
from synthesis.catalogue.limits.base import Claim, Limit, Machine, scaling
from synthesis.catalogue.motion import PlacedSegment, Segments

Largest = Annotated[float, Field(gt=0.0, le=1e30)] | None


class TravelLimit(Limit, ABC):
    """A largest value in mm of a slide, or in degrees of an arm.

    ``fields``: the two that may give it, by the unit of displacement; exactly one does.
    """

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
    def bound(self) -> float:
        """The largest value in the wire's unit."""
        return float(getattr(self, self.field))


class DerivativeLimit(TravelLimit, ABC):
    """|s^(order)| ω^order ≤ a limit, at every cam angle and on both sides of a jump."""

    order: ClassVar[int]
    upper: ClassVar[bool] = True  # ``bound`` is a largest value

    @property
    def quantity(self) -> str:
        """Name of the measured quantity."""
        return self.kind

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        largest = self.bound / machine.wire_factor(self.order)
        up, down = (
            LinearInequality(derivative(self.order, sign), (), largest, source=self.kind)
            for sign in (1.0, -1.0)
        )
        return up, down

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        factor, unit = machine.wire_factor(self.order), machine.derivative_unit(self.order)
        bounds = -self.bound / factor, self.bound / factor
        return (self._claim(segments, bounds, self.field, unit, to_wire=scaling(factor)),)


class Velocity(DerivativeLimit):
    """|v| ≤ the limit at every cam angle."""

    kind: Literal["velocity"] = "velocity"
    title: ClassVar[str] = "Velocity"
    order: ClassVar[int] = 1
    fields: ClassVar[dict[str, str]] = {"mm": "max_mm_per_s", "deg": "max_deg_per_s"}
    max_mm_per_s: Largest = Field(None, description="Largest |velocity| of a slide.")
    max_deg_per_s: Largest = Field(None, description="Largest |velocity| of an arm.")


class Acceleration(DerivativeLimit):
    """|a| ≤ the limit at every cam angle, on both sides of a jump."""

    kind: Literal["acceleration"] = "acceleration"
    title: ClassVar[str] = "Acceleration"
    order: ClassVar[int] = 2
    fields: ClassVar[dict[str, str]] = {"mm": "max_mm_per_s2", "deg": "max_deg_per_s2"}
    max_mm_per_s2: Largest = Field(None, description="Largest |acceleration| of a slide.")
    max_deg_per_s2: Largest = Field(None, description="Largest |acceleration| of an arm.")


class Jerk(DerivativeLimit):
    """|j| ≤ the limit at every cam angle. A jump of the acceleration is an infinite jerk."""

    kind: Literal["jerk"] = "jerk"
    title: ClassVar[str] = "Jerk"
    order: ClassVar[int] = 3
    fields: ClassVar[dict[str, str]] = {"mm": "max_mm_per_s3", "deg": "max_deg_per_s3"}
    max_mm_per_s3: Largest = Field(None, description="Largest |jerk| of a slide.")
    max_deg_per_s3: Largest = Field(None, description="Largest |jerk| of an arm.")
