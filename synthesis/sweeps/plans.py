"""Plans: how the axes of a sweep are combined."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, JsonValue
from pydantic_core import PydanticCustomError

from synthesis.sweeps.axes import MAX_VALUES, Place

Picks = Callable[[int], list[JsonValue]]


class Plan(BaseModel, ABC):
    """Which values go together in an item."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: str

    @abstractmethod
    def size(self, axes: Sequence[Place]) -> int:
        """How many items there are. Raises PydanticCustomError where the axes do not suit."""

    @abstractmethod
    def picks(self, axes: Sequence[Place]) -> Picks:
        """From an item's number, 0 upwards, to the values of the axes; always the same."""


class GridPlan(Plan):
    """Every value with every other; the last axis changes fastest."""

    kind: Literal["grid"] = "grid"

    def size(self, axes: Sequence[Place]) -> int:
        return math.prod(_counts(axes))

    def picks(self, axes: Sequence[Place]) -> Picks:
        counts = _counts(axes)

        def picked(number: int) -> list[JsonValue]:
            values: list[JsonValue] = []
            for axis, count in zip(reversed(axes), reversed(counts), strict=True):
                number, index = divmod(number, count)
                values.append(axis.at(index, count))
            return values[::-1]

        return picked


class RowsPlan(Plan):
    """Side by side: the first value of every axis, then the second of every axis, and so on."""

    kind: Literal["rows"]

    def size(self, axes: Sequence[Place]) -> int:
        counts = _counts(axes)
        for position, count in enumerate(counts):
            if count != counts[0]:
                raise PydanticCustomError(
                    "axes_of_unequal_length",
                    "axes/{position} has {count} values, but axes/0 has {first}; in rows all have "
                    "equally many. Give as many, or choose the plan grid.",
                    {"position": position, "count": count, "first": counts[0]},
                )
        return counts[0]

    def picks(self, axes: Sequence[Place]) -> Picks:
        size = self.size(axes)
        return lambda number: [axis.at(number, size) for axis in axes]


class LatinHypercubePlan(Plan):
    """Spread evenly at random: each axis is cut into ``count`` parts, each part used once."""

    kind: Literal["latin_hypercube"]
    count: Annotated[int, Field(ge=1, le=MAX_VALUES, description="How many items.")]
    seed: Annotated[
        int, Field(ge=0, le=2**32 - 1, description="The same seed, the same items.")
    ] = 0

    def size(self, axes: Sequence[Place]) -> int:
        return self.count

    def picks(self, axes: Sequence[Place]) -> Picks:
        from scipy.stats import qmc  # heavy, and most sweeps do without

        sampler = qmc.LatinHypercube(len(axes), rng=self.seed)
        shares = sampler.random(self.count)

        def picked(number: int) -> list[JsonValue]:
            row = shares[number]
            return [axis.between(float(share)) for axis, share in zip(axes, row, strict=True)]

        return picked


AnyPlan = Annotated[GridPlan | RowsPlan | LatinHypercubePlan, Field(discriminator="kind")]


def _counts(axes: Sequence[Place]) -> list[int]:
    counts = []
    for position, axis in enumerate(axes):
        if axis.size is None:
            raise PydanticCustomError(
                "axis_without_count",
                "axes/{position} has no count, which only a Latin hypercube does without. "
                "Give a count.",
                {"position": position},
            )
        counts.append(axis.size)
    return counts
