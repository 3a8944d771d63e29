"""Validation errors of pydantic as violations: where, value, rule, what to write instead.

Causes come before consequences: what is sure to be meant is written into a copy of the document,
which is validated again. An error that is gone then was a consequence, and is not told; one that
only shows then is told too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, get_args

from pydantic_core.core_schema import ErrorType

from synthesis.errors.names import meant_kind
from synthesis.errors.places import PLACES
from synthesis.errors.schema import (
    Body,
    Loc,
    Path,
    fields_at,
    is_required,
    kinds_of,
    schemas_at,
    value_at,
)
from synthesis.errors.values import (
    COMPARISONS,
    GIVE_A_NUMBER,
    LISTS,
    NUMBERS,
    OBJECTS,
    PLAIN,
    abbreviate,
    add_field,
    as_number,
    is_entry,
    missing_kind,
    not_a_list,
    not_a_number,
    not_an_object,
    out_of_range,
    which_kind,
)
from synthesis.errors.wrong_names import answer_name

MAX_LISTED = 50  # violations in one answer
LONGEST_POINTER = 500  # characters; the names of fields are at most 28 long
FEW = 8  # words that are all listed even where it is clear which one is meant
ROUNDS = 3  # of writing what is meant: names hide values, and these hide sums
SHAPES = ("model_type", "model_attributes_type", "list_type", "dict_type", "float_type")
# Other types are raised by the core, with messages "Rule. What to do." and numbers.
PYDANTICS_OWN = frozenset(get_args(ErrorType))
COUNTING = ("position", "segment", "other", "j", "k")  # names of numbers in them that say where
# What is told first: wrong names and kinds, then wrong values, then what is missing.
NAMES = ("extra_forbidden", "union_tag_invalid", "union_tag_not_found")

Validate = Callable[[Any], Sequence[Any]]  # a document's errors, as pydantic lists them


@dataclass(frozen=True)
class Change:
    """What is sure to be meant: the value that stands at ``path``, perhaps elsewhere, or another.

    ``to``: its path in the changed document; () where it is the whole document.
    """

    path: Loc
    to: Loc
    value: Any


@dataclass(frozen=True)
class Finding:
    """One error: its place, value, rule and remedy, and the change that mends it, where sure.

    ``kind``: pydantic's type of the error.
    """

    path: Loc
    value: Any
    rule: str
    remedy: str
    change: Change | None = None
    kind: str = ""

    def violation(self) -> dict[str, Any]:
        """The fields of a violation on the wire."""
        fields = violation(self.value, self.rule, self.remedy)
        return {"pointer": pointer_to(self.path), **fields}


# An error of pydantic, its path in the document, and whether the value lacks the shape of the
# union's member that the error is of.
_Located = tuple[Any, Loc, bool]


def violation(value: Any, rule: str, remedy: str) -> dict[str, Any]:
    """A violation without its place: the fields of ``Violation`` for a document."""
    return {"value": abbreviate(value), "rule": rule, "remedy": remedy}


def pointer_to(path: Path) -> str:
    """The JSON pointer of a path, '' for the whole document; absurdly long ones are cut."""
    parts = (str(part).replace("~", "~0").replace("/", "~1") for part in path)
    pointer = "".join(f"/{part}" for part in parts)
    return pointer if len(pointer) <= LONGEST_POINTER else pointer[: LONGEST_POINTER - 1] + "…"


def locate(body: Any, loc: Loc, kind: str) -> tuple[Loc, tuple[str, ...]]:
    """The path in the document of a location of pydantic's, and the names that pydantic inserts.

    It inserts the tags of discriminated unions and the names of union members: whatever is neither
    a key nor an index of the document at that point.
    """
    path: list[str | int] = []
    inserted: list[str] = []
    at = body
    for i, part in enumerate(loc):
        last = i == len(loc) - 1
        if isinstance(at, dict) and part in at:
            at = at[str(part)]
        elif isinstance(at, list) and isinstance(part, int) and part < len(at):
            at = at[part]
        elif not (last and kind == "missing"):
            inserted.append(str(part))
            continue
        path.append(part)
    return tuple(path), tuple(inserted)


def describe_errors(
    errors: Sequence[Any], body: Any, model: Body, validate: Validate | None = None
) -> tuple[list[dict[str, Any]], int]:
    """The first violations of a body, as documents list them; see ``find_causes``."""
    found, count = find_causes(errors, body, model, validate)
    return [each.violation() for each in found], count


def find_causes(
    errors: Sequence[Any], body: Any, model: Body, validate: Validate | None = None
) -> tuple[list[Finding], int]:
    """What is wrong with a body that ought to be a ``model``, at most 50, and how much there is.

    Args:
        errors: as ``ValidationError.errors()`` gives them. body: the parsed document.
        validate: of the model; None: no consequence is told from its cause.
    """
    found, places = _findings(errors, body, model)
    renamed: list[tuple[Loc, Loc]] = []  # path in the changed document, and in the one before
    document, new = body, found
    for _ in range(ROUNDS):
        changes = [each.change for each in new if each.change is not None]
        if validate is None or not changes:
            break
        document = _with_changes(document, changes)
        renamed[:0] = [(each.to, each.path) for each in changes if each.to != each.path]
        later = [
            replace(each, path=_as_sent(each.path, renamed))
            for each in _findings(validate(document), document, model)[0]
        ]
        left = {(each.path, each.rule) for each in later}
        known = {(each.path, each.rule) for each in found}
        new = [each for each in later if (each.path, each.rule) not in known]
        kept = [each for each in found if each.change or (each.path, each.rule) in left]
        found = [*kept, *new]
    return found[:MAX_LISTED], places if places > MAX_LISTED else len(found)


def _as_sent(path: Loc, renamed: Sequence[tuple[Loc, Loc]]) -> Loc:
    """A path of a changed document in the document as it was sent; the newest changes first."""
    for new, old in renamed:
        if path[: len(new)] == new:
            path = (*old, *path[len(new) :])
    return path


def _with_changes(document: Any, changes: Sequence[Change]) -> Any:
    """The document with changes; what is changed inside is copied once, all else shared."""
    copies: dict[Loc, Any] = {}

    def own(path: Loc) -> Any:
        if path not in copies:
            if path:
                holder = own(path[:-1])
                copies[path] = holder[path[-1]] = holder[path[-1]].copy()
            else:
                copies[path] = document.copy()
        return copies[path]

    for change in changes:
        if not change.to:
            return change.value
        if change.to != change.path:
            del own(change.path[:-1])[change.path[-1]]
        own(change.to[:-1])[change.to[-1]] = change.value
    return copies[()]


def _findings(errors: Sequence[Any], body: Any, model: Body) -> tuple[list[Finding], int]:
    """The first findings of errors, and in how many places there are errors."""
    by_path: dict[Loc, list[_Located]] = {}
    # For each place whose value may be one of several types: whether the value lacks the shape of
    # a type, for each error.
    shapes: dict[Loc, set[bool]] = {}
    for error in sorted(errors, key=_rank):
        path, inserted = locate(body, error["loc"], error["type"])
        if error["type"] in PLACES:  # a rule over several fields, within the spec that breaks it
            place = [part.format(**error.get("ctx") or {}) for part in PLACES[error["type"]]]
            within = path.index(place[0]) if place[0] in path else len(path)
            path = (*path[:within], *place)
        # The names of a union's members, without tags.
        plain = ("float", "int", "str")
        members = [n for n in inserted if "[" in n or n.removeprefix("constrained-") in plain]
        # An error inside a member is of a value that has the member's shape.
        wrong_shape = bool(members) and error["type"] in SHAPES and str(error["loc"][-1]) in members
        by_path.setdefault(path, []).append((error, path, wrong_shape))
        for name in members:
            whole = locate(body, error["loc"][: error["loc"].index(name)], "")[0]
            shapes.setdefault(whole, set()).add(wrong_shape)
    found: list[Finding] = []
    places = 0
    for path, located in by_path.items():
        if False in shapes.get(path, set()):  # the value has the shape of another type
            located = [each for each in located if not each[2]]
        if not located:
            continue
        places += 1
        if len(found) < MAX_LISTED:
            found += _at_one_place(located, body, model)
    return found, max(places, len(found))


def _rank(error: Any) -> int:
    return 0 if error["type"] in NAMES else (2 if error["type"] == "missing" else 1)


def unknown_field(path: Loc, body: Any, model: Body) -> dict[str, Any]:
    """The violation of a name at ``path`` that no field has."""
    return _unknown(path, body, model).violation()


def _unknown(path: Loc, body: Any, model: Body) -> Finding:
    answer = answer_name(path, body, model)
    change = None if answer.to is None else Change(path, answer.to, answer.value)
    return Finding(path, value_at(body, path), "is not a field here", answer.remedy, change)


def _at_one_place(located: Sequence[_Located], body: Any, model: Body) -> list[Finding]:
    """The findings at one place; those of a union's members become one."""
    found = [
        replace(_describe(error, path, body, model), kind=error["type"])
        for error, path, _ in located
    ]
    if len(found) > 1 and all(wrong_shape for *_, wrong_shape in located):
        first, *rest = dict.fromkeys(each.rule for each in found)
        rule = " or ".join([first, *(other.removeprefix("must be ") for other in rest)])
        sure = next((each for each in found if each.change), found[0])
        return [replace(sure, rule=rule)]
    return list({(each.rule, each.remedy): each for each in found}.values())


