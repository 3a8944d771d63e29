"""A finished shaper as the answer tells it: measured, with every wish checked."""

from __future__ import annotations

import math
from collections.abc import Sequence

from synthesis.design import Conflict, engine_version, question_id
from synthesis.linkages.shaper import course
from synthesis.linkages.shaper import found as wire
from synthesis.linkages.shaper.drive import Drive
from synthesis.linkages.shaper.mechanism import Shaper
from synthesis.linkages.shaper.spec import LENGTHS, ShaperSpec
from synthesis.ranges import ends
from synthesis.units import DEGREE, FULL_TURN

KIND = "six-bar shaper"
EXACT = 1e-9  # of a wish: what rounding may leave
ROUND = 1e-12  # rad


def told(spec: ShaperSpec, lengths: dict[str, float]) -> wire.SixBarShaper:
    """Everything that is known of a shaper with these lengths.

    Raises:
        InputError: it cannot turn all the way round.
    """
    shaper, drive = spec.shaper(lengths), spec.drive
    course.assembled(shaper)
    centres = course.dead_centres(shaper, drive)
    first, last = course.coupler_range(shaper)
    strokes = _strokes(centres, drive)
    stroke = max(c.ram for c in centres) - min(c.ram for c in centres)
    transmission = 90.0 - max(abs(first), abs(last)) / DEGREE
    values = {
        "stroke_mm": (stroke, "mm"),
        "quick_return_ratio": (strokes.ratio, ""),
        "least_transmission_angle_deg": (transmission, "deg"),
    }
    asked = (_limit(spec, name, *value) for name, value in values.items())
    limits = [limit for limit in asked if limit is not None]
    upright = 0.5 * math.pi
    rocks = None if shaper.whirls else _interval(upright - shaper.swing, upright + shaper.swing)
    return wire.SixBarShaper(
        id=question_id(spec, KIND),
        name=spec.name,
        engine_version=engine_version(),
        status="feasible" if all(limit.holds for limit in limits) else "infeasible",
        spec=spec,
        dimensions={name: lengths[name] for name in LENGTHS},
        guide="turns" if rocks is None else "rocks",
        guide_angle=rocks,
        coupler_angle=_interval(first, last),
        stroke_mm=stroke,
        quick_return=strokes,
        dead_centres=[_centre(one, drive) for one in centres],
        least_transmission_angle_deg=transmission,
        extremes=_extremes(shaper, drive),
        limits=limits,
        certificate=None,
        conflict=None,
    )  # fmt: skip


def nothing_fits(spec: ShaperSpec, conflict: Conflict) -> wire.SixBarShaper:
    """The answer where no lengths keep the wishes."""
    return wire.SixBarShaper(
        id=question_id(spec, KIND), name=spec.name, engine_version=engine_version(),
        status="infeasible", spec=spec, dimensions={}, guide=None, guide_angle=None,
        coupler_angle=None, stroke_mm=None, quick_return=None, dead_centres=[],
        least_transmission_angle_deg=None, extremes=[], limits=[], certificate=None,
        conflict=conflict,
    )  # fmt: skip


def _limit(spec: ShaperSpec, name: str, value: float, unit: str) -> wire.ShaperLimit | None:
    asked = getattr(spec, name)
    if asked is None:
        return None
    low, high = (asked, math.inf) if name.startswith("least") else ends(asked)
    margin = min(value - low, high - value)
    return wire.ShaperLimit(
        limit=name, value=value, unit=unit, lower=low, upper=None if math.isinf(high) else high,
        margin=margin, holds=margin >= -EXACT * abs(value),
    )  # fmt: skip


def _strokes(centres: Sequence[course.DeadCentre], drive: Drive) -> wire.QuickReturn:
    """The way from one outermost position to the other, and the way back."""
    left, right = (pick(centres, key=lambda c: c.ram) for pick in (min, max))
    rightwards = (right.turned - left.turned) % FULL_TURN
    slow = max(rightwards, FULL_TURN - rightwards)
    ratio = slow / (FULL_TURN - slow)
    return wire.QuickReturn(
        ratio=ratio,
        time_ratio=None if drive.acceleration else ratio,
        slow_deg=slow / DEGREE,
        quick_deg=(FULL_TURN - slow) / DEGREE,
        slow_towards="right" if rightwards >= math.pi - ROUND else "left",
    )


def _interval(low: float, high: float) -> wire.AngleInterval:
    return wire.AngleInterval(min_deg=low / DEGREE, max_deg=high / DEGREE)


def _centre(one: course.DeadCentre, drive: Drive) -> wire.RamDeadCentre:
    return wire.RamDeadCentre.model_validate(
        {
            "crank_deg": (one.phi / DEGREE) % 360.0,
            "turned_deg": one.turned / DEGREE,
            "time_s": float(drive.time(one.turned)),
            "ram_mm": one.ram,
            "cause": one.cause,
        }
    )


def _extremes(shaper: Shaper, drive: Drive) -> list[wire.ShaperExtremes]:
    found = course.extremes(shaper, drive, course.QUANTITIES)
    return [
        wire.ShaperExtremes(
            quantity=quantity.name,
            unit=quantity.unit,
            largest=_peak(largest, drive),
            smallest=_peak(smallest, drive),
        )
        for quantity, (largest, smallest) in zip(course.QUANTITIES, found, strict=True)
    ]


def _peak(peak: course.Peak, drive: Drive) -> wire.ShaperPeak:
    return wire.ShaperPeak(
        value=peak.value,
        crank_deg=(drive.phi(peak.turned) / DEGREE) % 360.0,
        turned_deg=peak.turned / DEGREE,
        width=peak.width,
    )
