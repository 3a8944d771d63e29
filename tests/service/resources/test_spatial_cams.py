"""/v1/spatial-cams: asked for now and later, looked at, listed, forgotten, refused."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import httpx2
import pytest
from typer.testing import CliRunner

from service import cli
from service.client import Client
from service.contract.examples import VARIANTS, examples
from synthesis import SpatialCamSpec, SpatialDesign, synthesise_spatial
from tests.service.conftest import Running
from tests.service.resources.test_designs import wait_for

WHERE = "/v1/spatial-cams"
P4 = examples("spatial-cams")["p4"]["value"]


def changed(**machine: Any) -> dict[str, Any]:
    body = deepcopy(P4)
    body["machine"].update(machine)
    return body


@pytest.mark.parametrize("name", examples("spatial-cams"))
def test_worked_examples(service: Running, name: str) -> None:
    value = examples("spatial-cams")[name]["value"]
    with Client(service.url) as client:
        answer = client.spatial_cam(value)
    found = SpatialDesign.model_validate(answer)
    assert found.status != "infeasible"
    assert answer["links"]["self"] == f"{WHERE}/{found.id}"
    document = service.client.get("/openapi.json").json()
    question = document["paths"][WHERE]["post"]["requestBody"]["content"]["application/json"]
    assert name in VARIANTS or question["examples"][name] == examples("spatial-cams")[name]


def test_the_library_says_the_same_and_files_have_the_same_cam(client: httpx2.Client) -> None:
    found = synthesise_spatial(SpatialCamSpec.model_validate(P4))
    answer = client.post(WHERE, json=P4).json()
    mine = json.loads(found.model_dump_json())
    for same in ("id", "dimensions", "motion", "walls", "extremes", "certificate", "status"):
        assert answer[same] == mine[same]
    cam = SpatialDesign.model_validate(answer).cam
    assert [wall.name for wall in cam.walls] == [wall["name"] for wall in answer["walls"]]


def test_asked_for_now_and_later_it_is_the_same(client: httpx2.Client) -> None:
    question = changed() | {"name": "later"}
    later = client.post(WHERE, json=question, headers={"Prefer": "respond-async"})
    assert later.status_code == 202
    where = later.headers["location"]
    found, now = wait_for(client, where), client.post(WHERE, json=question)
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


def test_every_file_and_the_catalogue(client: httpx2.Client) -> None:
    answer = client.post(WHERE, json=examples("spatial-cams")["cylindrical-rib"]["value"]).json()
    links = {name: at for name, at in answer["links"].items() if name != "self"}
    known = {each["name"]: each for each in client.get("/v1/formats").json()["spatial"]}
    assert set(links) == set(known)
    for name, where in links.items():
        found = client.get(where)
        assert found.status_code == 200, found.text
        assert found.headers["content-type"] == known[name]["media_type"]
        assert f'filename="Rib-cam-{name}"' in found.headers["content-disposition"]
        again = client.get(where, headers={"If-None-Match": found.headers["etag"]})
        assert again.status_code == 304
    assert float(client.get(links["developed.csv"]).headers["camwright-flat-offset-error-mm"]) > 0.0


def test_what_does_not_unroll_says_so(client: httpx2.Client) -> None:
    flat = client.post(WHERE, json=P4).json()["links"]
    assert not {name for name in flat if name.startswith("developed")}
    refused = client.get(f"{flat['self']}/developed.svg")
    assert refused.status_code == 422
    assert "no development on a cylinder" in refused.json()["errors"][0]["rule"]
    rib = client.post(WHERE, json=examples("spatial-cams")["cylindrical-rib"]["value"]).json()
    refused = client.get(rib["links"]["developed.svg"], params={"radius_mm": 60})
    (wrong,) = refused.json()["errors"]
    assert (refused.status_code, wrong["parameter"], wrong["value"]) == (422, "radius_mm", 60.0)


@pytest.mark.parametrize(
    ("machine", "pointer"),
    [
        ({"roller_width_mm": 75}, "/machine/roller_width_mm"),
        ({"roller_distance_mm": 22}, "/machine/roller_distance_mm"),
        ({"crown_radius_mm": 7}, "/machine/crown_radius_mm"),
        ({"initial_angle_deg": 80}, "/machine/initial_angle_deg"),
        ({"pivot_distance_mm": 70}, "/machine"),
    ],
)
def test_machines_that_cannot_be_are_refused(
    client: httpx2.Client, machine: dict[str, Any], pointer: str
) -> None:
    question = deepcopy(examples("spatial-cams")["cylindrical-rib"]["value"])
    question["machine"].update(machine)
    answer = client.post(WHERE, json=question)
    assert answer.status_code == 422
    assert [wrong["pointer"] for wrong in answer.json()["errors"]] == [pointer]


def test_the_command_says_where_and_writes_files(tmp_path: Path) -> None:
    question = tmp_path / "cam.json"
    question.write_text(json.dumps(P4), encoding="utf-8")
    said = CliRunner().invoke(cli.app, ["spatial", str(question), "--out", str(tmp_path / "out")])
    assert said.exit_code == 0, said.stderr
    assert "feasible; centre_distance_mm 180.0000" in said.stdout
    assert "41.0818" in said.stdout
    assert {"1L", "2L", "2R", "3R"} <= set(said.stdout.split())
    kept = (tmp_path / "out" / "spatial.json").read_text(encoding="utf-8")
    assert SpatialDesign.model_validate_json(kept).name == "P4"


def test_the_command_names_what_is_broken(service: Running, tmp_path: Path) -> None:
    question = tmp_path / "cam.json"
    question.write_text(json.dumps(changed(cam_width_mm=31.0)), encoding="utf-8")
    said = CliRunner().invoke(cli.app, ["spatial", str(question), "--url", service.url])
    assert said.exit_code == 3
    assert "infeasible, violated: contacts_left, contacts_right" in said.stdout
    assert "BROKEN" in said.stdout
    refused = changed(centre_distance_mm=101.5)
    question.write_text(json.dumps(refused), encoding="utf-8")
    said = CliRunner().invoke(cli.app, ["spatial", str(question)])
    assert said.exit_code == 2
    assert "/machine/centre_distance_mm = 101.5" in said.stderr
    assert "Increase centre_distance_mm, or make the rollers shorter" in said.stderr


WRONG: list[tuple[dict[str, Any], str, str]] = [
    ({"roller_radius_mm": 41.6}, "/machine/roller_radius_mm", "overlap on their turret"),
    ({"roller_radius_mm": -3.0}, "/machine/roller_radius_mm", "dimensions are above 0"),
    ({"bottom_clearance_mm": 78.1}, "/machine/centre_distance_mm", "grooves reach the cam's axis"),
    ({"roller_inner_mm": 1e9}, "/machine/roller_inner_mm", "dimensions are above 0"),
]


@pytest.mark.parametrize(("machine", "pointer", "reported"), WRONG)
def test_nonsense_is_refused_at_its_place(
    client: httpx2.Client, machine: dict[str, Any], pointer: str, reported: str
) -> None:
    answer = client.post(WHERE, json=changed(**machine))
    assert answer.status_code == 422, answer.text
    (wrong,) = answer.json()["errors"]
    assert wrong["pointer"] == pointer
    assert reported in wrong["rule"]
    assert wrong["remedy"]
