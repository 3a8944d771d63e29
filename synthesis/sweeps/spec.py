"""SweepSpec: a base spec, what is changed in it, and how the changes are combined."""

from __future__ import annotations

import copy
import hashlib
import json
from functools import cached_property
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, JsonValue, model_validator
from pydantic_core import PydanticCustomError

from synthesis.objectives import AnyObjective
from synthesis.spec import DesignSpec
from synthesis.sweeps.axes import Axis, found_at
from synthesis.sweeps.plans import AnyPlan, GridPlan, LatinHypercubePlan, Picks

MAX_AXES = 20


class SweepSpec(BaseModel):
    """Many designs: the base with other values in some of its fields."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: Annotated[str, Field(max_length=200, description="Shown in lists and file names.")] = ""
    base: Annotated[DesignSpec, Field(description="The design that is varied.")]
    axes: Annotated[
        list[Axis],
        Field(min_length=1, max_length=MAX_AXES, description="What is varied, and how."),
    ]
    plan: Annotated[AnyPlan, Field(description="How the axes are combined.")] = GridPlan()
    quantities: Annotated[
        list[AnyObjective],
        Field(max_length=10, description="Objectives whose values are measured on every design "
              "too, beside the dimensions and the base's own objectives: what it is traded for."),
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
    def _fields_are_there(self) -> SweepSpec:
        document, taken = self.document, dict[tuple[str, ...], int]()
        for position, axis in enumerate(self.axes):
            names = ["pointer", *("also" for _ in axis.also), "balance"]
            for name, field in zip(names, axis.fields, strict=False):
                try:
                    holder, key = found_at(document, field)
                except LookupError as error:
                    raise PydanticCustomError(
                        "axis_leads_nowhere",
                        "{value} is not a field of the base: {there}. Name one that it has.",
                        {"value": field, "there": str(error), "position": position, "name": name},
                    ) from None
                if axis.balance is not None:
                    _is_number(holder[key], field, position, name)
                _is_alone(tuple(field.split("/")), field, taken, position, name)
        return self

    @model_validator(mode="after")
    def _plan_suits(self) -> SweepSpec:
        self.plan.size(self.axes)
        return self

    @property
    def size(self) -> int:
        """How many items there are."""
        return self.plan.size(self.axes)

    @cached_property
    def document(self) -> dict[str, Any]:
        """The base as plain JSON, all fields there."""
        return self.base.model_dump(mode="json")

    @cached_property
    def picks(self) -> Picks:
        """From an item's number to the values of the axes."""
        return self.plan.picks(self.axes)

    def without_values(self) -> SweepSpec:
        """The same with no more than one value in a list: what ``item`` needs, and short."""
        axes = [axis.shortened() for axis in self.axes]
        one = LatinHypercubePlan(kind="latin_hypercube", count=1)  # the plan that any axes suit
        return self.model_copy(update={"axes": axes, "plan": one})

    def item(self, values: list[JsonValue]) -> dict[str, Any]:
        """The design spec of an item as plain JSON; whether it makes sense is not looked at.

        Raises:
            LookupError: another axis has put a value where this one's field was.
        """
        document = copy.deepcopy(self.document)
        for axis, value in zip(self.axes, values, strict=True):
            moved = 0.0
            for field in (axis.pointer, *axis.also):
                holder, key = found_at(document, field)
                if axis.balance is not None and isinstance(value, int | float):
                    moved += value - holder[key]
                holder[key] = value
            if axis.balance is not None:
                holder, key = found_at(document, axis.balance)
                holder[key] = float(f"{holder[key] - moved:.12g}")
        return document


def _is_number(value: Any, field: str, position: int, name: str) -> None:
    """Only numbers can give way, or make another one give way."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise PydanticCustomError(
            "balance_needs_numbers",
            "{value} is no number in the base, so nothing can balance it. Give a number there, or "
            "leave balance out.",
            {"value": field, "position": position, "name": name},
        )


def _is_alone(
    parts: tuple[str, ...], field: str, taken: dict[tuple[str, ...], int], position: int, name: str
) -> None:
    """No field is set twice, nor inside of another that is."""
    for other, by in taken.items():
        shorter = min(len(other), len(parts))
        if other[:shorter] == parts[:shorter]:
            raise PydanticCustomError(
                "axes_share_a_field",
                "{value} is set by axes/{other} as well. Leave one of the two out.",
                {"value": field, "other": by, "position": position, "name": name},
            )
    taken[parts] = position


def sweep_id(spec: SweepSpec, engine_version: str) -> str:
    """Hash of the spec and the engine's version: the same sweep has the same name."""
    body = json.dumps(spec.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(f"{engine_version}\nsweep\n{body}".encode()).hexdigest()[:32]
