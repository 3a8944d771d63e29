"""Every kept resource as a record: what is asked and answered, which worker task, which files."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field

from service.resources.resource import Accepted, Resource, ResourceFile, StatusOrNone
from service.storage.tables import AnswerRow
from service.sweeps.store import design_of_item
from service.wire.errors import ProblemType
from service.workers import tasks
from service.workers.tasks import DESIGN_FORMATS, write_file
from synthesis.design.analysis import Analysis
from synthesis.design.cam_set import CamSet
from synthesis.design.design import Design, Status
from synthesis.design.warnings import Severity
from synthesis.exporters import (
    DRAWINGS,
    MOTION_FORMATS,
    PICTURES,
    PROFILE_FORMATS,
    MotionOptions,
    Options,
    ProfileOptions,
)
from synthesis.exporters.bundle import MEDIA_TYPE, BundleOptions, bundle
from synthesis.exporters.diagrams.timing import timing_diagram
from synthesis.exporters.exporter import FileFormat
from synthesis.exporters.options import ChordTolerance
from synthesis.machines.dynamics import TrainResponse, TrainSpec
from synthesis.machines.dynamics.files import TRAIN_FILES
from synthesis.machines.linkages import LINKAGES, Linkage
from synthesis.machines.linkages.files import LINKAGE_FILES
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files import FORMATS
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.spec.cam_set import CamSetSpec
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
    severity: Severity = Field("none", description="That of the worst warning.")


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


DESIGNS = Resource(
    path="/v1/designs",
    tag="designs",
    file_tag="files",
    noun="design",
    id_name="design_id",
    spec=DesignSpec,
    answer=Design,
    summary=DesignSummary,
    task=None,
    unknown=ProblemType.UNKNOWN_DESIGN,
    title="Synthesise a cam",
    text="""Chooses base radius, offset and spline laws together and proves that every limit holds.

    That nothing fits is a result, not an error: status `infeasible` where it is proven over all
    that was asked, `unsolved` where no cam was found; both with the conflict.
    """,
    answer_text="Dimensions, motion, extremes, certificate, report and links.",
    status=Status,
    elsewhere=design_of_item,
    noun_in_id=False,
    files=(
        *(
            ResourceFile(each, write_design, f"{part}.{name}", ending=f"{part}{each.extension}")
            for part, formats in DESIGN_FORMATS.items()
            for name, each in formats.items()
        ),
        *(ResourceFile(PICTURES[name], write_design, name) for name in PICTURES if name != REPORT),
    ),
    marks_broken_limits=True,
    own_delete=True,
)


class DesignToProve(BaseModel):
    """A finished design, whose proof file is to be written: as JSON, with its name."""

    name: str
    design: str


def proof_question(row: AnswerRow, design: bytes) -> DesignToProve:
    """What the proof of a design is an answer to."""
    return DesignToProve(name=row.name, design=design.decode())


# Not a collection of its own: its answers are files of designs, kept as answers are.
PROOFS = Resource(
    path="/v1/designs/proof.json",
    tag="files",
    noun="proof",
    id_name="design_id",
    spec=DesignToProve,
    answer=Design,
    summary=Accepted,
    task=tasks.prove_design,
    unknown=ProblemType.UNKNOWN_DESIGN,
    title="Proof that anyone can check",
    text="",
)
ANALYSES = Resource(
    path="/v1/analyses",
    tag="analyses",
    noun="analysis",
    id_name="analysis_id",
    spec=DesignSpec,
    answer=Analysis,
    summary=AnalysisSummary,
    task=tasks.analyse_cam,
    unknown=ProblemType.UNKNOWN_ANALYSIS,
    title="Analyse a given cam",
    text="""Extremes of all curves, each limit with its margin, jumps, undercut, and what helps.

    The laws, the base radius and the offset must be given; what is left free is a problem (422).
    A limit that is broken is a result, not an error: `holds` is false, `violated` names it,
    `extremes` says by how much and where, `remedy` which size would help.
    Its pictures and its report are at `/v1/analyses/{id}/motion.svg`, `contact.svg`, …;
    for files of points, send the same spec to `POST /v1/designs`.
    """,
    status=Verdict,
    files=tuple(
        ResourceFile(
            replace(
                each, title=f"{each.title}, of an analysis", purpose="The same of a given cam.",
                in_worker=True,
            ),
            tasks.write_picture, name, "analysis_",
        )
        for name, each in DRAWINGS.items()
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
    task=tasks.analyse_profile,
    unknown=ProblemType.UNKNOWN_ANALYSIS,
    title="Read the motion back from a measured profile",
    text="""Displacement, velocity, acceleration, jerk and pressure angle that a real cam gives.

    The profile is smoothed as far as the points' own scatter and the tolerance allow; then the
    follower rides on it, held off by whatever stands out farthest. `peaks` says what the tolerance
    may hide of each derivative, `unreached_hollows` names the hollows that are too narrow
    for the roller, `contact_off_face` where contact leaves a flat face. Points that are no closed
    curve round the cam's axis are a problem (422) that names the place.
    """,
)


# In an archive, which may hold fifty cams.
MAX_POINTS_PER_DEGREE = 10.0
MIN_TOLERANCE_UM = 0.1

Density = Annotated[float, Field(gt=0.0, le=MAX_POINTS_PER_DEGREE)]


class CamSetSummary(Accepted):
    """One line of the list of cam sets."""

    status: Status | None = Field(description="The worst of its cams'.")
    cams: int | None = Field(None, description="How many cams; null until it is done.")
    solved: int | None = Field(None, description="For how many a cam was found.")


@dataclass(frozen=True)
class BundleQuery(Options):
    """What goes into the archive."""

    profile: Annotated[
        tuple[Literal[tuple(PROFILE_FORMATS)], ...],  # type: ignore[valid-type]
        Field(max_length=20, description="Formats of the profiles; may be repeated."),
    ] = BundleOptions().profile_formats
    motion: Annotated[
        tuple[Literal[tuple(MOTION_FORMATS)], ...],  # type: ignore[valid-type]
        Field(max_length=20, description="Formats of the motions; may be repeated."),
    ] = BundleOptions().motion_formats
    curve: Literal["profile", "pitch"] = "profile"
    """The cams' profiles, all flanks of each, or the rollers' paths."""
    points_per_degree: Density = ProfileOptions().points_per_degree
    """Points of profiles per degree of cam angle."""
    tolerance_um: Annotated[ChordTolerance, Field(ge=MIN_TOLERANCE_UM)] = None
    motion_points_per_degree: Density = MotionOptions().points_per_degree
    """Rows of motions per degree of cam angle."""


def _bundle(cams: CamSet, query: BundleQuery) -> bytes:
    profile = ProfileOptions(query.points_per_degree, query.tolerance_um, curve=query.curve)
    motion = MotionOptions(query.motion_points_per_degree)
    return bundle(cams, BundleOptions(query.profile, query.motion, profile, motion))


_TIMING = FileFormat[CamSet, Any](
    "timing.svg", "Timing diagram", "image/svg+xml", ".svg",
    lambda cams, _: timing_diagram(cams), Options,
    "The displacement of every follower over shaft angle, and how many move together.",
)  # fmt: skip
_BUNDLE = FileFormat[CamSet, Any](
    "bundle.zip", "All files in one archive", MEDIA_TYPE, ".zip", _bundle, BundleQuery,
    "Profiles in the cams' own frames and in the shaft's, motions, timing, and a manifest.\n\n"
    "A ZIP archive with a folder for each cam; `manifest.json` lists every file with its SHA-256 "
    "and says how the cams sit on the shaft. The same set and options give the same bytes.",
)  # fmt: skip
_NO_CAM_OF_SET = "No cam of this set fits its limits: see conflict in the designs."
_write_cams = partial(write_file, CamSet, attrgetter("has_cams"), _NO_CAM_OF_SET)
CAM_SETS = Resource(
    path="/v1/cam-sets",
    tag="cam sets",
    noun="cam set",
    id_name="set_id",
    spec=CamSetSpec,
    answer=CamSet,
    summary=CamSetSummary,
    task=tasks.solve_cam_set,
    unknown=ProblemType.UNKNOWN_CAM_SET,
    title="Synthesise the cams of a shaft",
    text="""Designs each cam as `POST /v1/designs` does, and puts them on the shaft by their phases.

    `turn_deg` says how a cam is turned on the shaft, `keyway_deg` where its keyway is; `timing`
    says what happens when and which followers move together. The cams share the time budget. The
    set's status is the worst of its cams'.
    """,
    answer_text="Every cam with its design and its place on the shaft, the timing, and links.",
    status=Status,
    files=(
        ResourceFile(_TIMING, _write_cams, _TIMING.name),
        ResourceFile(_BUNDLE, _write_cams, _BUNDLE.name, made_by=zlib.ZLIB_RUNTIME_VERSION),
    ),
)  # fmt: skip


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


_NO_WALLS = "No cam fits these limits, so that there is none to draw."
_write_cam = partial(write_file, SpatialDesign, attrgetter("motion"), _NO_WALLS)
SPATIAL_CAMS = Resource(
    path="/v1/spatial-cams",
    tag="spatial cams",
    noun="spatial cam",
    id_name="cam_id",
    spec=SpatialCamSpec,
    answer=SpatialDesign,
    summary=SpatialCamSummary,
    task=tasks.solve_spatial_cam,
    unknown=ProblemType.UNKNOWN_SPATIAL_CAM,
    title="Design a spatial cam",
    text="""The walls that the rollers of a turret leave of a cam, and what they do.

    `walls` says which side of which roller meets the cam when, `extremes` what was measured of
    them: value, cam angle, roller, side and place on the roller's axis. A wall that is undercut
    makes the cam `infeasible`: a result, not an error.
    """,
    answer_text="Dimensions, motion, walls, extremes, certificate, report and links.",
    status=Status,
    files=tuple(
        ResourceFile(each, _write_cam, name, "spatial_cam_") for name, each in FORMATS.items()
    ),
    marks_broken_limits=True,
)


def _linkages(linkage: Linkage) -> Resource:
    whose = f"of a {linkage.noun}"
    prefix = f"{linkage.name.replace('-', '_').removesuffix('s')}_"
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
            task=partial(tasks.solve_linkage, linkage.name),
        unknown=ProblemType.UNKNOWN_LINKAGE,
        title=linkage.title,
        text=linkage.purpose,
        answer_text="The answer, with links to its files.",
        status=Status,
        files=tuple(
            ResourceFile(replace(each, title=f"{each.title}, {whose}"), write, name, prefix)
            for name, each in LINKAGE_FILES[linkage.name].items()
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
    task=tasks.compute_train_response,
    unknown=ProblemType.UNKNOWN_TRAIN_RESPONSE,
    title="Respond to a cam with an elastic follower train",
    text="""Residual vibration in each dwell, contact force, loss of contact; exact but rounding.

    The train is a chain of masses, springs and dampers that the cam drives through the first link.
    Its periodic response and its way there from rest are computed mode by mode in closed form. The
    cam's own limits are its spec's; a law without residual vibration: the limit
    `residual_vibration`.
    """,
    files=tuple(ResourceFile(each, _write_response, each.name, "train_") for each in TRAIN_FILES),
)


ALL = (
    DESIGNS, CAM_SETS, ANALYSES, PROFILE_ANALYSES, SPATIAL_CAMS, TRAIN_RESPONSES,
    *LINKAGE_RESOURCES,
)  # fmt: skip
RESOURCES: Mapping[str, Resource] = MappingProxyType({each.path: each for each in ALL})
