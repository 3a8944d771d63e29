"""Analysis: what is found of a cam that is given in full. It is a response body."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from synthesis.catalogue.fields import AnswerModel, doc
from synthesis.design.design import Extreme, Forces, Relaxation, Status
from synthesis.design.warnings import DesignWarning, Severity
from synthesis.spec.design_spec import DesignSpec

Over = Literal["turn", "rise", "dwell", "return"]
Side = Literal["left", "right", "both"]


class Peak(AnswerModel):
    """A largest or smallest value, and one cam angle where it is reached."""

    value: float = doc("The value, in the curve's unit.")
    angle_deg: float = doc("Cam angle; where the value holds along an arc, one angle of it.")
    side: Side = doc(
        "`left` or `right` where the curve jumps at this angle and the value is that of one "
        "side; `both` elsewhere."
    )
    width: float = doc("Width of the proven enclosure of the value.")


class CurveSummary(AnswerModel):
    """The extremes of one curve, on the curve itself: what it does at a jump is one-sided."""

    curve: str = doc("Name of the curve.")
    over: Over = doc("Where: over the whole turn, or on all rises, dwells or returns.")
    unit: str = doc("Unit of the values.")
    largest: Peak | None = doc("Largest value; null where the curve has none.")
    smallest: Peak | None = doc("Smallest value; null where the curve has none.")
    infinite_deg: list[float] = doc(
        "Cam angles where the curve is infinite, because the one that it is a derivative of "
        "jumps there. The extremes are those between these angles."
    )


class CurveJump(AnswerModel):
    """A curve's two values at a joint."""

    curve: str = doc(
        "displacement, velocity, acceleration, pitch_curvature; profile_radius of a flat face."
    )
    unit: str = doc("Unit of the values.")
    angle_deg: float = doc("Cam angle of the joint.")
    before: float = doc("Value on the left.")
    after: float = doc("Value on the right.")
    jump: float = doc("after − before.")


class Undercut(AnswerModel):
    """The pitch curve bends more sharply than the roller: the profile has a cusp or a loop."""

    kind: Literal["undercut", "cusp", "corner"] = doc(
        "undercut: the roller is larger than the pitch curve's convex radius; cusp: as large; "
        "corner: a jump of the velocity breaks the pitch curve."
    )
    angle_deg: float = doc("Cam angle where it is worst.")
    pitch_radius_mm: float = doc(
        "Convex radius of the pitch curve there; under a flat face the profile's own, signed."
    )
    roller_radius_mm: float = doc("Radius of the roller; 0 under a flat face.")
    excess_mm: float = doc("Roller radius less that radius of curvature.")
    flank: str = Field("", description="Which flank, where the cam has several.")


class SelfCrossing(AnswerModel):
    """Far parts of the profile cross: the roller that cuts one of them cuts into the other."""

    profile_deg: float = doc("Cam angle of the profile point that is cut deepest.")
    roller_deg: float = doc("Cam angle at which the roller cuts into it.")
    depth_mm: float = doc("How deep it cuts: roller radius less the distance of its centre.")
    flank: str = Field("", description="Which flank, where the cam has several.")


class SizeChange(AnswerModel):
    """The smallest cam that keeps every limit, with the laws as they are."""

    offset: Literal["kept", "free"] = doc(
        "Whether the follower's own place stays as given: its offset, or the distance of its pivot."
    )
    status: Status | None = doc(
        "infeasible: proven that no size mends it; unsolved: none was found; optimal, feasible: "
        "certified; null: the solvers gave no answer."
    )
    dimensions: dict[str, float] = doc("Base radius, prime radius, offset, … by name and unit.")
    base_radius_change_mm: float | None = doc("New base radius less the given one.")
    offset_change_mm: float | None = doc("New offset less the given one; null without one.")
    changes: dict[str, float] = Field(
        {}, description="The same of every dimension that was freed: new value less the given one."
    )
    gap: float | None = doc("How far the base radius is at most from the least possible.")


class Remedy(AnswerModel):
    """What would make every limit hold."""

    sizes: list[SizeChange] = doc("The offset kept, and the offset free.")
    limits: list[str] = doc("The limits that cannot hold together.")
    relaxations: list[Relaxation] = doc("For each limit alone, what it would have to be.")
    evidence: str = doc("How the conflict is known, and whether it is proven.")


class Analysis(AnswerModel):
    """What a given cam does, and which limits it breaks, by how much and where."""

    name: str = doc("Name from the spec.")
    engine_version: str = doc("Version of Camwright that found it.")
    holds: bool = doc("Whether every limit holds at every cam angle.")
    severity: Severity = Field("none", description="That of the worst warning.")
    warnings: list[DesignWarning] = Field(
        [], description="What an engineer would say of the cam, the most severe first."
    )
    dimensions: dict[str, float] = doc("Base radius, prime radius, offset, … by name and unit.")
    violated: list[str] = doc("The limits that do not hold.")
    extremes: list[Extreme] = doc("Every limit, measured on the cam.")
    curves: list[CurveSummary] = doc("The extremes of every curve.")
    jumps: list[CurveJump] = doc("Where displacement, velocity, acceleration, curvature jump.")
    undercut: Undercut | None = doc("Undercut or cusp; null where there is none.")
    self_crossing: SelfCrossing | None = doc("Crossing far parts; null where there are none.")
    forces: Forces | None = Field(None, description="Its forces, where the spec tells its load.")
    remedy: Remedy | None = doc("What would mend it; null where every limit holds.")
    spec: DesignSpec = doc("The question.")


class Sensitivity(AnswerModel):
    """What one number of the spec is worth."""

    field: str = doc("JSON pointer to a limit, or to an end of a range, in the spec.")
    requested: float = doc("What the spec says there; the unit is in the field's name.")
    per_unit: float | None = doc(
        "Change of the objective for one unit more there, to first order, everything else free to "
        "follow; 0 where the number does not decide; null where more and less differ."
    )
    per_unit_more: float | None = doc(
        "The same for a change upwards alone; null: there the spec makes no sense, or no cam was "
        "found beside this one."
    )
    per_unit_less: float | None = doc(
        "The same for a change downwards alone, per unit more as well: both are equal unless the "
        "number stands where it just begins to decide."
    )
    sentence: str = doc("The same in words.")


class Sensitivities(AnswerModel):
    """What each limit costs: how the best value changes when the limit does."""

    objective: str = doc("The objective, with its unit.")
    value: float | None = doc("Its value on the finished cam; null: there is no cam.")
    sensitivities: list[Sensitivity] = doc("The dearest first; empty where they are not known.")
    unconfirmed: list[str] = doc(
        "Numbers without a sensitivity, because multipliers and a second solve disagree."
    )
    evidence: str = doc("How they are known, or why they are not.")
