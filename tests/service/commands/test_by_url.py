"""Commands that let a service do it: the same words and files as without, and how they say no."""

from __future__ import annotations

import json
import re
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from typer.testing import CliRunner

from service import cli
from service.client import Client, Retries
from service.commands import answering
from service.contract.examples import SELF_CHECK, examples
from tests.service.conftest import Running

EXAMPLES = Path(__file__).resolve().parents[3] / "openapi" / "examples"
runner = CliRunner()


def run(*given: str | Path, url: str | None = None) -> Result:
    env = {"CAMWRIGHT_URL": url} if url else {}
    return runner.invoke(cli.app, [str(one) for one in given], env=env)


def untimed(text: str) -> str:
    return re.sub(r"\d+ ms", "N ms", text)


def files(folder: Path) -> dict[str, bytes]:
    """What was written, without the seconds that stages of the printed report took."""
    found = {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*.*")}
    untimed = {name: re.sub(rb"[\d.e-]+ s\b", b"N s", content) for name, content in found.items()}
    return {name: content for name, content in untimed.items() if not name.endswith(".json")}


@pytest.mark.parametrize(
    ("command", "name"),
    [("design", "example-13-6-sized.json"), ("cam-set", "cam-sets/p3-set.json")],
)
def test_a_service_gives_the_same_files(
    real_service: Running, tmp_path: Path, command: str, name: str
) -> None:
    here = run(command, EXAMPLES / name, "--out", tmp_path / "same")
    written = files(tmp_path / "same")
    there = run(command, EXAMPLES / name, "--out", tmp_path / "same", url=real_service.url)
    assert here.exit_code == there.exit_code == 0, there.output
    assert untimed(here.stdout) == untimed(there.stdout)
    assert len(written) > 5
    assert files(tmp_path / "same") == written


def test_a_service_analyses_alike(real_service: Running) -> None:
    spec = EXAMPLES / "analyses" / "p2-as-given.json"
    here, there = run("analyse", spec), run("analyse", spec, "--url", real_service.url)
    assert here.exit_code == there.exit_code == 3
    assert here.stdout == there.stdout
    assert "pressure_angle" in there.stdout


def test_a_service_reads_back_alike(real_service: Running) -> None:
    spec = EXAMPLES / "profile-analyses" / "spare-roller.json"
    here, there = run("read-back", spec), run("read-back", spec, url=real_service.url)
    assert here.exit_code == there.exit_code == 0, there.output
    assert here.stdout == there.stdout


def test_where_no_cam_fits_that_is_the_answer(real_service: Running, tmp_path: Path) -> None:
    spec = EXAMPLES / "infeasible-on-purpose.json"
    there = run("design", spec, "--out", tmp_path, "--url", real_service.url)
    assert there.exit_code == 3
    assert "cannot hold together" in there.stdout


def test_the_best_so_far_is_kept_where_time_ends(service: Running, tmp_path: Path) -> None:
    body = {**examples()[SELF_CHECK]["value"], "name": "best"}
    path = tmp_path / "spec.json"
    path.write_text(json.dumps(body), encoding="utf-8")
    there = run("design", path, "--out", tmp_path, "--url", service.url)
    assert there.exit_code == 0, there.output
    assert "budget" in there.stderr
    assert json.loads((tmp_path / "design.json").read_text())["name"] == "best"


@pytest.mark.parametrize("url", ["nonsense", "ftp://127.0.0.1", "http://"])
@pytest.mark.parametrize("command", ["design", "sweep"])
def test_what_is_no_address_is_said(tmp_path: Path, command: str, url: str) -> None:
    name = {"design": "fixed-laws.json", "sweep": "sweeps/rollers-and-laws.json"}[command]
    found = run(command, EXAMPLES / name, "--out", tmp_path, url=url)
    assert found.exit_code == 2
    assert f"{url} is not the address of a service" in found.stderr


def test_nobody_there_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(answering, "Client", partial(Client, retries=Retries(tries=1)))
    found = run("design", EXAMPLES / "fixed-laws.json", url="http://127.0.0.1:9")
    assert found.exit_code == 2
    assert "No answer from http://127.0.0.1:9 (" in found.stderr


def test_an_answer_of_another_version_is_said(
    service: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    strange: dict[str, Any] = {"name": "from the future", "dimensions": {}}
    monkeypatch.setattr(Client, "answer", lambda self, path, spec: strange)
    found = run("design", EXAMPLES / "fixed-laws.json", url=service.url)
    assert found.exit_code == 2
    assert "not in the form that this command knows" in found.stderr


@pytest.mark.usefixtures("unexplained")
def test_what_limits_cost_is_told(tmp_path: Path) -> None:
    assert run("design", EXAMPLES / "p2-sized.json", "--out", tmp_path).exit_code == 0
    reported = run("costs", tmp_path / "design.json")
    assert reported.exit_code == 0, reported.output
    assert "1 deg more in /limits/0/rise_deg makes base_radius 2.253 mm smaller" in reported.stdout
    assert "/limits/0/return_deg has no influence" in reported.stdout
    run("design", EXAMPLES / "infeasible-on-purpose.json", "--out", tmp_path)
    reported = run("costs", tmp_path / "design.json", "--json")
    assert reported.exit_code == 3
    assert json.loads(reported.stdout)["sensitivities"] == []
