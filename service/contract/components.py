"""Move repeated parts of the OpenAPI document to its components."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from typing import Any

Json = dict[str, Any]


def share_components(document: Json) -> None:
    """Move parameters and responses that several operations share to the components.

    Different ones of the same name are numbered. Responses of status 200 stay with their operation,
    for readers. Titles that only repeat a field's name are removed.
    """
    components, operations = document["components"], list(_operations(document))
    for operation in operations:
        for parameter in operation.get("parameters", []):
            _remove_repeated_title(parameter["name"], parameter["schema"])
    for schema in components["schemas"].values():
        for name, field in schema.get("properties", {}).items():
            _remove_repeated_title(name, field)
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
    """What occurs at several places, by name; the places become references to it.

    Args:
        places: container, key and name of each. kind: the section of the components.
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


def _remove_repeated_title(name: str, field: Json) -> None:
    if field.get("title") == name.replace("_", " ").title():
        del field["title"]
