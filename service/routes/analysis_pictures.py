"""/v1/analyses/{id}/motion.svg, report.html, …: pictures of a given cam and of what it breaks."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial
from typing import Any

from fastapi import APIRouter, Request, Response

from service.routes.download import Download
from service.routes.files import ON_WORKERS
from service.routes.kept import done
from service.routes.offering import Offer, offer
from service.state import State
from service.workers.solve import pictured
from synthesis.exporters import DRAWINGS, Exporter, Made, Options

router = APIRouter(prefix="/v1/analyses/{analysis_id}", tags=["analyses"])


async def _made(parts: State, analysis: bytes, name: str, options: Options) -> Made:
    """Made by a worker: a table's law is smoothed once more, and solvers are not at home here."""
    budget_s = parts.settings.time_budget_s
    return Made(await parts.engine.run(pictured, analysis, name, options, budget_s=budget_s))


async def _file(
    name: str, exporter: Exporter[Any], request: Request, parts: State, id: str, options: Any
) -> Response:
    row, analysis = await done(parts.analyses, id)
    ending = name if row.status == "holds" else f"not-certified-{name}"
    make = partial(_made, parts, analysis, name, options)
    made_by = (name, repr(asdict(options)))
    return await Download(ending, exporter.media_type).sent(request, row, made_by, make)


for _name, _exporter in DRAWINGS.items():
    _offered = Offer(
        _exporter,
        f"/{_name}",
        f"get_analysis_{_name.replace('.', '_')}",
        of=", of an analysis",
        statuses=ON_WORKERS,
    )
    offer(router, _offered, "analysis_id", partial(_file, _name, _exporter))
