"""/v1/designs/{id}/contact.svg, animation.html, …: pictures and pages, one path each."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict

from service.documentation import in_parts, problems
from service.routes.files import Colours, file_of
from service.state import Parts
from synthesis.exporters import PICTURES, Exporter, PictureOptions

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


def _add(exporter: Exporter[PictureOptions]) -> None:
    content = {exporter.media_type.partition(";")[0]: {"schema": {"type": "string"}}}
    router.add_api_route(
        f"/{exporter.name}",
        _picture(exporter),
        name=f"get_{exporter.name.replace('.', '_')}",
        summary=exporter.title,
        response_class=Response,
        responses={
            **in_parts(description=exporter.title, content=content),
            **problems(404, 409, 422, 501),
        },
    )


for _exporter in PICTURES.values():
    _add(_exporter)
