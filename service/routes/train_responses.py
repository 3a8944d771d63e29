"""/v1/train-responses: what an elastic follower train does on a cam."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from service.contract.documentation import in_parts, problems, spec_body
from service.contract.examples import TRAINS
from service.resources.views import TrainResponsePage
from service.routes.collection import STOPPED, WAITING, Kept, Said, declare
from service.routes.download import SVG, Download, in_thread
from service.routes.kept import KnownTag, done
from service.state import Parts
from synthesis.dynamics import TrainResponse
from synthesis.exporters import Made
from synthesis.exporters.diagrams.train import response_svg, spectrum_svg
from synthesis.exporters.drawing.theme import Theme
from synthesis.exporters.tables.train_csv import (
    MEDIA_TYPE,
    TrainOptions,
    polydyne_csv,
    response_csv,
)
from synthesis.fields import Speed

router = APIRouter(prefix="/v1/train-responses", tags=["follower trains"])
MOST_TURNS, MOST_POINTS = 20, 20.0


class AtSpeed(BaseModel):
    """Which speed is drawn."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    speed_rpm: Annotated[
        Speed | None, Field(description="Any speed; left out, that of the cam's own spec.")
    ] = None

    def options(self) -> TrainOptions:
        """The same, as the core takes it."""
        return TrainOptions(**self.model_dump(exclude={"theme"}))


class Pictured(AtSpeed):
    """How a response is drawn."""

    theme: Annotated[Theme, Field(description="Colours of the picture.")] = "auto"


class Dense(AtSpeed):
    """How close the rows of a table are."""

    points_per_degree: Annotated[
        float, Field(gt=0.0, le=MOST_POINTS, description="At least so many rows per degree.")
    ] = TrainOptions().points_per_degree


class Tabled(Dense):
    """What of a response is written as a table."""

    turns: Annotated[
        int, Field(ge=0, le=MOST_TURNS, description="Turns from rest; 0: the periodic response.")
    ] = 0


CREATE = Said(
    "Respond to a cam with an elastic follower train",
    """Residual vibration in every dwell, contact force, loss of contact; exact but for rounding.

    The train is a chain of masses, springs and dampers that the cam drives through the first link.
    Its periodic response and its way there from rest are computed mode by mode in closed form. The
    cam's own limits are its spec's; a law without residual vibration: the limit
    `residual_vibration`. The same spec gives the same bytes.
    """,
)
declare(
    router,
    Kept(
        jobs=lambda parts: parts.train_responses,
        one="train_response",
        many="train_responses",
        id="train_id",
        found=TrainResponse,
        page=TrainResponsePage,
        on_page="Responses on a page.",
        body=spec_body(TRAINS, "TrainSpec"),
    ),
    create=CREATE,
    list="List train responses",
    get=Said(
        "A train response",
        "As `POST /v1/train-responses` answered, or would have without `respond-async`.\n\n"
        + WAITING,
    ),
    delete=Said("Forget a train response", f"One {STOPPED}"),
)


@dataclass(frozen=True)
class File:
    """A file of a response: how it is called, what may be asked of it, and how it is written."""

    download: Download
    title: str
    told: str
    query: type[AtSpeed]
    write: Callable[[TrainResponse, Any], bytes]


FILES = (
    File(
        Download("response.csv", MEDIA_TYPE), "The response as a table",
        "Motion of the cam and of every mass, contact force; a cam angle twice where it hits.",
        Tabled, lambda found, asked: response_csv(found, asked.options()),
    ),
    File(
        Download("response.svg", SVG), "The response as diagrams",
        "Output, its error and acceleration, and the contact force over the cam angle.",
        Pictured, lambda found, asked: response_svg(found, asked.options(), asked.theme),
    ),
    File(
        Download("spectrum.svg", SVG), "Residual spectrum of the cam's moves",
        "What every natural frequency would be left swinging with, and the train's own ones.",
        Pictured, lambda found, asked: spectrum_svg(found, asked.speed_rpm, asked.theme),
    ),
    File(
        Download("polydyne.csv", MEDIA_TYPE), "The cam motion that moves the output as asked",
        "A polydyne cam: its motion makes the last mass move as the spec's cam would have it, "
        "exactly, at one speed. It takes 2n + 1 continuous derivatives of that motion for n "
        "masses, and no dampers in the links; 422 says what is missing.",
        Dense, lambda found, asked: polydyne_csv(found, asked.options()),
    ),
)  # fmt: skip


def _handler(file: File) -> Callable[..., Awaitable[Response]]:
    async def handler(
        request: Request,
        train_id: str,
        parts: Parts,
        wanted: Annotated[file.query, Query()],  # type: ignore[name-defined]
        if_none_match: KnownTag = None,
    ) -> Response:
        row, body = await done(parts.train_responses, train_id)
        make = in_thread(partial(_made, body, file, wanted))
        made_by = (file.download.ending, repr(wanted))
        return await file.download.sent(request, row, made_by, make)

    # texts of annotations would be looked up where ``file`` is unknown
    handler.__annotations__["wanted"] = Annotated[file.query, Query()]
    return handler


def _made(body: bytes, file: File, wanted: AtSpeed) -> Made:
    return Made(file.write(TrainResponse.model_validate_json(body), wanted))


for _file in FILES:
    _content = {_file.download.media_type.partition(";")[0]: {"schema": {"type": "string"}}}
    router.add_api_route(
        f"/{{train_id}}/{_file.download.ending}",
        _handler(_file),
        name=f"get_train_{_file.download.ending.replace('.', '_')}",
        summary=_file.title,
        description=_file.told,
        response_class=Response,
        responses={
            **in_parts(description=_file.title, content=_content),
            **problems(404, 409, 422),
        },
    )
