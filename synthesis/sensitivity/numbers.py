"""The numbers that limit a cam, and the spec with one of them changed."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from pydantic import ValidationError

from synthesis.design import Design
from synthesis.ranges import ends
from synthesis.spec import DesignSpec

DEMANDS = ("windows", "points")  # of a segment
PLACES = ("from_deg", "to_deg", "angle_deg")  # of these: the knots of a law stand there
SMALL = 0.1  # of the stroke: what a number near 0 is compared with


class Number(ABC):
    """One number on which a design depends.

    Attributes:
        spec: with numbers in place of what it left free.
    """

    spec: DesignSpec

    @property
    @abstractmethod
    def asked(self) -> float:
        """Its value."""

    @property
    def size(self) -> float:
        """What a change of it is compared with."""
        return max(abs(self.asked), SMALL * self.spec.stroke())

    @abstractmethod
    def at(self, value: float) -> DesignSpec | None:
        """The spec with another value; None where that makes no sense."""


@dataclass(frozen=True, eq=False)
class Asked(Number):
    """A number that the spec says; ``path``: keys down to it."""

    spec: DesignSpec
    path: tuple[str | int, ...]

    @property
    def pointer(self) -> str:
        """Its JSON pointer."""
        return "".join(f"/{part}" for part in self.path)

    @cached_property
    def asked(self) -> float:
        return float(_down(self.spec.model_dump(mode="json"), self.path))

    def at(self, value: float) -> DesignSpec | None:
        document = copy.deepcopy(self.spec.model_dump(mode="json"))
        _down(document, self.path[:-1])[self.path[-1]] = value
        try:
            return DesignSpec.model_validate(document).alone()
        except ValidationError:
            return None


@dataclass(frozen=True, eq=False)
class Chosen(Number):
    """A number that the spec leaves free and the design has chosen.

    Attributes:
        question: the spec as asked. values: all that were chosen. position: this one's.
    """

    spec: DesignSpec
    question: DesignSpec
    values: tuple[float, ...]
    position: int

    @property
    def asked(self) -> float:
        return self.values[self.position]

    @property
    def ends(self) -> tuple[float, float]:
        """Of the range that it was chosen from."""
        return ends(self.question.openings.free[self.position].asked)

    def at(self, value: float) -> DesignSpec | None:
        moved = [value if k == self.position else old for k, old in enumerate(self.values)]
        try:
            return self.question.with_numbers(moved).alone()
        except ValidationError:
            return None


def chosen(design: Design) -> Iterator[Chosen]:
    """What a design has chosen for angles, lifts and lengths left free."""
    openings = design.spec.openings.free if design.chosen else ()
    values = tuple(design.chosen[opening.field] for opening in openings)
    for position in range(len(values)):
        yield Chosen(design.numbered, design.spec, values, position)


def asked(spec: DesignSpec) -> Iterator[Asked]:
    """All of a spec: in its limits, ends of ranges of its size, values of windows and points."""
    document = spec.model_dump(mode="json", exclude_none=True)
    roots: list[tuple[str | int, ...]] = [("limits",), ("base_radius_mm",)]
    roots += [("follower", name) for name in spec.follower.adjustable()]
    segments = range(len(spec.program))
    roots += [("program", index, part) for index in segments for part in DEMANDS]
    for root in roots:
        for path in _leaves(_down(document, root), root):
            exact = str(path[-1]).startswith("tolerance") and not _down(document, path)
            if path[-1] not in PLACES and not exact:
                yield Asked(spec, path)


def _down(at: Any, path: tuple[str | int, ...]) -> Any:
    for key in path:
        at = at.get(key) if isinstance(at, dict) else at[key]
        if at is None:
            break
    return at


def _leaves(at: Any, path: tuple[str | int, ...]) -> Iterator[tuple[str | int, ...]]:
    if isinstance(at, dict):
        for key, inner in at.items():
            yield from _leaves(inner, (*path, key))
    elif isinstance(at, list):
        for index, inner in enumerate(at):
            yield from _leaves(inner, (*path, index))
    elif isinstance(at, float) and isinstance(path[-1], str):  # a table's readings have no name
        yield path
