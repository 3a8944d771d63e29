"""The fields that the schema of a body has at a place of a document, for hints in messages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

from pydantic import BaseModel

Schema = dict[str, Any]


@cache
def _whole(model: type[BaseModel]) -> Schema:
    return model.model_json_schema()


@cache
def all_names(model: type[BaseModel]) -> frozenset[str] | None:
    """The name of every field at any place of a body; None where other names are allowed too."""
    whole = _whole(model)
    objects = [each for each in _schemas(whole) if each.get("type") == "object"]
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


def properties_at(
    body: Any, path: Sequence[str | int], model: type[BaseModel] | None
) -> dict[str, str]:
    """Names and descriptions of the fields of the object at ``path``; empty where unknown.

    Args:
        body: the document. path: a place in it. model: what it ought to be, if that is known.
    """
    if model is None:
        return {}
    whole = _whole(model)
    schemas, at = [whole], body
    for part in path:
        schemas = [below for schema in schemas for below in _below(schema, at, part, whole)]
        at = _child(at, part)
    fields: dict[str, str] = {}
    for schema in schemas:
        for member in _members(schema, at, whole):
            for name, inner in member.get("properties", {}).items():
                fields.setdefault(name, inner.get("description", ""))
    return fields


def _child(at: Any, part: str | int) -> Any:
    if isinstance(at, dict):
        return at.get(part)
    if isinstance(at, list) and isinstance(part, int) and part < len(at):
        return at[part]
    return None


def _below(schema: Schema, at: Any, part: str | int, whole: Schema) -> Iterator[Schema]:
    for member in _members(schema, at, whole):
        if isinstance(part, int) and "items" in member:
            yield member["items"]
        elif part in member.get("properties", {}):
            yield member["properties"][part]


def _members(schema: Schema, at: Any, whole: Schema) -> Iterator[Schema]:
    """The schema itself, or the members of a union that the value may be meant as."""
    schema = _resolved(schema, whole)
    tag = schema.get("discriminator", {})
    if tag:
        kind = at.get(tag["propertyName"]) if isinstance(at, dict) else None
        if isinstance(kind, str) and kind in tag["mapping"]:
            yield _resolved({"$ref": tag["mapping"][kind]}, whole)
        return
    options = schema.get("anyOf") or schema.get("oneOf")
    if not options:
        yield schema
        return
    for option in options:
        yield from _members(option, at, whole)


def _resolved(schema: Schema, whole: Schema) -> Schema:
    reference = schema.get("$ref")
    if reference is None:
        return schema
    target: Schema = whole["$defs"][reference.rpartition("/")[2]]
    return target
