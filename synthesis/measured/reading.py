"""ProfileAnalysis: what is read from a measured profile. It is a response body."""

from __future__ import annotations

from typing import Literal

from synthesis.design import Part, told


class Fit(Part):
    """How well smooth curves pass through what was measured."""

    points: int = told("Points that were used.")
    rms_mm: float = told("Root mean square of their distances from the smooth profile.")
    largest_mm: float = told("Largest of these distances; within the tolerance.")
    motion_mm: float = told("Largest distance of the motion's spline from the motion as read.")


class ReadSpline(Part):
    """The displacement over the turn as a periodic B-spline.

    Coefficient i belongs to the basis function over the knots i − degree to i + 1, counted round
    with 360° added per turn. A knot that is repeated is a kink.
    """

    degree: int = told("Polynomial degree.")
    knots_deg: list[float] = told("Knots in [0, 360), the first at 0.")
    unit: Literal["mm", "deg"] = told("Unit of displacements: deg where the follower swings.")
    coefficients: list[float] = told("One coefficient per knot, in this unit.")


class ReadPeak(Part):
    """An extreme of the motion as read."""

    curve: str = told("displacement, velocity, acceleration, jerk or pressure_angle.")
    unit: str = told("Unit of value and error.")
    largest: float = told("Largest value.")
    largest_deg: float = told("Cam angle of the largest value.")
    smallest: float = told("Smallest value.")
    smallest_deg: float = told("Cam angle of the smallest value.")
    error: float | None = told(
        "What the tolerance can hide: no other motion within it differs by more, if its fourth "
        "derivative is nowhere larger than the one read. Null where the velocity jumps, and for "
        "angles."
    )


class ReadDwell(Part):
    """An arc along which the follower stands still, as far as the tolerance tells."""

    start_deg: float = told("Cam angle where it begins.")
    angle_deg: float = told("Its length.")
    s: float = told("Displacement there, in the unit of the motion.")


class NotTouched(Part):
    """A hollow that the follower spans: its ground is never touched."""

    angle_deg: float = told("Cam angle at which the follower rests on both sides.")
    hollow_radius_mm: float | None = told("Smallest hollow radius there; null: an overhang.")
    roller_radius_mm: float = told("Roller radius; 0 of a knife edge and of a flat face.")
    gap_mm: float = told("Greatest distance left between follower and profile.")
    x_mm: float = told("The profile point farthest from the follower.")
    y_mm: float = told("The profile point farthest from the follower.")


class OffFace(Part):
    """An arc along which contact lies beyond the end of a flat face."""

    side: Literal["left", "right"] = told("Which end, on a ccw cam.")
    from_deg: float = told("Cam angle where contact leaves the face.")
    to_deg: float = told("Cam angle where it is back; less than from_deg across 360°.")
    worst_deg: float = told("Cam angle where it is farthest beyond.")
    beyond_mm: float = told("How far, at most.")


class ProfileAnalysis(Part):
    """The motion that a measured profile gives a follower."""

    name: str = told("Name from the request.")
    engine_version: str = told("Version of Camwright that read it.")
    dimensions: dict[str, float] = told("Base radius, prime radius, offset, stroke, … as read.")
    fit: Fit = told("How well the curves fit.")
    spline: ReadSpline = told("The motion.")
    peaks: list[ReadPeak] = told("The extremes of motion and pressure angle.")
    dwells: list[ReadDwell] = told("Where the follower stands still.")
    not_touched: list[NotTouched] = told("Hollows too narrow for the roller, or under the face.")
    off_face: list[OffFace] = told("Where contact leaves the face that was given.")
    table: dict[str, list[float]] = told(
        "The motion from cam angle 0, by columns: `angle_deg`; `s_mm`, `v_mm_per_s`, "
        "`a_mm_per_s2`, `j_mm_per_s3`, or the same with deg where the follower swings; "
        "`pressure_angle_deg`."
    )
