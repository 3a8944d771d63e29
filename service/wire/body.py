"""Read a JSON body strictly and validate it against a model.

The work is linear in the size of the body, whatever it contains: it runs in the event loop, which
answers no other request meanwhile.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import islice
from typing import Any, TypeVar

from fastapi import Request
from pydantic import BaseModel, ValidationError

from service.wire.errors import ProblemType, ServiceError
from service.wire.schema_walk import all_names
from service.wire.violations import (
    MAX_LISTED,
    describe_errors,
    pointer_to,
    unknown_field,
)

Model = TypeVar("Model", bound=BaseModel)
Path = list[str | int]

# Pydantic takes about 3 µs to build each error; beyond this many, they are not built.
MAX_ITEMISED = 1000
TOO_DEEP = "The body is nested too deeply. A design needs five levels."


async def read_body(request: Request, model: type[Model]) -> Model:
    """The body of a request as ``model``; see ``validated`` for the errors raised."""
    _require_json(request.headers.get("content-type"))
    return validated(await request.body(), model)


def validated(body: bytes, model: type[Model]) -> Model:
    """Bytes as ``model``, in strict mode: no number is read from a text.

    Raises:
        ServiceError: the bytes are not JSON, or do not satisfy the model.
    """
    known = all_names(model)
    document, unknown = _decoded(body, known)
    if known is not None and unknown > MAX_ITEMISED:
        paths = _paths_of_unknown_names(document, known)
        violations = [unknown_field(path, document, model) for path in islice(paths, MAX_LISTED)]
        raise _invalid_request(violations, unknown)
    try:
        return model.model_validate_json(body, strict=True)
    except ValidationError as error:
        raise _invalid(error, document, model) from None


def parsed(body: bytes) -> Any:
    """Bytes as plain JSON, without NaN and without repeated names.

    Raises:
        ServiceError: the bytes are not JSON, which has neither NaN nor Infinity.
    """
    return _decoded(body, None)[0]


def _decoded(body: bytes, known: frozenset[str] | None) -> tuple[Any, int]:
    """The document, and how many of its names are not among the known ones (None: all are)."""
    if not body.strip():
        raise ProblemType.NOT_JSON(
            "The body is empty. Send a JSON object; /docs holds worked examples."
        )
    unknown = constants = 0

    def make_object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        nonlocal unknown
        result = dict(pairs)
        if len(result) != len(pairs):
            raise ProblemType.NOT_JSON(_repeated_name(pairs))
        if known is not None and not known.issuperset(result):
            unknown += len(result.keys() - known)
        return result

    def make_constant(word: str) -> _NotANumber:
        nonlocal constants
        constants += 1
        return _NotANumber(word)

    try:
        document = json.loads(body, object_pairs_hook=make_object, parse_constant=make_constant)
    except json.JSONDecodeError as error:
        raise ProblemType.NOT_JSON(
            f"Line {error.lineno}, column {error.colno}: {error.msg}. Send valid JSON."
        ) from None
    except UnicodeDecodeError:
        raise ProblemType.NOT_JSON("The body is not UTF-8. Send JSON in UTF-8.") from None
    except RecursionError:
        raise ProblemType.NOT_JSON(TOO_DEEP) from None
    except ValueError as error:
        raise ProblemType.NOT_JSON("The body holds a number of thousands of digits.") from error
    if constants:
        raise _not_numbers(document, constants)
    return document, unknown


def _repeated_name(pairs: list[tuple[str, Any]]) -> str:
    seen: set[str] = set()
    for name, _ in pairs:
        if name in seen:
            return f"The name {name!r:.80} occurs twice in one object. Keep one of the two."
        seen.add(name)
    raise AssertionError("no name is repeated")


class _NotANumber(str):
    """NaN, Infinity or -Infinity in place of a number."""

    __slots__ = ()


def _not_numbers(document: Any, count: int) -> ServiceError:
    """The error for NaN and Infinity, with the places of the first of them."""
    constants = ((path, value) for path, value in _walk(document) if type(value) is _NotANumber)
    violations = [
        {
            "pointer": pointer_to(path),
            "value": value,
            "rule": "must be a finite number; JSON does not have this word",
            "remedy": "Leave it out, or give a number.",
        }
        for path, value in islice(constants, MAX_LISTED)
    ]
    return _invalid_request(violations, count)


def _paths_of_unknown_names(document: Any, known: frozenset[str]) -> Iterator[Path]:
    for path, _ in _walk(document):
        if path and isinstance(path[-1], str) and path[-1] not in known:
            yield path


def _walk(document: Any) -> Iterator[tuple[Path, Any]]:
    """Every value of a document with its path, in document order.

    Not recursive, for deep documents, and one list is the path of all values: copy it to keep it.
    """
    path: Path = []
    yield path, document
    levels = [_children(document)]
    while levels:
        child = next(levels[-1], None)
        if child is None:
            levels.pop()
            if path:
                path.pop()
            continue
        part, value = child
        path.append(part)
        yield path, value
        if isinstance(value, dict | list):
            levels.append(_children(value))
        else:
            path.pop()


def _children(value: Any) -> Iterator[tuple[str | int, Any]]:
    if isinstance(value, dict):
        return iter(value.items())
    return iter(enumerate(value)) if isinstance(value, list) else iter(())


def _invalid(error: ValidationError, document: Any, model: type[BaseModel]) -> Exception:
    """The violations that pydantic found, as an error of the service."""
    count = error.error_count()
    if count > MAX_ITEMISED:
        rule, remedy = f"has {count} errors, too many to list", "Compare it with those in /docs."
        violations = [{"pointer": "", "value": None, "rule": rule, "remedy": remedy}]
        return _invalid_request(violations, 1)
    errors = error.errors(include_url=False)
    if errors[0]["type"] == "json_invalid":  # what Python's reader accepts and pydantic's does not
        reason = str(errors[0].get("ctx", {}).get("error", ""))
        return ProblemType.NOT_JSON(
            TOO_DEEP if "recursion" in reason else f"{reason}. Send valid JSON.",
        )
    violations, places = describe_errors(errors, document, model)
    return _invalid_request(violations, places)


def _require_json(content_type: str | None) -> None:
    declared = (content_type or "").partition(";")[0].strip().lower()
    subtype = declared.removeprefix("application/")
    if declared == subtype or not (subtype == "json" or subtype.endswith("+json")):
        raise ProblemType.WRONG_MEDIA_TYPE(
            f"Content-Type is {declared[:80]!r}. Send the design with "
            "Content-Type: application/json.",
            {"Accept": "application/json"},
        )


def _invalid_request(violations: list[dict[str, Any]], count: int) -> ServiceError:
    """The error for these violations, of ``count`` in all; its text is the first in words."""
    first, more = violations[0], ""
    if count > len(violations):
        more = f" ({count} errors in all; the first {len(violations)} are under errors)"
    elif count > 1:
        more = f" ({count - 1} more under errors)"
    where = first["pointer"] or "the body"
    detail = f"{where}: {first['rule'].rstrip('.')}. {first['remedy']}{more}"
    return ProblemType.INVALID_REQUEST(detail, violations=violations)
