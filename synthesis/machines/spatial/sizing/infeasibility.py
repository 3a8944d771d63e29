"""Why no spatial cam fits: the least change of each single number of the spec that would do.

The planar engine (``optimise.infeasibility``) relaxes limits inside one elastic program. That is
not possible here, as walls, ribs and rollers are decided by sampling outside of the convex program:
each number is relaxed by itself, and the spec is sized anew with bisection on its value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import isfinite
from typing import Any

from synthesis.catalogue.ranges import Range, ends
from synthesis.design.design import Conflict, Relaxation
from synthesis.machines.spatial.machine import ROLLER_RADIUS
from synthesis.machines.spatial.sizing.size_cam import SizingResult, size_cam
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics import clock
from synthesis.optimise.parameters.table_smoothing import Tables

DIAGNOSIS_S = 6.0  # s: time for all of it
COARSE_TOLERANCE = 1e-2  # relative: of cams that only show that there is one
FARTHEST = 1e4  # a number is relaxed to so many times its value at most
FIRST_STEP = 0.02  # relative: of a value, tripled until a cam is found
ACCURACY = 1e-3  # relative: of the value needed
WIDEST_DEG = 89.0  # largest pressure angle that is tried
FOUND = "a cam was found with this value; that it is the least is not proven"
ALONE = "relaxing this alone was not seen to help"
LATE = "the time budget ended before this was known"


@dataclass(frozen=True)
class _Relaxable:
    """One number of the spec that may be in the way.

    Attributes:
        field: its path in the spec. name, text, unit: for people. value: as given.
        upper: whether a larger value is easier.
        place: position among the limits, or the machine's field.
    """

    field: str
    name: str
    text: str
    unit: str
    value: float
    upper: bool
    place: int | str


def diagnose(spec: SpatialCamSpec, tables: Tables, result: SizingResult, stop: float) -> Conflict:
    """Which numbers of the spec are in the way, and what each alone would have to be.

    Args:
        spec, tables: the question. result: what sizing came to.
        stop: ``clock.now()`` after which nothing more is tried.
    """
    until = min(stop, clock.now() + DIAGNOSIS_S)
    numbers = [*_dimensions(spec), *_limits(spec)]
    # Where walls failed, sizing must include them; otherwise existence of laws and size decides.
    existence_only = not result.walls_failed
    relaxations = [
        _relax(spec, tables, number, until, existence_only=existence_only) for number in numbers
    ]
    binding = [
        number.text
        for number, each in zip(numbers, relaxations, strict=True)
        if each.needed is not None
    ]
    known = "proven" if result.proven else "that there is none is not proven"
    return Conflict(
        limits=binding or [number.text for number in numbers],
        relaxations=relaxations,
        evidence=f"{result.why}; {known}"
        + ("; changing any one of those named would do" if binding else ""),
    )


def _dimensions(spec: SpatialCamSpec) -> Iterator[_Relaxable]:
    """Ends of the machine's dimensions, that of the minimised one first."""
    sizes = spec.machine.sizes()
    for name in sorted(sizes, key=lambda name: name != spec.machine.size_field):
        low, high = ends(sizes[name])
        upper = name != ROLLER_RADIUS
        end = high if upper else low
        if not isfinite(end) or end <= 0.0:
            continue
        tail = "" if low == high else "/max" if upper else "/min"
        sign = "=" if low == high else "≤" if upper else "≥"
        title = name.removesuffix("_mm")
        text = f"{title.replace('_', ' ')} {sign} {end:.6g} mm"
        yield _Relaxable(f"machine/{name}{tail}", title, text, "mm", end, upper, name)


def _limits(spec: SpatialCamSpec) -> Iterator[_Relaxable]:
    """Bounds of the limits."""
    for position, limit in enumerate(spec.limits):
        unit = limit.field.partition("_")[2].replace("_per_", "/").replace("s2", "s²")
        unit = unit.replace("s3", "s³")
        sign = "≤" if limit.upper else "≥"
        text = f"{limit.kind.replace('_', ' ')} {sign} {limit.bound:.6g} {unit}"
        field = f"limits/{position}/{limit.field}"
        yield _Relaxable(field, limit.kind, text, unit, limit.bound, limit.upper, position)


def _with_value(spec: SpatialCamSpec, number: _Relaxable, value: float) -> SpatialCamSpec:
    """The spec with another value of the number, not validated again."""
    tolerance = max(spec.tolerance, COARSE_TOLERANCE)
    if isinstance(number.place, int):
        limits = list(spec.limits)
        limit = limits[number.place]
        limits[number.place] = limit.model_copy(update={limit.field: value})
        return spec.model_copy(update={"limits": limits, "tolerance": tolerance})
    low, high = ends(spec.machine.sizes()[number.place])
    wider: Any = Range(
        min=(low if number.upper else value) if isfinite(low) else None,
        max=(value if number.upper else high) if isfinite(high) else None,
    )
    machine = spec.machine.model_copy(update={number.place: wider})
    return spec.model_copy(update={"machine": machine, "tolerance": tolerance})


def _relax(
    spec: SpatialCamSpec, tables: Tables, number: _Relaxable, until: float, *, existence_only: bool
) -> Relaxation:
    """What one number alone would have to be."""

    def relaxation(needed: float | None, note: str) -> Relaxation:
        return Relaxation(limit=number.name, field=number.field, unit=number.unit,
                          requested=number.value, needed=needed, note=note)  # fmt: skip

    def sized_with(value: float) -> SizingResult:
        changed = _with_value(spec, number, value)
        return size_cam(changed, tables, until, existence_only=existence_only)

    far = number.value * FARTHEST if number.upper else number.value / FARTHEST
    if number.unit == "deg" and number.upper:
        far = WIDEST_DEG
    if clock.now() >= until:
        return relaxation(None, LATE)
    widest = sized_with(far)
    if widest.sizes is None:
        return relaxation(None, ALONE)
    # The minimised dimension is its own answer; any other number is found by bisection.
    if number.place == spec.machine.size_field:
        return relaxation(widest.sizes[number.place] * (1.0 + ACCURACY), FOUND)
    needed = _least_change(
        lambda value: sized_with(value).sizes is not None, number.value, far, until
    )
    return relaxation(needed, FOUND)


def _least_change(fits: Callable[[float], bool], value: float, far: float, until: float) -> float:
    """The feasible value nearest to a given one as far as time allows; ``far`` is feasible."""
    bad, good, step = value, far, FIRST_STEP
    while clock.now() < until:
        at = value * (1.0 + step) if far > value else value / (1.0 + step)
        if (at - far) * (value - far) <= 0.0:
            break
        if fits(at):
            good = at
            break
        bad, step = at, 3.0 * step
    while clock.now() < until and abs(good - bad) > ACCURACY * abs(good):
        middle = 0.5 * (bad + good)
        if fits(middle):
            good = middle
        else:
            bad = middle
    return good
