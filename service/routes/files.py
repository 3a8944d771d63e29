"""/v1/designs/{id}/profile.*, motion.*, solid.* and pictures: a path for each in the registries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any, TypeVar

from fastapi import APIRouter, Query, Request, Response

from service.routes.download import Download, in_thread
from service.routes.kept import done
from service.routes.offering import Offer, add, offer
from service.state import Parts, State
from service.storage.store import Row
from service.workers.solve import file_of, priced
from synthesis.exporters import (
    MOTION_FORMATS,
    PICTURES,
    PROFILE_FORMATS,
    SOLID_FORMATS,
    Exporter,
    Made,
    report_with,
)
from synthesis.exporters.drawing.picture_options import Colours, PictureOptions
from synthesis.exporters.exporter import FileFormat
from synthesis.findings import Sensitivities

router = APIRouter(prefix="/v1/designs/{design_id}", tags=["files"])
T = TypeVar("T")
FORMATS = {"profile": PROFILE_FORMATS, "motion": MOTION_FORMATS, "solid": SOLID_FORMATS}
ON_WORKERS = (429, 500, 501, 503, 504)


async def _file(
    part: str, exporter: Exporter[Any], request: Request, parts: State, name: str, options: Any
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
    file = Download(f"{_named(part, row)}{exporter.extension}", exporter.media_type)
    made_by = (part, exporter.name, repr(asdict(options)))
    make = partial(by_worker, parts, work) if exporter.apart else in_thread(work)
    return await file.sent(request, row, made_by, make)


async def by_worker(parts: State, work: Callable[[], T]) -> T:
    """What takes long or much memory, made where designs are, if there is room."""
    parts.engine.admit()
    return await parts.engine.run(work, budget_s=parts.settings.budget_s(None))


def _named(part: str, row: Row) -> str:
    """A cam that is given and breaks its limits may be looked at, but its files say so."""
    return f"not-certified-{part}" if row.status == "infeasible" else part


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
    return await _file(which, report, request, parts, design_id, PictureOptions(theme))


def _offer(path: str, exporter: Exporter[Any], statuses: tuple[int, ...] = ()) -> Offer:
    further = statuses or (ON_WORKERS if exporter.apart else ())
    name = f"get_{path.replace('.', '_')}"
    return Offer(exporter, f"/{path}", name, exporter.purpose, statuses=further)


for _of, _formats in FORMATS.items():
    for _each in _formats.values():
        offer(router, _offer(f"{_of}.{_each.name}", _each), "design_id", partial(_file, _of, _each))
for _each in PICTURES.values():
    _part = _each.name.removesuffix(_each.extension)
    if _each.name == "report.html":
        add(router, _offer(_each.name, _each, (500, 503, 504)), _reported)
    else:
        offer(router, _offer(_each.name, _each), "design_id", partial(_file, _part, _each))
