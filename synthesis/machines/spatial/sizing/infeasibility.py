"""Why no spatial cam fits: the least change of each single number of the spec that would do.

Each number is relaxed by itself, and the spec is sized anew with bisection on its value, as
``pipeline.conflict`` does for planar cams.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import isfinite
from typing import Any

from synthesis.catalogue.fields import Range, ends
from synthesis.design.design import Conflict, Relaxation
from synthesis.machines.spatial.machine import ROLLER_RADIUS
from synthesis.machines.spatial.sizing.size_cam import Sizes, SizingResult, size_cam
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
        relaxation: what is reported of it. text: the bound, for people.
        upper: whether a larger value is easier.
        changed: the spec with another value, not validated again.
    """

    relaxation: Relaxation
    text: str
    upper: bool
    changed: Callable[[float], SpatialCamSpec]


def diagnose(spec: SpatialCamSpec, tables: Tables, result: SizingResult, stop: float) -> Conflict:
    """Which numbers of the spec are in the way, and what each alone would have to be.

    Args:
        spec, tables: the question. result: what sizing came to.
        stop: ``clock.now()`` after which nothing more is tried.
    """
    until = min(stop, clock.now() + DIAGNOSIS_S)
    # Cams that only show that there is one need no small gap.
    coarse = spec.model_copy(update={"tolerance": max(spec.tolerance, COARSE_TOLERANCE)})
    minimised = spec.machine.size_field
    names = sorted(spec.machine.sizes(), key=lambda name: name != minimised)
    numbers = [number for name in names for number in _dimension(coarse, name)]
    numbers += [_limit(coarse, position) for position in range(len(spec.limits))]

    def sized(changed: SpatialCamSpec) -> Sizes | None:
        # Where walls failed, sizing must include them; otherwise laws and size alone decide.
        existence_only = not result.walls_failed
        return size_cam(changed, tables, until, existence_only=existence_only).sizes

    relaxations = [_relax(number, sized, minimised, until) for number in numbers]
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


def _dimension(spec: SpatialCamSpec, name: str) -> Iterator[_Relaxable]:
    """The end of a dimension's range that may be in the way, if it has that end."""
    low, high = ends(spec.machine.sizes()[name])
    upper = name != ROLLER_RADIUS
    end = high if upper else low
    if not isfinite(end) or end <= 0.0:
        return

    def changed(value: float) -> SpatialCamSpec:
        least, most = (low, value) if upper else (value, high)
        wider: Any = Range(
            min=least if isfinite(low) else None, max=most if isfinite(high) else None
        )
        return spec.model_copy(update={"machine": spec.machine.model_copy(update={name: wider})})

    tail, sign = ("", "=") if low == high else ("/max", "≤") if upper else ("/min", "≥")
    title = name.removesuffix("_mm")
    text = f"{title.replace('_', ' ')} {sign} {end:.6g} mm"
    yield _Relaxable(_request(title, f"machine/{name}{tail}", "mm", end), text, upper, changed)


def _limit(spec: SpatialCamSpec, position: int) -> _Relaxable:
    """The bound of a limit."""
    limit = spec.limits[position]

    def changed(value: float) -> SpatialCamSpec:
        limits = list(spec.limits)
        limits[position] = limit.model_copy(update={limit.field: value})
        return spec.model_copy(update={"limits": limits})

    unit = limit.field.partition("_")[2].replace("_per_", "/")
    unit = unit.replace("s2", "s²").replace("s3", "s³")
    sign = "≤" if limit.upper else "≥"
    text = f"{limit.kind.replace('_', ' ')} {sign} {limit.bound:.6g} {unit}"
    field = f"limits/{position}/{limit.field}"
    return _Relaxable(_request(limit.kind, field, unit, limit.bound), text, limit.upper, changed)


def _request(name: str, field: str, unit: str, value: float) -> Relaxation:
    return Relaxation(limit=name, field=field, unit=unit, requested=value, needed=None, note=ALONE)


def _relax(
    number: _Relaxable,
    sized: Callable[[SpatialCamSpec], Sizes | None],
    minimised: str,
    until: float,
) -> Relaxation:
    """What one number alone would have to be, as far as time allows.

    Args:
        sized: dimensions of a cam, or None. minimised: field of the dimension that is minimised.
    """
    request = number.relaxation
    value = request.requested
    far = value * FARTHEST if number.upper else value / FARTHEST
    if request.unit == "deg" and number.upper:
        far = WIDEST_DEG
    if clock.now() >= until:
        return request.model_copy(update={"note": LATE})
    widest = sized(number.changed(far))
    if widest is None:
        return request
    # The minimised dimension is its own answer.
    if request.field.startswith(f"machine/{minimised}"):
        needed = {"needed": widest[minimised] * (1.0 + ACCURACY), "note": FOUND}
        return request.model_copy(update=needed)
    # Any other number: larger and larger changes until one is enough, then bisection.
    bad, good, step = value, far, FIRST_STEP
    while clock.now() < until:
        at = value * (1.0 + step) if far > value else value / (1.0 + step)
        if (at - far) * (value - far) <= 0.0:
            break
        if sized(number.changed(at)) is not None:
            good = at
            break
        bad, step = at, 3.0 * step
    while clock.now() < until and abs(good - bad) > ACCURACY * abs(good):
        middle = 0.5 * (bad + good)
        if sized(number.changed(middle)) is not None:
            good = middle
        else:
            bad = middle
    return request.model_copy(update={"needed": good, "note": FOUND})
