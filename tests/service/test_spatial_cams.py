"""/v1/spatial-cams: asked for now and later, looked at, listed, forgotten, refused."""

from __future__ import annotations

import json
from copy import deepcopy
from typing import Any

import httpx2
import pytest

from service.client import Client
from service.examples import SPATIAL_CAMS, examples
from synthesis import SpatialCamSpec, SpatialDesign, synthesise_spatial
from tests.service.conftest import Running
from tests.service.test_designs import wait_for

WHERE = "/v1/spatial-cams"
P4 = examples(SPATIAL_CAMS)["p4"]["value"]


def changed(**machine: Any) -> dict[str, Any]:
    body = deepcopy(P4)
    body["machine"].update(machine)
    return body


@pytest.mark.parametrize("name", examples(SPATIAL_CAMS))
def test_worked_examples(service: Running, name: str) -> None:
    value = examples(SPATIAL_CAMS)[name]["value"]
    with Client(service.url) as client:
        answer = client.spatial_cam(value)
    found = SpatialDesign.model_validate(answer)
    assert found.status != "infeasible"
    assert answer["links"]["self"] == f"{WHERE}/{found.id}"
    document = service.client.get("/openapi.json").json()
    asked = document["paths"][WHERE]["post"]["requestBody"]["content"]["application/json"]
    assert asked["examples"][name] == examples(SPATIAL_CAMS)[name]


def test_the_library_says_the_same_and_files_have_the_same_cam(client: httpx2.Client) -> None:
    found = synthesise_spatial(SpatialCamSpec.model_validate(P4))
    answer = client.post(WHERE, json=P4).json()
    mine = json.loads(found.model_dump_json())
    for same in ("id", "dimensions", "motion", "walls", "extremes", "certificate", "status"):
        assert answer[same] == mine[same]
    cam = SpatialDesign.model_validate(answer).cam
    assert [wall.name for wall in cam.walls] == [wall["name"] for wall in answer["walls"]]


def test_asked_for_now_and_later_it_is_the_same(client: httpx2.Client) -> None:
    asked = changed() | {"name": "later"}
    later = client.post(WHERE, json=asked, headers={"Prefer": "respond-async"})
    assert later.status_code == 202
    where = later.headers["location"]
    found, now = wait_for(client, where), client.post(WHERE, json=asked)
    assert found.status_code == now.status_code == 200, found.text
    assert found.content == now.content
    assert client.get(where, headers={"If-None-Match": now.headers["etag"]}).status_code == 304
    line = client.get(WHERE, params={"limit": 1, "status": now.json()["status"]}).json()["items"][0]
    assert (line["name"], line["machine"]) == ("later", "globoidal_indexer")
    assert line["dimensions"] == now.json()["dimensions"]
    assert client.delete(where).status_code == 204
    gone = client.get(where)
    assert gone.status_code == client.delete(where).status_code == 404
    assert gone.json()["type"] == "/problems/unknown-spatial-cam"


def test_an_index_that_meets_no_roller_is_refused_at_the_program(client: httpx2.Client) -> None:
    answer = client.post(WHERE, json=changed(rollers=5))
    assert answer.status_code == 422
    (wrong,) = answer.json()["errors"]
    assert wrong["pointer"] == "/program"
    assert "times the 72.0° between two of 5" in wrong["rule"]
