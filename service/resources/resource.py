"""What is kept by id: designs, cam sets, analyses. A table each, and one code for all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from operator import attrgetter
from typing import Any

from service.storage.store import (
    AnalysisRow,
    CamSetRow,
    DesignRow,
    Lookup,
    PalletisingArmRow,
    ProfileAnalysisRow,
    Row,
    SixBarShaperRow,
    SpatialCamRow,
    TrainResponseRow,
)  # fmt: skip
from service.sweeps.store import design_of_item
from service.wire.errors import (
    ServiceError,
    UnknownAnalysis,
    UnknownCamSet,
    UnknownDesign,
    UnknownLinkage,
    UnknownSpatialCam,
    UnknownTrainResponse,
)  # fmt: skip
from service.wire.links import (
    analysis_links,
    design_links,
    linkage_links,
    set_links,
    spatial_links,
    train_links,
)
from service.workers.solve import (
    Task,
    analyse,
    linked,
    read_back,
    respond,
    solve_set,
    solve_spatial,
)
from synthesis.camset import set_id
from synthesis.camset_spec import CamSetSpec
from synthesis.design import design_id, question_id
from synthesis.dynamics import TrainSpec
from synthesis.linkages import LINKAGES, Linkage
from synthesis.measured import MeasuredCam
from synthesis.spatial.design import spatial_id
from synthesis.spatial.spec import SpatialCamSpec
from synthesis.spec import DesignSpec


@dataclass(frozen=True)
class Resource:
    """A kind of question whose answers are kept.

    Attributes:
        path: of the collection. noun: for people.
        row: its table. spec: its request body. name_of: spec to id.
        task: what a worker does; None: what the engine does anyway.
        budget_of: spec to the time that it asks for [s]; None: what the server gives.
        links: id, and what lists show of the answer, to addresses.
        unknown: the error for an id that leads nowhere.
        elsewhere: finds what is kept as part of something else; None: there is no such thing.
    """

    path: str
    noun: str
    row: type[Row]
    spec: type[Any]
    name_of: Callable[[Any], str]
    task: Task | None
    links: Callable[[str, dict[str, Any]], dict[str, str]]
    unknown: type[ServiceError]
    budget_of: Callable[[Any], float | None] = attrgetter("time_budget_s")
    elsewhere: Lookup | None = None

    def at(self, name: str) -> str:
        """Address of one of them."""
        return f"{self.path}/{name}"


DESIGNS = Resource(
    path="/v1/designs",
    noun="design",
    row=DesignRow,
    spec=DesignSpec,
    name_of=design_id,
    task=None,
    links=lambda name, summary: design_links(name, has_cam=bool(summary.get("dimensions"))),
    unknown=UnknownDesign,
    elsewhere=design_of_item,
)
CAM_SETS = Resource(
    path="/v1/cam-sets",
    noun="cam set",
    row=CamSetRow,
    spec=CamSetSpec,
    name_of=set_id,
    task=solve_set,
    links=lambda name, summary: set_links(name, has_cams=bool(summary.get("fitting"))),
    unknown=UnknownCamSet,
)
ANALYSES = Resource(
    path="/v1/analyses",
    noun="analysis",
    row=AnalysisRow,
    spec=DesignSpec,
    name_of=lambda spec: question_id(spec, "analysis"),
    task=analyse,
    links=lambda name, _: analysis_links(name),
    unknown=UnknownAnalysis,
)
PROFILE_ANALYSES = Resource(
    path="/v1/profile-analyses",
    noun="profile analysis",
    row=ProfileAnalysisRow,
    spec=MeasuredCam,
    name_of=lambda cam: question_id(cam, "profile analysis"),
    task=read_back,
    links=lambda name, _: {"self": f"/v1/profile-analyses/{name}"},
    unknown=UnknownAnalysis,
    budget_of=lambda _: None,
)
SPATIAL_CAMS = Resource(
    path="/v1/spatial-cams",
    noun="spatial cam",
    row=SpatialCamRow,
    spec=SpatialCamSpec,
    name_of=spatial_id,
    task=solve_spatial,
    links=lambda name, summary: spatial_links(
        name, summary.get("machine", ""), has_cam=bool(summary.get("dimensions"))
    ),
    unknown=UnknownSpatialCam,
    budget_of=lambda _: None,
)
TRAIN_RESPONSES = Resource(
    path="/v1/train-responses",
    noun="train response",
    row=TrainResponseRow,
    spec=TrainSpec,
    name_of=lambda spec: question_id(spec, "train response"),
    task=respond,
    links=lambda name, _: train_links(name),
    unknown=UnknownTrainResponse,
)


def _linkages(linkage: Linkage, row: type[Row]) -> Resource:
    """A kind of linkage."""
    return Resource(
        path=f"/v1/linkages/{linkage.name}",
        noun=linkage.noun,
        row=row,
        spec=linkage.spec,
        name_of=lambda spec: question_id(spec, linkage.noun),
        task=partial(linked, linkage.name),
        links=lambda name, summary: linkage_links(linkage.name, name, summary.get("files", ())),
        unknown=UnknownLinkage,
    )


LINKAGE_ROWS = {"six-bar-shapers": SixBarShaperRow, "palletising-arms": PalletisingArmRow}
LINKAGE_RESOURCES = {
    name: _linkages(linkage, LINKAGE_ROWS[name]) for name, linkage in LINKAGES.items()
}
RESOURCES = (DESIGNS, CAM_SETS, ANALYSES, PROFILE_ANALYSES, SPATIAL_CAMS, TRAIN_RESPONSES)
