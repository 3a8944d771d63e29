"""What an earlier engine has answered is answered anew when it is asked for."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import httpx2
import pytest

from synthesis.design.identity import ENGINE_NUMBER, design_id
from synthesis.spec.design_spec import DesignSpec
from tests.service.conftest import Running, settings_for
from tests.service.specs import spec

OLD = "0" * 32


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("engines")


@pytest.fixture(scope="module")
def client(folder: Path) -> Iterator[httpx2.Client]:
    with Running(settings_for(folder), real=False) as running:
        yield running.client


def change(folder: Path, *statements: str) -> list[Any]:
    with closing(sqlite3.connect(folder / "designs.db")) as database, database:
        return [database.execute(statement).fetchall() for statement in statements]


def made_by_an_earlier_engine(folder: Path, id: str, old: str, table: str = "answers") -> None:
    """An earlier engine had another number, so the same question had another id."""
    engine = ENGINE_NUMBER - 1
    change(folder, f"UPDATE {table} SET id = '{old}', engine = {engine} WHERE id = '{id}'")
    change(folder, f"UPDATE holdings SET id = '{old}' WHERE id = '{id}'")


def wait_for(client: httpx2.Client, path: str) -> httpx2.Response:
    for _ in range(2400):
        answer = client.get(path)
        if answer.status_code != 202:
            return answer
        time.sleep(0.05)
    raise AssertionError("never finished")


def test_a_design_is_solved_anew(client: httpx2.Client, folder: Path) -> None:
    body = spec("of an earlier engine")
    first = client.post("/v1/designs", json=body)
    id = first.json()["id"]
    made_by_an_earlier_engine(folder, id, OLD)
    listed = client.get("/v1/designs").json()["items"]
    assert [each["id"] for each in listed if each["name"] == body["name"]] == [OLD]
    tag = {"If-None-Match": first.headers["etag"]}
    answer = client.get(f"/v1/designs/{OLD}", headers=tag)
    assert answer.status_code == 202
    assert answer.headers["location"] == f"/v1/designs/{id}"
    answer = wait_for(client, f"/v1/designs/{OLD}")
    assert answer.status_code == 200
    assert answer.headers["content-location"] == f"/v1/designs/{id}"
    assert answer.json()["id"] == id == design_id(DesignSpec.model_validate(body))
    listed = client.get("/v1/designs").json()["items"]
    assert [each["id"] for each in listed if each["name"] == body["name"]] == [id]
    ((row,),) = change(folder, f"SELECT state, body FROM answers WHERE id = '{OLD}'")
    assert row == ("superseded", None)
    assert client.delete(f"/v1/designs/{OLD}").status_code == 204
    assert client.get(f"/v1/designs/{OLD}").status_code == 404
    assert client.get(f"/v1/designs/{id}").status_code == 200


def test_its_files_wait_for_that(client: httpx2.Client, folder: Path) -> None:
    old, body = "1" * 32, spec("sleep 1")
    id = client.post("/v1/designs", json=body).json()["id"]
    made_by_an_earlier_engine(folder, id, old)
    answer = client.get(f"/v1/designs/{old}/report.html")
    assert answer.status_code == 409
    assert f"GET /v1/designs/{id} says how it stands" in answer.json()["detail"]
    assert "earlier engine" in answer.json()["detail"]
    assert wait_for(client, f"/v1/designs/{old}").status_code == 200
    assert client.get(f"/v1/designs/{old}/report.html").status_code == 200


def test_what_failed_is_tried_again(client: httpx2.Client, folder: Path) -> None:
    old, body = "2" * 32, spec("solver")
    where = client.post("/v1/designs", json=body, headers={"Prefer": "respond-async"})
    id = where.json()["id"]
    assert wait_for(client, f"/v1/designs/{id}").status_code == 500
    made_by_an_earlier_engine(folder, id, old)
    answer = client.get(f"/v1/designs/{old}")
    assert answer.status_code == 202
    assert wait_for(client, f"/v1/designs/{old}").status_code == 500


def test_a_key_does_not_lead_to_an_earlier_engine(client: httpx2.Client, folder: Path) -> None:
    body, key = spec("keyed"), {"Idempotency-Key": "a key of last week"}
    id = client.post("/v1/designs", json=body, headers=key).json()["id"]
    made_by_an_earlier_engine(folder, id, "3" * 32)
    again = client.post("/v1/designs", json=body, headers=key)
    assert again.status_code == 200
    assert again.json()["id"] == id
    other = client.post("/v1/designs", json=spec("other"), headers=key)
    assert other.status_code == 422


def test_a_spec_that_cannot_be_read_any_more(client: httpx2.Client, folder: Path) -> None:
    old = "4" * 32
    id = client.post("/v1/designs", json=spec("in an older form")).json()["id"]
    made_by_an_earlier_engine(folder, id, old)
    change(folder, f"UPDATE answers SET spec = '{{\"rpm\": 100}}' WHERE id = '{old}'")
    answer = client.get(f"/v1/designs/{old}")
    assert answer.status_code == 404
    assert "POST it to /v1/designs in today's form" in answer.json()["detail"]


def test_sweeps_are_records_of_their_engine(client: httpx2.Client, folder: Path) -> None:
    """Their table stays; a design out of it is answered anew."""
    old, item = "5" * 32, "6" * 32
    axis = {"kind": "range", "pointer": "/speed_rpm", "start": 50, "stop": 60, "count": 2}
    question = {"base": spec("swept"), "axes": [axis]}
    id = client.post("/v1/sweeps", json=question).json()["id"]
    while client.get(f"/v1/sweeps/{id}").json()["state"] in ("accepted", "running"):
        time.sleep(0.05)
    assert client.get(f"/v1/sweeps/{id}").json()["engine"] == ENGINE_NUMBER
    made_by_an_earlier_engine(folder, id, old, "sweeps")
    change(folder, f"UPDATE sweep_items SET design_id = '{item}' WHERE number = 0")
    kept = client.get(f"/v1/sweeps/{old}").json()
    assert (kept["engine"], kept["state"]) == (ENGINE_NUMBER - 1, "successful")
    answer = wait_for(client, f"/v1/designs/{item}")
    assert answer.status_code == 200
    assert answer.json()["id"] != item
    assert client.get(f"/v1/designs/{item}").content == answer.content
    assert client.post("/v1/sweeps", json=question).json()["id"] == id
    assert client.get(f"/v1/sweeps/{id}").json()["engine"] == ENGINE_NUMBER


def test_what_was_under_way_begins_anew(tmp_path: Path) -> None:
    axis = {"kind": "range", "pointer": "/speed_rpm", "start": 50, "stop": 60, "count": 2}
    question = {"base": spec("begun"), "axes": [axis]}
    with Running(settings_for(tmp_path), real=False) as running:
        id = running.client.post("/v1/designs", json=spec("under way")).json()["id"]
        sweep = running.client.post("/v1/sweeps", json=question).json()["id"]
        while running.client.get(f"/v1/sweeps/{sweep}").json()["state"] in ("accepted", "running"):
            time.sleep(0.05)
    made_by_an_earlier_engine(tmp_path, id, OLD)
    made_by_an_earlier_engine(tmp_path, sweep, OLD, "sweeps")
    change(tmp_path, "UPDATE answers SET state = 'accepted'", "UPDATE sweeps SET state = 'running'")
    with Running(settings_for(tmp_path), real=False) as running:
        assert wait_for(running.client, f"/v1/designs/{id}").status_code == 200
        assert running.client.get(f"/v1/designs/{OLD}").json()["id"] == id
        for _ in range(600):
            answer = running.client.get(f"/v1/sweeps/{sweep}")
            if answer.status_code == 200 and answer.json()["state"] == "successful":
                break
            time.sleep(0.05)
        assert answer.json()["engine"] == ENGINE_NUMBER
        assert running.client.get(f"/v1/sweeps/{OLD}").json()["state"] == "dismissed"
