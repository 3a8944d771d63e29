"""Cursors of lists, and times from the store."""

from __future__ import annotations

from datetime import UTC, datetime

from service.wire.errors import ProblemType


def position_of(cursor: str) -> int:
    """The sequence number of the row that a cursor continues after: the cursor itself."""
    if cursor.isascii() and cursor.isdecimal() and len(cursor) < 19:
        return int(cursor)
    raise ProblemType.INVALID_PARAMETER(
        "cursor: not one that this service gave. Take `next` of the page before."
    )


def in_utc(moment: datetime | None) -> datetime | None:
    """A time from the store; SQLite keeps none with a zone."""
    return moment.replace(tzinfo=UTC) if moment and moment.tzinfo is None else moment
