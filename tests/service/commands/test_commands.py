"""`python -m service` and `camwright`: what they print, and how they say no."""

from __future__ import annotations

import json
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from service import cli
from service.commands import answering
from service.contract.examples import SELF_CHECK, examples
from synthesis import DesignSpec
from synthesis.design.design import Design
from synthesis.design.identity import engine_version

runner = CliRunner()


@pytest.fixture
def spec_file(tmp_path: Path) -> Path:
    path = tmp_path / "spec.json"
    path.write_text(json.dumps(examples()[SELF_CHECK]["value"]), encoding="utf-8")
    return path


def test_the_service_starts_checks_itself_and_stops(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "service"]
    environment = {"CAMWRIGHT_PORT": "0", "CAMWRIGHT_WORKERS": "1", "PATH": "/usr/bin:/bin"}
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True
    ) as run:
        assert run.stdout is not None
        printed = []
        for line in run.stdout:
            printed.append(line)
            if line.startswith("Stop"):
                break
        run.send_signal(signal.SIGINT)
        run.wait(120)
    text = "".join(printed)
    found = re.search(r"Self-check, example 13-6: base radius (\d+\.\d+) mm, offset .*", text)
    assert found, text
    assert 30.0 < float(found[1]) < 40.0
    assert ", certified, " in found[0]
    assert re.search(r"http://127\.0\.0\.1:\d+/docs", text)
    assert (tmp_path / "camwright.db").exists()


def test_a_port_that_is_taken_is_said_in_one_sentence() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        run = runner.invoke(cli.app, ["serve", "--port", str(port)])
    assert run.exit_code == 1
    assert run.output.count("\n") == 1
    assert f"Port {port} on 127.0.0.1 is in use" in run.output
    assert "--port" in run.output


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["--port", "99999"], "--port) is 99999: "),
        (["--database-url", "nonsense"], "--database-url) is 'nonsense'"),
    ],
)
def test_settings_that_make_no_sense_are_said_in_one_sentence(given: list[str], words: str) -> None:
    run = runner.invoke(cli.app, ["serve", *given])
    assert run.exit_code == 1, run.output
    assert run.output.count("\n") == 1
    assert words in run.output


def test_a_store_that_cannot_be_is_said_in_one_sentence() -> None:
    """With a scheduler, so that no process to fork workers from is started for nothing."""
    environment = {"CAMWRIGHT_PORT": "0", "CAMWRIGHT_SCHEDULER": "tls://127.0.0.1:9"}
    given = ["serve", "--database-url", "sqlite:////proc/none/x.db"]
    run = runner.invoke(cli.app, given, env=environment)
    assert run.exit_code == 1, run.output
    assert run.output.count("\n") == 1
    assert "cannot be used: " in run.output


def test_one_design_without_a_service(spec_file: Path, tmp_path: Path) -> None:
    done = runner.invoke(cli.app, ["design", str(spec_file), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    design = Design.model_validate_json((tmp_path / "out" / "design.json").read_bytes())
    assert design.certificate.certified
    assert (tmp_path / "out" / "profile.csv").read_text().count("\n") > 1000
    assert (tmp_path / "out" / "motion.csv").read_text().count("\n") > 300
    assert "base_radius_mm" in done.output


def test_files_are_there_though_nobody_reads_the_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As after `| head`: the pipe is gone while the answer is printed."""

    def gone(*_: object) -> None:
        raise BrokenPipeError

    monkeypatch.setattr(answering, "print_answer", gone)
    kind = answering.QuestionKind(DesignSpec, lambda question: question)
    shown = answering.Shown(lambda *_: (), lambda _: {"design.json": b"{}"})
    with pytest.raises(BrokenPipeError):
        answering.run(kind, Path("fixed-laws"), shown, folder=tmp_path / "out")
    assert (tmp_path / "out" / "design.json").exists()


def test_a_design_is_confirmed(spec_file: Path, tmp_path: Path) -> None:
    runner.invoke(cli.app, ["design", str(spec_file), "--out", str(tmp_path)])
    written = tmp_path / "design.json"
    done = runner.invoke(cli.app, ["confirm", str(written)])
    assert done.exit_code == 0, done.output
    assert "confirmed: every line" in done.output
    assert "self_crossing" in done.output
    design = Design.model_validate_json(written.read_bytes())
    wrong = [e.model_copy(update={"holds": not e.holds}) for e in design.extremes]
    written.write_text(design.model_copy(update={"extremes": wrong}).model_dump_json())
    done = runner.invoke(cli.app, ["confirm", str(written), "--json"])
    assert done.exit_code == 3
    assert '"contradicted"' in done.output


def test_a_design_is_written_as_a_proof(spec_file: Path, tmp_path: Path) -> None:
    runner.invoke(cli.app, ["design", str(spec_file), "--out", str(tmp_path)])
    to = tmp_path / "files" / "proof.json"
    done = runner.invoke(cli.app, ["proof", str(tmp_path / "design.json"), "--out", str(to)])
    claims = json.loads(to.read_text())["claims"]
    assert done.exit_code == (0 if all(claim["proven"] for claim in claims) else 3), done.output
    assert all(f"{claim['place']}:" in done.output for claim in claims)


def test_a_design_with_a_table_has_a_proof_file_too(tmp_path: Path) -> None:
    """Its question holds pairs, which are lists in JSON."""
    runner.invoke(cli.app, ["design", "table", "--out", str(tmp_path)])
    to = tmp_path / "proof.json"
    done = runner.invoke(cli.app, ["proof", str(tmp_path / "design.json"), "--out", str(to)])
    assert done.exit_code == 3, done.output
    claims = json.loads(to.read_text())["claims"]
    assert {claim["proven"] for claim in claims} == {False}


def test_a_groove_brings_a_file_for_each_flank(tmp_path: Path) -> None:
    value = examples()["grooved"]["value"]
    program = [s | ({"law": {"kind": "cycloidal"}} if "law" in s else {}) for s in value["program"]]
    path, out = tmp_path / "spec.json", tmp_path / "out"
    path.write_text(json.dumps(value | {"program": program, "limits": []}), encoding="utf-8")
    done = runner.invoke(cli.app, ["design", str(path), "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert (out / "profile-outer.csv").read_text() != (out / "profile.csv").read_text()
    assert not (out / "profile-outer.svg").exists()  # one drawing shows both


def test_a_worked_example_is_a_spec_too(tmp_path: Path) -> None:
    path = tmp_path / "example.json"
    path.write_text(json.dumps(examples()["fixed-laws"]), encoding="utf-8")
    done = runner.invoke(cli.app, ["design", str(path), "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("{", "Line 1, column 2"),
        ('{"program": []}', "/program = []"),
        ('{"programme": 1}', 'Write "program" instead of "programme".'),
    ],
)
def test_a_wrong_spec_is_told_in_words(tmp_path: Path, content: str, words: str) -> None:
    path = tmp_path / "wrong.json"
    path.write_text(content, encoding="utf-8")
    done = runner.invoke(cli.app, ["design", str(path), "--out", str(tmp_path)])
    assert done.exit_code == 2
    assert words in done.output
    assert "Traceback" not in done.output


def test_a_missing_file_is_told_in_words(tmp_path: Path) -> None:
    done = runner.invoke(cli.app, ["design", str(tmp_path / "none.json")])
    assert done.exit_code == 2
    assert "cannot be read" in done.output


def test_version() -> None:
    assert engine_version() in runner.invoke(cli.app, ["--version"]).output
