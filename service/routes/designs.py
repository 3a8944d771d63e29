"""/v1/designs: ask for a cam, look at it, list them, forget it."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.documentation import problems, spec_body
from service.routes.kept import (
    CREATED,
    SHOWN,
    Cursor,
    Key,
    KnownTag,
    PageSize,
    Prefer,
    WithStatus,
    created,
    forgotten,
    listed,
    shown,
)  # fmt: skip
from service.state import Parts
from service.views import DesignPage
from synthesis.design import Design

router = APIRouter(prefix="/v1/designs", tags=["designs"])


@router.post(
    "",
    response_model=Design,
    responses=CREATED,
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
    return await created(request, parts, parts.designs, prefer, idempotency_key)


@router.get("", response_model=DesignPage, responses=problems(422), summary="List designs")
async def list_designs(
    parts: Parts,
    limit: Annotated[PageSize, Query(description="Designs on a page.")] = 50,
    cursor: Cursor = None,
    status: WithStatus = None,
) -> DesignPage:
    """The newest first."""
    return await listed(parts.designs, DesignPage, limit, cursor, status)


@router.get(
    "/{design_id}",
    response_model=Design,
    responses=SHOWN,
    summary="A design",
)
async def get_design(
    request: Request, design_id: str, parts: Parts, if_none_match: KnownTag = None
) -> Response:
    """Dimensions, motion, extremes, certificate, report and links.

    202 while it is being worked on; where it failed, the problem that the work ended with.
    """
    return await shown(request, parts.designs, design_id)


@router.delete("/{design_id}", status_code=204, responses=problems(404), summary="Forget a design")
async def delete_design(design_id: str, parts: Parts) -> None:
    """A design being worked on is stopped; a finished one is discarded."""
    await forgotten(parts.designs, design_id)
