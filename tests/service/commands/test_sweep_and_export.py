"""`camwright sweep` and `camwright export`: what they write, and how they say no."""

from __future__ import annotations

import csv
import json
import sqlite3
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from service import cli
from service.contract.examples import SELF_CHECK, examples
from synthesis.design.design import Design
from synthesis.exporters import (
    MOTION_FORMATS,
    PICTURES,
    PROFILE_FORMATS,
    PictureOptions,
    ProfileOptions,
)
from synthesis.exporters.options import DiagramOptions
from synthesis.pipeline.synthesise import synthesise
from synthesis.spec.design_spec import DesignSpec
from tests.service.conftest import Running
from tests.service.killing import Process, children
from tests.service.sweeps.test_kills import alive, until
from tests.service.sweeps.test_sweeps import sweep_of

runner = CliRunner()


def written(folder: Path, name: str, body: Any) -> str:
    (folder / name).write_text(json.dumps(body), encoding="utf-8")
    return str(folder / name)


@pytest.fixture(scope="module")
def fixed() -> Design:
    return synthesise(DesignSpec.model_validate(examples()["fixed-laws"]["value"]))


def test_a_sweep_by_a_service(service: Running, tmp_path: Path) -> None:
    file = written(tmp_path, "sweep.json", sweep_of([f"by command {i}" for i in range(12)]))
    folder = tmp_path / "results"
    run = runner.invoke(cli.app, ["sweep", file, "--out", str(folder), "--url", service.url])
    assert run.exit_code == 0, run.output
    assert "successful: 12 of 12 items, 12 optimal" in run.stdout
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["items.csv", "items.parquet", "sweep.json"]
    rows = list(csv.DictReader((folder / "items.csv").read_text().splitlines()))
    assert [row["/name"] for row in rows] == [f"by command {i}" for i in range(12)]
    assert json.loads((folder / "sweep.json").read_text())["counts"]["done"] == 12
    again = runner.invoke(cli.app, ["sweep", file, "--out", str(folder), "--url", service.url])
    assert again.stdout == run.stdout


def test_a_sweep_that_comes_to_nothing(service: Running, tmp_path: Path) -> None:
    file = written(tmp_path, "sweep.json", sweep_of(["solver", "bug"]))
    run = runner.invoke(cli.app, ["sweep", file, "--out", str(tmp_path), "--url", service.url])
    assert run.exit_code == 3
    assert "failed: 2 of 2 items, 2 failed" in run.stdout


def test_a_sweep_that_is_refused_says_where_and_why(service: Running, tmp_path: Path) -> None:
    body, most = sweep_of(["x"]), service.app.state.parts.settings.max_sweep_items
    axis = {"kind": "range", "pointer": "/speed_rpm", "start": 1, "stop": 2, "count": most + 1}
    body["axes"] = [axis]
    file = written(tmp_path, "sweep.json", body)
    run = runner.invoke(cli.app, ["sweep", file, "--out", str(tmp_path), "--url", service.url])
    assert run.exit_code == 2
    assert f"/axes: makes {most + 1} items; this server takes {most}" in run.output
    body["axes"][0]["pointer"] = "/nothing/there"
    run = runner.invoke(cli.app, ["sweep", written(tmp_path, "sweep.json", body)])
    assert run.exit_code == 2
    assert "/nothing/there" in run.output


