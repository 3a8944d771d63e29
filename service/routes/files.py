"""/v1/designs/{id}/profile.*, motion.*, solid.* and pictures: a path for each in the registries."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any, TypeVar

from fastapi import APIRouter, Query, Request, Response

from service.documentation import in_parts, problems
from service.routes.download import PNG, Download, in_thread
from service.routes.kept import done
from service.solve import file_of, priced
from service.state import Parts, State
from service.store import Row
from synthesis.exporters import (
    MOTION_FORMATS,
    PICTURES,
    PROFILE_FORMATS,
    SOLID_FORMATS,
    Exporter,
    Made,
    form,
    report_with,
)
from synthesis.exporters.drawing.picture_options import Colours, PictureOptions
from synthesis.exporters.exporter import FileFormat
from synthesis.findings import Sensitivities

router = APIRouter(prefix="/v1/designs/{design_id}", tags=["files"])
Handler = Callable[..., Awaitable[Response]]
T = TypeVar("T")
PACKED = ("application/vnd.openxmlformats-officedocument.spreadsheetml.sheet", PNG, "model/stl")
FORMATS = {"profile": PROFILE_FORMATS, "motion": MOTION_FORMATS, "solid": SOLID_FORMATS}
ON_WORKERS = (429, 500, 501, 503, 504)


async def _file(
    request: Request, parts: State, name: str, part: str, exporter: Exporter[Any], options: Any
) -> Response:
    """The file of a finished design, made in a thread or by a worker, or 304."""
    row, design = await done(parts.designs, name)
    work = partial(file_of, design, exporter, options)
    return await sent(request, parts, row, part, exporter, options, work)


async def sent(
    request: Request,
    parts: State,
    row: Row,
    part: str,
    exporter: FileFormat[Any, Any],
    options: Any,
    work: Callable[[], Made],
) -> Response:
    """A file of a finished row, made by ``work`` in a thread or by a worker, or 304."""
    file = Download(f"{_part(part, row)}{exporter.extension}", exporter.media_type)
    made_by = (part, exporter.name, repr(asdict(options)))
    make = partial(by_worker, parts, work) if exporter.apart else in_thread(work)
    return await file.sent(request, row, made_by, make)


async def by_worker(parts: State, work: Callable[[], T]) -> T:
    """What takes long or much memory, made where designs are, if there is room."""
    parts.engine.admit()
    return await parts.engine.run(work, budget_s=parts.settings.budget_s(None))


def _part(part: str, row: Row) -> str:
    """A cam that is given and breaks its limits may be looked at, but its files say so."""
    return f"not-certified-{part}" if row.status == "infeasible" else part


def _handler(part: str, exporter: Exporter[Any]) -> Handler:
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


async def _reported(
    request: Request,
    design_id: str,
    parts: Parts,
    theme: Annotated[Colours, Query()] = "auto",
    sensitivities: Annotated[
        bool, Query(description="Tell what each limit costs too: a few solves more.")
    ] = False,
) -> Response:
    _, design = await done(parts.designs, design_id)
    costs = None
    if sensitivities:
        budget_s = parts.settings.time_budget_s
        told = await parts.engine.run(priced, design, budget_s, budget_s=budget_s)
        costs = Sensitivities.model_validate_json(told)
    report = report_with(PROFILE_FORMATS, MOTION_FORMATS, costs)
    which = "report-costs" if costs else "report"
    return await _file(request, parts, design_id, which, report, PictureOptions(theme))


def add(
    to: APIRouter, part: str, exporter: FileFormat[Any, Any], handler: Handler, of: str = ""
) -> None:
    """A path for a format; ``of`` tells its operation from that of another subject's."""
    content = {exporter.media_type.partition(";")[0]: {"schema": schema_of(exporter)}}
    to.add_api_route(
        f"/{part}",
        handler,
        name=f"get_{of}{part.replace('.', '_')}",
        summary=exporter.title,
        description=exporter.purpose,
        response_class=Response,
        responses={
            **in_parts(description=exporter.title, content=content),
            **problems(404, 409, 422, *FURTHER.get(part, ON_WORKERS if exporter.apart else ())),
        },
    )  # fmt: skip


OWN: dict[str, Handler] = {"report.html": _reported}
FURTHER = {"report.html": (500, 503, 504)}


def schema_of(exporter: FileFormat[Any, Any]) -> dict[str, str]:
    """What its body is, for the contract."""
    if exporter.media_type == "application/json":
        return {"type": "object"}
    packed = exporter.media_type in PACKED
    return {"type": "string", "format": "binary"} if packed else {"type": "string"}


for _of, _formats in FORMATS.items():
    for _exporter in _formats.values():
        add(router, f"{_of}.{_exporter.name}", _exporter, _handler(_of, _exporter))
for _picture in PICTURES.values():
    _stem = _picture.name.removesuffix(_picture.extension)
    add(router, _picture.name, _picture, OWN.get(_picture.name) or _handler(_stem, _picture))
