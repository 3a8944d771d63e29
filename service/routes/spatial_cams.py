"""/v1/spatial-cams: cams whose rollers' axes do not lie along the cam's."""

from __future__ import annotations

from fastapi import APIRouter

from service.contract.documentation import spec_body
from service.contract.examples import SPATIAL_CAMS
from service.resources.views import SpatialCamPage
from service.routes.collection import STOPPED, WAITING, Kept, Said, declare
from service.routes.kept import WithStatus
from synthesis.spatial.design import SpatialDesign

router = APIRouter(prefix="/v1/spatial-cams", tags=["spatial cams"])

CREATE = Said(
    "Design a spatial cam",
    """The walls that the rollers of a turret leave of a cam, and what they do.

    `walls` says which side of which roller meets the cam when, `extremes` what was measured of
    them: value, cam angle, roller, side and place on the roller's axis. A wall that is undercut
    makes the cam `infeasible`: a result, not an error. The same spec gives the same id.
    """,
)
declare(
    router,
    Kept(
        jobs=lambda parts: parts.spatial_cams,
        one="spatial_cam",
        many="spatial_cams",
        id="cam_id",
        found=SpatialDesign,
        page=SpatialCamPage,
        on_page="Spatial cams on a page.",
        body=spec_body(SPATIAL_CAMS, "SpatialCamSpec"),
        status=WithStatus,
    ),
    create=CREATE,
    list="List spatial cams",
    get=Said(
        "A spatial cam",
        f"Dimensions, motion, walls, extremes, certificate, report and links.\n\n{WAITING}",
    ),
    delete=Said("Forget a spatial cam", f"One {STOPPED}"),
)
