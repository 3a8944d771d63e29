"""Validation errors of pydantic as violations: pointer, value, rule, way out.

Hints name the fields that the schema of a body has at a place of the document.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from functools import cache
from typing import Any, get_args

from pydantic import BaseModel, Field
from pydantic_core.core_schema import ErrorType

MAX_LISTED = 50  # violations in one answer
LONGEST_VALUE = 200  # characters of a wrong value that are sent back
LONGEST_POINTER = 500  # characters; the names of fields are at most 28 long
LONGEST_GUESSED = 80  # characters of a wrong name that are compared with the right ones
# Rules over several fields, by the place in the spec that the caller is pointed to. The spec may be
# part of a set. Names in braces are in the error's context.
PLACES = {
    kind: tuple(place.split("/"))
    for place, kinds in {
        "program": (
            "program_angles program_lift program_still numbers_do_not_fit swing_too_large "
            "face_turns_with_cam index_not_whole"
        ),
        "program/{segment}/{name}": "one_number_free",
        "program/{segment}/{end}": "states_differ state_not_met",
        "program/{segment}": (
            "state_not_neighbours state_backwards acceleration_alone law_backwards"
        ),
        "base_radius_mm": "base_radius_positive roller_fills_ring base_radius_inside_hub",
        "shaft_diameter_mm": "keyway_without_shaft keyway_has_no_standard ring_has_no_hub",
        "hub_diameter_mm": "hub_too_small",
        "follower/offset_mm": "offset_beyond_prime_radius",
        "program/{position}": "lift_does_not_suit",
        "limits/{position}": (
            "limit_unit_does_not_suit crown_leans limit_needs_load limit_needs_contact "
            "edge_has_no_pressure"
        ),
        "follower/centre_distance_mm": "centre_distance_positive face_swings_too_far",
        "follower": "arm_does_not_reach",
        "follower/arm_mm": "roller_on_pivot",
        "follower/{name}": "no_length_serves",
        "follower/initial_angle_deg": "initial_angle_range initial_angle_contradicts",
        "objective": (
            "no_best_pressure_angle pressure_angle_given objective_does_not_suit "
            "objective_needs_load process_not_steady"
        ),
        "limits": (
            "no_smallest_cam limit_does_not_suit nothing_keeps_large outer_radius_too_small "
            "vibration_too_far_off no_dwell_to_ring_in"
        ),
        "program/{position}/law": "spline_too_rough",
        "machine/{name}": "no_such_size",
        "machine": "machine_in_full rollers_vanish roller_beside_cylinder",
        "machine/roller_radius_mm": "rollers_overlap",
        "machine/centre_distance_mm": "grooves_reach_axis",
        "cams/{position}/spec/{field}": "cam_off_the_shaft",
        "axes/{position}/{name}": "axis_leads_nowhere axes_share_a_field balance_needs_numbers",
        "axes/{position}": "axis_without_count axes_of_unequal_length",
        "{name}": "wish_missing",
        "acceleration_rad_per_s2": "sized_at_constant_speed",
        "follower/roller_radius_mm": "groove_needs_roller",
        "follower/closure/rim_mm": "rim_without_ring",
        "load/kind": "load_does_not_suit",
        "load": "nothing_presses_follower",
        "load/friction": "friction_does_not_suit friction_needs_sense",
        "load/friction/overhang_mm": "overhang_too_short",
        "limits/{position}/min_n": "never_floats",
        "train/masses": "train_not_held train_grows",
        "speeds_rpm/{position}": "train_resonates",
        "machine/crown_radius_mm": "crown_too_round",
        "machine/roller_width_mm": "roller_reaches_axis",
        "machine/roller_distance_mm": "rollers_touch",
        "machine/initial_angle_deg": "arm_along_cam",
    }.items()
    for kind in kinds.split()
}
LEAVE_OUT = "Leave it out, or give a number."
SHAPES = ("model_type", "model_attributes_type", "list_type", "dict_type", "float_type")
OBJECTS = ("model_type", "model_attributes_type", "dict_type")
# Shapes in plain words.
PLAIN = {
    **dict.fromkeys(OBJECTS, "must be an object"),
    "list_type": "must be a list",
    "tuple_type": "must be a list",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "string_type": "must be a text",
}
# Other types are raised by the core, with messages "Rule. What to do." and numbers.
PYDANTICS_OWN = frozenset(get_args(ErrorType))
COMPARISONS = {
    "greater_than": ("gt", "must be greater than"),
    "greater_than_equal": ("ge", "must be at least"),
    "less_than": ("lt", "must be less than"),
    "less_than_equal": ("le", "must be at most"),
}

Loc = tuple[str | int, ...]
Schema = dict[str, Any]
Body = type[BaseModel] | None  # what a document ought to be; None: it is not one
# An error of pydantic, its path in the document, and whether the value lacks the shape of the
# union's member that the error is of.
_Located = tuple[Any, Loc, bool]


class Violation(BaseModel):
    """One error of the request."""

    pointer: str | None = Field(
        None, description="JSON pointer (RFC 6901) into the body as it was sent."
    )
    parameter: str | None = Field(
        None, description="Name of the query parameter, path part or header instead."
    )
    value: Any = Field(description="The value found there, shortened if it is long.")
    rule: str = Field(description="The rule that it breaks.")
    remedy: str = Field(description="What to do about it.")


def abbreviate(value: Any) -> Any:
    """A value as a problem document shows it: short, and valid JSON."""
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else ("Infinity" if value > 0.0 else "-Infinity")
    try:
        text = json.dumps(value, allow_nan=True, default=str, ensure_ascii=False)
    except (ValueError, RecursionError):
        return f"a {type(value).__name__}"
    if isinstance(value, bool | int | float | str | None) and len(text) <= LONGEST_VALUE:
        return value
    plain = len(text) <= LONGEST_VALUE and "NaN" not in text and "Infinity" not in text
    return value if plain else text[: LONGEST_VALUE - 1] + "…"


def violation(value: Any, rule: str, remedy: str) -> dict[str, Any]:
    """A violation without its place: the fields of ``Violation`` for a document."""
    return {"value": abbreviate(value), "rule": rule, "remedy": remedy}


def pointer_to(path: Sequence[str | int]) -> str:
    """The JSON pointer of a path, '' for the whole document; absurdly long ones are cut."""
    parts = (str(part).replace("~", "~0").replace("/", "~1") for part in path)
    pointer = "".join(f"/{part}" for part in parts)
    return pointer if len(pointer) <= LONGEST_POINTER else pointer[: LONGEST_POINTER - 1] + "…"


def locate(body: Any, loc: Loc, kind: str) -> tuple[tuple[str | int, ...], tuple[str, ...]]:
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
    errors: Sequence[Any], body: Any, model: Body
) -> tuple[list[dict[str, Any]], int]:
    """The first violations of a body that ought to be a ``model``, and how many places are wrong.

    Args:
        errors: as ``ValidationError.errors()`` gives them. body: the parsed document.
    """
    by_pointer: dict[str, list[_Located]] = {}
    # For each place whose value may be one of several types: whether the value lacks the shape of
    # a type, for each error.
    shapes: dict[str, set[bool]] = {}
    for error in errors:
        path, inserted = locate(body, error["loc"], error["type"])
        if error["type"] in PLACES:  # a rule over several fields, within the spec that breaks it
            place = [part.format(**error.get("ctx") or {}) for part in PLACES[error["type"]]]
            within = path.index(place[0]) if place[0] in path else len(path)
            path = (*path[:within], *place)
        if error["type"] in ("union_tag_invalid", "union_tag_not_found"):
            path = (*path, error["ctx"]["discriminator"].strip("'"))
        # The names of a union's members, without tags.
        plain = ("float", "int", "str")
        members = [n for n in inserted if "[" in n or n.removeprefix("constrained-") in plain]
        wrong_shape = bool(members) and error["type"] in SHAPES
        by_pointer.setdefault(pointer_to(path), []).append((error, path, wrong_shape))
        for name in members:
            whole = pointer_to(locate(body, error["loc"][: error["loc"].index(name)], "")[0])
            shapes.setdefault(whole, set()).add(wrong_shape)
    described: list[dict[str, Any]] = []
    places = 0
    for pointer, located in by_pointer.items():
        if False in shapes.get(pointer, set()):  # the value has the shape of another type
            located = [each for each in located if not each[2]]
        if not located:
            continue
        places += 1
        if len(described) < MAX_LISTED:
            described += _at_one_place(pointer, located, body, model)
    return described[:MAX_LISTED], max(places, len(described))


def unknown_field(path: Sequence[str | int], body: Any, model: Body) -> dict[str, Any]:
    """The violation of a name at ``path`` that no field has."""
    value = body
    for part in path:
        value = value[part]
    rule = "is not a field here"
    return {"pointer": pointer_to(path), **violation(value, rule, _suggest_name(path, body, model))}


def _at_one_place(
    pointer: str, located: Sequence[_Located], body: Any, model: Body
) -> list[dict[str, Any]]:
    """The violations at one pointer; those of a union's members become one."""
    entries = [
        {"pointer": pointer, **_describe(error, path, body, model)} for error, path, _ in located
    ]
    if len(entries) > 1 and all(wrong_shape for *_, wrong_shape in located):
        first, *rest = dict.fromkeys(entry["rule"] for entry in entries)
        rule = " or ".join([first, *(other.removeprefix("must be ") for other in rest)])
        return [{**entries[0], "rule": rule}]
    return [entry for i, entry in enumerate(entries) if entry not in entries[:i]]


