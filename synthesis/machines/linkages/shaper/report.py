"""SixBarShaper, the response body, and the analysis over one turn that fills it.

Dead centres follow in closed form, extremes of velocities and accelerations by enclosures.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from pydantic import Field

from synthesis.catalogue.fields import AnswerModel, doc, ends
from synthesis.design.design import Conflict, Proof, Status
from synthesis.design.identity import engine_version, question_id
from synthesis.errors import InputError
from synthesis.machines.linkages.shaper.mechanism import SIGN, Drive, Motion, Shaper, Value
from synthesis.machines.linkages.shaper.spec import LENGTHS, ShaperSpec
from synthesis.numerics.enclosure import Extremum, ExtremumQuery, enclose
from synthesis.numerics.piecewise import Array
from synthesis.numerics.taylor import Taylor
from synthesis.units import DEGREE, FULL_TURN

Cause = Literal["guide_turns_back", "in_line"]
KIND: Final = "six-bar shaper"
BOXES: Final = 64  # crank-angle intervals of the first level of an enclosure
RELATIVE: Final = 1e-10  # width of an enclosure that is good enough
SAME: Final = 1e-9  # rad: nearer dead centres are one
SHORTEST: Final = 1e-6  # of the longest length: shorter ones drown in rounding
CHANGE_POINT: Final = 1e-9  # of the pivot distance: a crank this near to it has a change point
ROUNDING: Final = 1e-9  # relative: by so much a requirement may be missed
HALF_TURN_ROUNDING: Final = 1e-10  # deg: strokes this nearly equal go slowly to the right


class RamDeadCentre(AnswerModel):
    """A dead centre: a position where the ram's velocity is zero, in closed form."""

    crank_deg: float = doc("Crank angle, from 0 to 360.")
    crank_travel_deg: float = doc(
        "The same, measured from the start of the turn in the crank's sense."
    )
    time_s: float = doc("Time from the start of the turn.")
    ram_mm: float = doc("Position of the ram's pin.")
    cause: Cause = doc(
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
        "requirement is met; infeasible: proven, see conflict, or limits where all lengths are "
        "given; unsolved: no lengths were found."
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


@dataclass(frozen=True)
class Quantity:
    """A quantity with extremes over the turn."""

    name: str  # on the wire
    unit: str
    of: Callable[[Motion, Drive, Value], Value]  # from motion, drive and travel, in mm or radians

    @property
    def per_unit(self) -> float:
        """Core units in one of the wire's."""
        return DEGREE if self.unit.startswith("deg") else 1.0


QUANTITIES: Final = (
    Quantity("ram_velocity", "mm/s", lambda m, d, t: d.first(m.ram[1], t)),
    Quantity("ram_acceleration", "mm/s²", lambda m, d, t: d.second(m.ram[1], m.ram[2], t)),
    Quantity("guide_velocity", "deg/s", lambda m, d, t: d.first(m.guide_turn[0], t)),
    Quantity("guide_acceleration", "deg/s²", lambda m, d, t: d.second(*m.guide_turn, t)),
    Quantity("coupler_velocity", "deg/s", lambda m, d, t: d.first(m.coupler_turn[0], t)),
    Quantity("coupler_acceleration", "deg/s²", lambda m, d, t: d.second(*m.coupler_turn, t)),
    Quantity("sliding_velocity", "mm/s", lambda m, d, t: d.first(m.slide[1], t)),
    Quantity("sliding_acceleration", "mm/s²", lambda m, d, t: d.second(m.slide[1], m.slide[2], t)),
)


def analyse_shaper(spec: ShaperSpec, lengths: dict[str, float]) -> SixBarShaper:
    """Analyse a shaper with these lengths [mm].

    Raises:
        InputError: it cannot make a full turn.
    """
    shaper, drive = spec.shaper(lengths), spec.drive
    check_assembly(shaper)
    centres = dead_centres(shaper, drive)
    left, right = (pick(centres, key=lambda c: c.ram_mm) for pick in (min, max))
    stroke = right.ram_mm - left.ram_mm
    # The strokes between the outermost positions: the slow one takes at least half a turn.
    rightwards = (right.crank_travel_deg - left.crank_travel_deg) % 360.0
    slow = max(rightwards, 360.0 - rightwards)
    ratio = slow / (360.0 - slow)
    # The coupler's angle is monotone in sin ψ: its extremes are where that is extreme.
    sines = [shaper.coupler_sine(sine) for sine in shaper.guide_sine_range()]
    coupler = _interval(math.asin(min(sines)), math.asin(max(sines)))
    transmission = 90.0 - max(abs(coupler.min_deg), abs(coupler.max_deg))
    values = (
        ("stroke_mm", stroke, "mm"),
        ("quick_return_ratio", ratio, ""),
        ("least_transmission_angle_deg", transmission, "deg"),
    )
    limits = [_limit(spec, *each) for each in values if getattr(spec, each[0]) is not None]
    guide = None
    if not shaper.guide_rotates:
        guide = _interval(0.5 * math.pi - shaper.swing, 0.5 * math.pi + shaper.swing)
    return SixBarShaper(
        id=question_id(spec, KIND),
        name=spec.name,
        engine_version=engine_version(),
        status="feasible" if all(limit.holds for limit in limits) else "infeasible",
        spec=spec,
        dimensions={name: lengths[name] for name in LENGTHS},
        guide="turns" if shaper.guide_rotates else "rocks",
        guide_angle=guide,
        coupler_angle=coupler,
        stroke_mm=stroke,
        quick_return=QuickReturn(
            ratio=ratio,
            time_ratio=None if drive.acceleration else ratio,
            slow_deg=slow,
            quick_deg=360.0 - slow,
            slow_towards="right" if rightwards >= 180.0 - HALF_TURN_ROUNDING else "left",
        ),
        dead_centres=centres,
        least_transmission_angle_deg=transmission,
        extremes=extremes(shaper, drive),
        limits=limits,
        certificate=None,
        conflict=None,
    )


def report_infeasible(spec: ShaperSpec, conflict: Conflict) -> SixBarShaper:
    """The answer where no lengths meet the requirements."""
    status: Status = "infeasible" if conflict.proven else "unsolved"
    return SixBarShaper(
        id=question_id(spec, KIND), name=spec.name, engine_version=engine_version(),
        status=status, spec=spec, dimensions={}, guide=None, guide_angle=None,
        coupler_angle=None, stroke_mm=None, quick_return=None, dead_centres=[],
        least_transmission_angle_deg=None, extremes=[], limits=[], certificate=None,
        conflict=conflict,
    )  # fmt: skip


def _limit(spec: ShaperSpec, name: str, value: float, unit: str) -> ShaperLimit:
    required = getattr(spec, name)
    low, high = (required, math.inf) if name.startswith("least") else ends(required)
    margin = min(value - low, high - value)
    return ShaperLimit(
        limit=name, value=value, unit=unit, lower=low, upper=None if math.isinf(high) else high,
        margin=margin, holds=margin >= -ROUNDING * abs(value),
    )  # fmt: skip


def _interval(low: float, high: float) -> AngleInterval:
    return AngleInterval(min_deg=low / DEGREE, max_deg=high / DEGREE)


def check_assembly(shaper: Shaper) -> None:
    """Refuse a shaper that cannot make a full turn.

    Raises:
        InputError: the crank is as long as the pivot distance (a change point), the coupler does
            not reach the ram's line, or lengths differ by more than a factor of a million.
    """
    a, r = shaper.pivot_distance, shaper.crank
    lengths = dict(zip(LENGTHS, (r, shaper.guide, shaper.coupler, a), strict=False))
    shortest, longest = (pick(lengths, key=lambda name: lengths[name]) for pick in (min, max))
    if lengths[shortest] < SHORTEST * lengths[longest]:
        raise InputError(
            f"/{shortest}", lengths[shortest],
            f"It is less than a millionth of {longest} ({lengths[longest]:g} mm): the ram's motion "
            "would be lost in rounding.", f"Give at least {SHORTEST * lengths[longest]:g} mm.",
        )  # fmt: skip
    if abs(r - a) <= CHANGE_POINT * a:
        raise InputError(
            "/crank_mm", r, f"The crank's pin passes through the guide's pivot, {a:g} mm from the "
            "crank's: a change point, where the guide may turn either way.",
            "Give a shorter crank for a rocking guide, or a longer one for a guide that makes full "
            "turns.",
        )  # fmt: skip
    low, high = shaper.guide_sine_range()
    worst = max((low, high), key=lambda sine: abs(shaper.coupler_sine(sine)))
    distance = abs(shaper.ram_line - shaper.guide * worst)
    if distance >= shaper.coupler:
        phi = shaper.crank_at(math.asin(worst), outer=True) / DEGREE
        upper, lower = shaper.guide * high, shaper.guide * low
        ways = f"Give a coupler of more than {distance:.6g} mm"
        if upper - lower < 2.0 * shaper.coupler:
            ways += (f", or a ram_line_mm between {upper - shaper.coupler:.6g} and "
                     f"{lower + shaper.coupler:.6g}")  # fmt: skip
        raise InputError(
            "/coupler_mm", shaper.coupler,
            f"At crank angle {phi:.6g}° the guide's end is {distance:.6g} mm from the ram's line, "
            "and the coupler does not reach it.", f"{ways}.",
        )  # fmt: skip


def dead_centres(shaper: Shaper, drive: Drive) -> list[RamDeadCentre]:
    """All dead centres of the ram, in the order in which the crank passes them."""
    by_travel = dict[float, RamDeadCentre]()
    for phi, cause in _stationary_crank_angles(shaper):
        travel = drive.travel_to(phi)
        if all(abs(math.remainder(travel - other, FULL_TURN)) >= SAME for other in by_travel):
            by_travel[travel] = RamDeadCentre(
                crank_deg=(drive.phi(travel) / DEGREE) % 360.0,
                crank_travel_deg=travel / DEGREE,
                time_s=float(drive.time(travel)),
                ram_mm=float(shaper.motion(np.array(phi)).ram[0]),
                cause=cause,
            )
    return [by_travel[travel] for travel in sorted(by_travel)]


def _stationary_crank_angles(shaper: Shaper) -> Iterator[tuple[float, Cause]]:
    """Crank angles at which x' = 0: ψ' = 0, or γ = ψ, or γ = ψ + π."""
    if not shaper.guide_rotates:
        for psi in (0.5 * math.pi - shaper.swing, 0.5 * math.pi + shaper.swing):
            # ψ' = 0: the crank is perpendicular to the guide.
            yield psi + math.copysign(0.5 * math.pi, psi - 0.5 * math.pi), "guide_turns_back"
    for along in (1.0, -1.0):
        length = shaper.guide + along * shaper.coupler
        if abs(shaper.ram_line) > abs(length) or length == 0.0:
            continue
        psi = math.asin(shaper.ram_line / length)
        for each in (psi, math.pi - psi):
            if along * math.cos(each) * SIGN[shaper.side] > 0.0:
                if shaper.guide_rotates:
                    yield shaper.crank_at(each, outer=True), "in_line"
                elif math.sin(each) >= math.cos(shaper.swing):  # within its swing
                    for outer in (True, False):
                        yield shaper.crank_at(each, outer), "in_line"


def extremes(shaper: Shaper, drive: Drive) -> list[ShaperExtremes]:
    """Largest and smallest value of every quantity over the turn, with proven enclosures.

    Taylor models of the loop equations over intervals of the crank angle.
    """
    # How far a quantity exceeds 0, and how far it falls below 0, are its extremes.
    count = len(QUANTITIES)
    queries = [
        ExtremumQuery(np.array([0]), low, high, function=k, relative=RELATIVE)
        for low, high in ((-np.inf, 0.0), (0.0, np.inf))
        for k in range(count)
    ]

    def models(_: Any, lo: Array, hi: Array, numbers: Sequence[int]) -> list[Taylor]:
        centre = 0.5 * (lo + hi)
        half = 0.5 * (hi - lo) + 2.0**-50 * (np.abs(lo) + np.abs(hi))  # roundings of the centre
        nothing = np.zeros_like(centre)
        travel = Taylor.of(centre, half, nothing, nothing)
        motion = shaper.motion(drive.phi(travel))
        return [QUANTITIES[k].of(motion, drive, travel) for k in numbers]

    def peak(quantity: Quantity, extremum: Extremum) -> ShaperPeak:
        # In the wire's unit; where nothing was proven, the value at its angle.
        enclosure, unit = extremum.enclosure, quantity.per_unit
        value, phi = enclosure.value, drive.phi(enclosure.angle)
        if not math.isfinite(value):
            value = float(quantity.of(shaper.motion(phi), drive, enclosure.angle))
        return ShaperPeak(
            value=value / unit,
            crank_deg=(phi / DEGREE) % 360.0,
            crank_travel_deg=enclosure.angle / DEGREE,
            width=enclosure.width / unit if math.isfinite(enclosure.width) else None,
        )

    extrema = enclose(models, np.array([0.0, FULL_TURN]), np.array([BOXES]), queries)
    return [
        ShaperExtremes(
            quantity=one.name, unit=one.unit, largest=peak(one, most), smallest=peak(one, least)
        )
        for one, most, least in zip(QUANTITIES, extrema[:count], extrema[count:], strict=True)
    ]
