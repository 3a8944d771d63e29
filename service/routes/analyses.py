"""/v1/analyses: what a cam does that is given in full."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.documentation import problems, spec_body
from service.examples import ANALYSES
from service.routes.kept import (
    CREATED,
    SHOWN,
    Cursor,
    Key,
    KnownTag,
    PageSize,
    Prefer,
    created,
    forgotten,
    listed,
    shown,
)  # fmt: skip
from service.state import Parts
from service.views import AnalysisPage, Verdict
from synthesis.findings import Analysis

router = APIRouter(prefix="/v1/analyses", tags=["analyses"])


@router.post(
    "",
    response_model=Analysis,
    responses=CREATED,
    openapi_extra=spec_body(ANALYSES),
    summary="Analyse a given cam",
)
async def create_analysis(
    request: Request, parts: Parts, prefer: Prefer = "", idempotency_key: Key = None
) -> Response:
    """Extremes of every curve, every limit with its margin, jumps, undercut, and what mends it.

    The laws, the base radius and the offset must be given; what is left free is a problem (422).
    A limit that is broken is a result, not an error: `holds` is false, `broken` names it,
    `extremes` says by how much and where, `mend` which size would help. The same spec gives the
    same bytes. Its pictures and its report are at `/v1/analyses/{id}/motion.svg`, `contact.svg`, …;
    for files of points, send the same spec to `POST /v1/designs`.
    """
    return await created(request, parts, parts.analyses, prefer, idempotency_key)


@router.get("", response_model=AnalysisPage, responses=problems(422), summary="List analyses")
async def list_analyses(
    parts: Parts,
    limit: Annotated[PageSize, Query(description="Analyses on a page.")] = 50,
    cursor: Cursor = None,
    status: Annotated[Verdict | None, Query(description="Only those with this result.")] = None,
) -> AnalysisPage:
    """The newest first."""
    return await listed(parts.analyses, AnalysisPage, limit, cursor, status)


@router.get(
    "/{analysis_id}",
    response_model=Analysis,
    responses=SHOWN,
    summary="An analysis",
)
async def get_analysis(
    request: Request, analysis_id: str, parts: Parts, if_none_match: KnownTag = None
) -> Response:
    """As `POST /v1/analyses` answered, or would have without `respond-async`.

    202 while it is being worked on; where it failed, the problem that the work ended with.
    """
    return await shown(request, parts.analyses, analysis_id)


@router.delete(
    "/{analysis_id}", status_code=204, responses=problems(404), summary="Forget an analysis"
)
async def delete_analysis(analysis_id: str, parts: Parts) -> None:
    """An analysis being worked on is stopped; a finished one is discarded."""
    await forgotten(parts.analyses, analysis_id)
