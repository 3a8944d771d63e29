"""What a body may hold at a place, read from its JSON schema."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

from pydantic import BaseModel

Schema = dict[str, Any]
Path = Sequence[str | int]
Loc = tuple[str | int, ...]
Body = type[BaseModel] | None  # what a document ought to be; None: it is not one


@cache
def whole_schema(model: type[BaseModel]) -> Schema:
    """The schema of a body; of options, that of their form."""
    return model.model_json_schema()


def schemas_in(model: type[BaseModel]) -> Iterator[Schema]:
    """Every object of a body's schema, at any depth."""
    return _schemas(whole_schema(model))


@cache
def all_names(model: type[BaseModel]) -> frozenset[str] | None:
    """The name of every field at any place of a body; None where other names are allowed too."""
    objects = [each for each in schemas_in(model) if each.get("type") == "object"]
    if any(schema.get("additionalProperties") is not False for schema in objects):
        return None
    return frozenset(name for schema in objects for name in schema["properties"])


def _schemas(part: Any) -> Iterator[Schema]:
    """Every object of a schema, at any depth."""
    if isinstance(part, dict):
        yield part
    if isinstance(part, dict | list):
        for inner in part.values() if isinstance(part, dict) else part:
            yield from _schemas(inner)


def value_at(body: Any, path: Path) -> Any:
    """What stands at a place of a document; None where nothing does."""
    for part in path:
        try:
            body = body[part]
        except (LookupError, TypeError):
            return None
    return body


def schemas_at(body: Any, path: Path, model: Body) -> list[Schema]:
    """What the value at ``path`` may be: the members of unions one by one, empty where unknown.

    Of the members of a union that ``kind`` selects, the one that the body names; all of them where
    it names none.
    """
    if model is None:
        return []
    whole = whole_schema(model)
    members = list(_members(whole, body, whole))
    for part in path:
        inner = (
            member.get("items") if isinstance(part, int) else member.get("properties", {}).get(part)
            for member in members
        )
        below = [schema for schema in inner if schema is not None]
        body = value_at(body, [part])
        members = [member for schema in below for member in _members(schema, body, whole)]
    return members


def fields_at(body: Any, path: Path, model: Body) -> dict[str, Schema]:
    """The fields of the object at ``path``, by name; empty where unknown."""
    fields: dict[str, Schema] = {}
    for member in schemas_at(body, path, model):
        for name, inner in member.get("properties", {}).items():
            fields.setdefault(name, inner)
    return fields


def is_required(body: Any, path: Path, model: Body) -> bool:
    """Whether the field at ``path`` has to be there."""
    around = [each for each in schemas_at(body, path[:-1], model) if "properties" in each]
    return bool(around) and all(path[-1] in each.get("required", ()) for each in around)


def _members(schema: Schema, at: Any, whole: Schema) -> Iterator[Schema]:
    """The schema itself, or the members of a union that the value may be meant as.

    What the field says, as its description, goes with each.
    """
    said = {key: schema[key] for key in ("description",) if key in schema}
    if "$ref" in schema:
        schema = whole["$defs"][schema["$ref"].rpartition("/")[2]]
    tag = schema.get("discriminator", {})
    kind = at.get(tag["propertyName"]) if tag and isinstance(at, dict) else None
    if isinstance(kind, str) and kind in tag["mapping"]:
        yield whole["$defs"][tag["mapping"][kind].rpartition("/")[2]]
        return
    options = schema.get("anyOf") or schema.get("oneOf")
    if not options:
        yield {**schema, **said}
        return
    for option in options:
        yield from _members({**said, **option} if "$ref" not in option else option, at, whole)


@cache
def places(model: type[BaseModel]) -> dict[str, list[Loc]]:
    """Where in a body each name is a field: paths of the objects, the highest first.

    "…" stands for an entry of a list.
    """
    whole, found = whole_schema(model), dict[str, list[Loc]]()
    level: list[tuple[Loc, Schema, tuple[str, ...]]] = [((), whole, ())]
    while level:
        deeper: list[tuple[Loc, Schema, tuple[str, ...]]] = []
        for place, schema, seen in level:
            for member in _members(schema, None, whole):
                title = str(member.get("title", ""))
                if title in seen:  # a schema that holds itself
                    continue
                for name, inner in member.get("properties", {}).items():
                    own = found.setdefault(name, [])
                    if place not in own:
                        own.append(place)
                    deeper.append(((*place, name), inner, (*seen, title)))
                if "items" in member:
                    deeper.append(((*place, "…"), member["items"], seen))
        level = deeper
    return found


def kinds_of(schemas: Sequence[Schema]) -> list[str]:
    """The kinds that the fields named ``kind`` of these schemas allow."""
    found: list[str] = []
    for schema in schemas:
        kind = schema.get("properties", {}).get("kind", {})
        found += kind.get("enum") or ([kind["const"]] if "const" in kind else [])
    return found
