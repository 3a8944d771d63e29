"""Receive a body of limited size, and have it read where it holds up nobody."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, TypeVar

from fastapi import Request
from pydantic import BaseModel

from service.wire.errors import ProblemType
from service.wire.tracing import span
from service.wire.validation import Question, read_question

READ_ON = 32  # times the limit: so much of a refused body is read, so that clients see the answer
# Bytes that are read in the event loop, in 1 to 3 ms where they are a usual spec. No body of this
# size takes 50 ms; the transfer to a reader and back takes half a millisecond.
SHORT = 2048


T = TypeVar("T")


class Readers(Protocol):
    """Processes that do some work outside of the event loop."""

    async def run(self, work: Callable[..., T], *arguments: Any) -> T:
        """What a function makes of its arguments there."""


async def receive_body(request: Request, max_bytes: int) -> bytes:
    """The body of a request; ServiceError where it is too large, or not declared as JSON."""
    chunks, size = [], 0
    async for chunk in request.stream():
        size += len(chunk)
        if size > READ_ON * max_bytes:
            break
        chunks.append(chunk if size <= max_bytes else b"")
    if size > max_bytes:
        raise ProblemType.BODY_TOO_LARGE(
            f"The body is larger than {max_bytes} bytes, the limit of this server. "
            "A design with 100 segments needs less than 50 kB."
        )
    declared = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    subtype = declared.removeprefix("application/")
    if declared == subtype or not (subtype == "json" or subtype.endswith("+json")):
        raise ProblemType.WRONG_MEDIA_TYPE(
            f"Content-Type is {declared[:80]!r}. Send the design with "
            "Content-Type: application/json.",
            {"Accept": "application/json"},
        )
    return b"".join(chunks)


async def read_body(
    request: Request, readers: Readers, model: type[BaseModel], max_bytes: int
) -> tuple[Question, bytes]:
    """The question in a request, and its bytes; ServiceError where they are none of ``model``."""
    body = await receive_body(request, max_bytes)
    with span("validation"):
        if len(body) <= SHORT:
            return read_question(body, model), body
        return await readers.run(read_question, body, model), body
