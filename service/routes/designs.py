"""/v1/designs: ask for a cam, look at it, list them, forget it."""

from __future__ import annotations

import hashlib
from typing import Annotated, Any

from fastapi import APIRouter, Header, Query, Request, Response

from service.body import read_body
from service.documentation import UNDER_WAY_HEADERS, problems, spec_body, tagged
from service.errors import BadQuery, KeyReused, UnknownDesign
from service.etag import unchanged
from service.jobs import finished
from service.problem import respond
from service.state import Parts, State
from service.store import DesignRow
from service.views import Accepted, DesignPage, accepted, cursor_of, page_of, position_of
from synthesis.design import Design, Status, design_id
from synthesis.spec import DesignSpec

router = APIRouter(prefix="/v1/designs", tags=["designs"])
UNDER_WAY: dict[int | str, dict[str, Any]] = {
    202: {
        "model": Accepted,
        "description": "Being worked on; ask again.",
        "headers": UNDER_WAY_HEADERS,
    }
}

Prefer = Annotated[
    str, Header(description="`respond-async`: answer 202 at once and work on it meanwhile.")
]
Key = Annotated[
    str | None,
    Header(
        min_length=1,
        max_length=255,
        description="The same key and body within 24 h give the same design; "
        "the same key with another body is refused.",
    ),
]
KnownTag = Annotated[str | None, Header(description="ETag that you have; answers 304 if current.")]


@router.post(
    "",
    response_model=Design,
    responses={
        200: tagged()[200],
        **UNDER_WAY,
        **problems(400, 409, 413, 415, 422, 429, 500, 503, 504),
    },
    openapi_extra=spec_body(),
    summary="Synthesise a cam",
)
async def create_design(
    request: Request, parts: Parts, prefer: Prefer = "", idempotency_key: Key = None
) -> Response:
    """Picks base radius, offset and spline laws together and proves that every limit holds.

    Infeasible is a result (status `infeasible`, with the conflict), not an error. The same spec
    gives the same id and the same bytes.
    """
    spec = await read_body(request, DesignSpec)
    name = await _name(parts, spec, idempotency_key, await request.body())
    row = await parts.store.find(name)
    if row is None or row.state != "done":
        if "respond-async" in prefer.lower():
            return _under_way(await parts.jobs.accept(spec), applied=True)
        row = await finished(parts.jobs.start(spec))
    return _done(row)


@router.get("", response_model=DesignPage, responses=problems(422), summary="List designs")
async def list_designs(
    parts: Parts,
    limit: Annotated[int, Query(ge=1, le=200, description="Designs on a page.")] = 50,
    cursor: Annotated[str | None, Query(description="`next` of the page before.")] = None,
    status: Annotated[Status | None, Query(description="Only those with this status.")] = None,
) -> DesignPage:
    """The newest first."""
    before = None if cursor is None else position_of(cursor)
    rows = await parts.store.page(before, limit + 1, status)
    return page_of(rows[:limit], cursor_of(rows[limit - 1]) if len(rows) > limit else None)


@router.get(
    "/{design_id}",
    response_model=Design,
    responses={**tagged(), **UNDER_WAY, **problems(404, 500, 503, 504)},
    summary="A design",
)
async def get_design(
    request: Request, design_id: str, parts: Parts, if_none_match: KnownTag = None
) -> Response:
    """Dimensions, motion, extremes, certificate, report and links.

    202 while it is being worked on; where it failed, the problem that the work ended with.
    """
    row = await known(parts, design_id)
    if row.state == "accepted":
        return _under_way(row)
    if row.problem is not None and row.state == "failed":
        return respond(request, row.problem)
    return unchanged(request, row.etag or "") or _done(row)


@router.delete("/{design_id}", status_code=204, responses=problems(404), summary="Forget a design")
async def delete_design(design_id: str, parts: Parts) -> None:
    """A design being worked on is stopped; a finished one is discarded."""
    if not await parts.jobs.dismiss(design_id):
        raise unknown(design_id)


async def known(parts: State, name: str) -> DesignRow:
    """The design with this id, or UnknownDesign."""
    row = await parts.store.find(name)
    if row is None:
        raise unknown(name)
    return row


def unknown(name: str) -> UnknownDesign:
    """The error for an id that leads nowhere."""
    return UnknownDesign(
        f"There is no design {name[:64]!r}. GET /v1/designs lists those there are; "
        "POST the spec again to make it anew."
    )


async def _name(parts: State, spec: DesignSpec, key: str | None, body: bytes) -> str:
    """The design's id: what the key stands for, if one was given."""
    if key is None:
        return design_id(spec)
    if not key.isprintable():
        raise BadQuery("Idempotency-Key: use printable characters only.")
    body_hash = hashlib.sha256(body).hexdigest()
    row = await parts.store.key(key, body_hash, design_id(spec))
    if row.body_hash != body_hash:
        raise KeyReused(
            f"Idempotency-Key {key!r} came with another body before. Use a new key for a new body."
        )
    return row.design_id


def _done(row: DesignRow) -> Response:
    headers = {"ETag": f'"{row.etag}"', "Content-Location": f"/v1/designs/{row.id}"}
    return Response(row.design, 200, headers, "application/json")


def _under_way(row: DesignRow, applied: bool = False) -> Response:
    headers = {"Location": f"/v1/designs/{row.id}", "Retry-After": "1"}
    if applied:
        headers["Preference-Applied"] = "respond-async"
    return Response(accepted(row).model_dump_json(), 202, headers, "application/json")
