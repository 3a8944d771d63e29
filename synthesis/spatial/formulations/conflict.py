"""Why no spatial cam fits, and the least change of one number at a time that would do."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import isfinite
from typing import Any

from synthesis import clock
from synthesis.design import Conflict, Relaxation
from synthesis.formulations.free_numbers.tables import Tables
from synthesis.ranges import Range, ends
from synthesis.spatial.formulations.optimise import Sized, sized
from synthesis.spatial.spec import SpatialCamSpec

DIAGNOSIS_S = 6.0  # for all of it
ROUGH = 1e-2  # tolerance of cams that only show that there is one
FAR, FIRST = 1e4, 0.02  # a number is tried so many times as large at most; a first step, relative
ENOUGH = 1e-3  # relative: what is needed is known so well
WIDEST_DEG = 89.0
FOUND = "a cam was found with this value; that it is the least is not proven"
ALONE = "relaxing this alone was not seen to help"
LATE = "the time budget ended before this was known"


@dataclass(frozen=True)
class _Part:
    """One number of the spec that may be in the way.

    Attributes:
        field: where it stands. name, words, unit, asked: as told. upper: whether larger is easier.
        place: position among the limits, or the machine's field.
    """

    field: str
    name: str
    words: str
    unit: str
    asked: float
    upper: bool
    place: int | str


def diagnosed(spec: SpatialCamSpec, tables: Tables, found: Sized, stop: float) -> Conflict:
    """Why nothing fits: the numbers each of which alone is in the way.

    Args:
        spec, tables: the question. found: what came of it.
        stop: ``clock.now()`` after which nothing more is tried.
    """
    until = min(stop, clock.now() + DIAGNOSIS_S)
    parts = list(_parts(spec))
    relaxations = [
        _relaxation(spec, tables, part, until, quick=not found.cramped) for part in parts
    ]
    binding = [
        part.words for part, each in zip(parts, relaxations, strict=True) if each.needed is not None
    ]
    known = "proven" if found.proven else "that there is none is not proven"
    return Conflict(
        limits=binding or [part.words for part in parts],
        relaxations=relaxations,
        evidence=f"{found.why}; {known}"
        + ("; changing any one of those named would do" if binding else ""),
    )


def _parts(spec: SpatialCamSpec) -> Iterator[_Part]:
    yield from _dimensions(spec)
    for position, limit in enumerate(spec.limits):
        unit = limit.field.partition("_")[2].replace("_per_", "/").replace("s2", "s²")
        unit = unit.replace("s3", "s³")
        sign = "≤" if limit.upper else "≥"
        words = f"{limit.kind.replace('_', ' ')} {sign} {limit.bound:.6g} {unit}"
        field = f"limits/{position}/{limit.field}"
        yield _Part(field, limit.kind, words, unit, limit.bound, limit.upper, position)


def _dimensions(spec: SpatialCamSpec) -> Iterator[_Part]:
    """Ends of the machine's dimensions, that of the one sought first."""
    sizes = spec.machine.sizes()
    for name in sorted(sizes, key=lambda name: name != spec.machine.sought):
        low, high = ends(sizes[name])
        upper = name != spec.machine.roller_field
        end = high if upper else low
        if not isfinite(end) or end <= 0.0:
            continue
        tail = "" if low == high else "/max" if upper else "/min"
        sign = "=" if low == high else "≤" if upper else "≥"
        title = name.removesuffix("_mm")
        words = f"{title.replace('_', ' ')} {sign} {end:.6g} mm"
        yield _Part(f"machine/{name}{tail}", title, words, "mm", end, upper, name)


def _changed(spec: SpatialCamSpec, part: _Part, value: float) -> SpatialCamSpec:
    """The spec with another number, its rules not asked again."""
    rough = max(spec.tolerance, ROUGH)
    if isinstance(part.place, int):
        limits = list(spec.limits)
        limit = limits[part.place]
        limits[part.place] = limit.model_copy(update={limit.field: value})
        return spec.model_copy(update={"limits": limits, "tolerance": rough})
    low, high = ends(spec.machine.sizes()[part.place])
    wider: Any = Range(
        min=(low if part.upper else value) if isfinite(low) else None,
        max=(value if part.upper else high) if isfinite(high) else None,
    )
    machine = spec.machine.model_copy(update={part.place: wider})
    return spec.model_copy(update={"machine": machine, "tolerance": rough})


def _relaxation(
    spec: SpatialCamSpec, tables: Tables, part: _Part, until: float, *, quick: bool
) -> Relaxation:
    """What one number alone would have to be."""

    def told(needed: float | None, note: str) -> Relaxation:
        return Relaxation(limit=part.name, field=part.field, unit=part.unit, asked=part.asked,
                          needed=needed, note=note)  # fmt: skip

    def tried(value: float) -> Sized:
        return sized(_changed(spec, part, value), tables, until, quick=quick)

    def fits(value: float) -> bool:
        return tried(value).sizes is not None

    far = part.asked * FAR if part.upper else part.asked / FAR
    if part.unit == "deg" and part.upper:
        far = WIDEST_DEG
    if clock.now() >= until:
        return told(None, LATE)
    widest = tried(far)
    if widest.sizes is None:
        return told(None, ALONE)
    if part.place == spec.machine.sought:
        return told(widest.sizes[part.place] * (1.0 + ENOUGH), FOUND)
    return told(_nearest(fits, part.asked, far, until), FOUND)


def _nearest(fits: Callable[[float], bool], asked: float, far: float, until: float) -> float:
    """The value next to the one asked for that fits, as far as time allows; the far one does."""
    bad, good, step = asked, far, FIRST
    while clock.now() < until:
        at = asked * (1.0 + step) if far > asked else asked / (1.0 + step)
        if (at - far) * (asked - far) <= 0.0:
            break
        if fits(at):
            good = at
            break
        bad, step = at, 3.0 * step
    while clock.now() < until and abs(good - bad) > ENOUGH * abs(good):
        middle = 0.5 * (bad + good)
        if fits(middle):
            good = middle
        else:
            bad = middle
    return good
