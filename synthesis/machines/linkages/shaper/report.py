"""SixBarShaper: the response body, and how it is put together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from pydantic import Field

from synthesis.catalogue.fields import AnswerModel, doc
from synthesis.catalogue.ranges import ends
from synthesis.design.design import Conflict, Proof, Status
from synthesis.design.identity import engine_version, question_id
from synthesis.machines.linkages.shaper import turn_analysis
from synthesis.machines.linkages.shaper.drive import Drive
from synthesis.machines.linkages.shaper.mechanism import Shaper
from synthesis.machines.linkages.shaper.spec import LENGTHS, ShaperSpec
from synthesis.units import DEGREE, FULL_TURN


class RamDeadCentre(AnswerModel):
    """A dead centre: a position where the ram's velocity is zero, in closed form."""

    crank_deg: float = doc("Crank angle, from 0 to 360.")
    crank_travel_deg: float = doc(
        "The same, measured from the start of the turn in the crank's sense."
    )
    time_s: float = doc("Time from the start of the turn.")
    ram_mm: float = doc("Position of the ram's pin.")
    cause: Literal["guide_turns_back", "in_line"] = doc(
        "guide_turns_back: the crank is perpendicular to the guide; in_line: guide and coupler are "
        "in line."
    )


class QuickReturn(AnswerModel):
    """The two strokes between the outermost positions of the ram."""

    ratio: float = doc("Crank angle of the slow stroke over that of the quick one.")
    time_ratio: float | None = doc(
        "Time of the slow stroke over that of the quick one; null where the crank accelerates: the "
        "strokes then differ from turn to turn."
    )
    slow_deg: float = doc("Crank angle of the slow stroke.")
    quick_deg: float = doc("Crank angle of the quick stroke.")
    slow_towards: Literal["left", "right"] = doc("Direction of the ram during the slow stroke.")


class ShaperPeak(AnswerModel):
    """A largest or smallest value and where it is reached."""

    value: float = doc("The value, in the quantity's unit.")
    crank_deg: float = doc("Crank angle there, from 0 to 360.")
    crank_travel_deg: float = doc("The same, measured from the start of the turn.")
    width: float | None = doc(
        "Width of the proven enclosure of the value; null: near a singular position (coupler "
        "upright, or guide free to turn either way) nothing is proven, and the value is one that "
        "is reached."
    )


class ShaperExtremes(AnswerModel):
    """The extremes of one quantity over the turn."""

    quantity: str = doc("Its name.")
    unit: str = doc("Its unit.")
    largest: ShaperPeak = doc("Largest value.")
    smallest: ShaperPeak = doc("Smallest value.")


class AngleInterval(AnswerModel):
    """Range of an angle [deg]."""

    min_deg: float = doc("Smallest angle [deg].")
    max_deg: float = doc("Largest angle [deg].")


class ShaperLimit(AnswerModel):
    """A requirement of the spec and the value reached."""

    limit: str = doc("The field of the spec.")
    value: float = doc("The value, measured on the finished linkage.")
    unit: str = doc("Unit of value and bounds.")
    lower: float | None = doc("Least value required; null: none.")
    upper: float | None = doc("Largest value required; null: none.")
    margin: float = doc("Distance to the nearer bound, negative where it is violated.")
    holds: bool = doc("Whether it is kept, to within 1e-9 of the value.")


class SixBarShaper(AnswerModel):
    """A six-bar shaper: what it does over a turn."""

    id: str = doc("Hash of the spec and the engine's version.")
    name: str = doc("Name from the spec.")
    engine_version: str = doc("Version of Camwright that made it.")
    status: Status = doc(
        "optimal: every requirement is met and the gap is within the tolerance; feasible: every "
        "requirement is met; infeasible: see conflict, or limits where all lengths are given."
    )
    spec: ShaperSpec = doc("The request.")
    dimensions: dict[str, float] = doc("Every length [mm]; empty where nothing fits.")
    guide: Literal["rocks", "turns"] | None = doc(
        "rocks: the crank is shorter than the pivot distance; turns: it is longer, and the guide "
        "makes full turns."
    )
    guide_angle: AngleInterval | None = doc("Range of the guide's angle; null where it turns.")
    coupler_angle: AngleInterval | None = doc("Range of the coupler's angle to the ram's line.")
    stroke_mm: float | None = doc("Distance between the outermost positions of the ram.")
    quick_return: QuickReturn | None = doc("The two strokes.")
    dead_centres: list[RamDeadCentre] = doc(
        "Dead centres of the ram, in the order in which the crank passes them."
    )
    least_transmission_angle_deg: float | None = doc(
        "Least angle between the coupler and the perpendicular to the ram's line. At the crank's "
        "pin it is always 90°: the sliding block pushes at a right angle to the guide."
    )
    extremes: list[ShaperExtremes] = doc("Extremes of velocities and accelerations over the turn.")
    limits: list[ShaperLimit] = doc("The requirements, measured on the finished linkage.")
    certificate: Proof | None = doc("Value, bound and gap; null where all lengths are given.")
    conflict: Conflict | None = doc("Why nothing fits, and what would help.")
    links: dict[str, str] = Field({}, description="Links to it and its files.")


