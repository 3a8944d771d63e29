"""Plans: how the axes of a sweep are combined into items."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, JsonValue
from pydantic_core import PydanticCustomError

from synthesis.studies.sweeps.axes import MAX_VALUES, SweepAxis

ItemValues = Callable[[int], list[JsonValue]]


class Plan(BaseModel, ABC):
    """Which values are combined in an item."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: str

    @abstractmethod
    def size(self, axes: Sequence[SweepAxis]) -> int:
        """Number of items.

        Raises:
            PydanticCustomError: the axes do not suit the plan.
        """

    @abstractmethod
    def item_values(self, axes: Sequence[SweepAxis]) -> ItemValues:
        """Maps an item's number, from 0, to the values of the axes; deterministic."""


class GridPlan(Plan):
    """Full factorial: all combinations; the last axis changes fastest."""

    kind: Literal["grid"] = "grid"

    def size(self, axes: Sequence[SweepAxis]) -> int:
        return math.prod(_counts(axes))

    def item_values(self, axes: Sequence[SweepAxis]) -> ItemValues:
        counts = _counts(axes)

        def values_of(number: int) -> list[JsonValue]:
            values: list[JsonValue] = []
            for axis, count in zip(reversed(axes), reversed(counts), strict=True):
                number, index = divmod(number, count)
                values.append(axis.at(index, count))
            return values[::-1]

        return values_of


class RowsPlan(Plan):
    """Item i takes value i of every axis."""

    kind: Literal["rows"]

    def size(self, axes: Sequence[SweepAxis]) -> int:
        counts = _counts(axes)
        for position, count in enumerate(counts):
            if count != counts[0]:
                raise PydanticCustomError(
                    "axes_of_unequal_length",
                    "axes/{position} has {count} values, but axes/0 has {first}; in the plan rows "
                    "all axes have the same number. Give as many, or choose the plan grid.",
                    {"position": position, "count": count, "first": counts[0]},
                )
        return counts[0]

    def item_values(self, axes: Sequence[SweepAxis]) -> ItemValues:
        size = self.size(axes)
        return lambda number: [axis.at(number, size) for axis in axes]


class LatinHypercubePlan(Plan):
    """Latin hypercube: each axis is divided into ``count`` parts, each of them used once."""

    kind: Literal["latin_hypercube"]
    count: Annotated[int, Field(ge=1, le=MAX_VALUES, description="Number of items.")]
    seed: Annotated[
        int, Field(ge=0, le=2**32 - 1, description="Seed: the same seed gives the same items.")
    ] = 0

    def size(self, axes: Sequence[SweepAxis]) -> int:
        return self.count

    def item_values(self, axes: Sequence[SweepAxis]) -> ItemValues:
        from scipy.stats import qmc  # slow to import, and most sweeps do without

        sampler = qmc.LatinHypercube(len(axes), rng=self.seed)
        shares = sampler.random(self.count)

        def values_of(number: int) -> list[JsonValue]:
            row = shares[number]
            return [axis.between(float(share)) for axis, share in zip(axes, row, strict=True)]

        return values_of


AnyPlan = Annotated[GridPlan | RowsPlan | LatinHypercubePlan, Field(discriminator="kind")]


def _counts(axes: Sequence[SweepAxis]) -> list[int]:
    counts = []
    for position, axis in enumerate(axes):
        if axis.size is None:
            raise PydanticCustomError(
                "axis_without_count",
                "axes/{position} has no count; only a Latin hypercube does without one. Give a "
                "count.",
                {"position": position},
            )
        counts.append(axis.size)
    return counts
