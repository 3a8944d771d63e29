"""Nondimensional specs: cams that differ by a scale factor are one and the same problem.

Every number of a spec is divided by the unit of its dimension, made of one length and one time of
the spec's own. The quotients are rounded to ``MANTISSA_BITS``, which removes the rounding errors of
the division, so that similar cams give the same spec to the last bit and every search takes the
same path. Masses keep their unit: with a load, the unit of time is the root of the unit of length,
so that forces and weights keep theirs.

This is the one place where physical and nondimensional specs are converted (table in ``units``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from math import sqrt
from types import MappingProxyType
from typing import Any, Self, get_args

from pydantic import BaseModel

from synthesis.catalogue.fields import Range, ends
from synthesis.numerics.double_double import round_mantissa
from synthesis.spec.design_spec import DesignSpec
from synthesis.units import FIELD_SUFFIXES, MotionUnits, rad_per_s

DIMENSIONS: Mapping[str, tuple[int, int]] = MappingProxyType({
    **{f"mm{per_time}": (1, -order) for order, per_time in enumerate(FIELD_SUFFIXES)},
    **{f"deg{per_time}": (0, -order) for order, per_time in enumerate(FIELD_SUFFIXES)},
    "rpm": (0, -1), "hz": (0, -1),
    "kg": (0, 0), "kg_per_m3": (-3, 0),
    "n": (1, -2), "n_per_mm": (0, -2), "n_s_per_m": (0, -1), "mpa": (-1, -2),
    "kg_m2": (2, 0), "n_m": (2, -2), "n_m_per_rad": (2, -2), "n_m_s_per_rad": (2, -1),
})  # fmt: skip
"""Exponents of length and of time, by the unit at the end of a field's name."""

DIMENSIONLESS = (0, 0)  # exponents of length and time
MANTISSA_BITS = 36  # of 53, 1e-11 relative: rounding errors of a spec's numbers are 1e-4 of that
Change = Callable[[str, float], float]


@lru_cache(maxsize=1024)
def unit_of(name: str) -> str:
    """The longest unit in ``DIMENSIONS`` that a field's name ends with; "" if there is none."""
    return max((unit for unit in DIMENSIONS if name.endswith(f"_{unit}")), key=len, default="")


@dataclass(frozen=True)
class ReferenceUnits:
    """Units of length [mm] and of time [s] in which a spec is expressed."""

    length: float
    time: float

    @classmethod
    def of(cls, spec: DesignSpec) -> ReferenceUnits:
        """The longest travel of a segment, and the time in which the cam turns by 1 rad."""
        free = spec.free_parameters
        program, follower = free.substitute([parameter.high for parameter in free.parameters])
        units = MotionUnits(follower.travel, rad_per_s(spec.speed_rpm))
        length = max(high - low for low, high in (segment.span(units) for segment in program))
        time = 1.0 / rad_per_s(spec.speed_rpm) if spec.load is None else sqrt(length)
        return cls(length, time)

    def of_field(self, name: str) -> float:
        """The reference unit of a field, in the unit that its name ends with; 1 without one."""
        length, time = DIMENSIONS.get(unit_of(name), DIMENSIONLESS)
        return float(self.length**length * self.time**time)


@dataclass(frozen=True, eq=False)
class NondimensionalSpec:
    """A physical spec, and the same spec in its reference units, which is what is solved."""

    physical: DesignSpec
    scaled: DesignSpec
    units: ReferenceUnits

    @classmethod
    def of(cls, physical: DesignSpec) -> Self:
        """Divide every number of a spec by its reference unit."""
        units = ReferenceUnits.of(physical)
        # The rule from shaft to hub is one of millimetres.
        told = physical.model_copy(update={"hub_diameter_mm": physical.hub})

        def divide(name: str, value: float) -> float:
            return float(round_mantissa(value / units.of_field(name), MANTISSA_BITS))

        return cls(physical, _map_numbers(_with_unit_fields(told), "", divide), units)

    def with_scaled(self, scaled: DesignSpec) -> NondimensionalSpec:
        """The same with another nondimensional spec; unchanged fields keep their bits."""
        return NondimensionalSpec(self.to_physical(scaled), scaled, self.units)

    def to_physical(self, scaled: DesignSpec) -> DesignSpec:
        """A nondimensional spec in physical units; unchanged fields are those of ``physical``."""
        if scaled is self.scaled:
            return self.physical
        same = scaled.program == self.scaled.program
        physical = self.physical if same else _with_unit_fields(self.physical)
        result = self._merge("", scaled, self.scaled, physical)
        assert isinstance(result, DesignSpec)
        return result

    def size_to_physical(self, scaled: tuple[float, ...]) -> tuple[float, ...]:
        """Size variables [mm] from nondimensional ones."""
        return tuple(value * self.units.length for value in scaled)

    def _merge(self, name: str, new: Any, old: Any, physical: Any) -> Any:
        """``physical``, with what differs between ``old`` and ``new`` converted from ``new``."""
        if new == old:
            return physical
        if isinstance(new, BaseModel) and type(new) is type(old):
            update = {
                field: self._merge(_unit_field(field, name), value, was, getattr(physical, field))
                for field in type(new).model_fields
                for value, was in [(getattr(new, field), getattr(old, field))]
                if value != was
            }
            return physical.model_copy(update=update)
        if isinstance(new, list) and len(new) == len(old):
            return [self._merge(name, *each) for each in zip(new, old, physical, strict=True)]
        result = _map_numbers(new, name, lambda field, value: value * self.units.of_field(field))
        if isinstance(result, float) and isinstance(physical, Range):
            # a number chosen within a range: rounding must not put it outside
            low, high = ends(physical)
            return min(max(result, low), high)
        return result


def _with_unit_fields(spec: DesignSpec) -> DesignSpec:
    """The same spec with every number in a field whose name ends with its unit."""
    program = [segment.with_unit_fields() for segment in spec.program]
    changed = any(new is not old for new, old in zip(program, spec.program, strict=True))
    return spec.model_copy(update={"program": program}) if changed else spec


def _unit_field(field: str, name: str) -> str:
    """The field whose name has the unit: ``min`` and ``max`` of a range inherit the range's."""
    return field if unit_of(field) else name


def _map_numbers(value: Any, name: str, change: Change) -> Any:
    """A body with ``change`` applied to every number that has a unit; else the same object."""
    if isinstance(value, float):
        return change(name, value)
    if isinstance(value, (list, tuple)):
        result = type(value)([_map_numbers(one, name, change) for one in value])
        return (
            result if any(new is not old for new, old in zip(result, value, strict=True)) else value
        )
    if not isinstance(value, BaseModel):
        return value
    update, known = {}, value.__dict__
    for field, unit_field in _dimensional_fields(type(value), name):
        old = known[field]
        new = _map_numbers(old, unit_field, change) if old else old  # 0 and None have no unit
        if new is not old:
            update[field] = new
    return value.model_copy(update=update) if update else value


@cache
def _dimensional_fields(model: type[BaseModel], name: str) -> tuple[tuple[str, str], ...]:
    """Fields of a model that may hold numbers with a unit, each with the field naming the unit."""
    result = (
        (field, _unit_field(field, name), i.annotation) for field, i in model.model_fields.items()
    )
    return tuple(
        (field, unit_field)
        for field, unit_field, annotation in result
        if DIMENSIONS.get(unit_of(unit_field), DIMENSIONLESS) != DIMENSIONLESS
        or any(_dimensional_fields(part, unit_field) for part in _models_in(annotation))
    )


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """The models that a field of this type may hold."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models_in(part)
