"""SweepSpec: a base spec, the axes along which it is varied, and the plan that combines them."""

from __future__ import annotations

import copy
import json
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, JsonValue, field_validator, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import FiniteModel, Name
from synthesis.catalogue.objectives import AnyObjective
from synthesis.design.identity import identity
from synthesis.errors.names import right_name
from synthesis.spec.design_spec import DesignSpec

MAX_VALUES = 100_000  # of an axis, and items of a Latin hypercube
MAX_LINKED = 100  # fields that one axis changes
MAX_AXES = 20  # of a sweep

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
        linked = [("linked_pointers", each) for each in self.linked_pointers]
        balance = [("balance_pointer", each) for each in (self.balance_pointer,) if each]
        return [("pointer", self.pointer), *linked, *balance]

    @property
    @abstractmethod
    def size(self) -> int | None:
        """Number of values; None: as many as the plan needs."""

    @property
    def numeric(self) -> bool:
        """Whether all of its values are numbers."""
        return True

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
        return lambda number: [
            axis.at(int(index), count)
            for axis, index, count in zip(
                axes, np.unravel_index(number, counts), counts, strict=True
            )
        ]


class RowsPlan(Plan):
    """Item i takes value i of every axis."""

    kind: Literal["rows"]

    def size(self, axes: Sequence[SweepAxis]) -> int:
        first, *others = _counts(axes)
        for position, count in enumerate(others, 1):
            if count != first:
                raise PydanticCustomError(
                    "axes_of_unequal_length",
                    "axes/{position} has {count} values, but axes/0 has {first}; in the plan rows "
                    "all axes have the same number. Give as many, or choose the plan grid.",
                    {"position": position, "count": count, "first": first},
                )
        return first

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
    counts = [axis.size for axis in axes]
    if None in counts:
        raise PydanticCustomError(
            "axis_without_count",
            "axes/{position} has no count; only a Latin hypercube does without one. Give a count.",
            {"position": counts.index(None)},
        )
    return [count for count in counts if count is not None]


class SweepSpec(FiniteModel):
    """Many designs: the base with other values of some fields."""

    name: Name = Field("", description="Shown in lists and file names.")
    base: DesignSpec = Field(
        description="The design that is varied; its `proof` is `quick` where it is left out."
    )
    axes: list[Axis] = Field(
        min_length=1, max_length=MAX_AXES, description="Fields to vary, and their values."
    )
    plan: AnyPlan = Field(GridPlan(), description="How the axes are combined.")
    quantities: list[AnyObjective] = Field(
        [],
        max_length=10,
        description="Further objectives to measure on every design, besides the dimensions and the "
        "base's own objectives, for trade-offs.",
    )
    warm_start: bool = Field(
        False,
        description="Where curvature decides, local searches begin where that of the item before "
        "has ended, in chains of eight: a quarter less time. Values may differ from those of the "
        "spec alone, within the gap; such a design has an id of its own and names the other one "
        "in started_from.",
    )

    @field_validator("base")
    @classmethod
    def _prove_quickly(cls, base: DesignSpec) -> DesignSpec:
        """Of many designs none takes seconds for its proof, unless that is asked for."""
        chosen = "proof" in base.model_fields_set
        return base if chosen else base.model_copy(update={"proof": "quick"})

    @model_validator(mode="after")
    def _check_fields(self) -> SweepSpec:
        set_by = dict[tuple[str, ...], int]()
        for position, axis in enumerate(self.axes):
            for name, field in axis.fields:
                wrong = {"value": field, "position": position, "name": name}
                try:
                    holder, key = _locate(self.document, field)
                except LookupError as error:
                    raise PydanticCustomError(
                        "axis_leads_nowhere",
                        "{value} is not a field of the base: {there}. {remedy}.",
                        {**wrong, "there": error.args[0], "remedy": error.args[1]},
                    ) from None
                # In JSON a boolean is no number, though in Python it is.
                if axis.balance_pointer is not None and type(holder[key]) not in (int, float):
                    raise PydanticCustomError(
                        "balance_needs_numbers",
                        "{value} is not a number in the base and cannot be balanced. Give a number "
                        "there, or leave balance out.",
                        wrong,
                    )
                # No field may be set twice, nor lie inside one that is set.
                parts = tuple(field.split("/"))
                for other, by in set_by.items():
                    if all(a == b for a, b in zip(other, parts, strict=False)):
                        raise PydanticCustomError(
                            "axes_share_a_field",
                            "{value} is also set by axes/{other}. Leave one of the two out.",
                            {**wrong, "other": by},
                        )
                set_by[parts] = position
        return self

    @model_validator(mode="after")
    def _check_plan(self) -> SweepSpec:
        self.plan.size(self.axes)
        return self

    @property
    def size(self) -> int:
        """Number of items."""
        return self.plan.size(self.axes)

    @cached_property
    def document(self) -> dict[str, Any]:
        """The base as plain JSON with all fields."""
        return self.base.model_dump(mode="json")

    @cached_property
    def item_values(self) -> ItemValues:
        """Maps an item's number to the values of the axes."""
        return self.plan.item_values(self.axes)

    def without_values(self) -> SweepSpec:
        """The same fields without their values: all that ``item`` needs, and short."""
        pointers = (axis.model_dump(include=set(SweepAxis.model_fields)) for axis in self.axes)
        axes = [ListAxis(kind="list", values=[None], **each) for each in pointers]
        return self.model_copy(update={"axes": axes, "plan": GridPlan()})

    def item(self, values: list[JsonValue]) -> dict[str, Any]:
        """The design spec of an item as plain JSON, not validated.

        Raises:
            LookupError: another axis replaced the container of this axis's field.
        """
        document = copy.deepcopy(self.document)
        for axis, value in zip(self.axes, values, strict=True):
            moved = 0.0
            for field in (axis.pointer, *axis.linked_pointers):
                holder, key = _locate(document, field)
                if axis.balance_pointer is not None and isinstance(value, int | float):
                    moved += value - holder[key]
                holder[key] = value
            if axis.balance_pointer is not None:
                holder, key = _locate(document, axis.balance_pointer)
                holder[key] = _twelve_digits(holder[key] - moved)
        return document


def _locate(document: Any, pointer: str) -> tuple[Any, str | int]:
    """The container of the field that a pointer names, and the field's key or index in it.

    Raises:
        LookupError: there is no such field; it says what there is instead, and what to do.
    """
    if not pointer.startswith("/"):
        path = re.sub(r"[./\[\]]+", "/", pointer).strip("/")  # as ``limits[0].rise_deg``
        raise LookupError("a pointer begins with / and names a field", f"Write /{path}")
    holder, at, where, choose = None, document, "", "Name an existing field"
    key: str | int
    for token in pointer.split("/")[1:]:
        key = token.replace("~1", "/").replace("~0", "~")
        if isinstance(at, dict):
            if key not in at:
                right, rest = right_name(key, at), pointer[len(where) + 1 + len(token) :]
                there = f"{where or 'the base'} has {', '.join(at)}"
                raise LookupError(there, f"Write {where}/{right}{rest}" if right else choose)
        elif isinstance(at, list):
            if not key.isdecimal() or int(key) >= len(at):
                raise LookupError(f"{where} has the entries 0 to {len(at) - 1}", choose)
            key = int(key)
        else:
            raise LookupError(f"{where} is {at!r}, which holds no fields", choose)
        holder, at, where = at, at[key], f"{where}/{token}"
    return holder, key


def sweep_id(spec: SweepSpec) -> str:
    """The sweep's id on this engine; the order of names within its values does not matter."""
    body = json.dumps(spec.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))
    return identity("sweep", body)
