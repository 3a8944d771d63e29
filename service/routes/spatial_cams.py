"""/v1/spatial-cams: cams whose rollers' axes do not lie along the cam's."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.documentation import problems, spec_body
from service.examples import SPATIAL_CAMS
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
from service.views import SpatialCamPage
from synthesis.spatial.design import SpatialDesign

router = APIRouter(prefix="/v1/spatial-cams", tags=["spatial cams"])


@router.post(
    "",
    response_model=SpatialDesign,
    responses=CREATED,
    openapi_extra=spec_body(SPATIAL_CAMS, "SpatialCamSpec"),
    summary="Design a spatial cam",
)
async def create_spatial_cam(
    request: Request, parts: Parts, prefer: Prefer = "", idempotency_key: Key = None
) -> Response:
    """The walls that the rollers of a turret leave of a cam, and what they do.

    `walls` says which side of which roller meets the cam when, `extremes` what was measured of
    them: value, cam angle, roller, side and place on the roller's axis. A wall that is undercut
    makes the cam `infeasible`: a result, not an error. The same spec gives the same id.
    """
    return await created(request, parts, parts.spatial_cams, prefer, idempotency_key)


@router.get("", response_model=SpatialCamPage, responses=problems(422), summary="List spatial cams")
async def list_spatial_cams(
    parts: Parts,
    limit: Annotated[PageSize, Query(description="Spatial cams on a page.")] = 50,
    cursor: Cursor = None,
    status: WithStatus = None,
) -> SpatialCamPage:
    """The newest first."""
    return await listed(parts.spatial_cams, SpatialCamPage, limit, cursor, status)


@router.get(
    "/{cam_id}",
    response_model=SpatialDesign,
    responses=SHOWN,
    summary="A spatial cam",
)
async def get_spatial_cam(
    request: Request, cam_id: str, parts: Parts, if_none_match: KnownTag = None
) -> Response:
    """Dimensions, motion, walls, extremes, certificate, report and links.

    202 while it is being worked on; where it failed, the problem that the work ended with.
    """
    return await shown(request, parts.spatial_cams, cam_id)


@router.delete(
    "/{cam_id}", status_code=204, responses=problems(404), summary="Forget a spatial cam"
)
async def delete_spatial_cam(cam_id: str, parts: Parts) -> None:
    """One being worked on is stopped; a finished one is discarded."""
    await forgotten(parts.spatial_cams, cam_id)
