"""The routes of what is kept by id: ask, list, look at one, forget it."""

# Without postponed annotations: those of handlers name what each resource brings along.

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from inspect import cleandoc
from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Request, Response
from pydantic import BaseModel

from service.contract.documentation import problems
from service.resources.jobs import Jobs
from service.resources.views import Page
from service.routes.kept import (
    CREATED,
    SHOWN,
    Cursor,
    Key,
    KnownTag,
    PageSize,
    Prefer,
    created,
    forgotten,
    listed,
    shown,
)  # fmt: skip
from service.state import Parts, State

Handler = Callable[..., Awaitable[Any]]
NEWEST = "The newest first."
WAITING = "202 while it is being worked on; where it failed, the problem that the work ended with."
STOPPED = "being worked on is stopped; a finished one is discarded."


@dataclass(frozen=True)
class Said:
    """What the contract says of an operation; ``text`` as a docstring is written."""

    summary: str
    text: str


@dataclass(frozen=True)
class Kept:
    """A kept resource as the contract has it.

    Attributes:
        jobs: where its questions are worked on.
        one, many: what its operations are called by: ``create_{one}``, ``list_{many}``.
        id: what paths call the id of one.
        found: its answer. page: of the list. on_page: what ``limit`` counts.
        body: what the contract says of its question.
        status: what the list may be cut down to, annotated as a parameter; None: nothing.
        path: behind the router's own.
    """

    jobs: Callable[[State], Jobs]
    one: str
    many: str
    id: str
    found: type[BaseModel]
    page: type[Page[Any]]
    on_page: str
    body: dict[str, Any]
    status: Any = None
    path: str = ""

    @property
    def path_of_one(self) -> str:
        """Behind the router's own."""
        return f"{self.path}/{{{self.id}}}"


def declare(
    to: APIRouter, of: Kept, *, create: Said, list: str, get: Said, delete: Said | None
) -> None:
    """The routes of a kept resource; without ``delete`` it has its own way of forgetting."""
    _add_create(to, of, create)
    _add_list(to, of, list)
    _add_get(to, of, get)
    if delete is not None:
        _add_delete(to, of, delete)


def _add_create(to: APIRouter, of: Kept, said: Said) -> None:
    async def handler(
        request: Request, parts: Parts, prefer: Prefer = "", idempotency_key: Key = None
    ) -> Response:
        return await created(request, parts, of.jobs(parts), prefer, idempotency_key)

    to.add_api_route(
        of.path, handler, methods=["POST"], name=f"create_{of.one}",
        response_model=of.found, responses=CREATED,
        openapi_extra=of.body, **_told(said),
    )  # fmt: skip


def _add_list(to: APIRouter, of: Kept, summary: str) -> None:
    handler = _list(of) if of.status is None else _list_by_status(of)
    to.add_api_route(
        of.path, handler, methods=["GET"], name=f"list_{of.many}",
        response_model=of.page, responses=problems(422), **_told(Said(summary, NEWEST)),
    )  # fmt: skip


def _add_get(to: APIRouter, of: Kept, said: Said) -> None:
    async def handler(
        request: Request,
        name: Annotated[str, Path(alias=of.id)],
        parts: Parts,
        if_none_match: KnownTag = None,
    ) -> Response:
        return await shown(request, of.jobs(parts), name)

    to.add_api_route(
        of.path_of_one, handler, methods=["GET"], name=f"get_{of.one}",
        response_model=of.found, responses=SHOWN, **_told(said),
    )  # fmt: skip


def _add_delete(to: APIRouter, of: Kept, said: Said) -> None:
    async def handler(name: Annotated[str, Path(alias=of.id)], parts: Parts) -> None:
        await forgotten(of.jobs(parts), name)

    to.add_api_route(
        of.path_of_one, handler, methods=["DELETE"], name=f"delete_{of.one}",
        status_code=204, responses=problems(404), **_told(said),
    )  # fmt: skip


def _list(of: Kept) -> Handler:
    async def handler(
        parts: Parts,
        limit: Annotated[PageSize, Query(description=of.on_page)] = 50,
        cursor: Cursor = None,
    ) -> Any:
        return await listed(of.jobs(parts), of.page, limit, cursor)

    return handler


def _list_by_status(of: Kept) -> Handler:
    async def handler(
        parts: Parts,
        limit: Annotated[PageSize, Query(description=of.on_page)] = 50,
        cursor: Cursor = None,
        status: of.status = None,  # type: ignore[name-defined]
    ) -> Any:
        return await listed(of.jobs(parts), of.page, limit, cursor, status)

    return handler


def _told(said: Said) -> dict[str, Any]:
    return {"summary": said.summary, "description": cleandoc(said.text)}
