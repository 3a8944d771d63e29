"""The routes of a kept resource: POST a question, list, GET and DELETE an answer, get its files."""

# Without postponed annotations: those of handlers name what each resource brings along.

import asyncio
import hashlib
import re
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from functools import partial
from inspect import cleandoc
from typing import Annotated, Any, TypeVar

from fastapi import APIRouter, Header, Path, Query, Request, Response
from fastapi.responses import StreamingResponse

from service.contract.documentation import (
    UNDER_WAY_HEADERS,
    etag_response,
    file_response,
    problems,
    spec_body,
)
from service.resources.resource import Accepted, Resource, ResourceFile, page_of
from service.state import Parts, State
from service.storage.tables import AnswerRow
from service.wire.body import read_body
from service.wire.conditional import IN_PARTS, not_modified, only_head, tag_of
from service.wire.errors import ProblemType, ServiceError
from service.wire.observe import SECURITY
from service.wire.problem import problem_response
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
LATER = 500  # HTTP statuses from here on: the same question may be answered another time
WORKER_STATUSES = (429, 500, 501, 503, 504)  # of what may go wrong where a worker makes the file
BROKEN_LIMITS = (*WITHOUT_CAM, "violated")
Handler = Callable[..., Awaitable[Any]]
UNDER_WAY: dict[int | str, dict[str, Any]] = {
    202: {
        "model": Accepted,
        "description": "Being worked on: ask again for the answer, or the problem that the work "
        "ends with.",
        "headers": UNDER_WAY_HEADERS,
    }
}
Prefer = Annotated[
    str, Header(description="`respond-async`: answer 202 at once and work on it meanwhile.")
]
Key = Annotated[
    str | None,
    Header(
        min_length=1,
        max_length=255,
        description="The same key and body within 24 h give the same answer; "
        "the same key with another body is refused.",
    ),
]
Cursor = Annotated[str | None, Query(description="`next` of the page before.")]
KnownTag = Annotated[str | None, Header(description="ETag that you have; answers 304 if current.")]


def router_of(resource: Resource) -> APIRouter:
    """All routes of a resource, but for those that it alone has."""
    router = APIRouter()
    for add in (_add_create, _add_list, _add_get):
        add(router, resource)
    if not resource.own_delete:
        _add_delete(router, resource)
    for file in resource.files:
        _add_file(router, resource, file)
    return router


def _add_create(router: APIRouter, resource: Resource) -> None:
    async def handler(
        request: Request, parts: Parts, prefer: Prefer = "", idempotency_key: Key = None
    ) -> Response:
        jobs = parts.jobs[resource.path]
        most = parts.settings.max_body_bytes
        spec, body = await read_body(request, parts.readers, resource.spec, most)
        await check_key(parts, idempotency_key, body)
        id = resource.id_of(spec)
        row = await jobs.answers.find(id, parts.owner)
        if row is None or row.state != "done":
            async with parts.quotas.room(parts.caller, id):
                with jobs.room(id):  # who is refused by then holds nothing
                    row = await jobs.answers.claim(id, parts.owner)
                    if "respond-async" in prefer.lower() and (row is None or row.state != "done"):
                        accepted = await jobs.accept(spec)
                        # As this owner has asked.
                        accepted.created = row.created if row else accepted.created
                        return _accepted(resource, accepted, applied=True)
                if row is None or row.state != "done":
                    row = await jobs.answer(spec, row, parts.owner)
        return _ended(request, resource, row, row.body)

    router.add_api_route(
        resource.path, handler, methods=["POST"], tags=[resource.tag],
        name=f"create_{_snake(resource.noun)}", summary=resource.title,
        description=cleandoc(resource.text), response_model=resource.answer,
        openapi_extra=spec_body(resource.examples, resource.spec.__name__),
        responses={
            200: etag_response()[200],
            **UNDER_WAY,
            **problems(400, 409, 413, 415, 422, 429, 500, 503, 504),
        },
    )  # fmt: skip


