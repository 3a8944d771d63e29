"""How stored designs look on the wire."""

from __future__ import annotations

import base64
import binascii
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Annotated, Literal

from pydantic import BaseModel, Field

from service.errors import BadQuery
from service.links import links_of
from service.store import DesignRow
from synthesis.design import Status

State = Literal["accepted", "done", "failed"]


class Accepted(BaseModel):
    """A design that is waiting or being worked on."""

    id: Annotated[str, Field(description="The id that the design will have.")]
    name: Annotated[str, Field(description="As in the spec.")]
    state: Annotated[State, Field(description="`accepted` until it is done or failed.")]
    created: Annotated[datetime, Field(description="When it was accepted, UTC.")]
    links: Annotated[dict[str, str], Field(description="Where to ask again.")]


class DesignSummary(Accepted):
    """One line of the list."""

    status: Annotated[Status | None, Field(description="What came out; null until it is done.")]
    dimensions: Annotated[
        dict[str, float], Field(description="Base radius, offset, …: name and unit.")
    ] = {}
    objective: Annotated[str | None, Field(description="What was made small.")] = None
    value: Annotated[float | None, Field(description="How small it became.")] = None
    gap: Annotated[float | None, Field(description="Relative distance to the bound.")] = None
    certified: Annotated[bool | None, Field(description="Every limit holds everywhere.")] = None


class DesignPage(BaseModel):
    """Designs, the newest first."""

    items: Annotated[list[DesignSummary], Field(description="The newest first.")]
    next: Annotated[str | None, Field(description="`cursor` of the next page; null at the end.")]


def accepted(row: DesignRow) -> Accepted:
    """A design under way."""
    summary = row.summary or {}
    links = links_of(row.id, has_cam=bool(summary.get("dimensions")))
    state: State = row.state  # type: ignore[assignment]
    return Accepted(id=row.id, name=row.name, state=state, created=_utc(row), links=links)


def page_of(rows: Sequence[DesignRow], following: str | None) -> DesignPage:
    """One page of the list."""
    items = [
        DesignSummary.model_validate(
            {**accepted(row).model_dump(), "status": row.status, **row.summary}
        )
        for row in rows
    ]
    return DesignPage(items=items, next=following)


def cursor_of(row: DesignRow) -> str:
    """A cursor that continues after this row."""
    return base64.urlsafe_b64encode(str(row.sequence).encode()).decode().rstrip("=")


def position_of(cursor: str) -> int:
    """The row that a cursor continues after."""
    try:
        text = base64.urlsafe_b64decode((cursor + "=" * (-len(cursor) % 4)).encode()).decode()
        if text.isascii() and text.isdecimal() and len(text) < 19:
            return int(text)
    except (binascii.Error, ValueError):
        pass
    raise BadQuery("cursor: not one that this service gave. Take `next` of the page before.")


def _utc(row: DesignRow) -> datetime:
    return row.created if row.created.tzinfo else row.created.replace(tzinfo=UTC)