KIND = "six-bar shaper"
ROUNDING = 1e-9  # relative: by so much a requirement may be missed
HALF_TURN_ROUNDING = 1e-12  # rad: strokes this nearly equal go slowly to the right


def report_shaper(spec: ShaperSpec, lengths: dict[str, float]) -> SixBarShaper:
    """Analyse a shaper with these lengths [mm].

    Raises:
        InputError: it cannot make a full turn.
    """
    shaper, drive = spec.shaper(lengths), spec.drive
    turn_analysis.check_assembly(shaper)
    centres = turn_analysis.dead_centres(shaper, drive)
    first, last = turn_analysis.coupler_range(shaper)
    strokes = _strokes(centres, drive)
    stroke = max(c.ram for c in centres) - min(c.ram for c in centres)
    transmission = 90.0 - max(abs(first), abs(last)) / DEGREE
    values = {
        "stroke_mm": (stroke, "mm"),
        "quick_return_ratio": (strokes.ratio, ""),
        "least_transmission_angle_deg": (transmission, "deg"),
    }
    required = (_limit(spec, name, *value) for name, value in values.items())
    limits = [limit for limit in required if limit is not None]
    upright = 0.5 * math.pi
    rocks = (
        None if shaper.guide_rotates else _interval(upright - shaper.swing, upright + shaper.swing)
    )
    return SixBarShaper(
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


def report_infeasible(spec: ShaperSpec, conflict: Conflict) -> SixBarShaper:
    """The answer where no lengths meet the requirements."""
    return SixBarShaper(
        id=question_id(spec, KIND), name=spec.name, engine_version=engine_version(),
        status="infeasible", spec=spec, dimensions={}, guide=None, guide_angle=None,
        coupler_angle=None, stroke_mm=None, quick_return=None, dead_centres=[],
        least_transmission_angle_deg=None, extremes=[], limits=[], certificate=None,
        conflict=conflict,
    )  # fmt: skip


def _limit(spec: ShaperSpec, name: str, value: float, unit: str) -> ShaperLimit | None:
    required = getattr(spec, name)
    if required is None:
        return None
    low, high = (required, math.inf) if name.startswith("least") else ends(required)
    margin = min(value - low, high - value)
    return ShaperLimit(
        limit=name, value=value, unit=unit, lower=low, upper=None if math.isinf(high) else high,
        margin=margin, holds=margin >= -ROUNDING * abs(value),
    )  # fmt: skip


def _strokes(centres: Sequence[turn_analysis.DeadCentre], drive: Drive) -> QuickReturn:
    """The strokes from one outermost position of the ram to the other and back."""
    left, right = (pick(centres, key=lambda c: c.ram) for pick in (min, max))
    rightwards = (right.turned - left.turned) % FULL_TURN
    slow = max(rightwards, FULL_TURN - rightwards)
    ratio = slow / (FULL_TURN - slow)
    return QuickReturn(
        ratio=ratio,
        time_ratio=None if drive.acceleration else ratio,
        slow_deg=slow / DEGREE,
        quick_deg=(FULL_TURN - slow) / DEGREE,
        slow_towards="right" if rightwards >= math.pi - HALF_TURN_ROUNDING else "left",
    )


def _interval(low: float, high: float) -> AngleInterval:
    return AngleInterval(min_deg=low / DEGREE, max_deg=high / DEGREE)


def _centre(one: turn_analysis.DeadCentre, drive: Drive) -> RamDeadCentre:
    return RamDeadCentre.model_validate(
        {
            "crank_deg": (one.phi / DEGREE) % 360.0,
            "crank_travel_deg": one.turned / DEGREE,
            "time_s": float(drive.time(one.turned)),
            "ram_mm": one.ram,
            "cause": one.cause,
        }
    )


def _extremes(shaper: Shaper, drive: Drive) -> list[ShaperExtremes]:
    found = turn_analysis.extremes(shaper, drive, turn_analysis.QUANTITIES)
    return [
        ShaperExtremes(
            quantity=quantity.name,
            unit=quantity.unit,
            largest=_peak(largest, drive),
            smallest=_peak(smallest, drive),
        )
        for quantity, (largest, smallest) in zip(turn_analysis.QUANTITIES, found, strict=True)
    ]


def _peak(peak: turn_analysis.Peak, drive: Drive) -> ShaperPeak:
    return ShaperPeak(
        value=peak.value,
        crank_deg=(drive.phi(peak.turned) / DEGREE) % 360.0,
        crank_travel_deg=peak.turned / DEGREE,
        width=peak.width,
    )
