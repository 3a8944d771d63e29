"""Wrong requests are answered by what to write; ``python -m`` prints the table of them."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from service.resources.records import RESOURCES
from service.wire.errors import ServiceError
from service.wire.validation import validate
from synthesis.studies.sweeps.spec import SweepSpec
from tests.service.wire.wrong_requests import BASES, REQUESTS, WrongRequest

# What pydantic says, and what only those understand who know it.
PRIVATE = (
    "Input", "valid dict", "instance", "union_", "tag", "extra", "discriminator", "unable to",
    "Correct it", "constrained", "1e99",
)  # fmt: skip


def refusal(path: str, body: Any) -> ServiceError:
    model = SweepSpec if path == "/v1/sweeps" else RESOURCES[path].spec
    with pytest.raises(ServiceError) as refused:
        validate(json.dumps(body).encode(), model)
    return refused.value


@pytest.mark.parametrize("request_", REQUESTS.values(), ids=REQUESTS.keys())
def test_a_wrong_request_is_told_what_to_write(request_: WrongRequest) -> None:
    told = refusal(request_.path, request_.body).violations
    first = told[0]
    assert first["pointer"] == request_.pointer
    for words in request_.words:
        assert words in f"{first['rule']} {first['remedy']}"
    assert request_.count in (len(told), ...), told
    assert first["remedy"].endswith((".", "?"))


def test_the_value_is_told_as_it_was_sent() -> None:
    # pydantic's text of a null where a kind belongs is "None"
    told = refusal("/v1/designs", REQUESTS["null for a kind"].body).violations[0]
    assert told["pointer"] == "/program/0/kind"
    assert told["value"] is None


def test_there_are_many_and_of_all_resources() -> None:
    assert len(REQUESTS) >= 60
    assert {request.base for request in REQUESTS.values()} == BASES.keys()
    assert sum(request.base != "designs" for request in REQUESTS.values()) >= 10


def places(value: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Every place of a document; of lists their first entry stands for all."""
    yield path
    inner = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value[:1])
        if isinstance(value, list)
        else ()
    )
    for part, each in inner:
        yield from places(each, (*path, part))


@pytest.mark.parametrize("base", BASES)
def test_no_message_speaks_the_validators_language(base: str) -> None:
    """Every field of an example with values of other types: each is answered by a way out."""
    path, right = BASES[base]
    for place in places(right):
        for value in ("x", "10 mm", -1, None, [], {}, 1e99, True, {"kind": "x"}):
            body = copy.deepcopy(right)
            holder: Any = body
            for part in place[:-1]:
                holder = holder[part]
            if place:
                holder[place[-1]] = value
            try:
                refused = refusal(path, body if place else value)
            except pytest.fail.Exception:
                continue  # a value that is allowed there
            for told in refused.violations:
                text = f"{told['rule']} {told['remedy']}"
                assert all(told[part] for part in ("rule", "remedy")), (place, value)
                assert not any(word in text for word in PRIVATE), text


def test_the_page_on_errors_tells_what_is_answered() -> None:
    page = (Path(__file__).resolve().parents[3] / "docs" / "errors.md").read_text("utf-8")
    example = page.split("POST /v1/designs\n")[1].split("\n\n")[0]
    told = refusal("/v1/designs", json.loads(example)).violations
    rows = [f"| `{e['pointer']}` | {e['rule']} | {e['remedy']} |" for e in told]
    assert "\n".join(rows) in page


def table() -> str:
    """Each wrong request with the sentence that answers it."""
    rows = ["| wrong request | at | value | answer |", "|---|---|---|---|"]
    for name, request in REQUESTS.items():
        first = refusal(request.path, request.body).violations[0]
        value = json.dumps(first["value"], ensure_ascii=False)
        value = value if len(value) < 60 else f"{value[:57]}…"
        rule = first["rule"].rstrip(".")
        rule = rule if len(rule) < 160 else f"{rule[:157]}…"
        where = first["pointer"] or "the body"
        cells = (f"{request.base}: {name}", where, value, f"{rule}. {first['remedy']}")
        rows.append(f"| {' | '.join(cell.replace('|', '¦') for cell in cells)} |")
    return "\n".join(rows)


if __name__ == "__main__":
    print(table())
