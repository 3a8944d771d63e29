"""What several places of the OpenAPI document have in common is said once, and by its name.

The document means the same afterwards, in fewer bytes, and client generators find names where
there were copies.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from typing import Any

Json = dict[str, Any]
Place = tuple[Any, Any, str]  # container, key, and what is there is to be called
FEW = 4  # fields: fewer are read sooner where they are than at another place
NULL = {"type": "null"}
# What a place says of a type beyond the type itself.
BESIDE = {"description", "default"}
COMPOSITE = {"anyOf", "oneOf", "items", "additionalProperties"}
# Types that are written out at several places, each by one of them.
NAMED = {
    "AnswerId": "Design.id",
    "Allowance": "BaseRadius.allowance",
    "BalancePointer": "RangeAxis.balance_pointer",
    "CrownRadius": "GloboidalIndexer.crown_radius_mm",
    "Cursor": "DesignPage.next",
    "Dimension": "OscillatingRoller.centre_distance_mm",
    "DwellOn": "GloboidalIndexer.dwell_on",
    "EngineVersion": "Design.engine_version",
    "Follower": "DesignSpec.follower",
    "Inflection": "Scca.inflection",
    "JsonObject": "Entry.json_schema",
    "Law": "Rise.law",
    "Lift": "Rise.lift_mm",
    "LinkedPointers": "RangeAxis.linked_pointers",
    "Links": "Accepted.links",
    "Numbers": "Design.dimensions",
    "Objective": "SweepSpec.quantities.items",
    "MeshAngle": "GloboidalIndexer.mesh_angle_deg",
    "PeakOrNone": "FlankGeometry.convex_radius_mm",
    "Pair": "BorderArc.from_mm",
    "PivotDirection": "OscillatingRoller.pivot_direction_deg",
    "Pointer": "RangeAxis.pointer",
    "Rim": "Groove.rim_mm",
    "Segment": "DesignSpec.program.items",
    "Rotation": "DesignSpec.rotation",
    "RollerDistance": "CylindricalOscillating.roller_distance_mm",
    "RollerWidth": "CylindricalOscillating.roller_width_mm",
    "SegmentAngle": "Rise.angle_deg",
    "SpecName": "DesignSpec.name",
    "Severity": "SpatialDesign.severity",
    "Speed": "DesignSpec.speed_rpm",
    "StateOrNone": "Rise.start",
    "StatusOrNone": "DesignSummary.status",
    "Swing": "Rise.lift_deg",
    "Warnings": "Design.warnings",
}


def share(document: Json) -> None:
    """Rewrite a document so that each thing stands once."""
    components = document["components"]
    schemas = components["schemas"]
    for place in _objects([document["paths"], components]):
        place |= {key: _whole(value) for key, value in place.items()}
    for name, schema in schemas.items():
        _drop_repetition(name, schema)
    for place in _objects(schemas):
        _merge_null(place)
        _close_pair(place)
        _require_kinds(place, schemas)
    for name, at in NAMED.items():
        _name_type(schemas, name, at.split("."))
    _open_answers(document["paths"], schemas)
    _inherit(schemas)
    components["schemas"] = dict(sorted(schemas.items()))
    operations = [each for methods in document["paths"].values() for each in methods.values()]
    lists = [operation.get("parameters", []) for operation in operations]
    for parameter in (each for one in lists for each in one):
        _shorten_parameter(parameter)
    answers = [operation["responses"] for operation in operations]
    headers = [each["headers"] for one in answers for each in one.values() if "headers" in each]
    components["headers"] = _move([(one, at, at) for one in headers for at in one], "headers")
    components["parameters"] = _move(
        [(one, at, each["name"]) for one in lists for at, each in enumerate(one)], "parameters"
    )
    components["responses"] = _move(
        [(one, at, _name_of(at, one[at])) for one in answers for at in one], "responses"
    )


def _objects(place: Any) -> Iterator[Json]:
    """Every object at or below a place."""
    rest = [place]
    while rest:
        at = rest.pop()
        if isinstance(at, dict):
            yield at
            rest.extend(at.values())
        elif isinstance(at, list):
            rest.extend(at)


def _whole(value: Any) -> Any:
    """A number without empty decimals, 60 for 60.0, which is the same in JSON; lists likewise."""
    if isinstance(value, list):
        return [_whole(each) for each in value]
    exact = isinstance(value, float) and value.is_integer() and abs(value) < 2.0**53
    return int(value) if exact else value


def _drop_repetition(name: str, schema: Json) -> None:
    """Drop titles that repeat names, and the default null of what may be null or left out."""
    if schema.get("title") == name:
        del schema["title"]
    for key, field in schema.get("properties", {}).items():
        if field.get("title") == key.replace("_", " ").title():
            del field["title"]
        if field.get("default", 0) is None:
            del field["default"]


def _merge_null(place: Json) -> None:
    """Say of a plain type that may be null that it is of two types."""
    several = place.get("anyOf")
    if isinstance(several, list) and len(several) == 2 and several[1] == NULL:
        kind = several[0].get("type")
        if isinstance(kind, str) and "enum" not in several[0] and not place.keys() & several[0]:
            del place["anyOf"]
            place |= {**several[0], "type": [kind, "null"]}


def _close_pair(place: Json) -> None:
    """Say of what kind the items of a pair are too: none follows, but linters ask for it."""
    if "prefixItems" in place:
        place.setdefault("items", place["prefixItems"][-1])


def _require_kinds(place: Json, schemas: Json) -> None:
    """Require what tells the members of a union apart: without it none is recognised."""
    told = place.get("discriminator")
    if isinstance(told, dict) and "mapping" in told:
        key = told["propertyName"]
        for reference in told["mapping"].values():
            member = schemas[reference.rpartition("/")[2]]
            kind = member["properties"][key]
            kind.pop("default", None)
            if "const" in kind:  # which says the type
                kind.pop("type", None)
            others = [each for each in member.get("required", []) if each != key]
            member["required"] = [key, *others]


def _name_type(schemas: Json, name: str, at: list[str]) -> None:
    """Give a type that is written out at several places a name; the places refer to it.

    Args:
        at: schema, field and further keys of one of the places.
    """
    schema, field, *keys = at
    found = schemas[schema]["properties"][field]
    for key in keys:
        found = found[key]
    kind, keys_of_kind = _kind_of(found), found.keys() - BESIDE
    alike = (each for each in _objects(schemas) if each.keys() - BESIDE == keys_of_kind)
    places = [each for each in alike if _kind_of(each) == kind]
    # What most places say beside the type is said with it; a default where all have it.
    named = {key: value for key, value in found.items() if key not in BESIDE}
    texts = Counter(each["description"] for each in places if "description" in each)
    if texts and texts.most_common(1)[0][1] > 1:
        named["description"] = texts.most_common(1)[0][0]
    if all(each.get("default", named) == found.get("default", named) for each in places):
        named |= {"default": found["default"]} if "default" in found else {}
    for place in places:
        beside = {key: place[key] for key in place if key in BESIDE}
        place.clear()
        place["$ref"] = f"#/components/schemas/{name}"
        place |= {key: value for key, value in beside.items() if value != named.get(key)}
    schemas[name] = named


def _kind_of(place: Json) -> str:
    """What makes two places one type: of plain ones the description too, which alone tells what."""
    kind = {key: place[key] for key in place if key not in BESIDE}
    if not COMPOSITE & place.keys():
        kind["description"] = place.get("description")
    return json.dumps(kind, sort_keys=True)


def _open_answers(paths: Json, schemas: Json) -> None:
    """Leave only what is sent closed and with defaults: answers say all, and later ones more."""
    bodies = [
        each["requestBody"]
        for one in paths.values()
        for each in one.values()
        if "requestBody" in each
    ]
    sent, open_ends = set[str](), list(_objects(bodies))
    while open_ends:
        name = str(open_ends.pop().get("$ref", "")).rpartition("/")[2]
        if name in schemas and name not in sent:
            sent.add(name)
            open_ends += _objects(schemas[name])
    for name in schemas.keys() - sent:
        if schemas[name].get("additionalProperties") is False:
            del schemas[name]["additionalProperties"]
        for field in schemas[name].get("properties", {}).values():
            field.pop("default", None)


def _inherit(schemas: Json) -> None:
    """Write an open object that has all fields of another as that one and what it has more."""
    fields = {
        name: schema["properties"]
        for name, schema in schemas.items()
        if "properties" in schema and "additionalProperties" not in schema
    }
    needed = {name: set(schemas[name].get("required", [])) for name in fields}
    for name, own in fields.items():
        bases = [
            base
            for base in fields
            if len(own) > len(fields[base]) >= FEW
            and fields[base].items() <= own.items()
            and needed[base] <= needed[name]
        ]
        if bases:
            base = max(bases, key=lambda each: len(fields[each]))
            schema = schemas[name]
            more = {
                "properties": {key: own[key] for key in own if key not in fields[base]},
                "required": [key for key in schema.pop("required", []) if key not in needed[base]],
                "type": schema.pop("type"),
            }
            del schema["properties"]
            # Generators take the only member of allOf for all that there is.
            schema["allOf"] = [{"$ref": f"#/components/schemas/{base}"}, more]


def _shorten_parameter(parameter: Json) -> None:
    """Drop what OpenAPI takes as said: not required; and no parameter of a query can be null."""
    schema = parameter["schema"]
    if parameter.get("required") is False:
        del parameter["required"]
    if schema.get("title") == parameter["name"].replace("_", " ").title():
        del schema["title"]
    if schema.get("description") == parameter.get("description"):
        schema.pop("description", None)
    several = schema.get("anyOf", [])
    if len(several) == 2 and several[1] == NULL:
        del schema["anyOf"]
        schema |= several[0]


def _name_of(status: str, response: Json) -> str:
    """What a response is called where several operations have it."""
    contents: Json = response.get("content", {})
    if status == "default":
        return "Problems"
    if status >= "400" or not contents:
        return status
    media_type, content = next(iter(contents.items()))
    schema = content.get("schema", {}).get("$ref", "").rpartition("/")[2]
    kind = media_type.partition("/")[2].partition("+")[0].split(".")[-1].capitalize()
    return f"{schema or kind}{'' if status == '200' else status}"


def _move(places: list[Place], kind: str) -> Json:
    """What occurs at several places, by name; the places become references to it.

    Args:
        places: different ones of a name are numbered. kind: the section of the components.
    """
    texts = [json.dumps((name, holder[key]), sort_keys=True) for holder, key, name in places]
    often, names, parts = Counter(texts), dict[str, str](), Json()
    first = {text: place for place, text in reversed(list(zip(places, texts, strict=True)))}
    for text, count in often.most_common():  # what occurs most has the shortest name
        if count > 1:
            holder, key, name = first[text]
            same = sum(each.partition("_no_")[0] == name for each in parts)
            names[text] = f"{name}_no_{same + 1}" if same else name
            parts[names[text]] = holder[key]
    for (holder, key, _), text in zip(places, texts, strict=True):
        if text in names:
            holder[key] = {"$ref": f"#/components/{kind}/{names[text]}"}
    return dict(sorted(parts.items()))
