"""/v1/designs/{id}/contact.svg, animation.html, …: pictures and pages, one path each."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from service.documentation import in_parts, problems
from service.routes.files import Colours, file_of
from service.routes.kept import done
from service.solve import priced
from service.state import Parts
from synthesis.exporters import PICTURES, Exporter, PictureOptions
from synthesis.findings import Sensitivities

router = APIRouter(prefix="/v1/designs/{design_id}", tags=["files"])


class PictureQuery(BaseModel):
    """How it looks."""

    model_config = ConfigDict(extra="forbid")

    theme: Colours = "auto"


def _picture(exporter: Exporter[PictureOptions]) -> Callable[..., Awaitable[Response]]:
    stem = exporter.name.removesuffix(exporter.extension)

    async def handler(
        request: Request, design_id: str, parts: Parts, options: Annotated[PictureQuery, Query()]
    ) -> Response:
        wanted = PictureOptions(**options.model_dump())
        return await file_of(request, parts, design_id, stem, exporter, wanted)

    return handler


class ReportQuery(PictureQuery):
    """How it looks, and what it tells."""

    sensitivities: Annotated[
        bool, Field(description="Tell what each limit costs too: a few solves more.")
    ] = False


def _report(exporter: Exporter[PictureOptions]) -> Callable[..., Awaitable[Response]]:
    async def handler(
        request: Request, design_id: str, parts: Parts, options: Annotated[ReportQuery, Query()]
    ) -> Response:
        found = None
        if options.sensitivities:
            _, design = await done(parts.designs, design_id)
            costs = await parts.engine.run(priced, design, budget_s=parts.settings.time_budget_s)
            found = Sensitivities.model_validate_json(costs)
        wanted = PictureOptions(theme=options.theme, sensitivities=found)
        return await file_of(request, parts, design_id, "report", exporter, wanted)

    return handler


HANDLERS = {"report.html": _report}


def _add(exporter: Exporter[PictureOptions], handler: Callable[..., Awaitable[Response]]) -> None:
    content = {exporter.media_type.partition(";")[0]: {"schema": {"type": "string"}}}
    router.add_api_route(
        f"/{exporter.name}",
        handler,
        name=f"get_{exporter.name.replace('.', '_')}",
        summary=exporter.title,
        response_class=Response,
        responses={
            **in_parts(description=exporter.title, content=content),
            **problems(404, 409, 422, 501),
        },
    )


for _exporter in PICTURES.values():
    _add(_exporter, HANDLERS.get(_exporter.name, _picture)(_exporter))
