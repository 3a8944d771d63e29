"""/v1/designs; /v1/analyses and /v1/profile-analyses: what a given or a measured cam does."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from operator import attrgetter
from typing import Literal

from pydantic import Field

from service.resources.resource import Accepted, Resource, ResourceFile, StatusOrNone, file_of
from service.sweeps.store import design_of_item
from service.wire.errors import ProblemType
from service.workers.tasks import (
    DESIGN_FORMATS,
    analyse_cam,
    analyse_profile,
    write_file,
    write_picture,
)
from synthesis.design.analysis import Analysis
from synthesis.design.design import Design, Status
from synthesis.design.identity import design_id, question_id
from synthesis.exporters import DRAWINGS, PICTURES
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.measured import MeasuredCam, ProfileAnalysis

NO_CAM = "No cam fits these limits: see conflict in the design for what would."
write_design = partial(write_file, Design, attrgetter("motion"), NO_CAM)
REPORT = "report.html"  # it has a route of its own: it may need a worker or not
Verdict = Literal["holds", "violated"]


class DesignSummary(Accepted):
    """One line of the list."""

    status: StatusOrNone
    dimensions: dict[str, float] = Field({}, description="Base radius, offset, …: name and unit.")
    objective: str | None = Field(None, description="What was minimised.")
    value: float | None = Field(None, description="The value that it reached.")
    gap: float | None = Field(None, description="Relative distance to the bound.")
    certified: bool | None = Field(None, description="Every limit holds everywhere.")


class AnalysisSummary(Accepted):
    """One line of the list of analyses."""

    status: Verdict | None = Field(description="Whether every limit holds; null until it is done.")
    violated: list[str] = Field([], description="The limits that do not hold.")


class ProfileAnalysisSummary(Accepted):
    """One line of the list of measured profiles."""

    status: Literal["read"] | None = Field(description="null until it is done.")
    dimensions: dict[str, float] = Field(
        {}, description="Base radius, stroke, … as read: name and unit."
    )


def _files() -> Iterator[ResourceFile]:
    for part, formats in DESIGN_FORMATS.items():
        for exporter in formats.values():
            name = f"{part}{exporter.extension}"
            path = f"{part}.{exporter.name}"
            yield file_of(write_design, exporter, path, download_name=name)
    for exporter in PICTURES.values():
        if exporter.name != REPORT:
            yield file_of(write_design, exporter, exporter.name)


DESIGNS = Resource(
    path="/v1/designs",
    tag="designs",
    file_tag="files",
    noun="design",
    id_name="design_id",
    spec=DesignSpec,
    answer=Design,
    summary=DesignSummary,
    id_of=design_id,
    task=None,
    unknown=ProblemType.UNKNOWN_DESIGN,
    title="Synthesise a cam",
    text="""Chooses base radius, offset and spline laws together and proves that every limit holds.

    Infeasible is a result (status `infeasible`, with the conflict), not an error. The same spec
    gives the same id and the same bytes.
    """,
    answer_text="Dimensions, motion, extremes, certificate, report and links.",
    status=Status,
    elsewhere=design_of_item,
    files=tuple(_files()),
    marks_broken_limits=True,
    own_delete=True,
)
ANALYSES = Resource(
    path="/v1/analyses",
    tag="analyses",
    noun="analysis",
    id_name="analysis_id",
    spec=DesignSpec,
    answer=Analysis,
    summary=AnalysisSummary,
    id_of=lambda spec: question_id(spec, "analysis"),
    task=analyse_cam,
    unknown=ProblemType.UNKNOWN_ANALYSIS,
    title="Analyse a given cam",
    text="""Extremes of all curves, each limit with its margin, jumps, undercut, and what helps.

    The laws, the base radius and the offset must be given; what is left free is a problem (422).
    A limit that is broken is a result, not an error: `holds` is false, `violated` names it,
    `extremes` says by how much and where, `remedy` which size would help. The same spec gives the
    same bytes. Its pictures and its report are at `/v1/analyses/{id}/motion.svg`, `contact.svg`, …;
    for files of points, send the same spec to `POST /v1/designs`.
    """,
    answer_text="As `POST /v1/analyses` answered, or would have without `respond-async`.",
    status=Verdict,
    files=tuple(
        file_of(
            write_picture, exporter, name, "analysis_",
            title=f"{exporter.title}, of an analysis", purpose="", in_worker=True,
        )
        for name, exporter in DRAWINGS.items()
    ),
    marks_broken_limits=True,
)  # fmt: skip
PROFILE_ANALYSES = Resource(
    path="/v1/profile-analyses",
    tag="analyses",
    noun="profile analysis",
    id_name="analysis_id",
    spec=MeasuredCam,
    answer=ProfileAnalysis,
    summary=ProfileAnalysisSummary,
    id_of=lambda cam: question_id(cam, "profile analysis"),
    task=analyse_profile,
    unknown=ProblemType.UNKNOWN_ANALYSIS,
    title="Read the motion back from a measured profile",
    text="""Displacement, velocity, acceleration, jerk and pressure angle that a real cam gives.

    The profile is smoothed as far as the points' own scatter and the tolerance allow; then the
    follower rides on it, held off by whatever stands out farthest. `peaks` says what the tolerance
    may hide of each derivative, `unreached_hollows` names the hollows that are too narrow
    for the roller, `contact_off_face` where contact leaves a flat face. Points that are no closed
    curve round the cam's axis are a problem (422) that names the place.
    """,
    answer_text="As `POST /v1/profile-analyses` answered, or would have without `respond-async`.",
    budget_of=lambda _: None,
)
