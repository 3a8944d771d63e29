"""SpatialDesign: a spatial cam as it is delivered. It is a response body, and files come of it."""

from __future__ import annotations

from functools import cached_property
from typing import Literal

from pydantic import Field

from synthesis.design import (
    Certificate,
    Conflict,
    Part,
    Report,
    SegmentMotion,
    Status,
    question_id,
    rebuilt,
    told,
)  # fmt: skip
from synthesis.fields import Rotation
from synthesis.motion import Motion
from synthesis.spatial.cam import SpatialCam, settled
from synthesis.spatial.spec import SpatialCamSpec

Side = Literal["L", "R"]


class Arc(Part):
    """A part of the turn."""

    start_deg: float = told("Cam angle where it starts.")
    end_deg: float = told("Cam angle where it ends.")


class SpatialWall(Part):
    """A wall of the cam: what one side of one roller leaves of it in a turn."""

    name: str = told("Roller and side, as in `2L`.")
    roller: int = told("Number of the roller.")
    side: Side = told(
        "R: on the side to which the follower moves as its travel grows; L: the other. Of a "
        "turret: as seen from the cam, with the turret's axis z upwards."
    )
    arcs: list[Arc] = told("Where in the turn the roller meets the cam.")


class SpatialExtreme(Part):
    """One quantity of the finished cam: its extreme, where that is, and how it is known."""

    quantity: str = told("What is measured.")
    value: float | None = told("Extreme over the whole cam; null: there is none, or it is infinite")
    unit: str = told("Unit of value, bound, margin and width.")
    angle_deg: float | None = told("Cam angle where the extreme occurs.")
    roller: int | None = told("Number of the roller; null where it is none's.")
    side: Side | None = told("Side of the roller, as in the walls' names.")
    rho_mm: float | None = told(
        "Place on the roller's axis; of a turret measured from the turret's axis."
    )
    bound: float | None = told("What is allowed; null: measured, not limited.")
    margin: float | None = told("Distance to the bound, negative where it is broken.")
    width: float = told(
        "How far the true extreme may lie beyond the value: proven where the evidence says so, "
        "otherwise what the last steps of the search still gained."
    )
    holds: bool = told("Margin not below the width.")
    evidence: str = told("How the extreme is known.")
    field: str = told("Field of the spec that sets the bound; empty where none does.")


class SpatialDesign(Part):
    """The answer to a SpatialCamSpec."""

    id: str = told("Hash of the spec and the engine's version.")
    name: str = told("Name from the spec.")
    engine_version: str = told("Version of Camwright that made it.")
    status: Status = told(
        "optimal: every limit holds and the gap is within the tolerance; feasible: every limit "
        "holds; infeasible: one does not, or no cam was found."
    )
    rotation: Rotation = told("Sense in which the cam turns.")
    speed_rpm: float = told("Cam speed.")
    machine: str = told("Kind of the machine.")
    dimensions: dict[str, float] = told("Every dimension of machine and cam by name and unit.")
    motion: list[SegmentMotion] = told("The follower's motion, segment by segment.")
    walls: list[SpatialWall] = told("By roller, then by side.")
    extremes: list[SpatialExtreme] = told("Measured on the finished cam.")
    certificate: Certificate = told("What was proven.")
    conflict: Conflict | None = Field(None, description="Why nothing fits, where nothing does.")
    report: Report = told("What was modelled and what it cost.")
    spec: SpatialCamSpec = told("The question.")
    links: dict[str, str] = Field({}, description="Where to find it and its files.")

    @cached_property
    def curve(self) -> Motion:
        """The motion, rebuilt to the last bit from the spec and the spline coefficients."""
        return rebuilt(self.spec.stretches(), self.motion)

    @cached_property
    def cam(self) -> SpatialCam:
        """The cam that files are made of."""
        sizes = {name: self.dimensions[name] for name in self.spec.machine.sizes()}
        return settled(self.spec, sizes, self.curve)


def spatial_id(spec: SpatialCamSpec) -> str:
    """The cam's id on this engine."""
    return question_id(spec, "spatial cam")
