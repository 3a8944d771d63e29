"""Read JSON strictly, and validate it against a model.

Reading is linear in the size of the bytes, whatever they hold; the rules of a model that holds many
things at once may take longer. `body` decides in which process it is done.
"""

from __future__ import annotations

import contextlib
import json
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from service.wire.errors import ProblemType, ServiceError
from synthesis.errors.schema import all_names
from synthesis.errors.values import GIVE_A_NUMBER
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


@dataclass(frozen=True)
class Question:
    """A question that was read: what is asked of it often, and its spec as text.

    All that its id, the store and the workers need: the model itself stays in the process that read
    it. ``text``: the spec as ``model_dump_json`` writes it.
    """

    name: str
    time_budget_s: float | None
    text: str

    def model_dump_json(self) -> str:
        """The spec as JSON with all fields, as a model writes it."""
        return self.text


def read_question(body: bytes, model: type[BaseModel]) -> Question:
    """Bytes as a question; see ``validate`` for the errors raised."""
    spec: Any = validate(body, model)
    return Question(spec.name, getattr(spec, "time_budget_s", None), spec.model_dump_json())


def kept_question(name: str, spec: bytes) -> Question:
    """A question as the store has kept it: it was valid, and is not checked again."""
    return Question(name, json.loads(spec).get("time_budget_s"), spec.decode())


def prepare(models: Iterable[type[BaseModel]]) -> None:
    """Build what the first wrong body of each model needs: schemas, and tables of words."""
    for model in models:
        with contextlib.suppress(ServiceError):
            validate(b'{"hub": "1 in"}', model)


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
        rule, remedy = "must be a finite number; JSON does not have this word", GIVE_A_NUMBER
        wrong = (
            {"pointer": pointer_to(path[1:]), **violation(str(value), rule, remedy)}
            for path, value in _walk(document)
            if type(value) is _NotANumber
        )
        raise _invalid_request(list(islice(wrong, MAX_LISTED)), constants)
    return document, unknown


def _in_json(error: json.JSONDecodeError) -> str:
    """What JSON has in place of what stands where reading it ended."""
    at = error.pos
    at += error.doc[at : at + 1] == ","  # from Python 3.13 on it ends at a comma too many
    found = error.doc[at : at + LONGEST_WORD].lstrip()
    if found[:1] in "}]" and not error.doc[:at].rstrip().endswith(","):
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
