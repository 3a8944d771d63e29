"""Files made of answers: a route each, tagged, made in a thread or by a worker."""

# Without postponed annotations: those of handlers name what each file brings along.

import asyncio
import re
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Annotated, Any, TypeVar

from fastapi import APIRouter, Header, Path, Query, Request, Response

from service.contract.documentation import in_parts, problems
from service.resources.resource import Resource, ResourceFile
from service.state import Parts, State
from service.storage.tables import AnswerRow
from service.wire.conditional import IN_PARTS, not_modified, tag_of
from synthesis.exporters import FileContent

T = TypeVar("T")
Handler = Callable[..., Awaitable[Response]]

SVG, PNG = "image/svg+xml", "image/png"
BINARY = (
    "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet", "application/zip",
    "model/stl", PNG,
)  # fmt: skip
# A picture runs nothing. A page runs its own script, has no origin, and can reach nothing.
PICTURE_POLICY = "default-src 'none'; style-src 'unsafe-inline'"
PAGE_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'unsafe-inline'; "
    "frame-ancestors 'self'; sandbox allow-scripts"
)
POLICIES = {SVG: PICTURE_POLICY, PNG: PICTURE_POLICY, "text/html": PAGE_POLICY}
WORKER_STATUSES = (429, 500, 501, 503, 504)  # of what may go wrong where a worker makes the file
BROKEN_LIMITS = ("infeasible", "violated")
KnownTag = Annotated[str | None, Header(description="ETag that you have; answers 304 if current.")]


def add_file(router: APIRouter, resource: Resource, file: ResourceFile) -> None:
    """Add the route of a file."""

    async def handler(
        request: Request,
        id: Annotated[str, Path(alias=resource.id_name)],
        parts: Parts,
        query: Annotated[file.query, Query()],  # type: ignore[name-defined]
        if_none_match: KnownTag = None,
    ) -> Response:
        options = file.options_of(query)
        row, body = await parts.jobs[resource.path].find_done(id)
        return await send_file(request, parts, resource, file, row, body, options)

    statuses = WORKER_STATUSES if file.in_worker else ()
    add_file_route(router, resource, file, handler, statuses)


def add_file_route(
    router: APIRouter,
    resource: Resource,
    file: ResourceFile,
    handler: Handler,
    statuses: tuple[int, ...],
) -> None:
    """Add the route of a file with a handler; ``statuses``: what may go wrong besides."""
    media_type = file.media_type.partition(";")[0]
    schema = {"type": "object"} if media_type == "application/json" else {"type": "string"}
    if file.media_type in BINARY:
        schema["format"] = "binary"
    router.add_api_route(
        f"{resource.path}/{{{resource.id_name}}}/{file.path}",
        handler,
        tags=[resource.file_tag or resource.tag],
        name=f"get_{file.operation}",
        summary=file.title,
        description=file.purpose,
        response_class=Response,
        responses={
            **in_parts(description=file.title, content={media_type: {"schema": schema}}),
            **problems(404, 409, 422, *statuses),
        },
    )


async def send_file(
    request: Request,
    parts: State,
    resource: Resource,
    file: ResourceFile,
    row: AnswerRow,
    body: bytes,
    options: Any,
) -> Response:
    """The file of a finished row, or 304 where the caller has it."""
    tag = tag_of(row.etag or "", file.path, repr(options), file.made_by)
    known = not_modified(request, tag)
    if known is not None:
        return known
    make = partial(file.make, body, options)
    content: FileContent = await (
        in_worker(parts, make) if file.in_worker else asyncio.to_thread(make)
    )
    name = file.download_name
    if resource.marks_broken_limits and row.status in BROKEN_LIMITS:
        name = f"not-certified-{name}"
    metadata = {f"Camwright-{key}": value for key, value in content.metadata.items()}
    return Response(
        content.data,
        headers={
            "ETag": f'"{tag}"', **IN_PARTS,
            **download_headers(row.name, name, file.media_type), **metadata,
        },
        media_type=file.media_type,
    )  # fmt: skip


async def in_worker(parts: State, work: Callable[[], T]) -> T:
    """Have a worker do what takes long or much memory, if there is room."""
    parts.engine.admit()
    return await parts.engine.run(work, budget_s=parts.settings.budget_s(None))


def download_headers(owner: str, ending: str, media_type: str) -> dict[str, str]:
    """Pictures and pages are shown, and reach nothing; everything else is saved as a file.

    Args:
        owner: name that the caller gave to the answer. ending: what the file's name ends in.
    """
    file_name = f'filename="{file_stem(owner)}-{ending}"'
    policy = POLICIES.get(media_type.partition(";")[0])
    if policy is None:
        return {"Content-Disposition": f"attachment; {file_name}"}
    return {"Content-Disposition": f"inline; {file_name}", "Content-Security-Policy": policy}


def file_stem(name: str) -> str:
    """The beginning of a file's name, in characters that every system takes."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-.")[:60] or "cam"