def _describe(error: Any, path: Sequence[str | int], body: Any, model: Body) -> dict[str, Any]:
    kind, ctx, value = error["type"], error.get("ctx") or {}, error.get("input")
    if kind in COMPARISONS:
        key, words = COMPARISONS[kind]
        return violation(value, f"{words} {ctx[key]:g}", "Give a value within that.")
    if kind == "missing":
        meaning = properties_at(body, path[:-1], model).get(str(path[-1]) if path else "", "")
        return violation(None, "is required", f"Add it. {meaning}".strip())
    if kind == "extra_forbidden":
        return violation(value, "is not a field here", _suggest_name(path, body, model))
    if kind in ("union_tag_invalid", "literal_error"):
        listed = str(ctx.get("expected_tags") or ctx["expected"]).replace(" or ", ",")
        allowed = [word.strip(" '") for word in listed.split(",")]
        tag = ctx.get("tag", value)
        remedy = _suggest(tag, allowed) or "Choose one of these."
        return violation(tag, f"must be one of {', '.join(allowed)}", remedy)
    if kind == "union_tag_not_found":
        return violation(None, "is required", "Add it: it selects the kind.")
    if kind == "finite_number":
        return violation(value, "must be a finite number", LEAVE_OUT)
    if kind in ("too_long", "too_short"):
        most = kind == "too_long"
        bound = ctx["max_length" if most else "min_length"]
        has = f", not {ctx['actual_length']}" if ctx.get("actual_length") is not None else ""
        rule = f"must have at {'most' if most else 'least'} {bound} entries{has}"
        return violation(value, rule, "Leave some out." if most else "Add what is missing.")
    if kind not in PYDANTICS_OWN:
        # Values of the caller in a message may hold ". " too: they are hidden while it is parted.
        message: str = error["msg"]
        texts = [text for text in ctx.values() if isinstance(text, str) and ". " in text]
        for i, text in enumerate(texts):
            message = message.replace(text, f"\0{i}\0")
        rule, _, remedy = message.partition(". ")
        for i, text in enumerate(texts):
            rule, remedy = (part.replace(f"\0{i}\0", text) for part in (rule, remedy))
        numbers = (each for each in ctx.values() if isinstance(each, int | float))
        return violation(ctx.get("value", next(numbers, None)), f"{rule}.", remedy)
    rule = error["msg"].replace("Input should be", "must be").replace(" or instance of", ":")
    return violation(value, PLAIN.get(kind, rule), _correct_type(kind, value if path else None))


