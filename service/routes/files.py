"""The files of answers: their routes, their heads, and who makes them."""

# Without postponed annotations: those of handlers name what each file brings along.

import re
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import partial
from typing import Annotated, Any, TypeVar

from fastapi import APIRouter, Path, Query, Request, Response
from fastapi.responses import StreamingResponse

from service.contract.documentation import file_response
from service.resources.resource import Resource, ResourceFile
from service.state import Parts, State
from service.storage.tables import AnswerRow
from service.wire.conditional import IN_PARTS, not_modified, only_head, tag_of
from service.wire.errors import ProblemType, ServiceError
from service.wire.observe import SECURITY
from service.wire.tracing import span
from synthesis.design.design import WITHOUT_CAM
from synthesis.errors import TimeBudgetExceeded
from synthesis.exporters import FileContent, form

T = TypeVar("T")

SVG, PNG = "image/svg+xml", "image/png"
BINARY = (
    "application/vnd.apache.parquet", "application/zip", "model/stl", PNG,
    "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
)  # fmt: skip
# A picture runs nothing. A page runs its own script, has no origin, and can reach nothing.
PICTURE_POLICY = SECURITY["Content-Security-Policy"]
PAGE_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'unsafe-inline'; "
    "frame-ancestors 'self'; sandbox allow-scripts"
)
POLICIES = {SVG: PICTURE_POLICY, PNG: PICTURE_POLICY, "text/html": PAGE_POLICY}
BROKEN_LIMITS = (*WITHOUT_CAM, "violated")
Handler = Callable[..., Awaitable[Any]]


def add_file(router: APIRouter, resource: Resource, file: ResourceFile) -> None:
    """Add the route of a file of a resource's answers."""

    async def handler(
        request: Request,
        id: Annotated[str, Path(alias=resource.id_name)],
        parts: Parts,
        query: Annotated[form(file.format.options), Query()],  # type: ignore[valid-type]
    ) -> Response:
        options = file.format.options(**dict(query))
        # Who may have the file already, or wants its head, seldom needs the answer itself.
        whole = not (only_head(request) or "if-none-match" in request.headers)
        row = await parts.jobs[resource.path].find_done(id, parts.owner, with_body=whole)
        return await send_file(request, parts, resource, file, row, options)

    add_file_route(router, resource, file, handler, file.format.in_worker)


def add_file_route(
    router: APIRouter, resource: Resource, file: ResourceFile, handler: Handler, may_lack: bool
) -> None:
    """Add the route of a file with a handler; ``may_lack``: whether it takes an optional part."""
    media_type = file.format.media_type.partition(";")[0]
    router.add_api_route(
        f"{resource.path}/{{{resource.id_name}}}/{file.path}",
        handler,
        tags=[resource.file_tag or resource.tag],
        name=f"get_{file.prefix}{file.path.replace('.', '_')}",
        summary=file.format.title,
        description=file.format.purpose,
        response_class=Response,
        responses=file_response(content_of(media_type), may_lack),
    )


def content_of(media_type: str) -> dict[str, Any]:
    """A file of this type as the contract has it."""
    schema = {"type": "object"} if media_type == "application/json" else {"type": "string"}
    if media_type in BINARY:
        schema["format"] = "binary"
    return {media_type: {"schema": schema}}


async def send_file(
    request: Request,
    parts: State,
    resource: Resource,
    file: ResourceFile,
    row: AnswerRow,
    options: Any,
) -> Response:
    """The file of a finished row, or 304 where the caller has it."""
    tag = tag_of(row.etag or "", file.path, repr(options), file.made_by)
    known = not_modified(request, tag)
    if known is not None:
        return known
    name = name_of_file(resource, row, file.ending or file.path)
    headers = download_headers(row.name, name, file.format.media_type)
    headers |= {"ETag": f'"{tag}"', **IN_PARTS}
    media_type = file.format.media_type
    # Where there is a cam there is a file. What only that itself tells, as its length, is left out.
    if only_head(request) and row.status not in WITHOUT_CAM:
        return StreamingResponse(nothing(), 200, headers, media_type)
    body = await parts.jobs[resource.path].body(row)
    make = partial(file.write, file.format, body, options)
    with span("file", file=file.path), parts.metrics.files.labels(file.path).time():
        place = make_in_worker if file.format.in_worker else make_beside
        content: FileContent = await place(request, parts, make)
    headers |= {f"Camwright-{key}": value for key, value in content.metadata.items()}
    return Response(content.data, 200, headers, media_type)


async def nothing() -> AsyncIterator[bytes]:
    """No bytes."""
    yield b""


async def make_in_worker(request: Request, parts: State, work: Callable[[], T]) -> T:
    """Have a worker make what a path leads to, if there is room: it takes long or much memory."""
    budget_s = parts.settings.budget_s(None)

    async def work_in_turn() -> T:
        async with parts.quotas.core(parts.caller, budget_s):
            return await parts.engine.run(work, budget_s=budget_s, limited=True)

    return await with_words_for_files(request, budget_s, work_in_turn())


async def make_beside(request: Request, parts: State, work: Callable[[], T]) -> T:
    """Have a process beside the event loop make what a path leads to, which is soon done."""
    budget_s = parts.settings.budget_s(None)
    return await with_words_for_files(request, budget_s, parts.writers.run(work))


def name_of_file(resource: Resource, row: AnswerRow, name: str) -> str:
    """The end of a saved file's name: it says where a cam breaks its limits."""
    broken = resource.marks_broken_limits and row.status in BROKEN_LIMITS
    return f"not-certified-{name}" if broken else name


async def with_words_for_files(request: Request, budget_s: float, work: Awaitable[T]) -> T:
    """Wait for a file; what goes wrong is said of the file that a path leads to."""
    owner, _, file = request.url.path.rpartition("/")
    again = f"{request.url.path}?{request.url.query}".removesuffix("?")
    later = (
        f"{owner} is as it was: ask for the file again by GET {again}, when less is going on here "
        "or with coarser options, such as fewer points."
    )
    try:
        return await work
    except TimeBudgetExceeded:
        raise ProblemType.TIME_BUDGET(
            f"{file} took longer than {budget_s:g} s, the time that this server gives a file. "
            f"{later}"
        ) from None
    except ServiceError as error:
        if error.problem is not ProblemType.WORKER_LOST:
            raise
        raise ProblemType.WORKER_LOST(
            f"The process that made {file} died, perhaps for lack of memory. {later}", error.headers
        ) from None


def download_headers(owner: str, ending: str, media_type: str) -> dict[str, str]:
    """Pictures and pages are shown, and reach nothing; everything else is saved as a file.

    Args:
        owner: name that the caller gave to the answer. ending: what the file's name ends in.
    """
    # In characters that every system takes.
    stem = re.sub(r"[^A-Za-z0-9._-]+", "-", owner).strip("-.")[:60] or "cam"
    file_name = f'filename="{stem}-{ending}"'
    policy = POLICIES.get(media_type.partition(";")[0])
    if policy is None:
        return {"Content-Disposition": f"attachment; {file_name}"}
    return {"Content-Disposition": f"inline; {file_name}", "Content-Security-Policy": policy}
