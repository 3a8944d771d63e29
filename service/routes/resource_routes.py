"""The routes of a kept resource: POST a question, list, GET and DELETE an answer."""

# Without postponed annotations: those of handlers name what each resource brings along.

import hashlib
from collections.abc import Sequence
from inspect import cleandoc
from typing import Annotated, Any

from fastapi import APIRouter, Header, Path, Query, Request, Response
from fastapi.responses import StreamingResponse

from service.contract.documentation import UNDER_WAY_HEADERS, etag_response, problems, spec_body
from service.resources.resource import Accepted, Resource, page_of
from service.routes.files import add_file, nothing
from service.state import Parts, State
from service.storage.tables import AnswerRow
from service.wire.body import read_body
from service.wire.conditional import not_modified, only_head
from service.wire.errors import ProblemType
from service.wire.problem import problem_response

LATER = 500  # HTTP statuses from here on: the same question may be answered another time
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
        add_file(router, resource, file)
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
        # What is kept is sent to its holder even where new work would be refused: it is looked for
        # first then. Otherwise claiming finds it too, in one transaction less.
        row, is_async = None, "respond-async" in prefer.lower()
        at_once = jobs.engine.queue.is_free and not parts.caller.quotas.limited
        if not at_once:
            row = await jobs.answers.find(id, parts.owner)
        if row is None or row.state != "done":
            async with parts.quotas.room(parts.caller, id):
                with jobs.room(id):  # who is refused by then holds nothing
                    row = await jobs.claim(id, spec, parts.owner, at_once and not is_async)
                    if is_async and (row is None or row.state != "done"):
                        accepted = await jobs.accept(spec)
                        # As this owner has asked.
                        accepted.created = row.created if row else accepted.created
                        return _accepted_response(resource, accepted, applied=True)
                if row is None or row.state != "done":
                    row = await jobs.answer(spec, row, parts.owner)
        return _final_response(request, resource, row, row.body)

    router.add_api_route(
        resource.path, handler, methods=["POST"], tags=[resource.tag],
        name=f"create_{_snake(resource.noun)}", summary=resource.title,
        description=cleandoc(resource.text), response_model=resource.answer,
        openapi_extra=spec_body(resource.examples, resource.spec.__name__),
        responses={
            200: etag_response()[200],
            **UNDER_WAY,
            **problems(409, 413, 415, 422, 504),
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
            return _accepted_response(resource, row)
        known = not_modified(request, row.etag or "")
        if known is not None:
            return known
        body = row.body if with_body else None
        if row.state == "done" and not with_body and not only_head(request):
            body = await jobs.body(row)
        return _final_response(request, resource, row, body)

    router.add_api_route(
        f"{resource.path}/{{{resource.id_name}}}", handler, methods=["GET"], tags=[resource.tag],
        name=f"get_{_snake(resource.noun)}", summary=article(resource.noun).capitalize(),
        description=text, response_model=resource.answer,
        responses={**etag_response(), **UNDER_WAY, **problems(404, 422, 504)},
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


def _final_response(
    request: Request, resource: Resource, row: AnswerRow, body: bytes | None
) -> Response:
    """The answer, or the problem document of a question that has failed.

    ``body``: None where only the head is wanted.
    """
    again = f"POST it to {resource.path} to have it tried again."
    headers = {"ETag": f'"{row.etag}"', "Content-Location": resource.at(row.id)}
    failed = failure(request, row, again)
    if failed is not None or body is None:
        return failed or StreamingResponse(nothing(), 200, headers, "application/json")
    return Response(body, 200, headers, "application/json")


def _accepted_response(resource: Resource, row: AnswerRow, applied: bool = False) -> Response:
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
