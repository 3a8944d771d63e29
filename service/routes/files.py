"""/v1/designs/{id}/profile.* and motion.*: one path for each format of the registries."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from service.documentation import in_parts, problems
from service.errors import NothingFits
from service.routes.download import ChordTolerance, Download
from service.routes.kept import done
from service.state import Parts, State
from service.store import Row
from synthesis.design import Design
from synthesis.exporters import (
    MOTION_FORMATS,
    PROFILE_FORMATS,
    CurveName,
    Exporter,
    MotionOptions,
    ProfileOptions,
)  # fmt: skip
from synthesis.exporters.theme import Theme

router = APIRouter(prefix="/v1/designs/{design_id}", tags=["files"])
MAX_POINTS_PER_DEGREE = 100.0
MIN_TOLERANCE_UM = 0.01

Density = Annotated[
    float,
    Field(gt=0.0, le=MAX_POINTS_PER_DEGREE, description="Points per degree of cam angle."),
]
Colours = Annotated[
    Theme,
    Field(
        description="Of drawings: `auto` is light, and dark on a screen that asks for it; `print` "
        "is black on white. Files of points have no colours."
    ),
]


class ProfileQuery(BaseModel):
    """How the curve is sampled."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    points_per_degree: Density = ProfileOptions().points_per_degree
    tolerance_um: Annotated[ChordTolerance, Field(ge=MIN_TOLERANCE_UM)] = None
    curve: Annotated[
        CurveName,
        Field(
            description="The cam's profile, or the path of the roller's centre. A groove has an "
            "inner and an outer profile, conjugate cams a main and a counter profile and a "
            "counter pitch curve; `profile` is the first of them. The drawing (svg) shows all."
        ),
    ] = "profile"
    turn_deg: Annotated[
        float,
        Field(
            ge=-360.0,
            le=360.0,
            description="Turn the points about the cam's axis by this angle, counter-clockwise "
            "positive: the cam as it sits on a shaft. The drawing (svg) stays as it is.",
        ),
    ] = 0.0
    z_mm: Annotated[
        float | None,
        Field(
            ge=-1e6,
            le=1e6,
            description="Position along the axis: the third column of point files (0 where it is "
            "left out), and a column z_mm of tables.",
        ),
    ] = None
    theme: Colours = "auto"


class MotionQuery(BaseModel):
    """How the motion is sampled."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    points_per_degree: Density = MotionOptions().points_per_degree
    theme: Colours = "auto"


async def file_of(
    request: Request, parts: State, name: str, part: str, exporter: Exporter[Any], options: Any
) -> Response:
    """The file of a finished design, made in a thread, or 304."""
    row, design = await done(parts.designs, name)
    file = Download(f"{named(part, row)}{exporter.extension}", exporter.media_type)
    made_by = (part, exporter.name, repr(asdict(options)))
    return await file.sent(request, row, made_by, partial(_written, design, exporter, options))


def _written(design: bytes, exporter: Exporter[Any], options: Any) -> bytes:
    finished = Design.model_validate_json(design)
    if not (finished.motion or exporter.without_cam):
        raise NothingFits("No cam fits these limits: see conflict in the design for what would.")
    return exporter.write(finished, options)


def named(part: str, row: Row) -> str:
    """A cam that is given and breaks its limits may be looked at, but its files say so."""
    return f"not-certified-{part}" if row.status == "infeasible" else part


def _profile(exporter: Exporter[ProfileOptions]) -> Callable[..., Awaitable[Response]]:
    async def handler(
        request: Request, design_id: str, parts: Parts, options: Annotated[ProfileQuery, Query()]
    ) -> Response:
        wanted = ProfileOptions(**options.model_dump())
        return await file_of(request, parts, design_id, "profile", exporter, wanted)

    return handler


def _motion(exporter: Exporter[MotionOptions]) -> Callable[..., Awaitable[Response]]:
    async def handler(
        request: Request, design_id: str, parts: Parts, options: Annotated[MotionQuery, Query()]
    ) -> Response:
        wanted = MotionOptions(**options.model_dump())
        return await file_of(request, parts, design_id, "motion", exporter, wanted)

    return handler


def _add(part: str, exporter: Exporter[Any], handler: Callable[..., Awaitable[Response]]) -> None:
    content = {exporter.media_type.partition(";")[0]: {"schema": _schema(exporter)}}
    router.add_api_route(
        f"/{part}.{exporter.name}",
        handler,
        name=f"get_{part}_{exporter.name}",
        summary=f"{part.capitalize()}: {exporter.title}",
        response_class=Response,
        responses={
            **in_parts(description=exporter.title, content=content),
            **problems(404, 409, 422),
        },
    )  # fmt: skip


def _schema(exporter: Exporter[Any]) -> dict[str, str]:
    return {"type": "object"} if exporter.media_type == "application/json" else {"type": "string"}


for _exporter in PROFILE_FORMATS.values():
    _add("profile", _exporter, _profile(_exporter))
for _exporter_of_motion in MOTION_FORMATS.values():
    _add("motion", _exporter_of_motion, _motion(_exporter_of_motion))
