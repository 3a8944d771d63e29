"""Analysis: what is found of a cam that is given in full. It is a response body."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from synthesis.design import Extreme, Part, Relaxation, Status, told
from synthesis.forces.told import Forces
from synthesis.spec import DesignSpec

Over = Literal["turn", "rise", "dwell", "return"]
Side = Literal["left", "right", "both"]


class Peak(Part):
    """A largest or smallest value, and one cam angle where it is reached."""

    value: float = told("The value, in the curve's unit.")
    angle_deg: float = told("Cam angle; where the value holds along an arc, one angle of it.")
    side: Side = told(
        "`left` or `right` where the curve jumps at this angle and the value is that of one "
        "side; `both` elsewhere."
    )
    width: float = told("Width of the proven enclosure of the value.")


class CurveSummary(Part):
    """The extremes of one curve, on the curve itself: what it does at a jump is one-sided."""

    curve: str = told("Name of the curve.")
    over: Over = told("Where: over the whole turn, or on all rises, dwells or returns.")
    unit: str = told("Unit of the values.")
    largest: Peak | None = told("Largest value; null where the curve has none.")
    smallest: Peak | None = told("Smallest value; null where the curve has none.")
    infinite_deg: list[float] = told(
        "Cam angles where the curve is infinite, because the one that it is a derivative of "
        "jumps there. The extremes are those between these angles."
    )


class CurveJump(Part):
    """A curve's two values at a joint."""

    curve: str = told(
        "displacement, velocity, acceleration, pitch_curvature; profile_radius of a flat face."
    )
    unit: str = told("Unit of the values.")
    angle_deg: float = told("Cam angle of the joint.")
    before: float = told("Value on the left.")
    after: float = told("Value on the right.")
    jump: float = told("after − before.")


class Undercut(Part):
    """The pitch curve bends more sharply than the roller: the profile has a cusp or a loop."""

    kind: Literal["undercut", "cusp", "corner"] = told(
        "undercut: the roller is larger than the pitch curve's convex radius; cusp: as large; "
        "corner: a jump of the velocity breaks the pitch curve."
    )
    angle_deg: float = told("Cam angle where it is worst.")
    pitch_radius_mm: float = told(
        "Convex radius of the pitch curve there; under a flat face the profile's own, signed."
    )
    roller_radius_mm: float = told("Radius of the roller; 0 under a flat face.")
    too_large_mm: float = told("Roller radius less that radius of curvature.")
    flank: str = Field("", description="Which flank, where the cam has several.")


class SelfCrossing(Part):
    """Far parts of the profile cross: the roller that cuts one of them cuts into the other."""

    profile_deg: float = told("Cam angle of the profile point that is cut deepest.")
    roller_deg: float = told("Cam angle at which the roller cuts into it.")
    depth_mm: float = told("How deep it cuts: roller radius less the distance of its centre.")
    flank: str = Field("", description="Which flank, where the cam has several.")


class SizeChange(Part):
    """The smallest cam that keeps every limit, with the laws as they are."""

    offset: Literal["kept", "free"] = told(
        "Whether the follower's own place stays as given: its offset, or the distance of its pivot."
    )
    status: Status | None = told(
        "infeasible: no size was found that mends it; optimal, feasible: certified; null: the "
        "solvers gave no answer."
    )
    dimensions: dict[str, float] = told("Base radius, prime radius, offset, … by name and unit.")
    base_radius_change_mm: float | None = told("New base radius less the given one.")
    offset_change_mm: float | None = told("New offset less the given one; null without one.")
    changes: dict[str, float] = Field(
        {},
        description="The same of every dimension that was freed: new value less the given one.",
    )
    gap: float | None = told("How far the base radius is at most from the least possible.")


class Mend(Part):
    """What would make every limit hold."""

    sizes: list[SizeChange] = told("The offset kept, and the offset free.")
    limits: list[str] = told("The limits that cannot hold together.")
    relaxations: list[Relaxation] = told("For each limit alone, what it would have to be.")
    evidence: str = told("How the conflict is known, and whether it is proven.")


class Analysis(Part):
    """What a given cam does, and which limits it breaks, by how much and where."""

    name: str = told("Name from the spec.")
    engine_version: str = told("Version of Camwright that found it.")
    holds: bool = told("Whether every limit holds at every cam angle.")
    dimensions: dict[str, float] = told("Base radius, prime radius, offset, … by name and unit.")
    broken: list[str] = told("The limits that do not hold.")
    extremes: list[Extreme] = told("Every limit, measured on the cam.")
    curves: list[CurveSummary] = told("The extremes of every curve.")
    jumps: list[CurveJump] = told("Where displacement, velocity, acceleration, curvature jump.")
    undercut: Undercut | None = told("Undercut or cusp; null where there is none.")
    self_crossing: SelfCrossing | None = told("Crossing far parts; null where there are none.")
    forces: Forces | None = Field(None, description="Its forces, where the spec tells its load.")
    mend: Mend | None = told("What would mend it; null where every limit holds.")
    spec: DesignSpec = told("The question.")


class Sensitivity(Part):
    """What one number of the spec is worth."""

    field: str = told("JSON pointer to a limit, or to an end of a range, in the spec.")
    asked: float = told("What the spec says there; the unit is in the field's name.")
    per_unit: float | None = told(
        "Change of the objective for one unit more there, to first order, everything else free to "
        "follow; 0 where the number does not decide; null where more and less differ."
    )
    per_unit_more: float | None = told(
        "The same for a change upwards alone; null: there the spec makes no sense, or no cam was "
        "found beside this one."
    )
    per_unit_less: float | None = told(
        "The same for a change downwards alone, per unit more as well: both are equal unless the "
        "number stands where it just begins to decide."
    )
    words: str = told("The same in words.")


class Sensitivities(Part):
    """What each limit costs: how the best value changes when the limit does."""

    objective: str = told("The objective, with its unit.")
    value: float | None = told("Its value on the finished cam; null: there is no cam.")
    sensitivities: list[Sensitivity] = told("The dearest first; empty where they are not known.")
    unconfirmed: list[str] = told(
        "Numbers of which nothing is told, because multipliers and seeking again disagree."
    )
    evidence: str = told("How they are known, or why they are not.")
