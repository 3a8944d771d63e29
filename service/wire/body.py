"""Reading a JSON body: strictly, once, and with a problem document for whatever is wrong."""

from __future__ import annotations

import json
from typing import Any, TypeVar

from fastapi import Request
from pydantic import BaseModel, ValidationError

from service.wire.errors import InvalidBody, NotJson, WrongMediaType
from service.wire.violations import of_body, pointer_to

Model = TypeVar("Model", bound=BaseModel)


async def read_body(request: Request, model: type[Model]) -> Model:
    """The body of a request as ``model``."""
    _declared_as_json(request.headers.get("content-type"))
    return validated(await request.body(), model)


def validated(body: bytes, model: type[Model]) -> Model:
    """Bytes as ``model``; numbers must be numbers, and nothing is guessed."""
    document = parsed(body)
    try:
        return model.model_validate_json(body, strict=True)
    except ValidationError as error:
        found = of_body(error.errors(include_url=False), document, model)
        raise InvalidBody(_in_words(found), found) from None


def parsed(body: bytes) -> Any:
    """Bytes as plain JSON: no NaN, no repeated names, not nested without end."""
    if not body.strip():
        raise NotJson("The body is empty. Send a JSON object; /docs holds worked examples.")
    foreign: list[str] = []
    try:
        document = json.loads(
            body, object_pairs_hook=_object, parse_constant=lambda word: foreign.append(word)
        )
    except json.JSONDecodeError as error:
        raise NotJson(
            f"Line {error.lineno}, column {error.colno}: {error.msg}. Send valid JSON."
        ) from None
    except UnicodeDecodeError:
        raise NotJson("The body is not UTF-8. Send JSON in UTF-8.") from None
    except RecursionError:
        raise NotJson("The body is nested too deeply. A design needs five levels.") from None
    except ValueError as error:
        raise NotJson("The body holds a number of thousands of digits.") from error
    if foreign:
        raise InvalidBody(*_not_numbers(body))
    return document


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result = dict(pairs)
    if len(result) != len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise NotJson(f"The name {twice!r:.80} occurs twice in one object. Keep one of the two.")
    return result


def _not_numbers(body: bytes) -> tuple[str, list[dict[str, Any]]]:
    """Where the document says NaN or Infinity, which JSON does not know."""

    def visit(at: Any, path: tuple[str | int, ...]) -> None:
        if isinstance(at, _Foreign):
            found.append(
                {
                    "pointer": pointer_to(path),
                    "value": at,
                    "rule": "must be a finite number; JSON knows no such word",
                    "way_out": "Leave it out, or give a number.",
                }
            )
        elif isinstance(at, dict):
            for key, inner in at.items():
                visit(inner, (*path, key))
        elif isinstance(at, list):
            for index, inner in enumerate(at):
                visit(inner, (*path, index))

    found: list[dict[str, Any]] = []
    visit(json.loads(body, parse_constant=_Foreign), ())
    return _in_words(found), found[:50]


class _Foreign(str):
    """A word in place of a number."""

    __slots__ = ()


def _declared_as_json(content_type: str | None) -> None:
    declared = (content_type or "").partition(";")[0].strip().lower()
    subtype = declared.removeprefix("application/")
    if declared == subtype or not (subtype == "json" or subtype.endswith("+json")):
        raise WrongMediaType(
            f"Content-Type is {declared[:80]!r}. Send the design with "
            "Content-Type: application/json.",
            {"Accept": "application/json"},
        )


def _in_words(found: list[dict[str, Any]]) -> str:
    if not found:
        return "The body does not fit. See /docs for the form."
    first = found[0]
    more = f" ({len(found) - 1} more under errors)" if len(found) > 1 else ""
    where = first["pointer"] or "the body"
    return f"{where}: {first['rule'].rstrip('.')}. {first['way_out']}{more}"
