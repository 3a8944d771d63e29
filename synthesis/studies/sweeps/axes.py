"""Axes, the fields of the base spec that a sweep changes, and plans that combine their values."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Annotated, Any, Literal, Self

from pydantic import Field, JsonValue, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import FiniteModel

MAX_VALUES = 100_000  # of an axis, and items of a Latin hypercube
MAX_LINKED = 100

Pointer = Annotated[
    str,
    Field(
        max_length=200,
        description="JSON pointer (RFC 6901) to a field of the base, such as "
        "`/limits/0/rise_deg` or `/program/0/law/kind`.",
    ),
]
End = Annotated[float, Field(ge=-1e12, le=1e12)]
ItemValues = Callable[[int], list[JsonValue]]


class SweepAxis(FiniteModel, ABC):
    """An axis of any kind: the field, and fields that change with it."""

    pointer: Pointer
    linked_pointers: list[Pointer] = Field(
        [],
        max_length=MAX_LINKED,
        description="Fields that take the same value, such as the return's lift along with the "
        "rise's.",
    )
    balance_pointer: Pointer | None = Field(
        None,
        description="Field that compensates, so that its sum with the others stays as in the "
        "base: such as the dwell that completes 360°.",
    )

    @property
    def fields(self) -> list[tuple[str, str]]:
        """Every field of the base that the axis changes, with the name of its pointer."""
        fields = [("pointer", self.pointer)]
        fields += [("linked_pointers", each) for each in self.linked_pointers]
        return fields + [("balance_pointer", each) for each in (self.balance_pointer,) if each]

    @property
    @abstractmethod
    def size(self) -> int | None:
        """Number of values; None: as many as the plan needs."""

    @property
    def numeric(self) -> bool:
        """Whether all of its values are numbers."""
        return True

    def shortened(self) -> Self:
        """The same axis without a long list of values."""
        return self

    @abstractmethod
    def at(self, index: int, size: int) -> JsonValue:
        """The value number ``index`` of ``size``."""

    @abstractmethod
    def between(self, share: float) -> JsonValue:
        """The value at a share in [0, 1)."""


class ListAxis(SweepAxis):
    """Values in a list: numbers, names, or whole objects such as a law."""

    kind: Literal["list"]
    values: list[JsonValue] = Field(
        min_length=1, max_length=MAX_VALUES, description="The values, in order."
    )

    @property
    def size(self) -> int | None:
        return len(self.values)

    @property
    def numeric(self) -> bool:
        return all(type(value) in (int, float) for value in self.values)

    def shortened(self) -> Self:
        return self.model_copy(update={"values": self.values[:1]})

    def at(self, index: int, size: int) -> JsonValue:
        return self.values[index]

    def between(self, share: float) -> JsonValue:
        return self.values[int(share * len(self.values))]


class Interval(SweepAxis):
    """Numbers from start to stop, both included; spacing by the kind."""

    start: End = Field(description="First value.")
    stop: End = Field(description="Last value.")
    count: int | None = Field(
        None,
        ge=1,
        le=MAX_VALUES,
        description="Number of values; left out in a Latin hypercube, which has its own count.",
    )

    @property
    def size(self) -> int | None:
        return self.count

    def at(self, index: int, size: int) -> JsonValue:
        if index == 0 or size == 1:
            return self.start
        return self.stop if index == size - 1 else self.between(index / (size - 1))


class RangeAxis(Interval):
    """Numbers at equal distances."""

    kind: Literal["range"]

    def between(self, share: float) -> JsonValue:
        return _twelve_digits(self.start + (self.stop - self.start) * share)


class LogRangeAxis(Interval):
    """Numbers at equal ratios."""

    kind: Literal["log_range"]

    @model_validator(mode="after")
    def _same_sign(self) -> LogRangeAxis:
        if self.start * self.stop <= 0.0:
            raise PydanticCustomError(
                "log_range_through_zero",
                "a log_range from {start} to {stop} contains zero. Give ends of one sign, or use a "
                "range.",
                {"start": self.start, "stop": self.stop},
            )
        return self

    def between(self, share: float) -> JsonValue:
        return _twelve_digits(self.start * math.exp(share * math.log(self.stop / self.start)))


Axis = Annotated[ListAxis | RangeAxis | LogRangeAxis, Field(discriminator="kind")]


def _twelve_digits(value: float) -> float:
    """Rounded to twelve digits, without the noise of rounding."""
    return float(f"{value:.12g}")


class Plan(FiniteModel, ABC):
    """Which values are combined in an item."""

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
                values.insert(0, axis.at(index, count))
            return values

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
    count: int = Field(ge=1, le=MAX_VALUES, description="Number of items.")
    seed: int = Field(
        0, ge=0, le=2**32 - 1, description="Seed: the same seed gives the same items."
    )

    def size(self, axes: Sequence[SweepAxis]) -> int:
        return self.count

    def item_values(self, axes: Sequence[SweepAxis]) -> ItemValues:
        from scipy.stats import qmc  # slow to import, and most sweeps do without

        shares = qmc.LatinHypercube(len(axes), rng=self.seed).random(self.count).tolist()
        return lambda number: [
            axis.between(share) for axis, share in zip(axes, shares[number], strict=True)
        ]


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


def locate(document: Any, pointer: str) -> tuple[Any, str | int]:
    """The container of the field that a pointer names, and the field's key or index in it.

    Raises:
        LookupError: there is no such field; its argument says what there is instead.
    """
    # The pointer's reference tokens; none where it is no pointer.
    parts = pointer.split("/")[1:] if pointer.startswith("/") else []
    at = document
    for depth, token in enumerate(parts):
        part = token.replace("~1", "/").replace("~0", "~")
        where = "/" + "/".join(parts[:depth]) if depth else "the base"
        if isinstance(at, dict):
            if part not in at:
                raise LookupError(f"{where} has {', '.join(map(str, at))}")
            key: str | int = part
        elif isinstance(at, list):
            if not part.isdecimal() or int(part) >= len(at):
                raise LookupError(f"{where} has the entries 0 to {len(at) - 1}")
            key = int(part)
        else:
            raise LookupError(f"{where} is {at!r}, which holds no fields")
        if depth == len(parts) - 1:
            return at, key
        at = at[key]
    raise LookupError("a pointer begins with / and names a field")
