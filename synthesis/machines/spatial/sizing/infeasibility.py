"""Why no spatial cam fits: the least change of each single number of the spec that would do.

Each number alone is relaxed as in ``pipeline.relaxable``, the spec is sized anew, and the value
that suffices is found by bisection. There is no deletion filter as in ``pipeline.conflict``: its
trials leave numbers out, and without its limit on the pressure angle a spec has no smallest cam.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from synthesis.design.design import Conflict, Relaxation
from synthesis.machines.spatial.machine import LARGEST, ROLLER_RADIUS
from synthesis.machines.spatial.sizing.size_cam import Sizes, SizingResult, size_cam
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics import clock
from synthesis.optimise.parameters.table_smoothing import Tables
from synthesis.pipeline.boundary import LATE
from synthesis.pipeline.oracle import ALONE
from synthesis.pipeline.relaxable import Relaxable, relaxed

DIAGNOSIS_S = 6.0  # s: time for all of it
COARSE_TOLERANCE = 1e-2  # relative: of cams that only show that there is one
FARTHEST = 1e4  # a number is relaxed to so many times its value at most
FIRST_STEP = 0.02  # relative: of a value, tripled until a cam is found
ACCURACY = 1e-3  # relative: of the value needed
WIDEST_DEG = 89.0  # largest pressure angle that is tried
FOUND = "a cam was found with this value; that it is the least is not proven"


def diagnose(spec: SpatialCamSpec, tables: Tables, result: SizingResult, stop: float) -> Conflict:
    """Which numbers of the spec are in the way, and what each alone would have to be.

    ``stop`` is the ``clock.now()`` after which nothing more is tried.
    """
    until = min(stop, clock.now() + DIAGNOSIS_S)
    coarse = spec.model_copy(update={"tolerance": max(spec.tolerance, COARSE_TOLERANCE)})

    def sizes_with(number: Relaxable, value: float) -> Sizes | None:
        # Where walls failed, sizing must include them; otherwise laws and size alone decide.
        existence_only = not result.walls_failed
        changed = relaxed(coarse, number, value)
        return size_cam(changed, tables, until, existence_only=existence_only).sizes

    minimised = spec.machine.size_field
    tried = [(str(number), _relax(number, far, sizes_with, minimised, until))
             for number, far in _numbers(spec)]  # fmt: skip
    binding = [name for name, each in tried if each.needed is not None]
    known = "proven" if result.proven else "that there is none is not proven"
    return Conflict(
        limits=binding or [name for name, _ in tried],
        relaxations=[each for _, each in tried],
        evidence=f"{result.why}; {known}"
        + ("; changing any one of those named would do" if binding else ""),
        proven=result.proven,
    )


def _numbers(spec: SpatialCamSpec) -> Iterator[tuple[Relaxable, float]]:
    """The numbers that may be in the way, the minimised dimension first, and how far to relax."""
    ranges, minimised = spec.machine.ranges(), spec.machine.size_field
    for field in sorted(ranges, key=lambda name: name != minimised):
        # Cams may be too large and rollers too thick; the other end of a range is in no way.
        low, high = ranges[field]
        end, far, sense, tail = (
            (low, low / FARTHEST, "≥", "/min")
            if field == ROLLER_RADIUS
            else (high, min(high * FARTHEST, LARGEST), "≤", "/max")
        )
        if low == high:
            sense, tail = "=", ""
        if 0.0 < end < LARGEST:
            name = field.removesuffix("_mm").replace("_", " ")
            yield Relaxable(name, (f"machine/{field}{tail}",), (end,), "mm", sense), far
    for position, limit in enumerate(spec.limits):
        name, bound = limit.kind.replace("_", " "), limit.bound
        unit = limit.field.partition("_")[2].replace("_per_", "/")
        unit = unit.replace("s2", "s²").replace("s3", "s³")
        sense, far = ("≤", bound * FARTHEST) if limit.upper else ("≥", bound / FARTHEST)
        if limit.upper and unit == "deg":
            far = WIDEST_DEG
        yield Relaxable(name, (f"limits/{position}/{limit.field}",), (bound,), unit, sense), far


def _relax(
    number: Relaxable,
    far: float,
    sizes_with: Callable[[Relaxable, float], Sizes | None],
    minimised: str,
    until: float,
) -> Relaxation:
    """What one number alone would have to be, at most ``far``, as far as time allows.

    ``sizes_with`` gives dimensions of a cam with a number at a value, or None.
    """
    (path,), (value,) = number.paths, number.requested

    def relaxation(needed: float | None, note: str) -> Relaxation:
        return Relaxation(
            limit=number.limit, field=path, unit=number.unit, requested=value, needed=needed,
            note=note,
        )  # fmt: skip

    if clock.now() >= until:
        return relaxation(None, LATE)
    widest = sizes_with(number, far)
    if widest is None:
        return relaxation(None, ALONE)
    # The minimised dimension is its own answer.
    if path.startswith(f"machine/{minimised}"):
        return relaxation(widest[minimised] * (1.0 + ACCURACY), FOUND)
    # Any other: changes that grow threefold until one is enough, then bisection.
    bad, good, step = value, far, FIRST_STEP
    while clock.now() < until and abs(good - bad) > ACCURACY * abs(good):
        at = value * (1.0 + step) if far > value else value / (1.0 + step)
        if good != far or (at - far) * (value - far) <= 0.0:
            at = 0.5 * (bad + good)
        if sizes_with(number, at) is None:
            bad, step = at, 3.0 * step
        else:
            good = at
    return relaxation(good, FOUND)
