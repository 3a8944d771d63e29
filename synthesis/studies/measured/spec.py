"""MeasuredCam: the request body of a measured profile: points, and the follower on it."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from synthesis.catalogue.fields import CamRotation, CamSpeed, FiniteModel, Name
from synthesis.catalogue.followers import AnyFollower
from synthesis.catalogue.limits.face_width import FaceWidth

MOST_POINTS = 20_000
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]


class MeasuredCam(FiniteModel):
    """Points measured on a cam, and the follower whose motion is wanted."""

    name: Name = Field("", description="Shown in reports.")
    speed_rpm: CamSpeed = 60.0
    rotation: CamRotation = "ccw"
    points_mm: list[tuple[Coordinate, Coordinate]] = Field(
        min_length=3,
        max_length=MOST_POINTS,
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
