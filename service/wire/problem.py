"""Problem documents (RFC 9457): the one form in which anything goes wrong on the wire."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping
from typing import Annotated, Any

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.routing import Match

from service.wire.errors import (
    BY_STATUS,
    PROBLEMS,
    BadQuery,
    InvalidBody,
    Kind,
    ServiceError,
    kind_of,
)
from service.wire.violations import Violation, of_parameters, shown
from synthesis.camset import CamSet
from synthesis.design import Design
from synthesis.errors import CamwrightError, InputError, TimeBudgetExceeded

MEDIA_TYPE = "application/problem+json"


class Problem(BaseModel):
    """What went wrong, in the form of RFC 9457."""

    type: Annotated[str, Field(description="Kind of problem; the address explains it.")]
    title: Annotated[str, Field(description="The kind in words; the same for each occurrence.")]
    status: Annotated[int, Field(description="The HTTP status once more.")]
    detail: Annotated[str, Field(description="What happened here, and the way out.")]
    instance: Annotated[str, Field(description="Path of the request.")]
    request_id: Annotated[str | None, Field(description="As in X-Request-ID and the logs.")] = None
    errors: Annotated[
        list[Violation], Field(description="Each wrong field: where, value, rule, way out.")
    ] = []


class LateProblem(Problem):
    """The time budget ended: a problem document with the best that was found by then."""

    best: Annotated[
        Design | CamSet | None,
        Field(
            description="The best certified design found in time, if any; of a set all cams, each "
            "as good as it became."
        ),
    ] = None


def document(
    kind: Kind,
    detail: str,
    errors: list[dict[str, Any]] | None = None,
    best: Design | CamSet | None = None,
) -> dict[str, Any]:
    """What is known of a problem before it has a request to answer."""
    body: dict[str, Any] = {
        "type": f"/problems/{kind.slug}",
        "title": kind.title,
        "status": kind.status,
        "detail": detail,
    }
    if errors:
        body["errors"] = errors
    if best is not None:
        body["best"] = best.model_dump(mode="json")
    return body


def described(error: Exception) -> dict[str, Any]:
    """Any exception as a problem; what the table does not know is a plain 500."""
    kind = kind_of(error)
    if kind is None:
        return document(BY_STATUS[500], "The fault is ours and has been logged.")
    if isinstance(error, InputError):
        found = {
            "pointer": error.field,
            "value": shown(error.value),
            "rule": error.rule,
            "way_out": error.way_out,
        }
        return document(kind, str(error), [found])
    if isinstance(error, InvalidBody):
        return document(kind, str(error), error.violations)
    if isinstance(error, TimeBudgetExceeded):
        return document(kind, str(error), best=error.best)
    meant_for_callers = isinstance(error, ServiceError | CamwrightError)
    return document(kind, str(error) if meant_for_callers else f"{kind.title}.")


def respond(
    request: Request, problem: dict[str, Any], headers: Mapping[str, str] | None = None
) -> Response:
    """A problem as the answer to a request."""
    asked = {"instance": request.url.path, "request_id": request.scope.get("request_id")}
    text = json.dumps({**problem, **asked}, ensure_ascii=False, allow_nan=False)
    body = text.encode("utf-8", "replace")
    return Response(body, problem["status"], dict(headers or {}), MEDIA_TYPE)


def answer(request: Request, error: Exception) -> Response:
    """Any exception as the answer to a request."""
    kind = kind_of(error)
    if kind is None:
        logging.getLogger("camwright").error("unexpected", exc_info=error)
    problem = described(error)
    again = {"Retry-After": str(kind.again_s)} if kind is not None and kind.again_s else None
    if isinstance(error, InputError) and request.method == "GET":  # there is no body to point into
        (found,) = problem["errors"]
        parameter = found.pop("pointer").removeprefix("/")
        problem = document(PROBLEMS[BadQuery], str(error), [{"parameter": parameter, **found}])
    return respond(request, problem, getattr(error, "headers", again))


async def _known(request: Request, error: Exception) -> Response:
    return answer(request, error)


async def _http(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    kind = BY_STATUS.get(error.status_code) or Kind(error.status_code, "http", str(error.detail))
    detail = f"{request.method} {request.url.path}: {kind.title}. See /docs for what there is."
    headers = {"Allow": _allowed(request)} if error.status_code == 405 else error.headers
    return respond(request, document(kind, detail), headers)


def _allowed(request: Request) -> str:
    """Every method that this path knows: routes only tell of their own."""
    routes = request.app.router.routes
    known = [
        method
        for method in ("GET", "POST", "PUT", "PATCH", "DELETE")
        if any(
            route.matches({**request.scope, "method": method})[0] == Match.FULL for route in routes
        )
    ]
    return ", ".join(known)


async def _parameters(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    found = of_parameters(error.errors())
    detail = "; ".join(f"{each['parameter']}: {each['rule']}" for each in found)
    return respond(request, document(PROBLEMS[BadQuery], detail, found))


def install(app: FastAPI) -> None:
    """Make the application answer every failure with a problem document."""
    for exception in PROBLEMS:
        app.add_exception_handler(exception, _known)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(RequestValidationError, _parameters)