def _add_list(router: APIRouter, resource: Resource) -> None:
    size = Query(ge=1, le=200, description="How many on a page.")
    filters = resource.status is not None
    kind: Any = (resource.status or str) | None
    only = Query(description="Only those with this status.", include_in_schema=filters)

    async def handler(
        parts: Parts,
        limit: Annotated[int, size] = 50,
        cursor: Cursor = None,
        status: Annotated[kind, only] = None,
    ) -> Any:
        answers = parts.jobs[resource.path].answers
        rows, following = await newest(
            answers, parts.owner, limit, cursor, status if filters else None
        )
        items = [{**resource.fields_of(row), "status": row.status, **row.summary} for row in rows]
        return page_of(resource.summary).model_validate({"items": items, "next": following})

    router.add_api_route(
        resource.path, handler, methods=["GET"], tags=[resource.tag],
        name=f"list_{_snake(resource.plural)}", summary=f"List {resource.plural}",
        description="The newest first.", response_model=page_of(resource.summary),
        responses=problems(422),
    )  # fmt: skip


def _add_get(router: APIRouter, resource: Resource) -> None:
    text = (
        resource.answer_text
        or f"As `POST {resource.path}` answered, or would have without `respond-async`."
    )

    async def handler(
        request: Request,
        id: Annotated[str, Path(alias=resource.id_name)],
        parts: Parts,
        if_none_match: KnownTag = None,
    ) -> Response:
        jobs, with_body = parts.jobs[resource.path], if_none_match is None
        with_body = with_body and not only_head(request)
        row = await jobs.find(id, parts.owner, with_body=with_body)
        if row.state == "accepted":
            return _accepted(resource, row)
        known = not_modified(request, row.etag or "")
        if known is not None:
            return known
        body = row.body if with_body else None
        if row.state == "done" and not with_body and not only_head(request):
            body = await jobs.body(row)
        return _ended(request, resource, row, body)

    router.add_api_route(
        f"{resource.path}/{{{resource.id_name}}}", handler, methods=["GET"], tags=[resource.tag],
        name=f"get_{_snake(resource.noun)}", summary=article(resource.noun).capitalize(),
        description=text, response_model=resource.answer,
        responses={**etag_response(), **UNDER_WAY, **problems(404, 422, 500, 503, 504)},
    )  # fmt: skip


def _add_delete(router: APIRouter, resource: Resource) -> None:
    async def handler(id: Annotated[str, Path(alias=resource.id_name)], parts: Parts) -> None:
        jobs = parts.jobs[resource.path]
        if not await jobs.dismiss(id, parts.owner):
            raise jobs.unknown(id)

    router.add_api_route(
        f"{resource.path}/{{{resource.id_name}}}", handler, methods=["DELETE"],
        tags=[resource.tag], name=f"delete_{_snake(resource.noun)}", status_code=204,
        summary=f"Delete {article(resource.noun)}",
        description="One being worked on is stopped; a finished one is discarded.",
        responses=problems(404),
    )  # fmt: skip


async def check_key(parts: State, key: str | None, body: bytes) -> None:
    """Refuse an Idempotency-Key that came with another body before.

    The key need not lead to an answer: the same body has the same id anyway.
    """
    if key is None:
        return
    if not key.isprintable():
        raise ProblemType.INVALID_PARAMETER("Idempotency-Key: use printable characters only.")
    body_hash = hashlib.sha256(body).hexdigest()
    if await parts.store.body_of_key(parts.owner, key, body_hash) != body_hash:
        raise ProblemType.IDEMPOTENCY_KEY_REUSED(
            f"Idempotency-Key {key!r} came with another body before. Use a new key for a new body."
        )


def position_of(cursor: str) -> int:
    """The sequence number of the row that a cursor continues after: the cursor itself."""
    if cursor.isascii() and cursor.isdecimal() and len(cursor) < 19:
        return int(cursor)
    raise ProblemType.INVALID_PARAMETER(
        "cursor: not one that this service gave. Take `next` of the page before."
    )


async def newest(
    kept: Any, owner: str, limit: int, cursor: str | None, state: str | None
) -> tuple[Sequence[Any], str | None]:
    """An owner's rows of a page and the cursor of the next one; ``kept`` has the rows."""
    before = None if cursor is None else position_of(cursor)
    rows = await kept.page(before, limit + 1, state, owner)
    return rows[:limit], str(rows[limit - 1].sequence) if len(rows) > limit else None


