"""MeasuredCam and ProfileAnalysis: request and response body of a measured profile."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from synthesis.catalogue.fields import AnswerModel, CamRotation, CamSpeed, FiniteModel, Name, doc
from synthesis.catalogue.followers import AnyFollower
from synthesis.catalogue.limits.face_width import FaceWidth

MAX_POINTS = 20_000  # of a measured curve
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]


class MeasuredCam(FiniteModel):
    """Points measured on a cam, and the follower whose motion is wanted."""

    name: Name = Field("", description="Shown in reports.")
    speed_rpm: CamSpeed = 60.0
    rotation: CamRotation = "ccw"
    points_mm: list[tuple[Coordinate, Coordinate]] = Field(
        min_length=3,
        max_length=MAX_POINTS,
        fail_fast=True,  # thousands of errors help nobody and take long to make
        description="Points [x, y] once around the profile, in order, in either direction and "
        "from any start, evenly spaced or not. The cam's axis is the origin; at cam angle 0 "
        "the follower moves along y.",
    )
    follower: AnyFollower = Field(description="The follower, its dimensions given as numbers.")
    face_width: FaceWidth | None = Field(
        None, description="Width of a flat face, to find where contact leaves it."
    )
    tolerance_mm: float = Field(
        0.01,
        gt=0.0,
        le=1e3,
        description="Largest distance of the smooth profile from a point: the accuracy of the "
        "measurement.",
    )
    rows_per_degree: float = Field(
        1.0, ge=0.1, le=20.0, description="Rows of the motion's table per degree."
    )

    @property
    def mirror(self) -> float:
        """−1 where the cam turns clockwise: its mirror image in x turns counter-clockwise."""
        return -1.0 if self.rotation == "cw" else 1.0


class Fit(AnswerModel):
    """How well the smooth curves fit the measurement."""

    points: int = doc("Points that were used.")
    rms_mm: float = doc("Root mean square of their distances from the smooth profile.")
    largest_mm: float = doc("Largest of these distances; within the tolerance.")
    motion_mm: float = doc("Largest distance of the motion's spline from the follower's positions.")


class ReadSpline(AnswerModel):
    """The displacement over the turn as a periodic B-spline.

    Coefficient i belongs to the basis function over the knots i − degree to i + 1, cyclic with 360°
    added per turn. A repeated knot is a kink.
    """

    degree: int = doc("Polynomial degree.")
    knots_deg: list[float] = doc("Knots in [0, 360), the first at 0.")
    unit: Literal["mm", "deg"] = doc("Unit of displacements: deg where the follower swings.")
    coefficients: list[float] = doc("One coefficient per knot, in this unit.")


class ReadPeak(AnswerModel):
    """The extremes of one curve of the motion."""

    curve: str = doc("displacement, velocity, acceleration, jerk or pressure_angle.")
    unit: str = doc("Unit of value and error.")
    largest: float = doc("Largest value.")
    largest_deg: float = doc("Cam angle of the largest value.")
    smallest: float = doc("Smallest value.")
    smallest_deg: float = doc("Cam angle of the smallest value.")
    error: float | None = doc(
        "Uncertainty from the tolerance: no motion within it differs by more, if its fourth "
        "derivative is nowhere larger than this motion's. Null where the velocity jumps, and for "
        "pressure_angle."
    )


class ReadDwell(AnswerModel):
    """An arc along which the follower dwells, within the tolerance."""

    start_deg: float = doc("Cam angle where it begins.")
    angle_deg: float = doc("Its cam angle.")
    s: float = doc("Displacement there, in the unit of the motion.")


class UnreachedHollow(AnswerModel):
    """A hollow that the follower spans: its bottom is never touched."""

    angle_deg: float = doc("Cam angle at which the follower touches both sides.")
    hollow_radius_mm: float | None = doc("Least concave radius there; null: an overhang.")
    roller_radius_mm: float = doc("Roller radius; 0 for a knife edge and a flat face.")
    gap_mm: float = doc("Largest distance between follower and profile.")
    x_mm: float = doc("The profile point farthest from the follower.")
    y_mm: float = doc("The profile point farthest from the follower.")


class ContactOffFace(AnswerModel):
    """An arc along which contact lies beyond the end of a flat face."""

    side: Literal["left", "right"] = doc("Which end, on a ccw cam.")
    from_deg: float = doc("Cam angle where contact leaves the face.")
    to_deg: float = doc("Cam angle where it returns; less than from_deg across 360°.")
    worst_deg: float = doc("Cam angle where it is farthest beyond the end.")
    excess_mm: float = doc("Largest distance beyond the end.")


class ProfileAnalysis(AnswerModel):
    """The motion that a measured profile gives a follower."""

    name: str = doc("Name from the request.")
    engine_version: str = doc("Version of Camwright that read it.")
    dimensions: dict[str, float] = doc(
        "Base radius, prime radius, offset, stroke, … of the measured cam."
    )
    fit: Fit = doc("How well the curves fit.")
    spline: ReadSpline = doc("The motion.")
    peaks: list[ReadPeak] = doc("Extremes of motion and pressure angle.")
    dwells: list[ReadDwell] = doc("Arcs along which the follower dwells.")
    unreached_hollows: list[UnreachedHollow] = doc(
        "Hollows too narrow for the roller, or under the face."
    )
    contact_off_face: list[ContactOffFace] = doc(
        "Arcs along which contact is beyond the given face."
    )
    table: dict[str, list[float]] = doc(
        "The motion from cam angle 0, by columns: `angle_deg`; `s_mm`, `v_mm_per_s`, "
        "`a_mm_per_s2`, `j_mm_per_s3`, or the same with deg where the follower swings; "
        "`pressure_angle_deg`."
    )
