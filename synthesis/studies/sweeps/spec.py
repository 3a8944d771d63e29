"""SweepSpec: a base spec, the axes along which it is varied, and how they are combined."""

from __future__ import annotations

import copy
import json
from functools import cached_property
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, JsonValue, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.objectives import AnyObjective
from synthesis.design.identity import identity
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.sweeps.axes import Axis, locate
from synthesis.studies.sweeps.plans import AnyPlan, GridPlan, ItemValues, LatinHypercubePlan

MAX_AXES = 20


class SweepSpec(BaseModel):
    """Many designs: the base with other values of some fields."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: Annotated[str, Field(max_length=200, description="Shown in lists and file names.")] = ""
    base: Annotated[DesignSpec, Field(description="The design that is varied.")]
    axes: Annotated[
        list[Axis],
        Field(min_length=1, max_length=MAX_AXES, description="Fields to vary, and their values."),
    ]
    plan: Annotated[AnyPlan, Field(description="How the axes are combined.")] = GridPlan()
    quantities: Annotated[
        list[AnyObjective],
        Field(max_length=10, description="Further objectives to measure on every design, besides "
              "the dimensions and the base's own objectives, for trade-offs."),
    ] = []  # fmt: skip
    warm_start: Annotated[
        bool,
        Field(
            description="Where curvature decides, a design's local search begins where that of "
            "the item before has ended, in chains of eight items: a quarter less time. Values may "
            "then differ from those of the same spec alone, within the gap that is told; such a "
            "design names the other one in started_from and has an id of its own.",
        ),
    ] = False

    @model_validator(mode="after")
    def _check_fields(self) -> SweepSpec:
        document, taken = self.document, dict[tuple[str, ...], int]()
        for position, axis in enumerate(self.axes):
            names = [
                "pointer",
                *("linked_pointers" for _ in axis.linked_pointers),
                "balance_pointer",
            ]
            for name, field in zip(names, axis.fields, strict=False):
                try:
                    holder, key = locate(document, field)
                except LookupError as error:
                    raise PydanticCustomError(
                        "axis_leads_nowhere",
                        "{value} is not a field of the base: {there}. Name an existing field.",
                        {"value": field, "there": str(error), "position": position, "name": name},
                    ) from None
                if axis.balance_pointer is not None:
                    _check_number(holder[key], field, position, name)
                _check_unique(tuple(field.split("/")), field, taken, position, name)
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
        """The same with at most one value in a list: all that ``item`` needs, and short."""
        axes = [axis.shortened() for axis in self.axes]
        one = LatinHypercubePlan(kind="latin_hypercube", count=1)  # suits any axes
        return self.model_copy(update={"axes": axes, "plan": one})

    def item(self, values: list[JsonValue]) -> dict[str, Any]:
        """The design spec of an item as plain JSON, not validated.

        Raises:
            LookupError: another axis replaced the container of this axis's field.
        """
        document = copy.deepcopy(self.document)
        for axis, value in zip(self.axes, values, strict=True):
            moved = 0.0
            for field in (axis.pointer, *axis.linked_pointers):
                holder, key = locate(document, field)
                if axis.balance_pointer is not None and isinstance(value, int | float):
                    moved += value - holder[key]
                holder[key] = value
            if axis.balance_pointer is not None:
                holder, key = locate(document, axis.balance_pointer)
                holder[key] = float(f"{holder[key] - moved:.12g}")
        return document


def _check_number(value: Any, field: str, position: int, name: str) -> None:
    """Refuse to balance a field that is not a number."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise PydanticCustomError(
            "balance_needs_numbers",
            "{value} is not a number in the base and cannot be balanced. Give a number there, or "
            "leave balance out.",
            {"value": field, "position": position, "name": name},
        )


def _check_unique(
    parts: tuple[str, ...], field: str, taken: dict[tuple[str, ...], int], position: int, name: str
) -> None:
    """Refuse a field that another axis sets, or that is inside one that is set."""
    for other, by in taken.items():
        shorter = min(len(other), len(parts))
        if other[:shorter] == parts[:shorter]:
            raise PydanticCustomError(
                "axes_share_a_field",
                "{value} is also set by axes/{other}. Leave one of the two out.",
                {"value": field, "other": by, "position": position, "name": name},
            )
    taken[parts] = position


def sweep_id(spec: SweepSpec) -> str:
    """The sweep's id on this engine; the order of names within its values does not matter."""
    body = json.dumps(spec.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))
    return identity("sweep", body)