def failure(request: Request, row: AnswerRow, again: str = "") -> Response | None:
    """The problem document of a question that has failed; None of any other.

    ``again``: how to have it tried again, where the question itself is not at fault.
    """
    problem = row.problem
    if problem is None or row.state != "failed":
        return None
    if again and problem["status"] >= LATER:
        problem = {**problem, "detail": f"{problem['detail']} The question has failed: {again}"}
    return problem_response(request, problem)


def _ended(request: Request, resource: Resource, row: AnswerRow, body: bytes | None) -> Response:
    """The answer, or the problem document of a question that has failed.

    ``body``: None where only the head is wanted.
    """
    again = f"POST it to {resource.path} to have it tried again."
    headers = {"ETag": f'"{row.etag}"', "Content-Location": resource.at(row.id)}
    failed = failure(request, row, again)
    if failed is not None or body is None:
        return failed or StreamingResponse(nothing(), 200, headers, "application/json")
    return Response(body, 200, headers, "application/json")


def _accepted(resource: Resource, row: AnswerRow, applied: bool = False) -> Response:
    headers = {"Location": resource.at(row.id), "Retry-After": "1"}
    if applied:
        headers["Preference-Applied"] = "respond-async"
    body = Accepted(**resource.fields_of(row)).model_dump_json()
    return Response(body, 202, headers, "application/json")


def article(noun: str) -> str:
    """A noun with its indefinite article."""
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _snake(words: str) -> str:
    """Words as a part of an operation's name."""
    return words.replace(" ", "_").replace("-", "_")


def _add_file(router: APIRouter, resource: Resource, file: ResourceFile) -> None:
    async def handler(
        request: Request,
        id: Annotated[str, Path(alias=resource.id_name)],
        parts: Parts,
        query: Annotated[form(file.format.options), Query()],  # type: ignore[valid-type]
    ) -> Response:
        options = file.format.options(**dict(query))
        row = await parts.jobs[resource.path].find_done(id, parts.owner)
        return await send_file(request, parts, resource, file, row, options)

    add_file_route(router, resource, file, handler, file.format.in_worker)


def add_file_route(
    router: APIRouter, resource: Resource, file: ResourceFile, handler: Handler, may_fail: bool
) -> None:
    """Add the route of a file with a handler, which may or may not fail at making it."""
    media_type = file.format.media_type.partition(";")[0]
    router.add_api_route(
        f"{resource.path}/{{{resource.id_name}}}/{file.path}",
        handler,
        tags=[resource.file_tag or resource.tag],
        name=f"get_{file.prefix}{file.path.replace('.', '_')}",
        summary=file.format.title,
        description=file.format.purpose,
        response_class=Response,
        responses=file_response(content_of(media_type), may_fail),
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
        content: FileContent = await (
            in_worker(request, parts, make) if file.format.in_worker else asyncio.to_thread(make)
        )
    headers |= {f"Camwright-{key}": value for key, value in content.metadata.items()}
    return Response(content.data, 200, headers, media_type)


async def nothing() -> AsyncIterator[bytes]:
    """No bytes."""
    yield b""


async def in_worker(request: Request, parts: State, work: Callable[[], T]) -> T:
    """Have a worker make what a path leads to, if there is room: it takes long or much memory."""
    budget_s = parts.settings.budget_s(None)
    with parts.engine.queue.room():
        pass

    async def making() -> T:
        async with parts.quotas.core(parts.caller, budget_s):
            return await parts.engine.run(work, budget_s=budget_s)

    return await with_words_for_files(request, budget_s, making())


def name_of_file(resource: Resource, row: AnswerRow, name: str) -> str:
    """The end of a saved file's name: it says where a cam breaks its limits."""
    broken = resource.marks_broken_limits and row.status in BROKEN_LIMITS
    return f"not-certified-{name}" if broken else name


async def with_words_for_files(request: Request, budget_s: float, making: Awaitable[T]) -> T:
    """Wait for a file; what goes wrong is said of the file that a path leads to."""
    owner, _, file = request.url.path.rpartition("/")
    again = f"{request.url.path}?{request.url.query}".removesuffix("?")
    later = (
        f"{owner} is as it was: ask for the file again by GET {again}, when less is going on here "
        "or with coarser options, such as fewer points."
    )
    try:
        return await making
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
