"""/v1/cam-sets: several cams on one shaft, their timing, and all files in one archive."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Collection
from dataclasses import asdict
from functools import partial
from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request, Response
from pydantic import AfterValidator, BaseModel, ConfigDict, Field
from pydantic.config import JsonDict
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from service.contract.documentation import in_parts, problems, spec_body
from service.contract.examples import CAM_SETS
from service.resources.views import CamSetPage
from service.routes.collection import STOPPED, WAITING, Kept, Said, declare
from service.routes.download import SVG, Download, in_thread
from service.routes.kept import KnownTag, WithStatus, done
from service.state import Parts, State
from service.wire.errors import NothingFits
from synthesis.camset import CamSet
from synthesis.exporters import MOTION_FORMATS, PROFILE_FORMATS, Made, MotionOptions, ProfileOptions
from synthesis.exporters.bundle import MEDIA_TYPE, BundleOptions, bundle
from synthesis.exporters.diagrams.timing import timing_diagram
from synthesis.exporters.options import ChordTolerance

router = APIRouter(prefix="/v1/cam-sets", tags=["cam sets"])
MAX_POINTS_PER_DEGREE = 10.0  # in an archive, of which one may hold fifty cams
MIN_TOLERANCE_UM = 0.1
TIMING = Download("timing.svg", SVG)
BUNDLE = Download("bundle.zip", MEDIA_TYPE)

Density = Annotated[float, Field(gt=0.0, le=MAX_POINTS_PER_DEGREE)]


def _among(known: Collection[str]) -> tuple[AfterValidator, FieldInfo]:
    """Checks and describes a list of formats."""

    def checked(names: list[str]) -> list[str]:
        for name in names:
            if name not in known:
                raise PydanticCustomError(
                    "unknown_format",
                    "{value} is not one of {known}. Name some of these; repeat it for several.",
                    {"value": name, "known": ", ".join(known)},
                )
        return names

    told: JsonDict = {"items": {"type": "string", "enum": list(known)}}
    return AfterValidator(checked), Field(max_length=20, json_schema_extra=told)


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
    curve: Annotated[
        Literal["profile", "pitch"],
        Field(description="The cams' profiles, all flanks of each, or the rollers' paths."),
    ] = "profile"
    points_per_degree: Annotated[
        Density, Field(description="Points of profiles per degree of cam angle.")
    ] = ProfileOptions().points_per_degree
    tolerance_um: Annotated[ChordTolerance, Field(ge=MIN_TOLERANCE_UM)] = None
    motion_points_per_degree: Annotated[
        Density, Field(description="Rows of motions per degree of cam angle.")
    ] = MotionOptions().points_per_degree

    def options(self) -> BundleOptions:
        """The same, as the core takes it."""
        return BundleOptions(
            tuple(self.profile),
            tuple(self.motion),
            ProfileOptions(self.points_per_degree, self.tolerance_um, curve=self.curve),
            MotionOptions(self.motion_points_per_degree),
        )


CREATE = Said(
    "Synthesise the cams of a shaft",
    """Designs every cam as `POST /v1/designs` does, and puts them on the shaft by their phases.

    `turn_deg` says how a cam is turned on the shaft, `keyway_deg` where its keyway is; `timing`
    says what happens when and which followers move together. The cams share the time budget. The
    set's status is the worst of its cams'. The same spec gives the same id and the same bytes.
    """,
)
declare(
    router,
    Kept(
        jobs=lambda parts: parts.cam_sets,
        one="cam_set",
        many="cam_sets",
        id="set_id",
        found=CamSet,
        page=CamSetPage,
        on_page="Cam sets on a page.",
        body=spec_body(CAM_SETS, "CamSetSpec"),
        status=WithStatus,
    ),
    create=CREATE,
    list="List cam sets",
    get=Said(
        "A cam set",
        "Every cam with its design and its place on the shaft, the timing, and links.\n\n"
        + WAITING,
    ),
    delete=Said("Forget a cam set", f"A set {STOPPED}"),
)


@router.get(
    "/{set_id}/timing.svg",
    response_class=Response,
    responses={
        **in_parts(description="The diagram.", content={SVG: {"schema": {"type": "string"}}}),
        **problems(404, 409),
    },
    summary="Timing diagram",
)
async def get_timing_svg(
    request: Request, set_id: str, parts: Parts, if_none_match: KnownTag = None
) -> Response:
    """The displacement of every follower over shaft angle, and how many move together."""
    return await _file(request, parts, set_id, TIMING, timing_diagram)


@router.get(
    "/{set_id}/bundle.zip",
    response_class=Response,
    responses={
        **in_parts(
            description="The archive.",
            content={MEDIA_TYPE: {"schema": {"type": "string", "format": "binary"}}},
        ),
        **problems(404, 409, 422),
    },
    summary="All files in one archive",
)
async def get_bundle_zip(
    request: Request,
    set_id: str,
    parts: Parts,
    wanted: Annotated[BundleQuery, Query()],
    if_none_match: KnownTag = None,
) -> Response:
    """Profiles in the cams' own frames and in the shaft's, motions, timing, and a manifest.

    A ZIP archive with a folder for each cam; `manifest.json` lists every file with its SHA-256 and
    says how the cams sit on the shaft. The same set and options give the same bytes.
    """
    options = wanted.options()
    made_by = (repr(asdict(options)), zlib.ZLIB_RUNTIME_VERSION)  # both decide on the bytes

    def packed(cams: CamSet) -> bytes:
        return bundle(cams, options)

    return await _file(request, parts, set_id, BUNDLE, packed, *made_by)


async def _file(
    request: Request,
    parts: State,
    name: str,
    file: Download,
    write: Callable[[CamSet], bytes],
    *made_by: str,
) -> Response:
    """A file of a finished set, or 304."""
    row, body = await done(parts.cam_sets, name)
    return await file.sent(
        request, row, (file.ending, *made_by), in_thread(partial(_made, body, write))
    )


def _made(body: bytes, write: Callable[[CamSet], bytes]) -> Made:
    cams = CamSet.model_validate_json(body)
    if not cams.has_cams:
        raise NothingFits("No cam of this set fits its limits: see conflict in the designs.")
    return Made(write(cams))
