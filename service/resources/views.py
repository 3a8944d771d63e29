"""How what is kept looks on the wire: one that is under way, and pages of lists."""

from __future__ import annotations

import base64
import binascii
from datetime import UTC, datetime
from typing import Annotated, Generic, Literal, TypeVar

from pydantic import BaseModel, Field

from service.wire.errors import ProblemType
from synthesis.design.design import Status

State = Literal["accepted", "done", "failed"]
Verdict = Literal["holds", "violated"]
StatusOrNone = Annotated[Status | None, Field(description="What came out; null until it is done.")]


class Accepted(BaseModel):
    """What is waiting or being worked on."""

    id: Annotated[str, Field(description="The id that the answer will have.")]
    name: Annotated[str, Field(description="As in the spec.")]
    state: Annotated[State, Field(description="`accepted` until it is done or failed.")]
    created: Annotated[datetime, Field(description="When it was accepted, UTC.")]
    links: Annotated[dict[str, str], Field(description="Where to ask again.")]


Summary = TypeVar("Summary", bound=Accepted)


class Page(BaseModel, Generic[Summary]):
    """Some lines of a list."""

    items: Annotated[list[Summary], Field(description="The newest first.")]
    next: Annotated[str | None, Field(description="`cursor` of the next page; null at the end.")]


class DesignSummary(Accepted):
    """One line of the list."""

    status: StatusOrNone
    dimensions: Annotated[
        dict[str, float], Field(description="Base radius, offset, …: name and unit.")
    ] = {}
    objective: Annotated[str | None, Field(description="What was minimised.")] = None
    value: Annotated[float | None, Field(description="The value that it reached.")] = None
    gap: Annotated[float | None, Field(description="Relative distance to the bound.")] = None
    certified: Annotated[bool | None, Field(description="Every limit holds everywhere.")] = None


class CamSetSummary(Accepted):
    """One line of the list of cam sets."""

    status: Annotated[Status | None, Field(description="The worst of its cams'.")]
    cams: Annotated[int | None, Field(description="How many cams; null until it is done.")] = None
    solved: Annotated[int | None, Field(description="For how many a cam was found.")] = None


class AnalysisSummary(Accepted):
    """One line of the list of analyses."""

    status: Annotated[
        Verdict | None, Field(description="Whether every limit holds; null until it is done.")
    ]
    violated: Annotated[list[str], Field(description="The limits that do not hold.")] = []


class ProfileAnalysisSummary(Accepted):
    """One line of the list of measured profiles."""

    status: Annotated[Literal["read"] | None, Field(description="null until it is done.")]
    dimensions: Annotated[
        dict[str, float], Field(description="Base radius, stroke, … as read: name and unit.")
    ] = {}


class SpatialCamSummary(Accepted):
    """One line of the list of spatial cams."""

    status: StatusOrNone
    machine: Annotated[str | None, Field(description="Kind of its machine.")] = None
    dimensions: Annotated[
        dict[str, float], Field(description="Centre distance, roller radius, …: name and unit.")
    ] = {}


class TrainResponseSummary(Accepted):
    """One line of the list of follower trains."""

    status: Annotated[Literal["computed"] | None, Field(description="null until it is done.")]
    modes_hz: Annotated[list[float], Field(description="Natural frequencies of the train.")] = []


class LinkageSummary(Accepted):
    """One line of a list of linkages."""

    status: StatusOrNone
    quantities: Annotated[
        dict[str, float], Field(description="Stroke, reach, …: name and unit.")
    ] = {}


class DesignPage(Page[DesignSummary]):
    """Designs, the newest first."""


class CamSetPage(Page[CamSetSummary]):
    """Cam sets, the newest first."""


class AnalysisPage(Page[AnalysisSummary]):
    """Analyses, the newest first."""


class ProfileAnalysisPage(Page[ProfileAnalysisSummary]):
    """Measured profiles, the newest first."""


class SpatialCamPage(Page[SpatialCamSummary]):
    """Spatial cams, the newest first."""


class TrainResponsePage(Page[TrainResponseSummary]):
    """Follower trains on their cams, the newest first."""


class LinkagePage(Page[LinkageSummary]):
    """Linkages of one kind, the newest first."""


def cursor_at(sequence: int) -> str:
    """A cursor that continues after the row with this sequence number."""
    return base64.urlsafe_b64encode(str(sequence).encode()).decode().rstrip("=")


def position_of(cursor: str) -> int:
    """The sequence number of the row that a cursor continues after."""
    try:
        text = base64.urlsafe_b64decode((cursor + "=" * (-len(cursor) % 4)).encode()).decode()
        if text.isascii() and text.isdecimal() and len(text) < 19:
            return int(text)
    except (binascii.Error, ValueError):
        pass
    raise ProblemType.INVALID_PARAMETER(
        "cursor: not one that this service gave. Take `next` of the page before."
    )


def in_utc(moment: datetime) -> datetime:
    """A time from the store; SQLite keeps none with a zone."""
    return moment if moment.tzinfo else moment.replace(tzinfo=UTC)
