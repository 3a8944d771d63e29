"""/v1/spatial-cams/{id}/flanks.*, body.* and others: a path for each in the registry."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response

from service.routes.files import Handler, add, sent
from service.routes.kept import done
from service.solve import spatial_file_of
from service.state import Parts
from synthesis.exporters import form
from synthesis.exporters.exporter import FileFormat
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.files import SPATIAL_FILES

router = APIRouter(prefix="/v1/spatial-cams/{cam_id}", tags=["files of spatial cams"])


def _handler(exporter: FileFormat[SpatialDesign, Any]) -> Handler:
    query = form(exporter.options)
    part = exporter.name.removesuffix(exporter.extension)

    async def handler(
        request: Request,
        cam_id: str,
        parts: Parts,
        options: Annotated[query, Query()],  # type: ignore[valid-type]
    ) -> Response:
        wanted = exporter.options(**dict(options))
        row, design = await done(parts.spatial_cams, cam_id)
        work = partial(spatial_file_of, design, exporter, wanted)
        return await sent(request, parts, row, part, exporter, wanted, work)

    # texts of annotations would be looked up where ``query`` is unknown
    handler.__annotations__["options"] = Annotated[query, Query()]
    return handler


for _exporter in SPATIAL_FILES.values():
    add(router, _exporter.name, _exporter, _handler(_exporter))
