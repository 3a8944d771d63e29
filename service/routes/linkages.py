"""/v1/linkages/{kind}: a resource for each kind of linkage in the registry, all alike."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response

from service.documentation import in_parts, problems, spec_body
from service.errors import NothingFits
from service.examples import LINKAGES as EXAMPLES
from service.routes.collection import Kept, Said, declare
from service.routes.download import Download, in_thread
from service.routes.kept import WithStatus, done
from service.state import Parts
from service.views import LinkagePage
from synthesis.exporters import Made, form
from synthesis.exporters.linkages import LINKAGE_FILES, LinkageFile
from synthesis.linkages import LINKAGES, Linkage

Handler = Callable[..., Awaitable[Any]]
router = APIRouter(prefix="/v1/linkages", tags=["linkages"])


def _made(linkage: Linkage, body: bytes, file: LinkageFile, options: Any) -> Made:
    found = linkage.found.model_validate_json(body)
    if not linkage.told(found):
        raise NothingFits("No lengths keep these wishes: see conflict in the answer.")
    return Made(file.write(found, options))


def _download(linkage: Linkage, name: str, file: LinkageFile) -> Handler:
    query = form(file.options)

    async def handler(
        request: Request,
        linkage_id: str,
        parts: Parts,
        options: Annotated[query, Query()],  # type: ignore[valid-type]
    ) -> Response:
        wanted = file.options(**dict(options))
        row, body = await done(parts.linkages[linkage.name], linkage_id)
        make = in_thread(partial(_made, linkage, body, file, wanted))
        made_by = (name, repr(asdict(wanted)))
        return await Download(name, file.media_type).sent(request, row, made_by, make)

    # texts of annotations would be looked up where ``query`` is unknown
    handler.__annotations__["options"] = Annotated[query, Query()]
    return handler


def _resource(linkage: Linkage) -> None:
    """The routes of one kind."""
    kind, noun = linkage.name.replace("-", "_"), linkage.noun
    one = kind.removesuffix("s")
    collection = Kept(
        jobs=lambda parts: parts.linkages[linkage.name],
        one=one,
        many=kind,
        id="linkage_id",
        found=linkage.found,
        page=LinkagePage,
        on_page="Linkages on a page.",
        body=spec_body(f"{EXAMPLES}/{linkage.name}", linkage.spec.__name__),
        status=WithStatus,
        path=f"/{linkage.name}",
    )
    declare(
        router,
        collection,
        create=Said(linkage.title, f"{linkage.purpose} The same spec gives the same bytes."),
        list=f"List {noun}s",
        get=Said(
            f"A {noun}",
            "As it was answered; 202 while it is being worked on, the problem where it failed.",
        ),
        delete=Said(f"Forget a {noun}", "One being worked on is stopped."),
    )
    for name, file in LINKAGE_FILES[linkage.name].items():
        schema = {"type": "object" if file.media_type == "application/json" else "string"}
        content = {file.media_type.partition(";")[0]: {"schema": schema}}
        router.add_api_route(
            f"{collection.path_of_one}/{name}", _download(linkage, name, file), methods=["GET"],
            name=f"get_{one}_{name.replace('.', '_')}", summary=f"{file.title}, of a {noun}",
            description=file.purpose, response_class=Response,
            responses={**in_parts(description=file.title, content=content),
                       **problems(404, 409, 422)},
        )  # fmt: skip


for _linkage in LINKAGES.values():
    _resource(_linkage)