def _correct_type(kind: str, value: Any) -> str:
    """What to do where a value has the wrong type."""
    if kind in OBJECTS and isinstance(value, str):
        return f'If that is its kind, write {{"kind": {json.dumps(abbreviate(value))}}}.'
    if kind in ("float_type", "int_type") and isinstance(value, str):
        return "Give a number, without quotes and without a unit: the field's name holds the unit."
    return "Correct it; /docs shows the schema and worked examples."


def _suggest(given: Any, allowed: Sequence[str]) -> str:
    close = get_close_matches(str(given)[:LONGEST_GUESSED], allowed, n=1)
    return f"Did you mean {close[0]!r}?" if close else ""


def _suggest_name(path: Sequence[str | int], body: Any, model: Body) -> str:
    allowed = list(properties_at(body, path[:-1], model))
    listed = f"{_suggest(path[-1], allowed)} Allowed: {', '.join(allowed)}."
    return listed.strip() if allowed else "Remove it."


def describe_parameter_errors(errors: Sequence[Any]) -> list[dict[str, Any]]:
    """The violations of query parameters, path parts and headers."""
    described = []
    for error in errors[:MAX_LISTED]:
        name = str(error["loc"][1])  # after where it stands: query, path or header
        entry = _describe({**error, "loc": ()}, (name,), {}, None)
        described.append({"parameter": name, **entry})
    return described


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
    """Names and descriptions of the fields of the object at ``path``; empty where unknown."""
    if model is None:
        return {}
    whole = _whole(model)
    members, at = list(_members(whole, body, whole)), body
    for part in path:
        inner = (
            member.get("items") if isinstance(part, int) else member.get("properties", {}).get(part)
            for member in members
        )
        below = [schema for schema in inner if schema is not None]
        try:
            at = at[part]
        except (LookupError, TypeError):
            at = None
        members = [member for schema in below for member in _members(schema, at, whole)]
    fields: dict[str, str] = {}
    for member in members:
        for name, inner in member.get("properties", {}).items():
            fields.setdefault(name, inner.get("description", ""))
    return fields


def _members(schema: Schema, at: Any, whole: Schema) -> Iterator[Schema]:
    """The schema itself, or the members of a union that the value may be meant as."""
    if "$ref" in schema:
        schema = whole["$defs"][schema["$ref"].rpartition("/")[2]]
    tag = schema.get("discriminator", {})
    if tag:
        kind = at.get(tag["propertyName"]) if isinstance(at, dict) else None
        if isinstance(kind, str) and kind in tag["mapping"]:
            yield whole["$defs"][tag["mapping"][kind].rpartition("/")[2]]
        return
    options = schema.get("anyOf") or schema.get("oneOf")
    if not options:
        yield schema
        return
    for option in options:
        yield from _members(option, at, whole)
