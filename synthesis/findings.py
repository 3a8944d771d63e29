"""Analysis: what is found of a cam that is given in full. It is a response body."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from synthesis.design import Extreme, Relaxation, Status
from synthesis.spec import DesignSpec

Over = Literal["turn", "rise", "dwell", "return"]
Side = Literal["left", "right", "both"]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


def _told(description: str) -> Any:
    """A required field with its description in the contract."""
    return Field(description=description)


class Peak(_Part):
    """A largest or smallest value, and one cam angle where it is reached."""

    value: float = _told("The value, in the curve's unit.")
    angle_deg: float = _told("Cam angle; where the value holds along an arc, one angle of it.")
    side: Side = _told(
        "`left` or `right` where the curve jumps at this angle and the value is that of one "
        "side; `both` elsewhere."
    )
    width: float = _told("Width of the proven enclosure of the value.")


class CurveSummary(_Part):
    """The extremes of one curve, on the curve itself: what it does at a jump is one-sided."""

    curve: str = _told("Name of the curve.")
    over: Over = _told("Where: over the whole turn, or on all rises, dwells or returns.")
    unit: str = _told("Unit of the values.")
    largest: Peak | None = _told("Largest value; null where the curve has none.")
    smallest: Peak | None = _told("Smallest value; null where the curve has none.")
    infinite_deg: list[float] = _told(
        "Cam angles where the curve is infinite, because the one that it is a derivative of "
        "jumps there. The extremes are those between these angles."
    )


class CurveJump(_Part):
    """A curve's two values at a joint."""

    curve: str = _told(
        "displacement, velocity, acceleration, pitch_curvature; profile_radius of a flat face."
    )
    unit: str = _told("Unit of the values.")
    angle_deg: float = _told("Cam angle of the joint.")
    before: float = _told("Value on the left.")
    after: float = _told("Value on the right.")
    jump: float = _told("after − before.")


class Undercut(_Part):
    """The pitch curve bends more sharply than the roller: the profile has a cusp or a loop."""

    kind: Literal["undercut", "cusp", "corner"] = _told(
        "undercut: the roller is larger than the pitch curve's convex radius; cusp: as large; "
        "corner: a jump of the velocity breaks the pitch curve."
    )
    angle_deg: float = _told("Cam angle where it is worst.")
    pitch_radius_mm: float = _told(
        "Convex radius of the pitch curve there; under a flat face the profile's own, signed."
    )
    roller_radius_mm: float = _told("Radius of the roller; 0 under a flat face.")
    too_large_mm: float = _told("Roller radius less that radius of curvature.")


class SizeChange(_Part):
    """The smallest cam that keeps every limit, with the laws as they are."""

    offset: Literal["kept", "free"] = _told("Whether the offset stays as given.")
    status: Status | None = _told(
        "infeasible: no size was found that mends it; optimal, feasible: certified; null: the "
        "solvers gave no answer."
    )
    dimensions: dict[str, float] = _told("Base radius, prime radius, offset, … in mm.")
    base_radius_change_mm: float | None = _told("New base radius less the given one.")
    offset_change_mm: float | None = _told("New offset less the given one.")
    gap: float | None = _told("How far the base radius is at most from the least possible.")


class Mend(_Part):
    """What would make every limit hold."""

    sizes: list[SizeChange] = _told("The offset kept, and the offset free.")
    limits: list[str] = _told("The limits that cannot hold together.")
    relaxations: list[Relaxation] = _told("For each limit alone, what it would have to be.")
    evidence: str = _told("How the conflict is known, and whether it is proven.")


class Analysis(_Part):
    """What a given cam does, and which limits it breaks, by how much and where."""

    name: str = _told("Name from the spec.")
    engine_version: str = _told("Version of Camwright that found it.")
    holds: bool = _told("Whether every limit holds at every cam angle.")
    dimensions: dict[str, float] = _told("Base radius, prime radius, offset, … in mm.")
    broken: list[str] = _told("The limits that do not hold.")
    extremes: list[Extreme] = _told("Every limit, measured on the cam.")
    curves: list[CurveSummary] = _told("The extremes of every curve.")
    jumps: list[CurveJump] = _told("Where displacement, velocity, acceleration, curvature jump.")
    undercut: Undercut | None = _told("Undercut or cusp; null where there is none.")
    mend: Mend | None = _told("What would mend it; null where every limit holds.")
    spec: DesignSpec = _told("The question.")
