"""Read a JSON body of limited size strictly, and validate it against a model.

The work is linear in the size of the body, whatever it contains: it runs in the event loop, which
answers no other request meanwhile.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any, TypeVar

from fastapi import Request
from pydantic import BaseModel, ValidationError

from service.wire.errors import ProblemType, ServiceError
from synthesis.errors.schema import all_names
from synthesis.errors.values import LEAVE_OUT
from synthesis.errors.violations import (
    MAX_LISTED,
    describe_errors,
    pointer_to,
    unknown_field,
    violation,
)

Model = TypeVar("Model", bound=BaseModel)
Path = list[str | int]

# Pydantic takes about 3 µs to build each error; beyond this many, they are not built.
MAX_ITEMISED = 1000
READ_ON = 32  # times the limit: so much of a refused body is read, so that clients see the answer
VALID = "Send valid JSON."
LONGEST_WORD = 20  # characters, blanks before it included, of what JSON has otherwise
# What other languages have that JSON has not, by how it begins.
OTHERWISE = {
    "'": "JSON has double quotes around texts and names.",
    "}": "Leave out the comma before it.",
    "]": "Leave out the comma before it.",
    "True": "JSON writes true, false and null.",
    "False": "JSON writes true, false and null.",
    "None": "JSON writes true, false and null.",
    "//": "JSON has no comments.",
    "#": "JSON has no comments.",
    ".": "A number begins with a digit: 0.5.",
    "+": "A number has no plus sign before it.",
}
TOO_DEEP = "The body is nested too deeply. A design needs five levels."


async def read_body(request: Request, model: type[Model], max_bytes: int) -> tuple[Model, bytes]:
    """The body of a request as ``model``, and its bytes; see ``validate`` for the errors raised."""
    chunks, size = [], 0
    async for chunk in request.stream():
        size += len(chunk)
        if size > READ_ON * max_bytes:
            break
        chunks.append(chunk if size <= max_bytes else b"")
    if size > max_bytes:
        raise ProblemType.BODY_TOO_LARGE(
            f"The body is larger than {max_bytes} bytes, the limit of this server. "
            "A design with 100 segments needs less than 50 kB."
        )
    declared = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    subtype = declared.removeprefix("application/")
    if declared == subtype or not (subtype == "json" or subtype.endswith("+json")):
        raise ProblemType.WRONG_MEDIA_TYPE(
            f"Content-Type is {declared[:80]!r}. Send the design with "
            "Content-Type: application/json.",
            {"Accept": "application/json"},
        )
    body = b"".join(chunks)
    return validate(body, model), body


def validate(body: bytes, model: type[Model]) -> Model:
    """Bytes as ``model``, in strict mode; ServiceError where they are no JSON, or of no model."""
    known = all_names(model)
    document, unknown = _decode(body, known)
    if known is not None and unknown > MAX_ITEMISED:
        wrong = (
            unknown_field(tuple(path[1:]), document, model)
            for path, _ in _walk(document)
            if isinstance(path[-1], str) and path[-1] not in known and len(path) > 1
        )
        raise _invalid_request(list(islice(wrong, MAX_LISTED)), unknown)
    try:
        return _strictly(body, model)
    except ValidationError as error:
        invalid = error
    count = invalid.error_count()
    if count > MAX_ITEMISED:
        rule, remedy = f"has {count} errors, too many to list", "Compare it with those in /docs."
        raise _invalid_request([{"pointer": "", **violation(None, rule, remedy)}], 1)
    errors = invalid.errors(include_url=False)
    if errors[0]["type"] == "json_invalid":  # what Python's reader accepts and pydantic's does not
        reason = str(errors[0].get("ctx", {}).get("error", ""))
        raise ProblemType.NOT_JSON(
            TOO_DEEP if "recursion" in reason else f"{reason}. Send valid JSON."
        )

    def errors_of(changed: Any) -> Sequence[Any]:
        try:
            _strictly(json.dumps(changed).encode(), model)
        except ValidationError as error:
            few = error.error_count() <= MAX_ITEMISED
            return error.errors(include_url=False) if few else ()
        return ()

    raise _invalid_request(*describe_errors(errors, document, model, errors_of))


def _strictly(body: bytes, model: type[Model]) -> Model:
    """Bytes as ``model``, with the errors of pydantic as they come."""
    made: Model = model.__pydantic_validator__.validate_json(body, strict=True)
    return made


def parse_json(body: bytes) -> Any:
    """Bytes as plain JSON; ServiceError for NaN, Infinity and repeated names too."""
    return _decode(body, None)[0]


def _decode(body: bytes, known: frozenset[str] | None) -> tuple[Any, int]:
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
            ((name, _),) = Counter(name for name, _ in pairs).most_common(1)
            raise ProblemType.NOT_JSON(
                f"The name {name!r:.80} occurs twice in one object. Keep one of the two."
            )
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
            f"Line {error.lineno}, column {error.colno}: {error.msg}. {_in_json(error)}"
        ) from None
    except UnicodeDecodeError:
        raise ProblemType.NOT_JSON("The body is not UTF-8. Send JSON in UTF-8.") from None
    except RecursionError:
        raise ProblemType.NOT_JSON(TOO_DEEP) from None
    except ValueError as error:
        raise ProblemType.NOT_JSON("The body holds a number of thousands of digits.") from error
    if constants:
        rule, remedy = "must be a finite number; JSON does not have this word", LEAVE_OUT
        wrong = (
            {"pointer": pointer_to(path[1:]), **violation(str(value), rule, remedy)}
            for path, value in _walk(document)
            if type(value) is _NotANumber
        )
        raise _invalid_request(list(islice(wrong, MAX_LISTED)), constants)
    return document, unknown


def _in_json(error: json.JSONDecodeError) -> str:
    """What JSON has in place of what stands where reading it ended."""
    found = error.doc[error.pos : error.pos + LONGEST_WORD].lstrip()
    if found[:1] in "}]" and not error.doc[: error.pos].rstrip().endswith(","):
        return VALID
    return next((said for begin, said in OTHERWISE.items() if found.startswith(begin)), VALID)


class _NotANumber(str):
    """NaN, Infinity or -Infinity in place of a number."""

    __slots__ = ()


def _walk(document: Any) -> Iterator[tuple[Path, Any]]:
    """Every value of a document with its path, in document order; all paths begin with "".

    Not recursive, for deep documents, and one list is the path of all values: copy it to keep it.
    """
    path: Path = []
    levels: list[Iterator[tuple[str | int, Any]]] = [iter([("", document)])]
    while levels:
        child = next(levels[-1], None)
        if child is None:
            levels.pop()
            del path[-1:]
            continue
        part, value = child
        path.append(part)
        yield path, value
        pairs = value.items() if isinstance(value, dict) else ()
        levels.append(iter(enumerate(value) if isinstance(value, list) else pairs))


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
