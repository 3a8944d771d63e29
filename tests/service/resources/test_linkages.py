"""/v1/linkages: every kind is asked for, looked at, drawn and forgotten in one way."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import httpx2
import pytest
from typer.testing import CliRunner

from service import cli
from service.contract.examples import VARIANTS, examples
from synthesis.machines.linkages import LINKAGES
from synthesis.machines.linkages.files import LINKAGE_FILES
from tests.service.contract.test_openapi import document

EXAMPLES = [(kind, name) for kind in LINKAGES for name in examples(f"linkages/{kind}")]
SHAPERS, ARMS = "/v1/linkages/six-bar-shapers", "/v1/linkages/palletising-arms"
SHAPER = examples("linkages/six-bar-shapers")["p5"]["value"]
ARM = examples("linkages/palletising-arms")["irb-660"]["value"]


@pytest.mark.parametrize(("kind", "name"), EXAMPLES)
def test_worked_examples(client: httpx2.Client, kind: str, name: str) -> None:
    """Answered as by the library, with links that lead to files."""
    example, linkage, path = (
        examples(f"linkages/{kind}")[name],
        LINKAGES[kind],
        f"/v1/linkages/{kind}",
    )
    said = document()["paths"][path]["post"]["requestBody"]["content"]["application/json"]
    assert name in VARIANTS or said["examples"][name] == example
    answer = client.post(path, json=example["value"])
    assert answer.status_code == 200, answer.text
    there = linkage.answer.model_validate_json(answer.content)
    here = linkage.solve(linkage.spec.model_validate(example["value"]), None)
    links = answer.json()["links"]
    assert there == here.model_copy(update={"links": links})
    files = {one for one, file in LINKAGE_FILES[kind].items() if file.suits(here)}
    assert set(links) == {"self", *(files if linkage.summary(here) else ())}
    assert client.get(links["self"]).content == answer.content
    for file, where in links.items():
        found = client.get(where)
        assert found.status_code == 200, found.text
        if file.endswith(".svg"):
            assert ElementTree.fromstring(found.content).tag.endswith("svg")
            assert "not certified" not in found.text
    (line,) = [x for x in client.get(path).json()["items"] if x["id"] == answer.json()["id"]]
    assert line["quantities"] == linkage.summary(here)
    assert client.delete(links["self"]).status_code == 204
    gone = client.get(links["self"])
    assert gone.status_code == 404
    assert linkage.noun in gone.json()["detail"]


@pytest.mark.parametrize(
    ("path", "body", "changes", "pointer", "words"),
    [
        (SHAPERS, SHAPER, {"coupler_mm": 20.0}, "/coupler_mm", "does not reach"),
        (SHAPERS, SHAPER, {"crank_mm": 275.0}, "/crank_mm", "passes through the guide's pivot"),
        (SHAPERS, SHAPER, {"acceleration_rad_per_s2": -1.0}, "/acceleration_rad_per_s2", "stop"),
        (SHAPERS, SHAPER, {"guide_mm": -600.0}, "/guide_mm", "positive"),
        (SHAPERS, SHAPER, {"ram_side": "up"}, "/ram_side", "left, right"),
        (SHAPERS, SHAPER, {"crank_mm": {"min": 90, "max": 200}}, "/stroke_mm", "is required while"),
        (ARMS, ARM, {"payload_kg": -1.0}, "/payload_kg", "at least 0"),
        (ARMS, ARM, {"opening_deg": {"min": 110}}, "/opening_deg", "No arm angles are left"),
        (
            ARMS,
            ARM,
            {"forearm_deg": {"min": 50, "max": 10}},
            "/forearm_deg",
            "nothing lies between",
        ),
        (ARMS, ARM, {"poses": [{"kind": "point", "x_mm": 1.0}]}, "/poses/0/z_mm", "required"),
        (ARMS, ARM, {"poses": [{"kind": "place", "x_mm": 1.0}]}, "/poses/0/kind", "joints, point"),
    ],
)
def test_what_makes_no_sense_is_told_with_its_place(
    client: httpx2.Client, path: str, body: dict[str, Any], changes: dict[str, Any], pointer: str,
    words: str,
) -> None:  # fmt: skip
    answer = client.post(path, json=body | changes)
    assert answer.status_code == 422, answer.text
    error = answer.json()["errors"][0]
    assert error["pointer"] == pointer
    assert words in error["rule"]
    assert error["remedy"]


def test_a_place_out_of_reach_is_an_answer(client: httpx2.Client) -> None:
    body = ARM | {"poses": [{"kind": "point", "x_mm": 4500.0, "z_mm": 0.0}]}
    answer = client.post(ARMS, json=body)
    assert answer.status_code == 200, answer.text
    assert answer.json()["status"] == "infeasible"
    assert "mm nearer" in answer.json()["poses"][0]["note"]


def test_asked_for_later_it_is_the_same(client: httpx2.Client) -> None:
    body = SHAPER | {"name": "later"}
    later = client.post(SHAPERS, json=body, headers={"Prefer": "respond-async"})
    assert later.status_code == 202, later.text
    now = client.post(SHAPERS, json=body)
    assert now.status_code == 200
    assert now.headers["content-location"] == later.headers["location"]


def test_the_command_writes_what_the_service_has(client: httpx2.Client, tmp_path: Path) -> None:
    """Here and by a service alike; a wish that cannot be kept ends with 3 and what would help."""
    path = tmp_path / "spec.json"
    path.write_text(json.dumps({"value": SHAPER}), encoding="utf-8")
    kind, url = "six-bar-shapers", str(client.base_url)
    for folder, more in (("here", []), ("there", ["--url", url])):
        words = ["linkage", kind, str(path), "--out", str(tmp_path / folder), *more]
        said = CliRunner().invoke(cli.app, words)
        assert said.exit_code == 0, said.output
        assert "feasible, stroke_mm 545.455, quick_return_ratio 1.85876" in said.stdout
    names = {name for name, file in LINKAGE_FILES[kind].items() if file.by_default}
    assert {each.name for each in (tmp_path / "here").iterdir()} == {"linkage.json", *names}
    for name in names:
        here, there = ((tmp_path / folder / name).read_bytes() for folder in ("here", "there"))
        assert here == there
    path.write_text(json.dumps(examples(f"linkages/{kind}")["impossible-on-purpose"]))
    said = CliRunner().invoke(cli.app, ["linkage", kind, str(path), "--out", str(tmp_path)])
    assert said.exit_code == 3
    assert "coupler_mm: 60 requested, 83.4174 mm needed" in said.stdout
    said = CliRunner().invoke(cli.app, ["linkage", "six-bars", str(path)])
    assert said.exit_code == 2
    assert "'six-bars' is not one of 'six-bar-shapers'" in said.output
