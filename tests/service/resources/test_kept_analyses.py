"""Both kinds of analyses are asked for, looked at and forgotten as designs are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import httpx2
import pytest

from service.contract.examples import examples
from tests.service.resources.test_designs import wait_for


@dataclass(frozen=True)
class Kind:
    """A kind of analysis with a question of its own, and one that cannot be answered."""

    path: str
    question: dict[str, Any]
    refused: dict[str, Any]
    pointer: str
    shown: dict[str, Any]

    def spec(self, name: str) -> dict[str, Any]:
        return self.question | {"name": name}


GIVEN = examples("analyses")["p2-as-given"]["value"]
POINTS = examples("profile-analyses")["spare-roller"]["value"]
KINDS = [
    Kind("/v1/analyses", GIVEN, {"base_radius_mm": None}, "/base_radius_mm",
         {"status": "violated", "violated": ["pressure_angle_rise"]}),
    Kind("/v1/profile-analyses", POINTS, {"points_mm": POINTS["points_mm"][:90]}, "/points_mm",
         {"status": "read"}),
]  # fmt: skip


@pytest.fixture(params=KINDS, ids=lambda kind: kind.path)
def kind(request: pytest.FixtureRequest) -> Kind:
    found: Kind = request.param
    return found


def post(client: httpx2.Client, kind: Kind, spec: dict[str, Any], **given: str) -> httpx2.Response:
    headers = {name.replace("_", "-"): value for name, value in given.items()}
    return client.post(kind.path, json=spec, headers=headers)


def test_asked_for_now_and_later_it_is_the_same(client: httpx2.Client, kind: Kind) -> None:
    spec = kind.spec("looked at twice")
    later = post(client, kind, spec, Prefer="respond-async")
    assert later.status_code == 202, later.text
    assert later.headers["preference-applied"] == "respond-async"
    where = later.headers["location"]
    assert where == f"{kind.path}/{later.json()['id']}" == later.json()["links"]["self"]
    found, now = wait_for(client, where), post(client, kind, spec)
    assert found.status_code == now.status_code == 200, found.text
    assert found.content == now.content
    assert now.headers["content-location"] == where
    known = {"If-None-Match": now.headers["etag"]}
    assert client.get(where, headers=known).status_code == 304


def test_a_key_stands_for_one_body(client: httpx2.Client, kind: Kind) -> None:
    key = f"key of {kind.path}"
    first = post(client, kind, kind.spec("keyed"), Idempotency_Key=key)
    again = post(client, kind, kind.spec("keyed"), Idempotency_Key=key)
    assert first.status_code == again.status_code == 200
    assert again.content == first.content
    other = post(client, kind, kind.spec("keyed otherwise"), Idempotency_Key=key)
    assert other.status_code == 422
    assert other.json()["type"] == "/problems/idempotency-key-reused"


def test_it_is_listed_and_forgotten(client: httpx2.Client, kind: Kind) -> None:
    made = post(client, kind, kind.spec("listed")).headers["content-location"]
    line = client.get(kind.path, params={"limit": 1}).json()["items"][0]
    assert (line["name"], line["state"], line["links"]["self"]) == ("listed", "done", made)
    assert line | kind.shown == line
    assert client.get("/v1/designs", params={"limit": 1}).json()["items"] != [line]
    assert client.delete(made).status_code == 204
    gone = client.get(made)
    assert gone.status_code == client.delete(made).status_code == 404
    assert gone.json()["type"] == "/problems/unknown-analysis"
    assert f"GET {kind.path} lists" in gone.json()["detail"]


def test_what_cannot_be_answered_later_is_told_where_one_asks(
    client: httpx2.Client, kind: Kind
) -> None:
    spec = kind.spec("refused") | kind.refused
    now = post(client, kind, spec)
    assert now.status_code == 422, now.text
    later = post(client, kind, spec, Prefer="respond-async")
    assert later.status_code == 202
    found = wait_for(client, later.headers["location"])
    assert found.status_code == 422
    for answer in (now, found):
        assert answer.json()["errors"][0]["pointer"] == kind.pointer
    assert found.json()["detail"] == now.json()["detail"]


def test_only_those_with_a_result(client: httpx2.Client) -> None:
    kind = KINDS[0]
    post(client, kind, kind.spec("breaks its limit"))
    for status in ("holds", "violated"):
        lines = client.get(kind.path, params={"status": status}).json()["items"]
        assert {line["status"] for line in lines} <= {status}
    assert lines
    wrong = client.get(kind.path, params={"status": "optimal"})
    assert wrong.status_code == 422
