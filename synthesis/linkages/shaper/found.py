"""What is found of a shaper: the response body."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from synthesis.design import Conflict, Part, Proof, Status, told
from synthesis.linkages.shaper.spec import ShaperSpec


class RamDeadCentre(Part):
    """Where the ram stands still, in closed form."""

    crank_deg: float = told("Crank angle, from 0 to 360.")
    turned_deg: float = told("The same, counted from the start of the turn as the crank turns.")
    time_s: float = told("Time from the start of the turn.")
    ram_mm: float = told("Position of the ram's pin.")
    cause: Literal["guide_turns_back", "in_line"] = told(
        "guide_turns_back: crank and guide are square to each other; in_line: guide and coupler "
        "are in one line."
    )


class QuickReturn(Part):
    """The two strokes between the outermost positions of the ram."""

    ratio: float = told("Crank angle of the slow stroke over that of the quick one.")
    time_ratio: float | None = told(
        "Time of the slow stroke over that of the quick one; null where the crank changes its "
        "speed: the strokes then differ from turn to turn."
    )
    slow_deg: float = told("Crank angle of the slow stroke.")
    quick_deg: float = told("Crank angle of the quick stroke.")
    slow_towards: Literal["left", "right"] = told("Where the ram goes during the slow stroke.")


class ShaperPeak(Part):
    """A largest or smallest value and where it is reached."""

    value: float = told("The value, in the quantity's unit.")
    crank_deg: float = told("Crank angle there, from 0 to 360.")
    turned_deg: float = told("The same, counted from the start of the turn.")
    width: float | None = told(
        "Width of the proven enclosure of the value; null: so close to where a coupler stands "
        "upright, or a guide may turn either way, nothing is proven, and the value is one that is "
        "reached."
    )


class ShaperExtremes(Part):
    """The extremes of one quantity over the turn."""

    quantity: str = told("Its name.")
    unit: str = told("Its unit.")
    largest: ShaperPeak = told("Largest value.")
    smallest: ShaperPeak = told("Smallest value.")


class AngleInterval(Part):
    """From where to where something moves [deg]."""

    min_deg: float = told("Smallest angle [deg].")
    max_deg: float = told("Largest angle [deg].")


class ShaperLimit(Part):
    """A wish, and what came out."""

    limit: str = told("The field of the spec.")
    value: float = told("What came out, measured on the finished linkage.")
    unit: str = told("Unit of value and bounds.")
    lower: float | None = told("Least value wanted; null: none.")
    upper: float | None = told("Largest value wanted; null: none.")
    margin: float = told("Distance to the nearer bound, negative where it is broken.")
    holds: bool = told("Whether it is kept, to within 1e-9 of the value.")


class SixBarShaper(Part):
    """A six-bar shaper: what it does over a turn."""

    id: str = told("Hash of the spec and the engine's version.")
    name: str = told("Name from the spec.")
    engine_version: str = told("Version of Camwright that made it.")
    status: Status = told(
        "optimal: every wish is kept and the gap is within the tolerance; feasible: every wish is "
        "kept; infeasible: see conflict, or limits where all lengths are given."
    )
    spec: ShaperSpec = told("What was asked.")
    dimensions: dict[str, float] = told("Every length [mm]; empty where nothing fits.")
    guide: Literal["rocks", "turns"] | None = told(
        "rocks: the crank is shorter than the pivots are apart; turns: longer, and the guide goes "
        "all the way round."
    )
    guide_angle: AngleInterval | None = told("Range of the guide's angle; null where it turns.")
    coupler_angle: AngleInterval | None = told("Range of the coupler's angle to the ram's line.")
    stroke_mm: float | None = told("Distance of the outermost positions of the ram.")
    quick_return: QuickReturn | None = told("The two strokes.")
    dead_centres: list[RamDeadCentre] = told("Where the ram stands still, in the crank's order.")
    least_transmission_angle_deg: float | None = told(
        "Least angle between coupler and upright at the ram. At the crank's pin it is 90° always: "
        "the sliding block pushes square to the guide."
    )
    extremes: list[ShaperExtremes] = told("Of velocities and accelerations over the turn.")
    limits: list[ShaperLimit] = told("The wishes, measured on the finished linkage.")
    certificate: Proof | None = told("How far from the best; null where all lengths are given.")
    conflict: Conflict | None = told("Why nothing fits, and what would.")
    links: dict[str, str] = Field({}, description="Where it and its files are.")
