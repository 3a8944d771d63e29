"""/v1/train-responses: asked for now and later, its files, refused, forgotten."""

from __future__ import annotations

import csv
import io
import json
import re
from copy import deepcopy
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import httpx2
import pytest
from typer.testing import CliRunner

from service import cli
from service.client import Client
from service.contract.examples import examples
from synthesis.machines.dynamics import TrainSpec
from synthesis.machines.dynamics.report import respond
from tests.service.conftest import Running
from tests.service.resources.test_designs import wait_for

WHERE = "/v1/train-responses"
BODY = examples("train-responses")["press-feeder"]["value"]


@pytest.fixture(scope="module")
def quick() -> dict[str, Any]:
    """One speed, laws given: next to nothing to compute."""
    body = deepcopy(BODY)
    for segment in (0, 2):
        body["cam"]["program"][segment]["law"] = {"kind": "cycloidal"}
    body["cam"]["limits"] = []
    return {**body, "name": "quick", "speeds_rpm": [231.0], "turns": 2}


def alike(one: Any, other: Any) -> None:
    """The same but for last digits: products of matrices depend on how many threads make them."""
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for key, value in one.items():
            if key != "rounding":
                alike(value, other[key])
    elif isinstance(one, list):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            alike(a, b)
    elif isinstance(one, float):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-12)
    else:
        assert one == other


def test_the_library_says_the_same(service: Running, quick: dict[str, Any]) -> None:
    request = {**quick, "turns": 0}
    with Client(service.url) as client:
        answer = client.train_response(request)
    mine = json.loads(respond(TrainSpec.model_validate(request)).model_dump_json())
    assert answer["id"] == mine["id"]
    for same in ("modes", "speeds", "float_onset_rpm"):
        alike(answer[same], mine[same])
    document = service.client.get("/openapi.json").json()
    body = document["paths"][WHERE]["post"]["requestBody"]["content"]["application/json"]
    assert body["examples"] == examples("train-responses")


def test_now_and_later_with_files(client: httpx2.Client, quick: dict[str, Any]) -> None:
    later = client.post(WHERE, json=quick, headers={"Prefer": "respond-async"})
    assert later.status_code == 202
    where = later.headers["location"]
    found, now = wait_for(client, where), client.post(WHERE, json=quick)
    assert found.content == now.content
    answer = now.json()
    line = client.get(WHERE, params={"limit": 1}).json()["items"][0]
    assert line["modes_hz"] == [mode["natural_frequency_hz"] for mode in answer["modes"]]
    request = {"points_per_degree": 1.0, "speed_rpm": 231.0}
    table = client.get(answer["links"]["response.csv"], params=request)
    rows = list(csv.DictReader(io.StringIO(table.text)))
    least = min(float(row["contact_force_n"]) for row in rows)
    assert least == pytest.approx(answer["speeds"][0]["contact_force_min_n"]["value"], rel=0.02)
    for name in ("response.svg", "spectrum.svg"):
        picture = client.get(answer["links"][name], params={"theme": "print"})
        assert picture.headers["content-type"].startswith("image/svg+xml")
        words = " ".join(ElementTree.fromstring(picture.content).itertext())
        assert {"response.svg": "Contact force", "spectrum.svg": "after segment 2"}[name] in words
    tag = {"If-None-Match": table.headers["etag"]}
    again = client.get(answer["links"]["response.csv"], params=request,
                       headers=tag)  # fmt: skip
    assert again.status_code == 304
    refused = client.get(answer["links"]["polydyne.csv"])
    assert refused.status_code == 422
    assert "/train/masses/0/damping_n_s_per_mm" in refused.text
    assert client.delete(where).status_code == 204
    gone = client.get(where)
    assert gone.status_code == 404
    assert gone.json()["type"] == "/problems/unknown-train-response"


def test_the_command_tells_and_writes(tmp_path: Path, quick: dict[str, Any]) -> None:
    question = tmp_path / "train.json"
    question.write_text(json.dumps({**quick, "turns": 0}), encoding="utf-8")
    run = CliRunner().invoke(cli.app, ["respond", str(question), "--out", str(tmp_path / "out")])
    assert run.exit_code == 0, run.output
    assert "Modes: 31 Hz" in run.output
    assert re.search(r"231 .* to .* to ", run.output)
    written = {file.name for file in (tmp_path / "out").iterdir()}
    assert written == {"train-response.json", "response.csv", "response.svg", "spectrum.svg"}


@pytest.mark.parametrize(
    ("changes", "pointer", "words"),
    [
        ({"speeds_rpm": [77.0, 60.0], "train": {"masses": [{"mass_kg": 1.0,
          "stiffness_n_per_mm": 1e-3 * (8.0 * 3.141592653589793) ** 2}]}},
         "/speeds_rpm/1", "harmonic 4 of the cam"),
        ({"train": {"masses": [{"mass_kg": 1.0, "stiffness_n_per_mm": 50.0,
                                "damping_n_s_per_mm": -0.1}]}}, "/train/masses", "is unstable"),
        ({"train": {"masses": [{"mass_kg": 0.0, "stiffness_n_per_mm": 50.0}]}},
         "/train/masses/0/mass_kg", "positive"),
        ({"cam": {**BODY["cam"], "limits": [{"kind": "residual_vibration", "max_mm": 0.0,
                                             "natural_frequency_hz": 1e7}]}},
         "/cam/limits", "swings in one turn"),
    ],
)  # fmt: skip
def test_refused_with_the_place(
    client: httpx2.Client, changes: dict[str, Any], pointer: str, words: str
) -> None:
    answer = client.post(WHERE, json={**BODY, **changes})
    assert answer.status_code == 422
    (violation,) = answer.json()["errors"]
    assert violation["pointer"] == pointer
    assert words in violation["rule"] + violation["remedy"]
