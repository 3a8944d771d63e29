"""The OpenAPI document: committed as generated, complete, and its examples are true."""

from __future__ import annotations

import json
import re
from collections import Counter
from functools import cache
from typing import Any

import httpx2
import pytest

from service.contract.documentation import ANY_REQUEST
from service.contract.examples import ORDER, SELF_CHECK, VARIANTS, examples
from service.contract.sharing import NAMED
from service.openapi import TARGET, openapi_text
from synthesis.spec.design_spec import DesignSpec

text = cache(openapi_text)


@cache
def document() -> dict[str, Any]:
    return json.loads(text())


def operations() -> list[dict[str, Any]]:
    return [each for methods in document()["paths"].values() for each in methods.values()]


def meant(part: dict[str, Any]) -> dict[str, Any]:
    """What stands there, or what it refers to."""
    kind, _, name = part.get("$ref", "").removeprefix("#/components/").partition("/")
    return document()["components"][kind][name] if name else part


def statuses(operation: dict[str, Any]) -> set[int]:
    """All that an operation answers with: each by itself, and those listed by ``default``."""
    listed = meant(operation["responses"]["default"])["description"]
    lines = re.findall(r"^\* ([\d, ]+): [^\n]+\.$", listed, re.MULTILINE)
    alone = operation["responses"].keys() - {"default"}
    return {int(each) for each in (*alone, *", ".join(lines).split(", "))}


def test_the_committed_document_is_the_one_that_is_served(client: httpx2.Client) -> None:
    assert TARGET.read_text(encoding="utf-8") == text(), "run `make openapi` and commit"
    assert client.get("/openapi.json").json() == document()


def test_it_stays_small() -> None:
    """A browser goes through all of it, and so does every reader."""
    compact = json.dumps(document(), ensure_ascii=False, separators=(",", ":")).encode()
    assert len(compact) <= 320 * 1024


def test_members_of_unions_are_told_apart_by_what_they_must_say() -> None:
    unions = []

    def collect(at: Any) -> None:
        if isinstance(at, dict):
            unions.extend([at] if "mapping" in at.get("discriminator", ()) else [])
            at = list(at.values())
        for inner in at if isinstance(at, list) else ():
            collect(inner)

    collect(document())
    assert len(unions) > 10
    for union in unions:
        key = union["discriminator"]["propertyName"]
        for kind, reference in union["discriminator"]["mapping"].items():
            member = meant({"$ref": reference})
            said = member["properties"][key]
            assert kind in said.get("enum", [said.get("const")])
            assert key in member["required"]
            assert "default" not in said


def test_names_for_generated_clients_are_clean_and_unique() -> None:
    names = [operation["operationId"] for operation in operations()]
    assert len(set(names)) == len(names)
    assert all(name.isidentifier() and name.islower() for name in names)
    # two models of one name are told apart by their modules, and then neither is in a client
    assert [
        name for name in document()["components"]["schemas"] if "__" in name or "-" in name
    ] == []


def test_everything_is_said_in_words(subtests: pytest.Subtests) -> None:
    for operation in operations():
        with subtests.test(operation["operationId"]):
            assert_described(operation)


def assert_described(operation: dict[str, Any]) -> None:
    assert operation["summary"]
    assert operation["tags"]
    for parameter in map(meant, operation.get("parameters", [])):
        described = parameter.get("description") or parameter["schema"].get("description")
        assert described or parameter["in"] == "path", parameter
    assert set(ANY_REQUEST) <= statuses(operation)
    for status, response in ((at, meant(each)) for at, each in operation["responses"].items()):
        assert response["description"]
        if status >= "400" and operation["operationId"] != "get_readyz":
            schema = response["content"]["application/problem+json"]["schema"]
            name = "LateProblem" if status == "504" else "Problem"  # which has the best in it
            assert schema == {"$ref": f"#/components/schemas/{name}"}


def test_every_reference_leads_somewhere() -> None:
    def references(at: Any) -> list[str]:
        if isinstance(at, dict):
            own = [at["$ref"]] if isinstance(at.get("$ref"), str) else []
            return own + [found for inner in at.values() for found in references(inner)]
        return [found for inner in at for found in references(inner)] if type(at) is list else []

    for reference in set(references(document())):
        at: Any = document()
        for part in reference.removeprefix("#/").split("/"):
            at = at[part]


def test_what_operations_have_alike_stands_once() -> None:
    alike = Counter[str]()
    for operation in operations():
        answers = (part for status, part in operation["responses"].items() if status != "200")
        for part in (*operation.get("parameters", []), *answers):
            if "$ref" not in part:
                alike[json.dumps(part, sort_keys=True)] += 1
    assert [part for part, count in alike.items() if count > 1] == []
    used = text()
    for kind in ("headers", "parameters", "responses"):
        for name in document()["components"][kind]:
            assert used.count(f'"#/components/{kind}/{name}"') > 1
    for name in NAMED:
        assert used.count(f'"#/components/schemas/{name}"') > 1, name
    for name, parameter in document()["components"]["parameters"].items():
        assert name.partition("_no_")[0] == parameter["name"]


def test_fields_of_answers_are_described() -> None:
    schemas = document()["components"]["schemas"]
    ours = ("DesignSummary", "DesignPage", "Problem", "Violation", "ServerLimits", "Formats")
    for name in ours:
        parts = [schemas[name], *schemas[name].get("allOf", [])]
        fields = [each for part in parts for each in part.get("properties", {}).items()]
        assert fields
        for field, schema in fields:
            reported = "description" in schema or "$ref" in schema or field in ("name", "items")
            assert reported or "anyOf" in schema or "discriminator" in schema, (name, field)


@pytest.mark.parametrize("name", examples())
def test_worked_examples_are_documented_and_sound(name: str) -> None:
    example = examples()[name]
    assert set(example) == {"summary", "description", "value"}
    DesignSpec.model_validate_json(json.dumps(example["value"]), strict=True)
    body = document()["paths"]["/v1/designs"]["post"]["requestBody"]["content"]["application/json"]
    assert name in VARIANTS or body["examples"][name] == example


def test_examples_come_from_the_simplest_to_the_special_with_a_sentence_each() -> None:
    found = []
    for methods in document()["paths"].values():
        content = methods.get("post", {}).get("requestBody", {}).get("content", {})
        shown = content.get("application/json", {}).get("examples", {})
        assert list(shown) == sorted(shown, key=ORDER.index)
        found += shown.values()
    assert len(found) == len(ORDER) - len(VARIANTS)
    for example in found:
        assert re.fullmatch(r"[^\n]{20,150}[^.\s]\.", example["description"])
        assert ". " not in example["description"]
        assert len(example["summary"]) < 60


def test_the_self_check_is_among_them() -> None:
    assert SELF_CHECK in examples()
    assert len(examples()) >= 5
