"""What is kept by id is asked for, looked at and forgotten in one way, whatever its kind."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Annotated, Any, TypeVar

from fastapi import Header, Query, Request, Response

from service.contract.documentation import UNDER_WAY_HEADERS, problems, tagged
from service.resources.jobs import Jobs, finished
from service.resources.resource import Resource
from service.resources.views import Accepted, Page, accepted, position_of
from service.state import State
from service.storage.store import Row
from service.wire.body import read_body
from service.wire.errors import BadQuery, KeyReused, NotDone, ServiceError
from service.wire.etag import unchanged
from service.wire.problem import respond
from synthesis.design import Status

UNDER_WAY: Mapping[int | str, dict[str, Any]] = {
    202: {
        "model": Accepted,
        "description": "Being worked on; ask again.",
        "headers": UNDER_WAY_HEADERS,
    }
}
CREATED = {
    200: tagged()[200],
    **UNDER_WAY,
    **problems(400, 409, 413, 415, 422, 429, 500, 503, 504),
}
SHOWN = {**tagged(), **UNDER_WAY, **problems(404, 422, 500, 503, 504)}
Prefer = Annotated[
    str, Header(description="`respond-async`: answer 202 at once and work on it meanwhile.")
]
Key = Annotated[
    str | None,
    Header(
        min_length=1,
        max_length=255,
        description="The same key and body within 24 h give the same answer; "
        "the same key with another body is refused.",
    ),
]
PageSize = Annotated[int, Query(ge=1, le=200)]
Cursor = Annotated[str | None, Query(description="`next` of the page before.")]
WithStatus = Annotated[Status | None, Query(description="Only those with this status.")]
Listed = TypeVar("Listed", bound=Page[Any])
KnownTag = Annotated[str | None, Header(description="ETag that you have; answers 304 if current.")]


async def created(
    request: Request, parts: State, jobs: Jobs, prefer: str, key: str | None
) -> Response:
    """The answer to the question in a request's body, or 202 where that is preferred."""
    spec = await read_body(request, jobs.kind.spec)
    name = await name_by_key(parts, jobs.kind.name_of(spec), key, await request.body())
    row = await jobs.answers.find(name)
    if row is None or row.state != "done":
        if "respond-async" in prefer.lower():
            return _under_way(jobs.kind, await jobs.accept(spec), applied=True)
        row = await finished(jobs.start(spec))
    return _done(jobs.kind, row)


async def shown(request: Request, jobs: Jobs, name: str) -> Response:
    """What came out; 202 while it is being worked on; the problem where it failed."""
    row = await known(jobs, name)
    if row.state == "accepted":
        return _under_way(jobs.kind, row)
    if row.problem is not None and row.state == "failed":
        return respond(request, row.problem)
    return unchanged(request, row.etag or "") or _done(jobs.kind, row)


async def listed(
    jobs: Jobs, page: type[Listed], limit: int, cursor: str | None, status: str | None = None
) -> Listed:
    """A page of the list, the newest first."""
    before = None if cursor is None else position_of(cursor)
    rows = await jobs.answers.page(before, limit + 1, status)
    return page.of(jobs.kind, rows, limit)


async def forgotten(jobs: Jobs, name: str) -> None:
    """Stop it or discard it."""
    if not await jobs.dismiss(name):
        raise unknown(jobs.kind, name)


async def known(jobs: Jobs, name: str) -> Row:
    """The row with this id, or the kind's error for what is unknown."""
    row = await jobs.answers.find(name)
    if row is None:
        raise unknown(jobs.kind, name)
    return row


async def done(jobs: Jobs, name: str) -> tuple[Row, bytes]:
    """The row with this id and its answer, or NotDone."""
    row = await known(jobs, name)
    if row.state != "done" or row.design is None:
        noun, path = jobs.kind.noun.capitalize(), jobs.kind.at(name)
        raise NotDone(f"{noun} {name} is {row.state}: GET {path} says how it stands.")
    return row, row.design


def unknown(kind: Resource, name: str) -> ServiceError:
    """The error for an id that leads nowhere."""
    return kind.unknown(
        f"There is no {kind.noun} {name[:64]!r}. GET {kind.path} lists those there are; "
        "POST the spec again to make it anew."
    )


async def name_by_key(parts: State, name: str, key: str | None, body: bytes) -> str:
    """The answer's id: what the key stands for, if one was given."""
    if key is None:
        return name
    if not key.isprintable():
        raise BadQuery("Idempotency-Key: use printable characters only.")
    body_hash = hashlib.sha256(body).hexdigest()
    row = await parts.store.key(key, body_hash, name)
    if row.body_hash != body_hash:
        raise KeyReused(
            f"Idempotency-Key {key!r} came with another body before. Use a new key for a new body."
        )
    return row.design_id


def _done(kind: Resource, row: Row) -> Response:
    headers = {"ETag": f'"{row.etag}"', "Content-Location": kind.at(row.id)}
    return Response(row.design, 200, headers, "application/json")


def _under_way(kind: Resource, row: Row, applied: bool = False) -> Response:
    headers = {"Location": kind.at(row.id), "Retry-After": "1"}
    if applied:
        headers["Preference-Applied"] = "respond-async"
    return Response(accepted(kind, row).model_dump_json(), 202, headers, "application/json")
