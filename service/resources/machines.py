"""/v1/spatial-cams, /v1/linkages/{kind}, /v1/train-responses: machines other than a plane cam."""

from __future__ import annotations

from functools import partial
from operator import attrgetter
from typing import Literal

from pydantic import Field

from service.resources.resource import Accepted, Resource, StatusOrNone, file_of
from service.wire.errors import ProblemType
from service.workers.tasks import (
    compute_train_response,
    solve_linkage,
    solve_spatial_cam,
    write_file,
)
from synthesis.design.design import Status
from synthesis.design.identity import question_id
from synthesis.machines.dynamics import TrainResponse, TrainSpec
from synthesis.machines.dynamics.files import TRAIN_FILES
from synthesis.machines.linkages import LINKAGES, Linkage
from synthesis.machines.linkages.files import LINKAGE_FILES
from synthesis.machines.spatial.design import SpatialDesign, spatial_design_id
from synthesis.machines.spatial.files import FORMATS
from synthesis.machines.spatial.spec import SpatialCamSpec


class SpatialCamSummary(Accepted):
    """One line of the list of spatial cams."""

    status: StatusOrNone
    machine: str | None = Field(None, description="Kind of its machine.")
    dimensions: dict[str, float] = Field(
        {}, description="Centre distance, roller radius, …: name and unit."
    )


class LinkageSummary(Accepted):
    """One line of a list of linkages."""

    status: StatusOrNone
    quantities: dict[str, float] = Field({}, description="Stroke, reach, …: name and unit.")


class TrainResponseSummary(Accepted):
    """One line of the list of follower trains."""

    status: Literal["computed"] | None = Field(description="null until it is done.")
    modes_hz: list[float] = Field([], description="Natural frequencies of the train.")


_NO_CAM = "No cam fits these limits, so that there is none to draw."
_write_cam = partial(write_file, SpatialDesign, attrgetter("motion"), _NO_CAM)
SPATIAL_CAMS = Resource(
    path="/v1/spatial-cams",
    tag="spatial cams",
    noun="spatial cam",
    id_name="cam_id",
    spec=SpatialCamSpec,
    answer=SpatialDesign,
    summary=SpatialCamSummary,
    id_of=spatial_design_id,
    task=solve_spatial_cam,
    unknown=ProblemType.UNKNOWN_SPATIAL_CAM,
    title="Design a spatial cam",
    text="""The walls that the rollers of a turret leave of a cam, and what they do.

    `walls` says which side of which roller meets the cam when, `extremes` what was measured of
    them: value, cam angle, roller, side and place on the roller's axis. A wall that is undercut
    makes the cam `infeasible`: a result, not an error. The same spec gives the same id.
    """,
    answer_text="Dimensions, motion, walls, extremes, certificate, report and links.",
    status=Status,
    budget_of=lambda _: None,
    files=tuple(
        file_of(_write_cam, exporter, name, "spatial_cam_") for name, exporter in FORMATS.items()
    ),
    marks_broken_limits=True,
)


def _linkages(linkage: Linkage) -> Resource:
    operation = linkage.name.replace("-", "_").removesuffix("s")
    nothing = "No lengths keep these wishes: see conflict in the answer."
    write = partial(write_file, linkage.answer, linkage.summary, nothing)
    return Resource(
        path=f"/v1/linkages/{linkage.name}",
        tag="linkages",
        noun=linkage.noun,
        id_name="linkage_id",
        spec=linkage.spec,
        answer=linkage.answer,
        summary=LinkageSummary,
        id_of=lambda spec: question_id(spec, linkage.noun),
        task=partial(solve_linkage, linkage.name),
        unknown=ProblemType.UNKNOWN_LINKAGE,
        title=linkage.title,
        text=f"{linkage.purpose} The same spec gives the same bytes.",
        answer_text="The answer, with links to its files.",
        status=Status,
        files=tuple(
            file_of(
                write, file, name, f"{operation}_",
                title=f"{file.title}, of a {linkage.noun}",
            )
            for name, file in LINKAGE_FILES[linkage.name].items()
        ),
    )  # fmt: skip


LINKAGE_RESOURCES = tuple(_linkages(linkage) for linkage in LINKAGES.values())


_write_response = partial(write_file, TrainResponse, bool, "")
TRAIN_RESPONSES = Resource(
    path="/v1/train-responses",
    tag="follower trains",
    noun="train response",
    id_name="train_id",
    spec=TrainSpec,
    answer=TrainResponse,
    summary=TrainResponseSummary,
    id_of=lambda spec: question_id(spec, "train response"),
    task=compute_train_response,
    unknown=ProblemType.UNKNOWN_TRAIN_RESPONSE,
    title="Respond to a cam with an elastic follower train",
    text="""Residual vibration in each dwell, contact force, loss of contact; exact but rounding.

    The train is a chain of masses, springs and dampers that the cam drives through the first link.
    Its periodic response and its way there from rest are computed mode by mode in closed form. The
    cam's own limits are its spec's; a law without residual vibration: the limit
    `residual_vibration`. The same spec gives the same bytes.
    """,
    answer_text="As `POST /v1/train-responses` answered, or would have without `respond-async`.",
    files=tuple(file_of(_write_response, file, file.name, "train_") for file in TRAIN_FILES),
)
