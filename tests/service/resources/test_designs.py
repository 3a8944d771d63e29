"""Designs over HTTP: ask, look, list, forget; the same question gives the same bytes."""

from __future__ import annotations

import os
import re
import time
from pathlib import Path
from typing import Any

import httpx2
import pytest

from service.workers import engine
from synthesis.design.design import Design
from synthesis.design.identity import design_id
from synthesis.spec.design_spec import DesignSpec
from tests.service.conftest import wait_until, wait_until_idle
from tests.service.fake_core import Gate
from tests.service.killing import children
from tests.service.specs import spec


def post(client: httpx2.Client, body: dict[str, Any], **headers: str) -> httpx2.Response:
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    return client.post("/v1/designs", json=body, headers=named)


def wait_for(client: httpx2.Client, path: str) -> httpx2.Response:
    for _ in range(4800):
        answer = client.get(path)
        if answer.status_code != 202:
            return answer
        assert int(answer.headers["retry-after"]) >= 1
        time.sleep(0.05)
    raise AssertionError("never finished")


def test_a_design_comes_back_and_stays(client: httpx2.Client) -> None:
    body = spec("first")
    answer = post(client, body)
    assert answer.status_code == 200
    design = Design.model_validate_json(answer.content)
    assert design.id == design_id(DesignSpec.model_validate(body))
    assert answer.headers["content-location"] == design.links["self"] == f"/v1/designs/{design.id}"
    again = client.get(design.links["self"])
    assert (again.status_code, again.content) == (200, answer.content)


def test_the_same_spec_gives_the_same_bytes(client: httpx2.Client) -> None:
    body = spec("twice")
    first, second = post(client, body), post(client, dict(reversed(body.items())))
    assert first.content == second.content
    assert first.headers["etag"] == second.headers["etag"]


def test_etags_are_strong_and_known_ones_are_not_sent_again(client: httpx2.Client) -> None:
    path = post(client, spec("tag")).json()["links"]["self"]
    plain = client.get(path, headers={"Accept-Encoding": "identity"})
    tag = plain.headers["etag"]
    assert re.fullmatch('"[0-9a-f]{32}"', tag)
    for known in (tag, f'"other", {tag}', f"W/{tag}", "*"):
        assert client.get(path, headers={"If-None-Match": known}).status_code == 304
    assert client.get(path, headers={"If-None-Match": '"other"'}).status_code == 200


def test_compressed_bytes_have_a_tag_of_their_own(client: httpx2.Client) -> None:
    path = post(client, spec("compressed")).json()["links"]["self"]
    plain = client.get(path, headers={"Accept-Encoding": "identity"})
    packed = client.get(path, headers={"Accept-Encoding": "br, gzip"})
    assert packed.headers["content-encoding"] == "gzip"
    assert packed.headers["vary"].lower() == "accept-encoding"
    assert packed.headers["etag"] != plain.headers["etag"]
    assert packed.json() == plain.json()
    again = client.get(path, headers={"If-None-Match": packed.headers["etag"]})
    assert again.status_code == 304
    assert again.headers["etag"] == packed.headers["etag"]


def test_asynchronously(client: httpx2.Client, tmp_path: Path) -> None:
    gate = Gate(tmp_path / "gate")
    (name,) = gate.names(1)
    body = spec(name)
    answer = post(client, body, Prefer="respond-async")
    assert answer.status_code == 202
    assert answer.headers["preference-applied"] == "respond-async"
    assert answer.json()["state"] == "accepted"
    where = answer.headers["location"]
    assert where == f"/v1/designs/{answer.json()['id']}"
    assert client.get(where).status_code == 202
    assert client.get(f"{where}/profile.csv").status_code == 409
    gate.open()
    done = wait_for(client, where)
    assert done.status_code == 200
    assert done.json()["status"] == "optimal"
    assert post(client, body, Prefer="respond-async").content == done.content


def test_a_failure_waits_for_whoever_asks_and_can_be_tried_again(client: httpx2.Client) -> None:
    body = spec("best")
    where = post(client, body, Prefer="respond-async").headers["location"]
    done = wait_for(client, where)
    assert done.status_code == 504
    assert done.headers["content-type"] == "application/problem+json"
    assert done.json()["best"]["status"] == "optimal"
    assert post(client, body, Prefer="respond-async").status_code == 202


def test_an_idempotency_key_replays(client: httpx2.Client) -> None:
    body = spec("keyed")
    first = post(client, body, Idempotency_Key="k-1")
    assert post(client, body, Idempotency_Key="k-1").content == first.content
    other = post(client, spec("keyed"), Idempotency_Key="k-1")
    assert other.status_code == 422
    assert other.json()["type"] == "/problems/idempotency-key-reused"
    assert post(client, spec("keyed"), Idempotency_Key="k-2").status_code == 200


def test_a_deleted_design_is_gone(client: httpx2.Client) -> None:
    path = post(client, spec("gone")).json()["links"]["self"]
    assert client.delete(path).status_code == 204
    assert client.get(path).status_code == 404
    assert client.delete(path).status_code == 404


def test_a_running_design_is_dismissed(
    client: httpx2.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It hears so at its clock: the same workers take what comes after it."""
    monkeypatch.setattr(engine, "CANCEL_S", 60.0)  # however busy the machine is
    wait_until_idle(client)
    workers = set(children(os.getpid()))
    endless = spec("look 250", time_budget_s=300)
    where = post(client, endless, Prefer="respond-async").headers["location"]
    wait_until(client, running=1)
    assert client.delete(where).status_code == 204
    assert client.get(where).status_code == 404
    assert all(post(client, spec("after")).status_code == 200 for _ in range(4))
    wait_until_idle(client)
    assert set(children(os.getpid())) == workers


def test_the_list_pages_from_the_newest_on(client: httpx2.Client) -> None:
    made = [post(client, spec(f"listed {i}", time_budget_s=9.0)).json()["id"] for i in range(5)]
    listed: list[str] = []
    cursor: str | None = None
    for _ in range(3):
        question = {"limit": "2"} | ({"cursor": cursor} if cursor else {})
        page = client.get("/v1/designs", params=question).json()
        listed += [item["id"] for item in page["items"]]
        cursor = page["next"]
    assert listed[:5] == made[::-1]
    line = client.get("/v1/designs", params={"limit": "1"}).json()["items"][0]
    assert line["status"] == "optimal"
    assert line["dimensions"]["base_radius_mm"] == 50.0
    assert line["created"].endswith("Z")
    assert client.get("/v1/designs", params={"status": "infeasible"}).json()["items"] == []


def test_the_last_page_says_so(client: httpx2.Client) -> None:
    assert client.get("/v1/designs", params={"limit": 200}).json()["next"] is None
