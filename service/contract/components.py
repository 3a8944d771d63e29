"""What the OpenAPI document would say in many places stands once, and is referred to."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from typing import Any

Json = dict[str, Any]


def refer_to_what_repeats(document: Json) -> None:
    """Parameters and responses that several operations have alike move to the components.

    Of those that differ and would have one name, the later ones carry a number. What an operation
    answers when all is well stays with it, for whoever reads. Titles that only say a field's own
    name in other letters go.
    """
    components, operations = document["components"], list(_operations(document))
    for operation in operations:
        for parameter in operation.get("parameters", []):
            _without_echo(parameter["name"], parameter["schema"])
    for schema in components["schemas"].values():
        for name, field in schema.get("properties", {}).items():
            _without_echo(name, field)
    lists = [operation.get("parameters", []) for operation in operations]
    places = [(each, at, each[at]["name"]) for each in lists for at in range(len(each))]
    components["parameters"] = _moved(places, "parameters")
    answers = [operation["responses"] for operation in operations]
    named = [(each, at, _named(at)) for each in answers for at in each if at != "200"]
    components["responses"] = _moved(named, "responses")


def _operations(document: Json) -> Iterator[Json]:
    for methods in document["paths"].values():
        yield from methods.values()


def _named(status: str) -> str:
    return f"{'Problem' if status >= '400' else 'Answer'}{status}"


def _moved(places: list[tuple[Any, Any, str]], kind: str) -> Json:
    """What stands at several of the places, by name; the places refer to it.

    Args:
        places: what holds it, key in that, name. kind: the part of the components.
    """
    texts = [json.dumps((name, holder[key]), sort_keys=True) for holder, key, name in places]
    often, names, parts = Counter(texts), dict[str, str](), Json()
    for (holder, key, name), text in zip(places, texts, strict=True):
        if often[text] == 1:
            continue
        if text not in names:
            same = sum(each.partition("_no_")[0] == name for each in parts)
            names[text] = f"{name}_no_{same + 1}" if same else name
            parts[names[text]] = holder[key]
        holder[key] = {"$ref": f"#/components/{kind}/{names[text]}"}
    return parts


def _without_echo(name: str, field: Json) -> None:
    if field.get("title") == name.replace("_", " ").title():
        del field["title"]
