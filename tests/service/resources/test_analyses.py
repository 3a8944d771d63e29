"""POST /v1/analyses and `camwright analyse`: the same answer, and refusals that name the field."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import httpx2
import pytest
from typer.testing import CliRunner

from service import cli
from service.contract.examples import VARIANTS, examples
from synthesis import Analysis, DesignSpec, analyse
from synthesis.exporters import DRAWINGS
from synthesis.studies.analyse import as_design
from tests.service.contract.test_openapi import document
from tests.service.specs import spec

runner = CliRunner()
NAMES = list(examples("analyses"))


def given(**changes: Any) -> dict[str, Any]:
    """The common spec with its size given."""
    follower = {"kind": "translating_roller", "roller_radius_mm": 10, "offset_mm": 11.7}
    return spec(**{"base_radius_mm": 41.3, "follower": follower} | changes)


@pytest.mark.usefixtures("unmended")
@pytest.mark.parametrize("name", NAMES)
def test_worked_examples(client: httpx2.Client, name: str) -> None:
    value = examples("analyses")[name]["value"]
    answer = client.post("/v1/analyses", json=value)
    assert answer.status_code == 200, answer.text
    assert answer.headers["etag"]
    body = document()["paths"]["/v1/analyses"]["post"]["requestBody"]["content"]["application/json"]
    assert name in VARIANTS or body["examples"][name] == examples("analyses")[name]
    there = Analysis.model_validate_json(answer.content)
    assert (there.remedy is None) == there.holds
    # what mends it is told by the command too, in test_by_url, with a service as without
    assert there.model_copy(update={"remedy": None}) == analyse(DesignSpec.model_validate(value))


def test_a_broken_limit_is_a_result(client: httpx2.Client) -> None:
    body = given()
    answer, again = (client.post("/v1/analyses", json=body) for _ in range(2))
    assert answer.status_code == 200
    found = answer.json()
    assert not found["holds"]
    assert found["violated"][0] == "pressure_angle_rise"
    assert {size["offset"] for size in found["remedy"]["sizes"]} == {"kept", "free"}
    assert again.content == answer.content
    assert again.headers["etag"] == answer.headers["etag"]


def test_an_analysis_has_the_pictures_of_a_design(client: httpx2.Client) -> None:
    value = examples("analyses")["p2-as-given"]["value"]
    answer = client.post("/v1/analyses", json=value)
    where = answer.headers["content-location"]
    listed = client.get("/v1/analyses").json()["items"]
    links = next(each["links"] for each in listed if each["links"]["self"] == where)
    assert set(links) == {"self", *DRAWINGS}
    design = as_design(Analysis.model_validate_json(answer.content))
    for name in ("motion.svg", "contact.svg", "report.html"):
        drawn = client.get(links[name], params={"theme": "print"})
        assert drawn.content == DRAWINGS[name].write(design, DRAWINGS[name].options(theme="print"))
        reported = drawn.headers["content-disposition"]
        assert reported.endswith(f'-not-certified-{name}"')
        assert reported.startswith("inline")
        same = {"If-None-Match": drawn.headers["etag"]}
        assert client.get(links[name], params={"theme": "print"}, headers=same).status_code == 304
    assert 'class="hatch"' in client.get(links["contact.svg"]).text
    assert client.get(f"{where}/contact.svg?theme=pink").status_code == 422


def test_an_analysis_is_no_design(client: httpx2.Client) -> None:
    body = given(name="analysed, not designed")
    assert client.post("/v1/analyses", json=body).status_code == 200
    listed = client.get("/v1/designs").json()["items"]
    assert body["name"] not in [each["name"] for each in listed]


@pytest.mark.parametrize(
    ("changes", "pointer", "value"),
    [
        ({"base_radius_mm": {"min": 20, "max": 90}}, "/base_radius_mm", {"min": 20, "max": 90}),
        (
            {"follower": {"kind": "translating_roller", "roller_radius_mm": 10}},
            "/follower/offset_mm", None,
        ),
    ],
)  # fmt: skip
def test_what_is_left_free_is_a_problem(
    client: httpx2.Client, changes: dict[str, Any], pointer: str, value: Any
) -> None:
    answer = client.post("/v1/analyses", json=given(**changes))
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert problem["type"] == "/problems/invalid-design"
    (error,) = problem["errors"]
    assert (error["pointer"], error["value"]) == (pointer, value)
    assert "given in full" in error["rule"]
    assert "/v1/designs" in error["remedy"]


def test_a_spline_law_is_a_problem(client: httpx2.Client) -> None:
    body = given()
    body["program"][2]["law"] = {"kind": "spline"}
    problem = client.post("/v1/analyses", json=body).json()
    assert problem["errors"][0]["pointer"] == "/program/2/law"


def test_wrong_input_is_told_as_for_designs(client: httpx2.Client) -> None:
    problem = client.post("/v1/analyses", json=given(base_radius=3)).json()
    assert problem["status"] == 422
    assert problem["errors"][0]["pointer"] == "/base_radius"
    assert "base_radius_mm" in problem["errors"][0]["remedy"]
    assert client.put("/v1/analyses").status_code == 405


@pytest.fixture
def example_file(tmp_path: Path) -> Path:
    path = tmp_path / "given.json"
    path.write_text(json.dumps(examples("analyses")["p2-as-given"]), encoding="utf-8")
    return path


def test_the_command_prints_tables(example_file: Path) -> None:
    done = runner.invoke(cli.app, ["analyse", str(example_file)])
    assert done.exit_code == 3, done.output
    for words in ("violated: pressure_angle_rise", "38.7067", "BROKEN", "250.000−", "54.8645",
                  "No undercut."):  # fmt: skip
        assert words in done.output, done.output
    assert "…" not in done.output


def test_the_command_prints_json(example_file: Path) -> None:
    done = runner.invoke(cli.app, ["analyse", str(example_file), "--json"])
    assert done.exit_code == 3
    found = Analysis.model_validate_json(done.stdout)
    assert found.violated == ["pressure_angle_rise"]


def test_the_command_says_that_a_cam_holds(tmp_path: Path) -> None:
    path = tmp_path / "given.json"
    path.write_text(json.dumps(given(base_radius_mm=71.3)), encoding="utf-8")
    done = runner.invoke(cli.app, ["analyse", str(path)])
    assert done.exit_code == 0, done.output
    assert "every limit holds" in done.output


def test_the_command_refuses_what_is_left_free(tmp_path: Path) -> None:
    path = tmp_path / "free.json"
    path.write_text(json.dumps(spec()), encoding="utf-8")
    done = runner.invoke(cli.app, ["analyse", str(path)])
    assert done.exit_code == 2
    assert "/base_radius_mm = None" in done.output
    assert "Traceback" not in done.output


@pytest.mark.usefixtures("unmended")
def test_the_command_tells_of_undercut(tmp_path: Path) -> None:
    path = tmp_path / "undercut.json"
    body = given(base_radius_mm=2.6, limits=[])
    body["follower"] = {"kind": "translating_roller", "roller_radius_mm": 23.1, "offset_mm": 3.3}
    path.write_text(json.dumps(body), encoding="utf-8")
    done = runner.invoke(cli.app, ["analyse", str(path)])
    assert done.exit_code == 3
    assert "Undercut at " in done.output
