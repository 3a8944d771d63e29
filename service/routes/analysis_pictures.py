"""/v1/analyses/{id}/motion.svg, report.html, …: pictures of a given cam and of what it breaks."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response

from service.documentation import in_parts, problems
from service.routes.download import Download
from service.routes.files import schema_of
from service.routes.kept import done
from service.solve import pictured
from service.state import Parts, State
from synthesis.exporters import DRAWINGS, Exporter, Made, Options, form

router = APIRouter(prefix="/v1/analyses/{analysis_id}", tags=["analyses"])


async def _made(parts: State, analysis: bytes, name: str, options: Options) -> Made:
    """Made by a worker: a table's law is smoothed once more, and solvers are not at home here."""
    budget_s = parts.settings.time_budget_s
    return Made(await parts.engine.run(pictured, analysis, name, options, budget_s=budget_s))


def _handler(name: str, exporter: Exporter[Any]) -> Callable[..., Awaitable[Response]]:
    query = form(exporter.options)

    async def handler(
        request: Request,
        analysis_id: str,
        parts: Parts,
        options: Annotated[query, Query()],  # type: ignore[valid-type]
    ) -> Response:
        wanted = exporter.options(**dict(options))
        row, analysis = await done(parts.analyses, analysis_id)
        ending = name if row.status == "holds" else f"not-certified-{name}"
        make = partial(_made, parts, analysis, name, wanted)
        made_by = (name, repr(asdict(wanted)))
        return await Download(ending, exporter.media_type).sent(request, row, made_by, make)

    # texts of annotations would be looked up where ``query`` is unknown
    handler.__annotations__["options"] = Annotated[query, Query()]
    return handler


for _name, _exporter in DRAWINGS.items():
    _content = {_exporter.media_type.partition(";")[0]: {"schema": schema_of(_exporter)}}
    router.add_api_route(
        f"/{_name}",
        _handler(_name, _exporter),
        name=f"get_analysis_{_name.replace('.', '_')}",
        summary=f"{_exporter.title}, of an analysis",
        response_class=Response,
        responses={
            **in_parts(description=_exporter.title, content=_content),
            **problems(404, 409, 422, 429, 500, 501, 503, 504),
        },
    )
