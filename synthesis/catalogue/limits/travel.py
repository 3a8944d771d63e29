"""What limits have in common that are given in the unit of the follower's displacement."""

from __future__ import annotations

from abc import ABC
from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.limits.base import Limit

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
    def largest(self) -> float:
        """The limit in the wire's unit."""
        return float(getattr(self, self.field))
