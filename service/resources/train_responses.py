"""/v1/train-responses: what an elastic follower train does on a cam."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from service.resources.resource import Resource, ResourceFile
from service.resources.views import TrainResponsePage
from service.wire.errors import UnknownTrainResponse
from service.wire.links import train_links
from service.workers.tasks import compute_train_response
from synthesis.catalogue.fields import Speed
from synthesis.design.identity import question_id
from synthesis.exporters import Made
from synthesis.exporters.drawing.theme import Theme
from synthesis.machines.dynamics import TrainResponse, TrainSpec
from synthesis.machines.dynamics.files.train_csv import (
    MEDIA_TYPE,
    TrainOptions,
    polydyne_csv,
    response_csv,
)
from synthesis.machines.dynamics.files.train_diagrams import response_svg, spectrum_svg

MAX_TURNS, MAX_POINTS_PER_DEGREE = 20, 20.0
SVG = "image/svg+xml"


class SpeedQuery(BaseModel):
    """Which speed is drawn."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    speed_rpm: Annotated[
        Speed | None, Field(description="Any speed; left out, that of the cam's own spec.")
    ] = None

    def options(self) -> TrainOptions:
        """The same, as the core takes it."""
        return TrainOptions(**self.model_dump(exclude={"theme"}))


class PictureQuery(SpeedQuery):
    """How a response is drawn."""

    theme: Annotated[Theme, Field(description="Colours of the picture.")] = "auto"


class PolydyneQuery(SpeedQuery):
    """How close the rows of a table are."""

    points_per_degree: Annotated[
        float,
        Field(gt=0.0, le=MAX_POINTS_PER_DEGREE, description="At least so many rows per degree."),
    ] = TrainOptions().points_per_degree


class TableQuery(PolydyneQuery):
    """What of a response is written as a table."""

    turns: Annotated[
        int, Field(ge=0, le=MAX_TURNS, description="Turns from rest; 0: the periodic response.")
    ] = 0


def _made(write: Callable[[TrainResponse, Any], bytes], body: bytes, query: Any) -> Made:
    return Made(write(TrainResponse.model_validate_json(body), query))


def _file(
    path: str,
    media_type: str,
    query: type[SpeedQuery],
    write: Callable[[TrainResponse, Any], bytes],
    title: str,
    purpose: str,
) -> ResourceFile:
    return ResourceFile(
        path=path, operation=f"train_{path.replace('.', '_')}", title=title, purpose=purpose,
        media_type=media_type, query=query, make=partial(_made, write), download_name=path,
    )  # fmt: skip


TRAIN_RESPONSES = Resource(
    path="/v1/train-responses",
    tag="follower trains",
    noun="train response",
    plural="train responses",
    id_name="train_id",
    spec=TrainSpec,
    answer=TrainResponse,
    page=TrainResponsePage,
    examples="train-responses",
    id_of=lambda spec: question_id(spec, "train response"),
    task=compute_train_response,
    links=lambda id, _: train_links(id),
    unknown=UnknownTrainResponse,
    title="Respond to a cam with an elastic follower train",
    text="""Residual vibration in each dwell, contact force, loss of contact; exact but rounding.

    The train is a chain of masses, springs and dampers that the cam drives through the first link.
    Its periodic response and its way there from rest are computed mode by mode in closed form. The
    cam's own limits are its spec's; a law without residual vibration: the limit
    `residual_vibration`. The same spec gives the same bytes.
    """,
    answer_text="As `POST /v1/train-responses` answered, or would have without `respond-async`.",
    files=(
        _file(
            "response.csv", MEDIA_TYPE, TableQuery,
            lambda found, query: response_csv(found, query.options()),
            "The response as a table",
            "Motion of the cam and of every mass, contact force; a cam angle twice where it hits.",
        ),
        _file(
            "response.svg", SVG, PictureQuery,
            lambda found, query: response_svg(found, query.options(), query.theme),
            "The response as diagrams",
            "Output, its error and acceleration, and the contact force over the cam angle.",
        ),
        _file(
            "spectrum.svg", SVG, PictureQuery,
            lambda found, query: spectrum_svg(found, query.speed_rpm, query.theme),
            "Residual spectrum of the cam's moves",
            "What every natural frequency would be left swinging with, and the train's own ones.",
        ),
        _file(
            "polydyne.csv", MEDIA_TYPE, PolydyneQuery,
            lambda found, query: polydyne_csv(found, query.options()),
            "The cam motion for a given output motion",
            "A polydyne cam: its motion makes the last mass move as the spec's cam would have it, "
            "exactly, at one speed. It takes 2n + 1 continuous derivatives of that motion for n "
            "masses, and no dampers in the links; 422 says what is missing.",
        ),
    ),
)  # fmt: skip
