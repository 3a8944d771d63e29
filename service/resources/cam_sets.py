"""/v1/cam-sets: several cams on one shaft, their timing, and all files in one archive."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Collection
from functools import partial
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from service.resources.resource import Accepted, Resource, ResourceFile
from service.wire.errors import ProblemType
from service.workers.tasks import solve_cam_set
from synthesis.design.cam_set import CamSet, set_id
from synthesis.design.design import Status
from synthesis.exporters import (
    MOTION_FORMATS,
    PROFILE_FORMATS,
    FileContent,
    MotionOptions,
    ProfileOptions,
)
from synthesis.exporters.bundle import MEDIA_TYPE, BundleOptions, bundle
from synthesis.exporters.diagrams.timing import timing_diagram
from synthesis.exporters.options import ChordTolerance
from synthesis.spec.cam_set import CamSetSpec

# In an archive, which may hold fifty cams.
MAX_POINTS_PER_DEGREE = 10.0
MIN_TOLERANCE_UM = 0.1

Density = Annotated[float, Field(gt=0.0, le=MAX_POINTS_PER_DEGREE)]


def _among(known: Collection[str]) -> tuple[AfterValidator, FieldInfo]:
    """Checks and describes a list of formats."""

    def check(names: list[str]) -> list[str]:
        for name in names:
            if name not in known:
                raise PydanticCustomError(
                    "unknown_format",
                    "{value} is not one of {known}. Name some of these; repeat it for several.",
                    {"value": name, "known": ", ".join(known)},
                )
        return names

    schema: dict[str, Any] = {"items": {"type": "string", "enum": list(known)}}
    return AfterValidator(check), Field(max_length=20, json_schema_extra=schema)


class CamSetSummary(Accepted):
    """One line of the list of cam sets."""

    status: Status | None = Field(description="The worst of its cams'.")
    cams: int | None = Field(None, description="How many cams; null until it is done.")
    solved: int | None = Field(None, description="For how many a cam was found.")


class NoOptions(BaseModel):
    """There is nothing to choose."""

    model_config = ConfigDict(extra="forbid")


class BundleQuery(BaseModel):
    """What goes into the archive."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    profile: Annotated[
        list[str],
        *_among(PROFILE_FORMATS),
        Field(description="Formats of the profiles; may be repeated."),
    ] = list(BundleOptions().profile_formats)
    motion: Annotated[
        list[str],
        *_among(MOTION_FORMATS),
        Field(description="Formats of the motions; may be repeated."),
    ] = list(BundleOptions().motion_formats)
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


def _file(write: Callable[[CamSet, Any], bytes], body: bytes, options: Any) -> FileContent:
    cams = CamSet.model_validate_json(body)
    if not cams.has_cams:
        raise ProblemType.NOTHING_FITS(
            "No cam of this set fits its limits: see conflict in the designs."
        )
    return FileContent(write(cams, options))


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
        ResourceFile(
            path="timing.svg", operation="timing_svg", title="Timing diagram",
            purpose="The displacement of every follower over shaft angle, and how many move "
            "together.",
            media_type="image/svg+xml", query=NoOptions, download_name="timing.svg",
            make=partial(_file, lambda cams, _: timing_diagram(cams)),
        ),
        ResourceFile(
            path="bundle.zip", operation="bundle_zip", title="All files in one archive",
            purpose="Profiles in the cams' own frames and in the shaft's, motions, timing, and a "
            "manifest.\n\nA ZIP archive with a folder for each cam; `manifest.json` lists every "
            "file with its SHA-256 and says how the cams sit on the shaft. The same set and "
            "options give the same bytes.",
            media_type=MEDIA_TYPE, query=BundleQuery, options_of=BundleQuery.options,
            download_name="bundle.zip", make=partial(_file, bundle),
            made_by=zlib.ZLIB_RUNTIME_VERSION,
        ),
    ),
)  # fmt: skip
