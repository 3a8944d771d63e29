"""/v1/designs/{id}/profile.* and motion.*: one path for each format of the registries."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response

from service.documentation import in_parts, problems
from service.errors import NothingFits
from service.routes.download import Download, in_thread
from service.routes.kept import done
from service.state import Parts, State
from service.store import Row
from synthesis.design import Design
from synthesis.exporters import MOTION_FORMATS, PROFILE_FORMATS, Exporter, Made, form

router = APIRouter(prefix="/v1/designs/{design_id}", tags=["files"])
PACKED = ("application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",)
FORMATS = {"profile": PROFILE_FORMATS, "motion": MOTION_FORMATS}


async def _file(
    request: Request, parts: State, name: str, part: str, exporter: Exporter[Any], options: Any
) -> Response:
    """The file of a finished design, made in a thread, or 304."""
    row, design = await done(parts.designs, name)
    file = Download(f"{_part(part, row)}{exporter.extension}", exporter.media_type)
    made_by = (part, exporter.name, repr(asdict(options)))
    return await file.sent(
        request, row, made_by, in_thread(partial(_made, design, exporter, options))
    )


def _made(design: bytes, exporter: Exporter[Any], options: Any) -> Made:
    finished = Design.model_validate_json(design)
    if not finished.motion:
        raise NothingFits("No cam fits these limits: see conflict in the design for what would.")
    return exporter.whole(finished, options)


def _part(part: str, row: Row) -> str:
    """A cam that is given and breaks its limits may be looked at, but its files say so."""
    return f"not-certified-{part}" if row.status == "infeasible" else part


def _handler(part: str, exporter: Exporter[Any]) -> Callable[..., Awaitable[Response]]:
    query = form(exporter.options)

    async def handler(
        request: Request,
        design_id: str,
        parts: Parts,
        options: Annotated[query, Query()],  # type: ignore[valid-type]
    ) -> Response:
        wanted = exporter.options(**dict(options))
        return await _file(request, parts, design_id, part, exporter, wanted)

    # texts of annotations would be looked up where ``query`` is unknown
    handler.__annotations__["options"] = Annotated[query, Query()]
    return handler


def _add(part: str, exporter: Exporter[Any]) -> None:
    content = {exporter.media_type.partition(";")[0]: {"schema": _schema(exporter)}}
    router.add_api_route(
        f"/{part}.{exporter.name}",
        _handler(part, exporter),
        name=f"get_{part}_{exporter.name.replace('.', '_')}",
        summary=f"{part.capitalize()}: {exporter.title}",
        description=exporter.purpose,
        response_class=Response,
        responses={
            **in_parts(description=exporter.title, content=content),
            **problems(404, 409, 422),
        },
    )  # fmt: skip


def _schema(exporter: Exporter[Any]) -> dict[str, str]:
    if exporter.media_type == "application/json":
        return {"type": "object"}
    packed = exporter.media_type in PACKED
    return {"type": "string", "format": "binary"} if packed else {"type": "string"}


for _of, _formats in FORMATS.items():
    for _exporter in _formats.values():
        _add(_of, _exporter)
