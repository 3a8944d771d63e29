"""/v1/spatial-cams/{id}/flanks.ibl, body.stl, …: a path for each of the files of spatial cams."""

from __future__ import annotations

from functools import partial
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.routes.files import Handler, add, sent
from service.routes.kept import done
from service.solve import spatial_file
from service.state import Parts
from synthesis.exporters import form
from synthesis.spatial.files import FORMATS, Format

router = APIRouter(prefix="/v1/spatial-cams/{cam_id}", tags=["spatial cams"])


def _handler(name: str, exporter: Format) -> Handler:
    query = form(exporter.options)
    part = name.removesuffix(exporter.extension)

    async def handler(
        request: Request,
        cam_id: str,
        parts: Parts,
        options: Annotated[query, Query()],  # type: ignore[valid-type]
    ) -> Response:
        wanted = exporter.options(**dict(options))
        row, design = await done(parts.spatial_cams, cam_id)
        work = partial(spatial_file, design, exporter, wanted)
        return await sent(request, parts, row, part, exporter, wanted, work)

    # texts of annotations would be looked up where ``query`` is unknown
    handler.__annotations__["options"] = Annotated[query, Query()]
    return handler


for _name, _exporter in FORMATS.items():
    add(router, _name, _exporter, _handler(_name, _exporter), of="spatial_cam_")
