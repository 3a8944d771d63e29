"""Axes: the fields of the base spec that a sweep changes, and their values."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, JsonValue, model_validator
from pydantic_core import PydanticCustomError

MAX_VALUES = 100_000
MAX_ALSO = 100

Pointer = Annotated[
    str,
    Field(
        max_length=200,
        description="JSON pointer (RFC 6901) to a field of the base, such as "
        "`/limits/0/rise_deg` or `/program/0/law/kind`.",
    ),
]


class SweepAxis(BaseModel, ABC):
    """An axis of any kind: the field, and fields that change with it."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    pointer: Pointer
    linked_pointers: Annotated[
        list[Pointer],
        Field(max_length=MAX_ALSO, description="Fields that take the same value, such as the "
              "return's lift along with the rise's."),
    ] = []  # fmt: skip
    balance_pointer: Annotated[
        Pointer | None,
        Field(
            description="Field that compensates, so that its sum with the others stays as in the "
            "base: such as the dwell that completes 360°."
        ),
    ] = None

    @property
    def fields(self) -> list[str]:
        """Every field of the base that the axis changes."""
        return [
            self.pointer,
            *self.linked_pointers,
            *([] if self.balance_pointer is None else [self.balance_pointer]),
        ]

    @property
    @abstractmethod
    def size(self) -> int | None:
        """Number of values; None: as many as the plan needs."""

    @property
    @abstractmethod
    def numeric(self) -> bool:
        """Whether all of its values are numbers."""

    @abstractmethod
    def shortened(self) -> Self:
        """The same axis without a long list of values."""

    @abstractmethod
    def at(self, index: int, size: int) -> JsonValue:
        """The value number ``index`` of ``size``."""

    @abstractmethod
    def between(self, share: float) -> JsonValue:
        """The value at a share in [0, 1)."""


class ListAxis(SweepAxis):
    """Values in a list: numbers, names, or whole objects such as a law."""

    kind: Literal["list"]
    values: Annotated[
        list[JsonValue],
        Field(min_length=1, max_length=MAX_VALUES, description="The values, in order."),
    ]

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

    start: Annotated[float, Field(ge=-1e12, le=1e12, description="First value.")]
    stop: Annotated[float, Field(ge=-1e12, le=1e12, description="Last value.")]
    count: Annotated[
        int | None,
        Field(
            ge=1,
            le=MAX_VALUES,
            description="Number of values; left out in a Latin hypercube, which has its own count.",
        ),
    ] = None

    @property
    def size(self) -> int | None:
        return self.count

    @property
    def numeric(self) -> bool:
        return True

    def shortened(self) -> Self:
        return self

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


def _pointer_parts(pointer: str) -> list[str]:
    """The reference tokens of a JSON pointer; none where it is no pointer."""
    if not pointer.startswith("/"):
        return []
    return [part.replace("~1", "/").replace("~0", "~") for part in pointer.split("/")[1:]]


def locate(document: Any, pointer: str) -> tuple[Any, str | int]:
    """The container of the field that a pointer names, and the field's key or index in it.

    Raises:
        LookupError: there is no such field; its argument says what there is instead.
    """
    at, parts = document, _pointer_parts(pointer)
    for depth, part in enumerate(parts):
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
