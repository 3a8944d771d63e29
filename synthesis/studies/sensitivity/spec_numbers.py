"""The numbers of a spec on which a design depends, and the spec with one of them changed."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from pydantic import ValidationError

from synthesis.catalogue.ranges import ends
from synthesis.design.design import Design
from synthesis.spec.design_spec import DesignSpec

DEMANDS = ("windows", "points")  # of a segment
PLACES = ("from_deg", "to_deg", "angle_deg")  # of these: knots of a law, which are fixed
SMALL = 0.1  # of the stroke: size of a number near 0

Path = tuple[str | int, ...]


class Number(ABC):
    """One number on which a design depends.

    Attributes:
        spec: with numbers in place of what it left free.
    """

    spec: DesignSpec

    @property
    @abstractmethod
    def value(self) -> float:
        """Its value."""

    @property
    def size(self) -> float:
        """The magnitude that steps are relative to."""
        return max(abs(self.value), SMALL * self.spec.stroke())

    @abstractmethod
    def at(self, value: float) -> DesignSpec | None:
        """The spec with another value; None where that is no valid spec."""


@dataclass(frozen=True, eq=False)
class SpecNumber(Number):
    """A number that the spec gives.

    Attributes:
        path: keys and indices down to it.
    """

    spec: DesignSpec
    path: Path

    @property
    def pointer(self) -> str:
        """Its JSON pointer."""
        return "".join(f"/{part}" for part in self.path)

    @cached_property
    def value(self) -> float:
        return float(_resolve(self.spec.model_dump(mode="json"), self.path))

    def at(self, value: float) -> DesignSpec | None:
        document = copy.deepcopy(self.spec.model_dump(mode="json"))
        _resolve(document, self.path[:-1])[self.path[-1]] = value
        try:
            return DesignSpec.model_validate(document).without_deferred()
        except ValidationError:
            return None


@dataclass(frozen=True, eq=False)
class ChosenNumber(Number):
    """A number that the spec leaves free and the design has chosen.

    Attributes:
        question: the spec as it was sent. values: all chosen numbers. position: of this one.
    """

    spec: DesignSpec
    question: DesignSpec
    values: tuple[float, ...]
    position: int

    @property
    def value(self) -> float:
        return self.values[self.position]

    @property
    def ends(self) -> tuple[float, float]:
        """Least and largest value of the range that it was chosen from."""
        return ends(self.question.free_parameters.parameters[self.position].requested)

    def at(self, value: float) -> DesignSpec | None:
        moved = [value if k == self.position else old for k, old in enumerate(self.values)]
        try:
            return self.question.with_values(moved).without_deferred()
        except ValidationError:
            return None


def chosen_numbers(design: Design) -> Iterator[ChosenNumber]:
    """The angles, lifts and lengths that a design has chosen."""
    searched = design.spec.free_parameters.parameters if design.free_parameters else ()
    values = tuple(design.free_parameters[parameter.field] for parameter in searched)
    for position in range(len(values)):
        yield ChosenNumber(design.resolved_spec, design.spec, values, position)


def spec_numbers(spec: DesignSpec) -> Iterator[SpecNumber]:
    """The numbers of limits, of ranges of the size, and of windows and points."""
    document = spec.model_dump(mode="json", exclude_none=True)
    roots: list[Path] = [("limits",), ("base_radius_mm",)]
    roots += [("follower", name) for name in spec.follower.adjustable_dimensions()]
    segments = range(len(spec.program))
    roots += [("program", index, part) for index in segments for part in DEMANDS]
    for root in roots:
        for path in _numeric_leaves(_resolve(document, root), root):
            exact = str(path[-1]).startswith("tolerance") and not _resolve(document, path)
            if path[-1] not in PLACES and not exact:
                yield SpecNumber(spec, path)


def _resolve(at: Any, path: Path) -> Any:
    for key in path:
        at = at.get(key) if isinstance(at, dict) else at[key]
        if at is None:
            break
    return at


def _numeric_leaves(at: Any, path: Path) -> Iterator[Path]:
    if isinstance(at, dict):
        for key, inner in at.items():
            yield from _numeric_leaves(inner, (*path, key))
    elif isinstance(at, list):
        for index, inner in enumerate(at):
            yield from _numeric_leaves(inner, (*path, index))
    elif isinstance(at, float) and isinstance(path[-1], str):  # values of a table have no name
        yield path
