"""SixBarShaper: the response body of a six-bar shaper."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from synthesis.catalogue.fields import AnswerModel, doc
from synthesis.design.design import Conflict, Proof, Status
from synthesis.machines.linkages.shaper.spec import ShaperSpec

Cause = Literal["guide_turns_back", "in_line"]


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
