"""POST /v1/profile-analyses and `camwright read-back`: the same answer, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import pytest
from typer.testing import CliRunner

from service import cli
from service.commands.questions import points_in
from service.contract.examples import examples
from synthesis import DesignSpec
from synthesis.errors import InputError
from synthesis.studies.measured import MeasuredCam, ProfileAnalysis, read_back
from tests.service.contract.test_openapi import document
from tests.studies.measured.cams import ROLLER, profile, spec

runner = CliRunner()
WHERE = "/v1/profile-analyses"
EXAMPLES = examples("profile-analyses")


def body(**changes: Any) -> dict[str, Any]:
    points = np.round(profile(spec(ROLLER), 500), 4).tolist()
    given = {"speed_rpm": 97, "points_mm": points, "follower": ROLLER, "tolerance_mm": 2e-3}
    return given | changes


@pytest.mark.parametrize("name", EXAMPLES)
def test_worked_examples(client: httpx2.Client, name: str) -> None:
    value = EXAMPLES[name]["value"]
    answer = client.post(WHERE, json=value)
    assert answer.status_code == 200, answer.text
    assert answer.headers["etag"]
    said = document()["paths"][WHERE]["post"]["requestBody"]["content"]["application/json"]
    assert said["examples"][name] == EXAMPLES[name]
    assert said["schema"] == {"$ref": "#/components/schemas/MeasuredCam"}
    there = ProfileAnalysis.model_validate_json(answer.content)
    assert there == read_back(MeasuredCam.model_validate(value))
    assert there.unreached_hollows


def test_the_same_points_give_the_same_bytes(client: httpx2.Client) -> None:
    answer, again = (client.post(WHERE, json=body()) for _ in range(2))
    assert answer.content == again.content
    assert answer.headers["etag"] == again.headers["etag"]


@pytest.mark.parametrize(
    ("changes", "pointer", "words"),
    [
        ({"points_mm": [[0.0, 1.0]] * 2}, "/points_mm", "at least 3"),
        ({"points_mm": [[30.0, 0.0], [0.0, 30.0], [-30.0, 0.0]]}, "/points_mm", "fewer than"),
        ({"points_mm": body()["points_mm"][:400]}, "/points_mm", "not closed"),
        ({"tolerance_mm": 0.0}, "/tolerance_mm", "greater than 0"),
        ({"tolerance_mm": 1e-9}, "/tolerance_mm", "scatter"),
        ({"follower": {"kind": "translating_roller", "roller_radius_mm": 3}},
         "/follower/offset_mm", "given"),
        ({"follower": ROLLER | {"offset_mm": 77.0}}, "/follower", "does not reach"),
        ({"points": []}, "/points", "not a field"),
        ({"face_width": {"kind": "face_width"}}, "/face_width", "no width"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_with_its_place(
    client: httpx2.Client, changes: dict[str, Any], pointer: str, words: str
) -> None:
    answer = client.post(WHERE, json=body(**changes))
    assert answer.status_code == 422, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    error = answer.json()["errors"][0]
    assert error["pointer"] == pointer
    assert words in error["rule"]
    assert error["remedy"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1.5 2\n-3,4\n\n# note\n5;6 # more\n", [[1.5, 2.0], [-3.0, 4.0], [5.0, 6.0]]),
        ("x y z\n1 2 0\n", [[1.0, 2.0]]),
        ("angle_deg,side,x_mm,y_mm\n0,0,7.5,8.5\n1,0,9,10\n", [[7.5, 8.5], [9.0, 10.0]]),
        ("\ufeff\"x\";\"y\"\n1;2\n", [[1.0, 2.0]]),
        ("1,5;-2,5;0\n3,25\t4\n5,5 6,5\n", [[1.5, -2.5], [3.25, 4.0], [5.5, 6.5]]),
        ("1, 2, 3\n4 ,5\n6,7;\n", [[1.0, 2.0], [4.0, 5.0], [6.0, 7.0]]),
    ],
)  # fmt: skip
def test_points_are_read_from_text(tmp_path: Path, text: str, expected: list[list[float]]) -> None:
    path = tmp_path / "points.txt"
    path.write_text(text, encoding="utf-8")
    assert points_in(path) == expected


def test_a_broken_row_is_named(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("1,2\n3,four\n")
    with pytest.raises(InputError, match="line 2"):
        points_in(path)


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    """A request without points, and our own table of the profile as the points' file."""
    from synthesis import synthesise
    from synthesis.exporters import PROFILE_FORMATS, ProfileOptions

    question: DesignSpec = spec(ROLLER)
    table = PROFILE_FORMATS["csv"].write(synthesise(question), ProfileOptions(points_per_degree=2))
    points, request = tmp_path / "profile.csv", tmp_path / "request.json"
    points.write_bytes(table)
    given = {"speed_rpm": 97, "follower": ROLLER, "tolerance_mm": 2e-3}
    request.write_text(json.dumps(given), encoding="utf-8")
    return request, points


def test_the_command_reads_our_own_table(files: tuple[Path, Path]) -> None:
    request, points = files
    done = runner.invoke(cli.app, ["read-back", str(request), "--points", str(points)])
    assert done.exit_code == 0, done.output
    for words in ("base_radius_mm 41.299", "stroke_mm 23.700", "Dwells", "acceleration", "µm rms"):
        assert words in done.output, done.output
    assert "…" not in done.output


def test_the_command_prints_json(files: tuple[Path, Path]) -> None:
    request, points = files
    done = runner.invoke(cli.app, ["read-back", str(request), "--points", str(points), "--json"])
    assert done.exit_code == 0, done.output
    found = ProfileAnalysis.model_validate_json(done.stdout)
    assert found.dimensions["base_radius_mm"] == pytest.approx(41.3, abs=1e-3)


def test_the_command_tells_of_what_is_not_touched(tmp_path: Path) -> None:
    path = tmp_path / "example.json"
    path.write_text(json.dumps(EXAMPLES["spare-roller"]), encoding="utf-8")
    done = runner.invoke(cli.app, ["read-back", str(path)])
    assert done.exit_code == 0, done.output
    assert "Not touched" in done.output


def test_the_command_refuses_in_words(files: tuple[Path, Path], tmp_path: Path) -> None:
    request, _ = files
    for arguments, words in (
        ([], "points_mm"),
        (["--points", str(tmp_path / "none.csv")], "cannot be read"),
        (["--points", str(request)], "at least 3"),
    ):
        done = runner.invoke(cli.app, ["read-back", str(request), *arguments])
        assert done.exit_code == 2, done.output
        assert words in done.output
        assert "Traceback" not in done.output
