"""Files at paths of their own: what may be chosen about them, and what the contract says."""

# Without postponed annotations: those of handlers name what each file brings along.

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Request, Response

from service.contract.documentation import in_parts, problems
from service.routes.download import PNG
from service.state import Parts, State
from synthesis.exporters import form
from synthesis.exporters.exporter import FileFormat

Handler = Callable[..., Awaitable[Response]]
# Of the owner's id, with what was chosen, as the format takes it.
Send = Callable[[Request, State, str, Any], Awaitable[Response]]
PACKED = ("application/vnd.openxmlformats-officedocument.spreadsheetml.sheet", PNG, "model/stl")


@dataclass(frozen=True)
class Offer:
    """A file as the contract has it.

    Attributes:
        file: its format. path: behind the router's own. name: of the operation.
        text: what it is for. of: what its title goes on with in a list of all operations.
        statuses: of what may go wrong besides 404, 409, 416 and 422.
    """

    file: FileFormat[Any, Any]
    path: str
    name: str
    text: str = ""
    of: str = ""
    statuses: tuple[int, ...] = ()


def offer(to: APIRouter, offered: Offer, id: str, send: Send) -> None:
    """Add a file's path; ``id``: what the path calls its owner's."""
    options = offered.file.options
    query = form(options)

    async def handler(
        request: Request,
        name: Annotated[str, Path(alias=id)],
        parts: Parts,
        chosen: Annotated[query, Query()],  # type: ignore[valid-type]
    ) -> Response:
        return await send(request, parts, name, options(**dict(chosen)))

    add(to, offered, handler)


def add(to: APIRouter, offered: Offer, handler: Handler) -> None:
    """Add a file's path with a handler of its own."""
    file = offered.file
    content = {file.media_type.partition(";")[0]: {"schema": _schema_of(file.media_type)}}
    to.add_api_route(
        offered.path,
        handler,
        name=offered.name,
        summary=f"{file.title}{offered.of}",
        description=offered.text,
        response_class=Response,
        responses={
            **in_parts(description=file.title, content=content),
            **problems(404, 409, 422, *offered.statuses),
        },
    )


def _schema_of(media_type: str) -> dict[str, str]:
    if media_type == "application/json":
        return {"type": "object"}
    return {"type": "string", "format": "binary"} if media_type in PACKED else {"type": "string"}
