"""/v1/cam-sets: several cams on one shaft, their timing, and all files in one archive."""

from __future__ import annotations

import zlib
from functools import partial
from operator import attrgetter
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from service.resources.resource import Accepted, Resource, file_of
from service.wire.errors import ProblemType
from service.workers.tasks import solve_cam_set, write_file
from synthesis.design.cam_set import CamSet, set_id
from synthesis.design.design import Status
from synthesis.exporters import (
    MOTION_FORMATS,
    PROFILE_FORMATS,
    MotionOptions,
    Options,
    ProfileOptions,
)
from synthesis.exporters.bundle import MEDIA_TYPE, BundleOptions, bundle
from synthesis.exporters.diagrams.timing import timing_diagram
from synthesis.exporters.exporter import FileFormat
from synthesis.exporters.options import ChordTolerance
from synthesis.spec.cam_set import CamSetSpec

# In an archive, which may hold fifty cams.
MAX_POINTS_PER_DEGREE = 10.0
MIN_TOLERANCE_UM = 0.1

Density = Annotated[float, Field(gt=0.0, le=MAX_POINTS_PER_DEGREE)]


class CamSetSummary(Accepted):
    """One line of the list of cam sets."""

    status: Status | None = Field(description="The worst of its cams'.")
    cams: int | None = Field(None, description="How many cams; null until it is done.")
    solved: int | None = Field(None, description="For how many a cam was found.")


class BundleQuery(BaseModel):
    """What goes into the archive."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    profile: list[Literal[tuple(PROFILE_FORMATS)]] = Field(  # type: ignore[valid-type]
        list(BundleOptions().profile_formats),
        max_length=20,
        description="Formats of the profiles; may be repeated.",
    )
    motion: list[Literal[tuple(MOTION_FORMATS)]] = Field(  # type: ignore[valid-type]
        list(BundleOptions().motion_formats),
        max_length=20,
        description="Formats of the motions; may be repeated.",
    )
    curve: Literal["profile", "pitch"] = Field(
        "profile", description="The cams' profiles, all flanks of each, or the rollers' paths."
    )
    points_per_degree: Density = Field(
        ProfileOptions().points_per_degree,
        description="Points of profiles per degree of cam angle.",
    )
    tolerance_um: Annotated[ChordTolerance, Field(ge=MIN_TOLERANCE_UM)] = None
    motion_points_per_degree: Density = Field(
        MotionOptions().points_per_degree, description="Rows of motions per degree of cam angle."
    )

    def options(self) -> BundleOptions:
        """The same, as the core takes it."""
        return BundleOptions(
            tuple(self.profile),
            tuple(self.motion),
            ProfileOptions(self.points_per_degree, self.tolerance_um, curve=self.curve),
            MotionOptions(self.motion_points_per_degree),
        )


_TIMING = FileFormat[CamSet, Any](
    "timing.svg", "Timing diagram", "image/svg+xml", ".svg",
    lambda cams, _: timing_diagram(cams), Options,
    "The displacement of every follower over shaft angle, and how many move together.",
)  # fmt: skip
_BUNDLE = FileFormat[CamSet, Any](
    "bundle.zip", "All files in one archive", MEDIA_TYPE, ".zip", bundle, Options,
    "Profiles in the cams' own frames and in the shaft's, motions, timing, and a manifest.\n\n"
    "A ZIP archive with a folder for each cam; `manifest.json` lists every file with its SHA-256 "
    "and says how the cams sit on the shaft. The same set and options give the same bytes.",
)  # fmt: skip
_NO_CAM = "No cam of this set fits its limits: see conflict in the designs."
_write = partial(write_file, CamSet, attrgetter("has_cams"), _NO_CAM)
CAM_SETS = Resource(
    path="/v1/cam-sets",
    tag="cam sets",
    noun="cam set",
    id_name="set_id",
    spec=CamSetSpec,
    answer=CamSet,
    summary=CamSetSummary,
    id_of=set_id,
    task=solve_cam_set,
    unknown=ProblemType.UNKNOWN_CAM_SET,
    title="Synthesise the cams of a shaft",
    text="""Designs each cam as `POST /v1/designs` does, and puts them on the shaft by their phases.

    `turn_deg` says how a cam is turned on the shaft, `keyway_deg` where its keyway is; `timing`
    says what happens when and which followers move together. The cams share the time budget. The
    set's status is the worst of its cams'. The same spec gives the same id and the same bytes.
    """,
    answer_text="Every cam with its design and its place on the shaft, the timing, and links.",
    status=Status,
    files=(
        file_of(_write, _TIMING, _TIMING.name),
        file_of(
            _write, _BUNDLE, _BUNDLE.name, query=BundleQuery, options_of=BundleQuery.options,
            made_by=zlib.ZLIB_RUNTIME_VERSION,
        ),
    ),
)  # fmt: skip
