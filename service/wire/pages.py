"""Cursors of lists, and times from the store."""

from __future__ import annotations

import base64
import binascii
from datetime import UTC, datetime

from service.wire.errors import ProblemType


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


def in_utc(moment: datetime | None) -> datetime | None:
    """A time from the store; SQLite keeps none with a zone."""
    return moment.replace(tzinfo=UTC) if moment and moment.tzinfo is None else moment
