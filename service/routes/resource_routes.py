"""The routes of a kept resource: POST a question, list, GET and DELETE an answer, get its files."""

# Without postponed annotations: those of handlers name what each resource brings along.

import hashlib
from collections.abc import Awaitable, Callable, Sequence
from inspect import cleandoc
from typing import Annotated, Any, Optional

from fastapi import APIRouter, Header, Path, Query, Request, Response

from service.contract.documentation import UNDER_WAY_HEADERS, problems, spec_body, tagged
from service.resources.jobs import result_of
from service.resources.resource import Accepted, Resource, page_of
from service.routes.file_routes import add_file
from service.state import Parts, State
from service.storage.tables import AnswerRow
from service.wire.body import read_body
from service.wire.conditional import not_modified
from service.wire.errors import ProblemType
from service.wire.problem import problem_response

Handler = Callable[..., Awaitable[Any]]
WAITING = "202 while it is being worked on; where it failed, the problem that the work ended with."
UNDER_WAY: dict[int | str, dict[str, Any]] = {
    202: {
        "model": Accepted,
        "description": "Being worked on; ask again.",
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
        add_file(router, resource, file)
    return router


def _add_create(router: APIRouter, resource: Resource) -> None:
    async def handler(
        request: Request, parts: Parts, prefer: Prefer = "", idempotency_key: Key = None
    ) -> Response:
        jobs = parts.jobs[resource.path]
        spec = await read_body(request, resource.spec)
        await check_key(parts, idempotency_key, await request.body())
        row = await jobs.answers.find(resource.id_of(spec))
        if row is None or row.state != "done":
            if "respond-async" in prefer.lower():
                return _accepted(resource, await jobs.accept(spec), applied=True)
            row = await result_of(jobs.start(spec))
        return _done(resource, row)

    router.add_api_route(
        resource.path, handler, methods=["POST"], tags=[resource.tag],
        name=f"create_{_snake(resource.noun)}", summary=resource.title,
        description=cleandoc(resource.text), response_model=resource.answer,
        openapi_extra=spec_body(resource.examples, resource.spec.__name__),
        responses={
            200: tagged()[200],
            **UNDER_WAY,
            **problems(400, 409, 413, 415, 422, 429, 500, 503, 504),
        },
    )  # fmt: skip


def _add_list(router: APIRouter, resource: Resource) -> None:
    size = Query(ge=1, le=200, description=f"{resource.plural.capitalize()} on a page.")

    async def handler(
        parts: Parts,
        limit: Annotated[int, size] = 50,
        cursor: Cursor = None,
    ) -> Any:
        return await _page(parts, resource, limit, cursor, None)

    async def handler_by_status(
        parts: Parts,
        limit: Annotated[int, size] = 50,
        cursor: Cursor = None,
        status: Annotated[
            Optional[resource.status],  # type: ignore[name-defined]  # noqa: UP045
            Query(description="Only those with this status."),
        ] = None,
    ) -> Any:
        return await _page(parts, resource, limit, cursor, status)

    router.add_api_route(
        resource.path, handler if resource.status is None else handler_by_status,
        methods=["GET"], tags=[resource.tag], name=f"list_{_snake(resource.plural)}",
        summary=f"List {resource.plural}", description="The newest first.",
        response_model=page_of(resource.summary), responses=problems(422),
    )  # fmt: skip


def _add_get(router: APIRouter, resource: Resource) -> None:
    async def handler(
        request: Request,
        id: Annotated[str, Path(alias=resource.id_name)],
        parts: Parts,
        if_none_match: KnownTag = None,
    ) -> Response:
        row = await parts.jobs[resource.path].find(id)
        if row.state == "accepted":
            return _accepted(resource, row)
        if row.problem is not None and row.state == "failed":
            return problem_response(request, row.problem)
        return not_modified(request, row.etag or "") or _done(resource, row)

    router.add_api_route(
        f"{resource.path}/{{{resource.id_name}}}", handler, methods=["GET"], tags=[resource.tag],
        name=f"get_{_snake(resource.noun)}", summary=article(resource.noun).capitalize(),
        description=f"{resource.answer_text}\n\n{WAITING}", response_model=resource.answer,
        responses={**tagged(), **UNDER_WAY, **problems(404, 422, 500, 503, 504)},
    )  # fmt: skip


def _add_delete(router: APIRouter, resource: Resource) -> None:
    async def handler(id: Annotated[str, Path(alias=resource.id_name)], parts: Parts) -> None:
        jobs = parts.jobs[resource.path]
        if not await jobs.dismiss(id):
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
    if await parts.store.body_of_key(key, body_hash) != body_hash:
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


async def _page(
    parts: State, resource: Resource, limit: int, cursor: str | None, status: str | None
) -> Any:
    before = None if cursor is None else position_of(cursor)
    rows: Sequence[AnswerRow] = await parts.jobs[resource.path].answers.page(
        before, limit + 1, status
    )
    items = [
        {**resource.fields_of(row), "status": row.status, **row.summary} for row in rows[:limit]
    ]
    following = str(rows[limit - 1].sequence) if len(rows) > limit else None
    return page_of(resource.summary).model_validate({"items": items, "next": following})


def _done(resource: Resource, row: AnswerRow) -> Response:
    headers = {"ETag": f'"{row.etag}"', "Content-Location": resource.at(row.id)}
    return Response(row.body, 200, headers, "application/json")


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
