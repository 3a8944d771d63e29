"""Wrong requests are answered by what to write; ``python -m`` prints the table of them."""

from __future__ import annotations

import json
from typing import Any

import pytest

from service.resources.records import RESOURCES
from service.wire.body import validate
from service.wire.errors import ServiceError
from synthesis.studies.sweeps.spec import SweepSpec
from tests.service.wire.wrong_requests import BASES, REQUESTS, WrongRequest

# What pydantic says, and what only those understand who know it.
PRIVATE = ("Input", "valid dict", "instance", "union", "tag", "extra", "discriminator", "parse")


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


def test_there_are_many_and_of_all_resources() -> None:
    assert len(REQUESTS) >= 60
    assert {request.base for request in REQUESTS.values()} == BASES.keys()
    assert sum(request.base != "designs" for request in REQUESTS.values()) >= 10


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