def test_a_sweep_here_is_kept_in_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second time nothing is done again: even the times of the items are the same."""
    monkeypatch.setenv("CAMWRIGHT_WORKERS", "1")
    base = examples()[SELF_CHECK]["value"]
    axis = {"kind": "list", "pointer": "/limits/0/rise_deg", "values": [26, 31, 33]}
    file = written(tmp_path, "asked.json", {"name": "here", "base": base, "axes": [axis]})
    tables = []
    for _ in range(2):
        run = runner.invoke(cli.app, ["sweep", file, "--out", str(tmp_path / "kept")])
        assert run.exit_code == 0, run.output
        tables.append((tmp_path / "kept" / "items.csv").read_bytes())
    assert tables[0] == tables[1]
    radii = [float(row["base_radius_mm"])
             for row in csv.DictReader(tables[0].decode().splitlines())]  # fmt: skip
    assert len(radii) == 3
    assert radii == sorted(radii, reverse=True)


def test_a_sweep_here_that_is_killed_goes_on_when_called_again(tmp_path: Path) -> None:
    """kill -9 of the command; what was done is not done again, nothing is lost or there twice."""
    count, folder = 24, tmp_path / "kept"
    axis = {"kind": "range", "pointer": "/limits/0/rise_deg", "start": 26, "stop": 34}
    base = examples()[SELF_CHECK]["value"]
    body = {"name": "killed", "base": base, "axes": [axis | {"count": count}]}
    question = ["sweep", written(tmp_path, "asked.json", body), "--out", str(folder)]
    command = Process("-m", "service.cli", *question, CAMWRIGHT_WORKERS="1")
    try:
        until(lambda: (folder / "sweeps.db").exists() and len(kept(folder)) > 3)
        workers = children(command.running.pid)
    finally:
        command.kill()
    before = kept(folder)
    assert 3 < len(before) < count, "it was over before it was killed"
    until(lambda: not any(map(alive, workers)))
    command.start()
    assert command.running.wait(600.0) == 0
    after = kept(folder)
    assert after[: len(before)] == before
    assert sorted(number for number, _ in after) == list(range(count))
    rows = csv.DictReader((folder / "items.csv").read_text().splitlines())
    assert [int(row["number"]) for row in rows] == list(range(count))


def kept(folder: Path) -> list[tuple[int, float]]:
    """Finished items in the order in which they were: number, and seconds in the core."""
    with sqlite3.connect(folder / "sweeps.db") as database:
        there = "select count(*) from sqlite_master where name = 'sweep_items'"
        question = "select number, seconds from sweep_items order by sequence"
        made = database.execute(there).fetchone()[0]
        found: list[tuple[int, float]] = database.execute(question).fetchall() if made else []
    database.close()
    return found


@pytest.mark.parametrize("kept", [False, True])
def test_export_writes_what_the_core_does(tmp_path: Path, fixed: Design, kept: bool) -> None:
    body = json.loads(fixed.model_dump_json()) if kept else examples()["fixed-laws"]
    file = written(tmp_path, "cam.json", body)
    options = ["--points-per-degree", "3", "--curve", "pitch", "--turn-deg", "17.5"]
    question = ["export", file, "--format", "csv", "--format", "txt", *options]
    run = runner.invoke(cli.app, [*question, "--out", str(tmp_path / "files")])
    assert run.exit_code == 0, run.output
    expected = ProfileOptions(points_per_degree=3.0, curve="pitch", turn_deg=17.5)
    for name in ("csv", "txt"):
        known = PROFILE_FORMATS[name]
        content = (tmp_path / "files" / f"pitch.{name}").read_bytes()
        assert content == known.write(fixed, known.options_like(expected))
    question = ["export", file, "--part", "motion", "--format", "svg", "--out", str(tmp_path)]
    assert runner.invoke(cli.app, question).exit_code == 0
    drawn = MOTION_FORMATS["svg"].write(fixed, DiagramOptions())
    assert (tmp_path / "motion.svg").read_bytes() == drawn
    question = ["export", file, "--part", "picture", "--format", "contact.svg", "--theme", "print"]
    assert runner.invoke(cli.app, [*question, "--out", str(tmp_path)]).exit_code == 0
    drawn = PICTURES["contact.svg"].write(fixed, PictureOptions(theme="print"))
    assert (tmp_path / "contact.svg").read_bytes() == drawn


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("fixed-laws", ["--format", "doc"], "--format doc: a profile is written as json, csv"),
        ("fixed-laws", ["--part", "picture"], "--format csv: a picture is written as contact.svg"),
        ("fixed-laws", ["--format", "svg", "--theme", "pink"], "--theme"),
        ("fixed-laws", ["--theme", "dark"], "csv has no such option"),
        ("fixed-laws", ["--curve", "outside"], "outside"),
        ("fixed-laws", ["--points-per-degree", "0"], "above 0 and at most 100"),
        ("fixed-laws", ["--decimals", "3"], "--decimals: csv has no such option. It has --curve"),
        ("fixed-laws", ["--part", "shadow"], "shadow"),
        ("flat-face", ["--format", "grinding.nc"], "Give curve=cutter and cutter_diameter_mm"),
        (
            "fixed-laws",
            ["--format", "nc", "--safe-z-mm", "-9", "--z-mm", "-4"],
            "Raise safe_z_mm above the workpiece",
        ),
        ("infeasible-on-purpose", [], "no cam fits its limits"),
    ],
)
def test_export_says_no(tmp_path: Path, name: str, options: list[str], said: str) -> None:
    file = written(tmp_path, "cam.json", examples()[name])
    run = runner.invoke(cli.app, ["export", file, *options, "--out", str(tmp_path / "none")])
    assert run.exit_code == 2
    assert said in run.output
    assert not (tmp_path / "none").exists()


def test_export_of_what_is_not_there(tmp_path: Path) -> None:
    run = runner.invoke(cli.app, ["export", str(tmp_path / "missing.json")])
    assert run.exit_code == 2
    assert "cannot be read" in run.output