def _describe(error: Any, path: Loc, body: Any, model: Body) -> Finding:
    kind, ctx, value = error["type"], error.get("ctx") or {}, error.get("input")
    schemas = schemas_at(body, path, model)
    if kind in COMPARISONS:
        return Finding(path, value, *out_of_range(error, path, body, schemas))
    if kind == "missing":
        schema = fields_at(body, path[:-1], model).get(str(path[-1]) if path else "", {})
        return Finding(path, None, "is required", add_field(path[-1] if path else "", schema))
    if kind == "extra_forbidden":
        return _unknown(path, body, model)
    if kind in ("union_tag_invalid", "literal_error"):
        return _other_word(error, path, body)
    if kind == "union_tag_not_found":
        return _without_kind(path, body, model, str(ctx["discriminator"]).strip("'"))
    if kind == "finite_number":
        return Finding(path, value, "must be a finite number", GIVE_A_NUMBER)
    if kind in ("too_long", "too_short"):
        most = kind == "too_long"
        bound = ctx["max_length" if most else "min_length"]
        has = f", not {ctx['actual_length']}" if ctx.get("actual_length") is not None else ""
        rule = f"must have at {'most' if most else 'least'} {bound} entries{has}"
        return Finding(path, value, rule, "Leave some out." if most else "Add what is missing.")
    if kind in ("string_too_long", "string_too_short"):
        most = kind == "string_too_long"
        bound = ctx["max_length" if most else "min_length"]
        rule = f"must have at {'most' if most else 'least'} {bound} characters"
        return Finding(path, value, rule, "Shorten it." if most else "Give a longer text.")
    if kind not in PYDANTICS_OWN:
        return _of_the_core(error, path, ctx)
    return _wrong_shape(error, path, body, model)


