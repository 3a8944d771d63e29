"""A question in units of its own: what cams of one shape, small or large, have in common.

Similarity of machines: a spec whose every number is divided by the unit of its kind, made of one
length and one time of the spec's own, asks the same. Divided so, and without the last digits that
the division leaves, cams that differ by a factor are one and the same question to the last bit; so
every search takes the same path. Masses keep their unit: with a load, time goes with the root of
length, so that forces and weights keep theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from math import sqrt
from types import MappingProxyType
from typing import Any, Self, get_args

from pydantic import BaseModel

from synthesis.numerics.digits import rounded
from synthesis.ranges import Range, ends
from synthesis.spec import DesignSpec
from synthesis.units import Pace, rad_per_s

KINDS: Mapping[str, tuple[int, int]] = MappingProxyType({
    "mm": (1, 0), "mm_per_s": (1, -1), "mm_per_s2": (1, -2), "mm_per_s3": (1, -3),
    "deg": (0, 0), "deg_per_s": (0, -1), "deg_per_s2": (0, -2), "deg_per_s3": (0, -3),
    "rpm": (0, -1), "hz": (0, -1),
    "kg": (0, 0), "n": (1, -2), "n_per_mm": (0, -2), "n_s_per_m": (0, -1), "mpa": (-1, -2),
    "kg_m2": (2, 0), "n_m": (2, -2), "n_m_per_rad": (2, -2), "n_m_s_per_rad": (2, -1),
})  # fmt: skip
"""Powers of length and of time by the end of a field's name; those of mass have no say."""

NEITHER = (0, 0)
BITS = 36  # of 53, 1e-11 relative: roundings of a spec's numbers are a ten thousandth of that
Change = Callable[[str, float], float]


@lru_cache(maxsize=1024)
def kind_of(name: str) -> str:
    """The longest of the kinds that a field's name ends with; empty where it ends with none."""
    return max((kind for kind in KINDS if name.endswith(f"_{kind}")), key=len, default="")


@dataclass(frozen=True)
class Units:
    """Units of length [mm] and of time [s] that a spec is measured in."""

    length: float
    time: float

    @classmethod
    def of(cls, spec: DesignSpec) -> Units:
        """A spec's own: the longest way of a segment, and the time in which the cam turns 1 rad."""
        openings = spec.openings
        program, follower = openings.filled([opening.high for opening in openings.free])
        pace = Pace(follower.travel, rad_per_s(spec.speed_rpm))
        length = max(high - low for low, high in (segment.span(pace) for segment in program))
        time = 1.0 / rad_per_s(spec.speed_rpm) if spec.load is None else sqrt(length)
        return cls(length, time)

    def of_field(self, name: str) -> float:
        """The unit that a field of this name is measured in, in the wire's own."""
        kind = kind_of(name)
        if not kind:
            return 1.0
        length, time = KINDS[kind]
        return float(self.length**length * self.time**time)


@dataclass(frozen=True, eq=False)
class Question:
    """What is asked, and the same in units of its own, which is what is solved."""

    asked: DesignSpec
    natural: DesignSpec
    units: Units

    @classmethod
    def of(cls, asked: DesignSpec) -> Self:
        """A question as it is asked."""
        units = Units.of(asked)

        def measured(name: str, value: float) -> float:
            return float(rounded(value / units.of_field(name), BITS))

        return cls(asked, _each(_spelled(asked), "", measured), units)

    def changed(self, natural: DesignSpec) -> Question:
        """The same with another spec in its own units; what that leaves alone stays as asked."""
        return Question(self.told(natural), natural, self.units)

    def told(self, natural: DesignSpec) -> DesignSpec:
        """A spec in its own units in the wire's; what it shares with the question is as asked."""
        if natural is self.natural:
            return self.asked
        same = _same(natural.program, self.natural.program)
        asked = self.asked if same else _spelled(self.asked)
        found = self._merged("", natural, self.natural, asked)
        assert isinstance(found, DesignSpec)
        return found

    def size(self, natural: tuple[float, ...]) -> tuple[float, ...]:
        """Size variables [mm]."""
        return tuple(value * self.units.length for value in natural)

    def _merged(self, name: str, new: Any, old: Any, asked: Any) -> Any:
        """``asked``, with what differs between ``old`` and ``new``."""
        if _same(new, old):
            return asked
        if isinstance(new, BaseModel) and type(new) is type(old):
            update = {
                field: self._merged(_inherited(field, name), value, was, getattr(asked, field))
                for field in type(new).model_fields
                for value, was in [(getattr(new, field), getattr(old, field))]
                if not _same(value, was)
            }
            return asked.model_copy(update=update)
        if isinstance(new, list) and len(new) == len(old):
            return [self._merged(name, *each) for each in zip(new, old, asked, strict=True)]
        found = _each(new, name, lambda field, value: value * self.units.of_field(field))
        if isinstance(found, float) and isinstance(asked, Range):
            low, high = ends(asked)
            return min(max(found, low), high)
        return found


def _same(one: Any, other: Any) -> bool:
    """Whether two parts of a body say the same: what is left alone is one and the same object."""
    return one is other or bool(one == other)


def _spelled(spec: DesignSpec) -> DesignSpec:
    """The same with every number in a field whose name tells its unit."""
    program = [segment.spelled() for segment in spec.program]
    spelled = any(new is not old for new, old in zip(program, spec.program, strict=True))
    return spec.model_copy(update={"program": program}) if spelled else spec


def _inherited(field: str, name: str) -> str:
    """Whose unit a field has: its own, or that of what it is a part of, as the ends of a range."""
    return field if kind_of(field) else name


def _each(value: Any, name: str, change: Change) -> Any:
    """A body of the wire with every number that has a unit changed, by the name of its field."""
    if isinstance(value, float):
        return change(name, value)
    if isinstance(value, (list, tuple)):
        found = type(value)([_each(one, name, change) for one in value])
        return (
            found if any(new is not old for new, old in zip(found, value, strict=True)) else value
        )
    if not isinstance(value, BaseModel):
        return value
    update, known = {}, value.__dict__
    for field, whose in _measured(type(value), name):
        old = known[field]
        new = _each(old, whose, change) if old else old  # nothing is nothing in any unit
        if new is not old:
            update[field] = new
    return value.model_copy(update=update) if update else value


@cache
def _measured(model: type[BaseModel], name: str) -> tuple[tuple[str, str], ...]:
    """Fields of a model that may hold numbers with a unit, and whose unit that is."""
    found = (
        (field, _inherited(field, name), i.annotation) for field, i in model.model_fields.items()
    )
    return tuple(
        (field, whose)
        for field, whose, annotation in found
        if KINDS.get(kind_of(whose), NEITHER) != NEITHER
        or any(_measured(part, whose) for part in _models_in(annotation))
    )


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """The models that a field of this type may hold."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models_in(part)
