"""/v1/train-responses: what an elastic follower train does on a cam."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from service.documentation import in_parts, problems, spec_body
from service.examples import TRAINS
from service.routes.download import SVG, Download, in_thread
from service.routes.kept import (
    CREATED,
    SHOWN,
    Cursor,
    Key,
    KnownTag,
    PageSize,
    Prefer,
    created,
    done,
    forgotten,
    listed,
    shown,
)  # fmt: skip
from service.state import Parts, State
from service.views import TrainResponsePage
from synthesis.dynamics import TrainResponse
from synthesis.exporters import Made
from synthesis.exporters.svg_train import response_svg, spectrum_svg
from synthesis.exporters.theme import Theme
from synthesis.exporters.train_csv import MEDIA_TYPE, TrainOptions, response_csv
from synthesis.fields import Speed

router = APIRouter(prefix="/v1/train-responses", tags=["follower trains"])
TABLE = Download("response.csv", MEDIA_TYPE)
RESPONSE = Download("response.svg", SVG)
SPECTRUM = Download("spectrum.svg", SVG)
MOST_TURNS, MOST_POINTS = 20, 20.0


class AtSpeed(BaseModel):
    """Which speed is drawn."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    speed_rpm: Annotated[
        Speed | None, Field(description="Any speed; left out, that of the cam's own spec.")
    ] = None


class Pictured(AtSpeed):
    """How a response is drawn."""

    theme: Annotated[Theme, Field(description="Colours of the picture.")] = "auto"


class Tabled(AtSpeed):
    """What of a response is written as a table."""

    turns: Annotated[
        int, Field(ge=0, le=MOST_TURNS, description="Turns from rest; 0: the periodic response.")
    ] = 0
    points_per_degree: Annotated[
        float, Field(gt=0.0, le=MOST_POINTS, description="At least so many rows per degree.")
    ] = TrainOptions().points_per_degree


@router.post(
    "",
    response_model=TrainResponse,
    responses=CREATED,
    openapi_extra=spec_body(TRAINS, "TrainSpec"),
    summary="Respond to a cam with an elastic follower train",
)
async def create_train_response(
    request: Request, parts: Parts, prefer: Prefer = "", idempotency_key: Key = None
) -> Response:
    """Residual vibration in every dwell, contact force, loss of contact; exact but for rounding.

    The train is a chain of masses, springs and dampers that the cam drives through the first link.
    Its periodic response and its way there from rest are computed mode by mode in closed form. The
    cam's own limits are its spec's; a law without residual vibration: the limit
    `residual_vibration`. The same spec gives the same bytes.
    """
    return await created(request, parts, parts.train_responses, prefer, idempotency_key)


@router.get(
    "", response_model=TrainResponsePage, responses=problems(422), summary="List train responses"
)
async def list_train_responses(
    parts: Parts,
    limit: Annotated[PageSize, Query(description="Responses on a page.")] = 50,
    cursor: Cursor = None,
) -> TrainResponsePage:
    """The newest first."""
    return await listed(parts.train_responses, TrainResponsePage, limit, cursor)


@router.get(
    "/{train_id}", response_model=TrainResponse, responses=SHOWN, summary="A train response"
)
async def get_train_response(
    request: Request, train_id: str, parts: Parts, if_none_match: KnownTag = None
) -> Response:
    """As `POST /v1/train-responses` answered, or would have without `respond-async`.

    202 while it is being worked on; where it failed, the problem that the work ended with.
    """
    return await shown(request, parts.train_responses, train_id)


@router.delete(
    "/{train_id}", status_code=204, responses=problems(404), summary="Forget a train response"
)
async def delete_train_response(train_id: str, parts: Parts) -> None:
    """One being worked on is stopped; a finished one is discarded."""
    await forgotten(parts.train_responses, train_id)


def _file(description: str, media_type: str) -> dict[int | str, dict[str, object]]:
    content = {media_type.partition(";")[0]: {"schema": {"type": "string"}}}
    return {**in_parts(description=description, content=content), **problems(404, 409, 422)}


@router.get(
    "/{train_id}/response.csv",
    response_class=Response,
    responses=_file("The table.", MEDIA_TYPE),
    summary="The response as a table",
)
async def get_train_response_csv(
    request: Request,
    train_id: str,
    parts: Parts,
    wanted: Annotated[Tabled, Query()],
    if_none_match: KnownTag = None,
) -> Response:
    """Motion of the cam and of every mass, contact force; a cam angle twice where it hits."""
    options = TrainOptions(wanted.speed_rpm, wanted.turns, wanted.points_per_degree)
    return await _sent(
        request, parts, train_id, TABLE, lambda found: response_csv(found, options), repr(options)
    )


@router.get(
    "/{train_id}/response.svg",
    response_class=Response,
    responses=_file("The diagrams.", SVG),
    summary="The response as diagrams",
)
async def get_train_response_svg(
    request: Request,
    train_id: str,
    parts: Parts,
    wanted: Annotated[Pictured, Query()],
    if_none_match: KnownTag = None,
) -> Response:
    """Output, its error and acceleration, and the contact force over the cam angle."""
    options, theme = TrainOptions(wanted.speed_rpm), wanted.theme
    return await _sent(
        request, parts, train_id, RESPONSE,
        lambda found: response_svg(found, options, theme), repr(options), theme,
    )  # fmt: skip


@router.get(
    "/{train_id}/spectrum.svg",
    response_class=Response,
    responses=_file("The spectrum.", SVG),
    summary="Residual spectrum of the cam's moves",
)
async def get_train_spectrum_svg(
    request: Request,
    train_id: str,
    parts: Parts,
    wanted: Annotated[Pictured, Query()],
    if_none_match: KnownTag = None,
) -> Response:
    """What every natural frequency would be left swinging with, and where the train's own are."""
    speed, theme = wanted.speed_rpm, wanted.theme
    return await _sent(
        request, parts, train_id, SPECTRUM,
        lambda found: spectrum_svg(found, speed, theme), repr(speed), theme,
    )  # fmt: skip


async def _sent(
    request: Request,
    parts: State,
    name: str,
    file: Download,
    write: Callable[[TrainResponse], bytes],
    *made_by: str,
) -> Response:
    """A file of a finished response, or 304."""
    row, body = await done(parts.train_responses, name)
    make = in_thread(partial(_made, body, write))
    return await file.sent(request, row, (file.ending, *made_by), make)


def _made(body: bytes, write: Callable[[TrainResponse], bytes]) -> Made:
    return Made(write(TrainResponse.model_validate_json(body)))
