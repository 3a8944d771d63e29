"""Why no spatial cam fits, and the least change of one number at a time that would do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from typing import Any

from synthesis import clock
from synthesis.design import Conflict, Relaxation
from synthesis.formulations.tables import Tables
from synthesis.ranges import Range, ends
from synthesis.spatial.formulations.optimise import Sized, sized
from synthesis.spatial.spec import SpatialCamSpec

DIAGNOSIS_S = 6.0  # for all of it
ROUGH = 1e-2  # tolerance of cams that only show that there is one
FAR, HALVINGS = 1e4, 14  # a number is tried up to so many times as large; steps of the search
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
    relaxations = [_relaxation(spec, tables, part, until) for part in parts]
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
    for position, limit in enumerate(spec.limits):
        unit = limit.field.partition("_")[2].replace("_per_", "/").replace("s2", "s²")
        unit = unit.replace("s3", "s³")
        sign = "≤" if limit.upper else "≥"
        words = f"{limit.kind.replace('_', ' ')} {sign} {limit.bound:.6g} {unit}"
        field = f"limits/{position}/{limit.field}"
        yield _Part(field, limit.kind, words, unit, limit.bound, limit.upper, position)
    for name, given in spec.machine.sizes().items():
        low, high = ends(given)
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
    if isinstance(part.place, int):
        limits = list(spec.limits)
        limit = limits[part.place]
        limits[part.place] = limit.model_copy(update={limit.field: value})
        return spec.model_copy(update={"limits": limits})
    low, high = ends(spec.machine.sizes()[part.place])
    wider: Any = Range(
        min=(low if part.upper else value) if isfinite(low) else None,
        max=(value if part.upper else high) if isfinite(high) else None,
    )
    machine = spec.machine.model_copy(update={part.place: wider})
    return spec.model_copy(update={"machine": machine, "tolerance": max(spec.tolerance, ROUGH)})


def _relaxation(spec: SpatialCamSpec, tables: Tables, part: _Part, until: float) -> Relaxation:
    """What one number alone would have to be."""

    def told(needed: float | None, note: str) -> Relaxation:
        return Relaxation(limit=part.name, field=part.field, unit=part.unit, asked=part.asked,
                          needed=needed, note=note)  # fmt: skip

    def fits(value: float) -> bool:
        asked = _changed(spec, part, value).model_copy(update={"tolerance": ROUGH})
        return sized(asked, tables, until).sizes is not None

    far = part.asked * FAR if part.upper else part.asked / FAR
    if part.unit == "deg" and part.upper:
        far = WIDEST_DEG
    if clock.now() >= until:
        return told(None, LATE)
    if not fits(far):
        return told(None, ALONE)
    bad, good = part.asked, far
    for _ in range(HALVINGS):
        if clock.now() >= until or abs(good - bad) <= ENOUGH * abs(good):
            break
        # evenly in the logarithm while far apart, evenly at last
        middle = (bad * good) ** 0.5
        if fits(middle):
            good = middle
        else:
            bad = middle
    return told(good, FOUND)
