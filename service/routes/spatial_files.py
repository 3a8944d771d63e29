"""/v1/spatial-cams/{id}/developed.svg, …: a path for each of the files of spatial cams."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import asdict
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.documentation import in_parts, problems
from service.routes.download import Download, in_thread
from service.routes.files import ON_WORKERS, by_worker, schema_of
from service.routes.kept import done
from service.solve import spatial_file
from service.state import Parts
from synthesis.exporters import form
from synthesis.spatial.files import FORMATS, Format

router = APIRouter(prefix="/v1/spatial-cams/{cam_id}", tags=["spatial cams"])


def _handler(name: str, exporter: Format) -> Callable[..., Awaitable[Response]]:
    query = form(exporter.options)

    async def handler(
        request: Request,
        cam_id: str,
        parts: Parts,
        options: Annotated[query, Query()],  # type: ignore[valid-type]
    ) -> Response:
        wanted = exporter.options(**dict(options))
        row, design = await done(parts.spatial_cams, cam_id)
        ending = f"not-certified-{name}" if row.status == "infeasible" else name
        work = partial(spatial_file, design, exporter, wanted)
        make = partial(by_worker, parts, work) if exporter.apart else in_thread(work)
        made_by = (name, repr(asdict(wanted)))
        return await Download(ending, exporter.media_type).sent(request, row, made_by, make)

    # texts of annotations would be looked up where ``query`` is unknown
    handler.__annotations__["options"] = Annotated[query, Query()]
    return handler


for _name, _exporter in FORMATS.items():
    _content = {_exporter.media_type.partition(";")[0]: {"schema": schema_of(_exporter)}}
    router.add_api_route(
        f"/{_name}",
        _handler(_name, _exporter),
        name=f"get_spatial_cam_{_name.replace('.', '_')}",
        summary=f"{_exporter.title}, of a spatial cam",
        description=_exporter.purpose,
        response_class=Response,
        responses={
            **in_parts(description=_exporter.title, content=_content),
            **problems(404, 409, 422, *(ON_WORKERS if _exporter.apart else ())),
        },
    )