def _other_word(error: Any, path: Loc, body: Any) -> Finding:
    """A word that is not among those that there are."""
    ctx = error.get("ctx") or {}
    listed = str(ctx.get("expected_tags") or ctx["expected"]).replace(" or ", ",")
    allowed = [word.strip(" '") for word in listed.split(",")]
    given = error.get("input")
    if "discriminator" in ctx:  # of it pydantic tells what stands there as a text, null as "None"
        path = (*path, str(ctx["discriminator"]).strip("'"))
        given = value_at(body, path)
    remedy, word = which_kind(given, allowed)
    rule = f"must be one of {', '.join(allowed)}"
    if word is not None and len(allowed) > FEW:
        rule = f"is not a {'kind' if path[-1:] == ('kind',) else 'word'} here"
    change = Change(path, path, word) if word else None
    return Finding(path, given, rule, remedy, change)


def _without_kind(path: Loc, body: Any, model: Body, tag: str) -> Finding:
    """An object without the kind that says which of several it is."""
    inside, members = value_at(body, path), schemas_at(body, path, model)
    known = {name for member in members for name in member.get("properties", {})}
    for name in inside if isinstance(inside, dict) else ():
        if name not in known:
            found = _unknown((*path, name), body, model)
            if found.change is not None and found.change.to == (*path, tag):
                return found
    return Finding((*path, tag), None, "is required", missing_kind(inside, members))


def _of_the_core(error: Any, path: Loc, ctx: Any) -> Finding:
    # Values of the caller in a message may hold ". " too: they are hidden while it is parted.
    message: str = error["msg"]
    texts = [text for text in ctx.values() if isinstance(text, str) and ". " in text]
    for i, text in enumerate(texts):
        message = message.replace(text, f"\0{i}\0")
    rule, _, remedy = message.partition(". ")
    for i, text in enumerate(texts):
        rule, remedy = (part.replace(f"\0{i}\0", text) for part in (rule, remedy))
    numbers = (each for key, each in ctx.items()
               if isinstance(each, int | float) and key not in COUNTING)  # fmt: skip
    return Finding(path, ctx.get("value", next(numbers, None)), f"{rule}.", remedy)


def _wrong_shape(error: Any, path: Loc, body: Any, model: Body) -> Finding:
    """A text where a number belongs, an object where a list does, and so on."""
    kind, value = error["type"], error.get("input")
    schemas, change = schemas_at(body, path, model), None
    rule = PLAIN.get(kind, error["msg"].replace("Input should be", "must be"))
    remedy = "Correct it; /docs shows the schema and worked examples."
    field: Any = path[-1] if path else ""
    if kind in NUMBERS:
        remedy = not_a_number(kind, value, path, schemas, is_required(body, path, model))
        number = as_number(value, str(field))
        if number is not None and path and not kind.startswith("int"):
            change = Change(path, path, number)
    elif kind in OBJECTS:
        if any("min" in each.get("properties", {}) for each in schemas):
            rule = "must be a range"
        remedy = not_an_object(value, schemas, path)
        word = meant_kind(value, kinds_of(schemas)) if isinstance(value, str) else None
        if word is not None:
            change = Change(path, path, {"kind": word})
    elif kind in LISTS:
        items = schemas_at(body, [*path, 0], model)
        remedy = not_a_list(value, schemas, items, is_required(body, path, model))
        if is_entry(value, items):
            change = Change(path, path, [value])
    elif kind == "string_type":
        remedy = "Write it in quotes."
    elif kind.startswith("bool"):
        remedy = f"Write true or false{', without quotes' if kind == 'bool_type' else ''}."
    return Finding(path, value, rule, remedy, change)
