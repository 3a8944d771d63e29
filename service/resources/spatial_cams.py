"""/v1/spatial-cams: cams whose rollers' axes do not lie along the cam's."""

from __future__ import annotations

from functools import partial

from service.resources.resource import Resource, file_of
from service.resources.views import SpatialCamPage
from service.wire.errors import ProblemType
from service.wire.links import spatial_links
from service.workers.tasks import solve_spatial_cam, spatial_file
from synthesis.design.design import Status
from synthesis.machines.spatial.design import SpatialDesign, spatial_design_id
from synthesis.machines.spatial.files import FORMATS
from synthesis.machines.spatial.spec import SpatialCamSpec

SPATIAL_CAMS = Resource(
    path="/v1/spatial-cams",
    tag="spatial cams",
    noun="spatial cam",
    plural="spatial cams",
    id_name="cam_id",
    spec=SpatialCamSpec,
    answer=SpatialDesign,
    page=SpatialCamPage,
    examples="spatial-cams",
    id_of=spatial_design_id,
    task=solve_spatial_cam,
    links=lambda id, summary: spatial_links(
        id, summary.get("machine", ""), has_cam=bool(summary.get("dimensions"))
    ),
    unknown=ProblemType.UNKNOWN_SPATIAL_CAM,
    title="Design a spatial cam",
    text="""The walls that the rollers of a turret leave of a cam, and what they do.

    `walls` says which side of which roller meets the cam when, `extremes` what was measured of
    them: value, cam angle, roller, side and place on the roller's axis. A wall that is undercut
    makes the cam `infeasible`: a result, not an error. The same spec gives the same id.
    """,
    answer_text="Dimensions, motion, walls, extremes, certificate, report and links.",
    status=Status,
    budget_of=lambda _: None,
    files=tuple(
        file_of(
            exporter, name, f"spatial_cam_{name.replace('.', '_')}", partial(spatial_file, exporter)
        )
        for name, exporter in FORMATS.items()
    ),
    marks_broken_limits=True,
)
