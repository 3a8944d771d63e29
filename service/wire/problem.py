"""Problem documents (RFC 9457): the form of every error on the wire."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping
from typing import Any

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, Field
from sqlalchemy.exc import SQLAlchemyError
from starlette.exceptions import HTTPException
from starlette.routing import Match

from service.wire.errors import TYPES, ProblemType, ServiceError, is_damage, problem_type
from service.wire.violations import Violation, describe_parameter_errors
from synthesis.design.cam_set import CamSet
from synthesis.design.design import Design
from synthesis.errors import CamwrightError, InputError, TimeBudgetExceeded
from synthesis.errors.names import did_you_mean
from synthesis.errors.violations import violation

MEDIA_TYPE = "application/problem+json"
LONGEST_PATH = 500  # characters that are compared with the paths that there are
STORE_AGAIN_S = "2"  # Retry-After: a restart of the database takes about so long
STARLETTES = (ProblemType.NOT_FOUND, ProblemType.METHOD_NOT_ALLOWED)  # what it answers by itself


class Problem(BaseModel):
    """What went wrong, in the form of RFC 9457."""

    type: str = Field(description="Kind of problem; the address explains it.")
    title: str = Field(description="The kind in words; the same for each occurrence.")
    status: int = Field(description="The HTTP status once more.")
    detail: str = Field(description="What happened here, and the way out.")
    instance: str = Field(description="Path of the request.")
    request_id: str | None = Field(None, description="As in X-Request-ID and the logs.")
    errors: list[Violation] = Field(
        [], description="Each wrong field: where, value, rule, way out."
    )


class LateProblem(Problem):
    """The time budget ended: a problem document with the best answer found by then."""

    best: Design | CamSet | None = Field(
        None,
        description="The best certified design found in time, if any; of a cam set all cams, "
        "each as good as was found.",
    )


def problem_document(
    kind: ProblemType,
    detail: str,
    errors: list[dict[str, Any]] | None = None,
    best: Design | CamSet | None = None,
) -> dict[str, Any]:
    """A problem document without what it takes from the request."""
    return {
        "type": f"/problems/{kind.slug}",
        "title": kind.title,
        "status": kind.status,
        "detail": detail,
        **({"errors": errors} if errors else {}),
        **({"best": best.model_dump(mode="json")} if best else {}),
    }


def problem_of(error: Exception) -> dict[str, Any]:
    """The problem document of an exception; one that is not in the table is a 500."""
    kind, violations = problem_type(error), getattr(error, "violations", None)
    if kind is ProblemType.INTERNAL:
        return problem_document(kind, "An error of the service, which has been logged.")
    if isinstance(error, InputError):
        wrong = violation(error.value, error.rule, error.remedy)
        violations = [{"pointer": error.field, **wrong}]
    meant_for_callers = isinstance(error, ServiceError | CamwrightError)
    detail = str(error) if meant_for_callers else f"{kind.title}."
    if is_damage(error):
        detail = "Its database is damaged where this is kept; its operator has to restore a backup."
    best = error.best if isinstance(error, TimeBudgetExceeded) else None
    return problem_document(kind, detail, violations, best)


def problem_response(
    request: Request, problem: dict[str, Any], headers: Mapping[str, str] | None = None
) -> Response:
    """The response with a problem document."""
    fields = {"instance": request.url.path, "request_id": request.scope.get("request_id")}
    text = json.dumps({**problem, **fields}, ensure_ascii=False, allow_nan=False)
    body = text.encode("utf-8", "replace")
    return Response(body, problem["status"], dict(headers or {}), MEDIA_TYPE)


def error_response(request: Request, error: Exception) -> Response:
    """The response to a request that raised an exception."""
    problem = problem_of(error)
    if problem_type(error) is ProblemType.INTERNAL:
        logging.getLogger("camwright").error("unexpected", exc_info=error)
    again = {"Retry-After": STORE_AGAIN_S} if isinstance(error, SQLAlchemyError) else None
    # A GET has no body that a pointer could point into: the field is a query parameter.
    if isinstance(error, InputError) and request.method == "GET":
        (violation,) = problem["errors"]
        violation["parameter"] = violation.pop("pointer").removeprefix("/")
        problem = problem_document(ProblemType.INVALID_PARAMETER, str(error), [violation])
    return problem_response(request, problem, getattr(error, "headers", again))


async def _known(request: Request, error: Exception) -> Response:
    return error_response(request, error)


async def _http(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    status, headers = error.status_code, error.headers
    kind = next((kind for kind in STARLETTES if kind.status == status), None)
    title = kind.title if kind else str(error.detail)
    hint = "See /docs for what there is."
    if kind is ProblemType.METHOD_NOT_ALLOWED:  # a route knows only its own method
        allowed = ", ".join(
            method
            for method in ("GET", "POST", "PUT", "PATCH", "DELETE")
            for scope in [{**request.scope, "method": method}]
            if any(each.matches(scope)[0] == Match.FULL for each in request.app.router.routes)
        ).replace("GET", "GET, HEAD")
        headers, hint = {"Allow": allowed}, f"It has {allowed}."
    elif kind is ProblemType.NOT_FOUND:
        hint = _paths_beside(request) or hint
    detail = f"{request.method} {request.url.path}: {title}. {hint}"
    problem = {"type": "/problems/http", "title": title, "status": status, "detail": detail}
    if kind is not None:
        problem = problem_document(kind, detail)
    return problem_response(request, problem, headers)


def _paths_beside(request: Request) -> str:
    """What there is beside a path that leads nowhere, such as the files of a design; '' if nothing.

    Of templates, a part in braces stands for any.
    """
    *above, last = request.url.path.rstrip("/")[:LONGEST_PATH].split("/")
    routes = request.app.router.routes
    inner = (
        getattr(getattr(route, "original_router", None), "routes", [route]) for route in routes
    )
    paths = (getattr(route, "path", "") for several in inner for route in several)
    known = {path.strip("/") for path in paths if "{path" not in path}
    beside = set()
    for *own, end in (f"/{path}".split("/") for path in known):
        same = len(own) == len(above)
        if same and all(x == y or x[:1] == "{" for x, y in zip(own, above, strict=True)):
            beside.add(end)
    files = sorted(end for end in beside if end and end[0] != "{")
    question = did_you_mean(last, files)
    if len(above) > 1 and files:
        return f"{question} There are: {', '.join(files)}.".strip()
    fixed = [f"/{path}" for path in known if "{" not in path]
    return did_you_mean(request.url.path, fixed)


def _options(request: Request) -> type[BaseModel] | None:
    """The model of a route's query parameters, where it has one."""
    dependant = getattr(request.scope.get("route"), "dependant", None)
    types = (each.field_info.annotation for each in getattr(dependant, "query_params", ()))
    return next((t for t in types if isinstance(t, type) and issubclass(t, BaseModel)), None)


async def _parameters(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    query = dict(request.query_params)
    violations = describe_parameter_errors(error.errors(), query, _options(request))
    detail = "; ".join(
        f"{each['parameter']} {each['rule'].rstrip('.')}. {each['remedy']}" for each in violations
    )
    return problem_response(
        request, problem_document(ProblemType.INVALID_PARAMETER, detail, violations)
    )


def install(app: FastAPI) -> None:
    """Make the application answer every error with a problem document."""
    exceptions: list[type[Exception]] = [ServiceError, *TYPES]
    for exception in exceptions:
        app.add_exception_handler(exception, _known)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(RequestValidationError, _parameters)
