"""/v1/spatial-cams/{id}/flanks.ibl, body.stl, …: a path for each of the files of spatial cams."""

from __future__ import annotations

from functools import partial
from typing import Any

from fastapi import APIRouter, Request, Response

from service.routes.files import ON_WORKERS, sent
from service.routes.kept import done
from service.routes.offering import Offer, offer
from service.state import State
from service.workers.solve import spatial_file
from synthesis.spatial.files import FORMATS, Format

router = APIRouter(prefix="/v1/spatial-cams/{cam_id}", tags=["spatial cams"])


async def _file(
    part: str, exporter: Format, request: Request, parts: State, name: str, options: Any
) -> Response:
    row, design = await done(parts.spatial_cams, name)
    work = partial(spatial_file, design, exporter, options)
    return await sent(request, parts, row, part, exporter, options, work)


for _name, _exporter in FORMATS.items():
    _offered = Offer(
        _exporter,
        f"/{_name}",
        f"get_spatial_cam_{_name.replace('.', '_')}",
        _exporter.purpose,
        statuses=ON_WORKERS if _exporter.apart else (),
    )
    _part = _name.removesuffix(_exporter.extension)
    offer(router, _offered, "cam_id", partial(_file, _part, _exporter))
