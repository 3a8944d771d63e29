"""/v1/profile-analyses: measured points of a profile back to motion."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.documentation import problems, spec_body
from service.examples import PROFILE_ANALYSES
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
from service.views import ProfileAnalysisPage
from synthesis.measured import ProfileAnalysis

router = APIRouter(prefix="/v1/profile-analyses", tags=["analyses"])


@router.post(
    "",
    response_model=ProfileAnalysis,
    responses=CREATED,
    openapi_extra=spec_body(PROFILE_ANALYSES, "MeasuredCam"),
    summary="Read the motion back from a measured profile",
)
async def create_profile_analysis(
    request: Request, parts: Parts, prefer: Prefer = "", idempotency_key: Key = None
) -> Response:
    """Displacement, velocity, acceleration, jerk and pressure angle that a real cam gives.

    The profile is smoothed as far as the points' own scatter and the tolerance allow; then the
    follower rides on it, held off by whatever stands out farthest. `peaks` says what the tolerance
    may hide of each derivative, `not_touched` names the hollows that are too narrow for the roller,
    `off_face` where contact leaves a flat face. Points that are no closed curve round the cam's
    axis are a problem (422) that names the place.
    """
    return await created(request, parts, parts.profile_analyses, prefer, idempotency_key)


@router.get(
    "",
    response_model=ProfileAnalysisPage,
    responses=problems(422),
    summary="List profiles that were read back",
)
async def list_profile_analyses(
    parts: Parts,
    limit: Annotated[PageSize, Query(description="Profiles on a page.")] = 50,
    cursor: Cursor = None,
) -> ProfileAnalysisPage:
    """The newest first."""
    return await listed(parts.profile_analyses, ProfileAnalysisPage, limit, cursor)


@router.get(
    "/{analysis_id}",
    response_model=ProfileAnalysis,
    responses=SHOWN,
    summary="A profile that was read back",
)
async def get_profile_analysis(
    request: Request, analysis_id: str, parts: Parts, if_none_match: KnownTag = None
) -> Response:
    """As `POST /v1/profile-analyses` answered, or would have without `respond-async`.

    202 while it is being worked on; where it failed, the problem that the work ended with.
    """
    return await shown(request, parts.profile_analyses, analysis_id)


@router.delete(
    "/{analysis_id}",
    status_code=204,
    responses=problems(404),
    summary="Forget a profile that was read back",
)
async def delete_profile_analysis(analysis_id: str, parts: Parts) -> None:
    """One being worked on is stopped; a finished one is discarded."""
    await forgotten(parts.profile_analyses, analysis_id)
