"""SweepSpec: a base spec, the axes along which it is varied, and how they are combined."""

from __future__ import annotations

import copy
import json
from functools import cached_property
from typing import Any

from pydantic import Field, JsonValue, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import FiniteModel, Name
from synthesis.catalogue.objectives import AnyObjective
from synthesis.design.identity import identity
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.sweeps.axes import (
    AnyPlan,
    Axis,
    GridPlan,
    ItemValues,
    LatinHypercubePlan,
    locate,
)

MAX_AXES = 20


class SweepSpec(FiniteModel):
    """Many designs: the base with other values of some fields."""

    name: Name = Field("", description="Shown in lists and file names.")
    base: DesignSpec = Field(description="The design that is varied.")
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
        description="Where curvature decides, a design's local search begins where that of "
        "the item before has ended, in chains of eight items: a quarter less time. Values may "
        "then differ from those of the same spec alone, within the gap that is told; such a "
        "design names the other one in started_from and has an id of its own.",
    )

    @model_validator(mode="after")
    def _check_fields(self) -> SweepSpec:
        set_by = dict[tuple[str, ...], int]()
        for position, axis in enumerate(self.axes):
            for name, field in axis.fields:
                wrong = {"value": field, "position": position, "name": name}
                try:
                    holder, key = locate(self.document, field)
                except LookupError as error:
                    raise PydanticCustomError(
                        "axis_leads_nowhere",
                        "{value} is not a field of the base: {there}. Name an existing field.",
                        {**wrong, "there": str(error)},
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


def sweep_id(spec: SweepSpec) -> str:
    """The sweep's id on this engine; the order of names within its values does not matter."""
    body = json.dumps(spec.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))
    return identity("sweep", body)
