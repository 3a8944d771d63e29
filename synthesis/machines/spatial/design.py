"""SpatialDesign: the response body of a spatial cam, from which files are made."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Literal

from pydantic import Field

from synthesis.catalogue.fields import AnswerModel, Rotation, doc
from synthesis.catalogue.motion import Motion
from synthesis.design.design import (
    Certificate,
    Conflict,
    Report,
    SegmentMotion,
    Status,
    rebuild_motion,
)  # fmt: skip
from synthesis.design.identity import question_id
from synthesis.design.warnings import DesignWarning, Severity
from synthesis.machines.spatial.cam import SpatialCam, build_cam
from synthesis.machines.spatial.spec import SpatialCamSpec

Side = Literal["L", "R"]


class Arc(AnswerModel):
    """An interval of cam angle."""

    start_deg: float = doc("Cam angle at its start.")
    end_deg: float = doc("Cam angle at its end.")


class SpatialWall(AnswerModel):
    """A wall of the cam: the surface that one side of one roller envelops in a turn."""

    name: str = doc("Roller and side, as in `2L`.")
    roller: int = doc("Number of the roller.")
    side: Side = doc(
        "R: on the side towards which the follower moves as its travel grows; L: the other. For a "
        "turret: as seen from the cam, with the turret's axis z upwards."
    )
    arcs: list[Arc] = doc("Intervals in which the roller meets the cam.")


class SpatialExtreme(AnswerModel):
    """One quantity of the finished cam: its extreme, where it occurs, and how it is known."""

    quantity: str = doc("Name of the measured quantity.")
    value: float | None = doc("Extreme over the whole cam; null: there is none, or it is infinite.")
    unit: str = doc("Unit of value, bound, margin and width.")
    angle_deg: float | None = doc("Cam angle where the extreme occurs.")
    roller: int | None = doc("Number of the roller; null where none is concerned.")
    side: Side | None = doc("Side of the roller, as in the walls' names.")
    rho_mm: float | None = doc(
        "Place on the roller's axis; for a turret measured from the turret's axis."
    )
    bound: float | None = doc("Allowed value; null: not limited.")
    margin: float | None = doc("Distance to the bound, negative where it is violated.")
    width: float = doc(
        "Distance by which the true extreme may lie beyond the value: proven where the evidence "
        "says so, otherwise the gain of the last refinement."
    )
    holds: bool = doc("Whether the margin is at least the width.")
    evidence: str = doc("How the extreme is known.")
    field: str = doc("Field of the spec that sets the bound; empty where none does.")


class SpatialDesign(AnswerModel):
    """The answer to a SpatialCamSpec."""

    id: str = doc("Hash of the spec and the engine's version.")
    name: str = doc("Name from the spec.")
    engine_version: str = doc("Version of Camwright that made it.")
    status: Status = doc(
        "optimal: every limit holds and the gap is within the tolerance; feasible: every limit "
        "holds; infeasible: one does not on a cam that was given, or it is proven that no cam "
        "fits; unsolved: no cam was found."
    )
    severity: Severity = Field("none", description="That of the worst warning.")
    warnings: list[DesignWarning] = Field(
        [], description="What an engineer would say of the cam, the most severe first."
    )
    rotation: Rotation = doc("Sense in which the cam turns.")
    speed_rpm: float = doc("Cam speed.")
    machine: str = doc("Kind of the machine.")
    dimensions: dict[str, float] = doc("Dimensions of machine and cam, by name with unit.")
    motion: list[SegmentMotion] = doc("The follower's motion, segment by segment.")
    walls: list[SpatialWall] = doc("By roller, then by side.")
    extremes: list[SpatialExtreme] = doc("Extremes measured on the finished cam.")
    certificate: Certificate = doc("What was proven.")
    conflict: Conflict | None = Field(None, description="Why nothing fits, where nothing does.")
    report: Report = doc("Models solved and their cost.")
    spec: SpatialCamSpec = doc("The request.")
    links: dict[str, str] = Field({}, description="Links to it and its files.")

    @cached_property
    def curve(self) -> Motion:
        """The motion, rebuilt to the bit from the spec and the spline coefficients."""
        return rebuild_motion(self.spec.placed_segments(), self.motion)

    @cached_property
    def cam(self) -> SpatialCam:
        """The cam from which files are made."""
        sizes = {name: self.dimensions[name] for name in self.spec.machine.size_fields}
        return build_cam(self.spec, sizes, self.curve)

    @property
    def identification(self) -> dict[str, Any]:
        """What JSON files say of the cam that they are of."""
        names = ("id", "name", "engine_version", "status", "machine", "dimensions", "rotation",
                 "speed_rpm")  # fmt: skip
        return {name: getattr(self, name) for name in names}


def spatial_design_id(spec: SpatialCamSpec) -> str:
    """The cam's id on this engine."""
    return question_id(spec, "spatial cam")
