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
from service.routes.download import Download, in_thread
from service.routes.kept import (
    CREATED,
    SHOWN,
    Cursor,
    Key,
    KnownTag,
    PageSize,
    Prefer,
    WithStatus,
    created,
    done,
    forgotten,
    listed,
    shown,
)  # fmt: skip
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


def _create(kind: str) -> Handler:
    async def handler(
        request: Request, parts: Parts, prefer: Prefer = "", idempotency_key: Key = None
    ) -> Response:
        return await created(request, parts, parts.linkages[kind], prefer, idempotency_key)

    return handler


def _list(kind: str) -> Handler:
    async def handler(
        parts: Parts,
        limit: Annotated[PageSize, Query(description="Linkages on a page.")] = 50,
        cursor: Cursor = None,
        status: WithStatus = None,
    ) -> LinkagePage:
        return await listed(parts.linkages[kind], LinkagePage, limit, cursor, status)

    return handler


def _get(kind: str) -> Handler:
    async def handler(
        request: Request, linkage_id: str, parts: Parts, if_none_match: KnownTag = None
    ) -> Response:
        return await shown(request, parts.linkages[kind], linkage_id)

    return handler


def _delete(kind: str) -> Handler:
    async def handler(linkage_id: str, parts: Parts) -> None:
        await forgotten(parts.linkages[kind], linkage_id)

    return handler


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
    path, kind = f"/{linkage.name}", linkage.name.replace("-", "_")
    one, noun = kind.removesuffix("s"), linkage.noun
    router.add_api_route(
        path, _create(linkage.name), methods=["POST"], name=f"create_{one}",
        summary=linkage.title, description=f"{linkage.purpose} The same spec gives the same bytes.",
        response_model=linkage.found, responses=CREATED,
        openapi_extra=spec_body(f"{EXAMPLES}/{linkage.name}", linkage.spec.__name__),
    )  # fmt: skip
    router.add_api_route(
        path, _list(linkage.name), methods=["GET"], name=f"list_{kind}",
        summary=f"List {noun}s", description="The newest first.",
        response_model=LinkagePage, responses=problems(422),
    )  # fmt: skip
    path += "/{linkage_id}"
    router.add_api_route(
        path, _get(linkage.name), methods=["GET"], name=f"get_{one}", summary=f"A {noun}",
        description="As it was answered; 202 while it is being worked on, the problem where it "
        "failed.", response_model=linkage.found, responses=SHOWN,
    )  # fmt: skip
    router.add_api_route(
        path, _delete(linkage.name), methods=["DELETE"], name=f"delete_{one}", status_code=204,
        summary=f"Forget a {noun}", description="One being worked on is stopped.",
        responses=problems(404),
    )  # fmt: skip
    for name, file in LINKAGE_FILES[linkage.name].items():
        schema = {"type": "object" if file.media_type == "application/json" else "string"}
        content = {file.media_type.partition(";")[0]: {"schema": schema}}
        router.add_api_route(
            f"{path}/{name}", _download(linkage, name, file), methods=["GET"],
            name=f"get_{one}_{name.replace('.', '_')}", summary=f"{file.title}, of a {noun}",
            description=file.purpose, response_class=Response,
            responses={**in_parts(description=file.title, content=content),
                       **problems(404, 409, 422)},
        )  # fmt: skip


for _linkage in LINKAGES.values():
    _resource(_linkage)
