"""The closing spring: given, or chosen between two ends."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, field_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.ranges import Range, ends

RATE = "A number fixes it; {min, max} leaves it free in between; left out, it is free from 0 on."


def _not_negative(value: Any, what: str) -> Any:
    low, _ = ends(value)
    if -math.inf < low < 0.0:
        raise PydanticCustomError(
            "spring_negative",
            "{what} = {value} is negative: such a spring pulls the follower off its cam. "
            "Give 0 or more, or leave the spring out.",
            {"what": what, "value": low},
        )
    return value


class Spring(BaseModel):
    """What a spring promises, whatever its unit: its two fields are rate and preload."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @property
    def requested(self) -> dict[str, float | Range | None]:
        """Requested rate and preload, by field, in this order."""
        return {name: getattr(self, name) for name in type(self).model_fields}

    @property
    def ranges(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Ends of rate and preload [wire], open ends at 0 and infinity."""
        rate, preload = ((max(low, 0.0), high) for low, high in map(ends, self.requested.values()))
        return rate, preload


class SlideSpring(Spring):
    """A spring that presses a slide on its cam."""

    rate_n_per_mm: Annotated[float | Range | None, Field(description=f"Spring rate. {RATE}")] = None
    preload_n: Annotated[
        float | Range | None,
        Field(description=f"Force with which it presses at the lowest position. {RATE}"),
    ] = None

    @field_validator("rate_n_per_mm", "preload_n")
    @classmethod
    def _presses(cls, value: Any, info: Any) -> Any:
        return _not_negative(value, info.field_name)


class ArmSpring(Spring):
    """A spring that turns an arm against its cam."""

    rate_n_m_per_rad: Annotated[
        float | Range | None, Field(description=f"Rate about the pivot. {RATE}")
    ] = None
    preload_n_m: Annotated[
        float | Range | None,
        Field(description=f"Moment with which it presses at the lowest position. {RATE}"),
    ] = None

    @field_validator("rate_n_m_per_rad", "preload_n_m")
    @classmethod
    def _presses(cls, value: Any, info: Any) -> Any:
        return _not_negative(value, info.field_name)
