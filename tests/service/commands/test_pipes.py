"""Questions on standard input, lengths in inches, completion, and what `--help` loads."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import get_args

import pytest
from typer.testing import CliRunner

from service import cli
from service.commands.display import Table, in_inches
from service.commands.export import OPTIONS
from service.commands.questions import LinkageKind
from service.commands.stream import documents
from service.contract.examples import example_paths, examples
from service.openapi import options_text
from synthesis.machines.linkages import LINKAGES

FIXED = json.dumps(examples()["fixed-laws"]["value"])
HEAVY = {"casadi", "clarabel", "fastapi", "httpx2", "numpy", "pydantic", "rich", "sqlalchemy"}
runner = CliRunner()


@pytest.mark.usefixtures("unexplained")
def test_each_question_of_a_pipe_has_its_line() -> None:
    wrong = '{"speed_rpm": 3}'
    given = f"{FIXED}\n\n{wrong}\n{json.dumps(examples()['infeasible-on-purpose'], indent=1)}\n"
    run = runner.invoke(cli.app, ["design", "-"], input=given)
    assert run.exit_code == 2, run.output
    good, refused, impossible = map(json.loads, run.stdout.splitlines())
    assert good["certificate"]["certified"]
    assert (refused["type"], refused["status"]) == ("/problems/invalid-request", 422)
    assert refused["instance"] == "#2"
    assert {each["pointer"] for each in refused["errors"]} == {"/program", "/follower"}
    assert impossible["status"] == "infeasible"
    # what a command could not answer is handed on by the next one, in its place
    then = runner.invoke(cli.app, ["confirm", "-"], input=run.stdout)
    assert then.exit_code == 2
    lines = list(map(json.loads, then.stdout.splitlines()))
    assert [line.get("verdict") for line in lines] == ["confirmed", None, None]
    assert lines[1] == refused
    assert lines[2]["type"] == "/problems/invalid-design"  # a cam that is not there


def test_a_no_is_exit_code_3_and_files_go_to_a_folder_of_each(tmp_path: Path) -> None:
    known = examples("linkages/six-bar-shapers")
    given = "\n".join(json.dumps(known[name]) for name in ("p5", "impossible-on-purpose"))
    question = ["linkage", "six-bar-shapers", "-", "--out", str(tmp_path)]
    run = runner.invoke(cli.app, question, input=given)
    assert run.exit_code == 3, run.output
    assert len(run.stdout.splitlines()) == 2
    assert (tmp_path / "1" / "motion.csv").is_file()
    assert [path.name for path in (tmp_path / "2").iterdir()] == ["linkage.json"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('{"a": 1}\n{"b": 2}\n', ['{"a": 1}', '{"b": 2}']),
        ('{\n "a": 1\n}\n\n[1,\n2]', ['{\n "a": 1\n}', "[1,\n2]"]),
        ('{"a": 1\n{"b": 2}\n', ['{"a": 1', '{"b": 2}']),  # one wrong line costs no other
        ('{"a": }\n{"b": 2}\n', ['{"a": }', '{"b": 2}']),
        ('{"a": 1} {"b": 2}\n3\n', ['{"a": 1} {"b": 2}', "3"]),
        ('{"a": "x', ['{"a": "x']),
        ("\n \n", []),
    ],
)
def test_documents_of_a_pipe(text: str, expected: list[str]) -> None:
    found = documents(line.encode() for line in text.splitlines(keepends=True))
    assert [each.decode().strip() for each in found] == expected


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("radius_mm 36.2300, offset_mm -8.6, 5 %", "radius_in 1.42638, offset_in -0.3386, 5 %"),
        ("at 3.5°: 254 mm and 2.54e3 mm/s², 645.16 mm²", "at 3.5°: 10 in and 100 in/s², 1 in²"),
        ("3 N/mm, 5 N mm, 7 µm, 8 ms", "3 N/mm, 5 N mm, 7 µm, 8 ms"),
        ("832462.8512 mm⁴", "2 in⁴"),
        ("from 25.4 to -50.8 mm, 3° to 254 mm", "from 1 to -2 in, 3° to 10 in"),
    ],
)  # fmt: skip
def test_lines_in_inches(line: str, expected: str) -> None:
    assert in_inches(line) == expected


def test_tables_in_inches() -> None:
    table = Table(
        "T", ("name", "value", "unit", "at °", "allowed", "rho mm", "jumps"),
        [("25.4 a", 254.0, "mm/s", "25.4", "±2.54", 25.4, "43"),
         ("b", 30.0, "deg", "1", None, "50.8", "0.5")],
    )  # fmt: skip
    said = in_inches(table)
    assert isinstance(said, Table)
    assert said.columns == ["name", "value", "unit", "at °", "allowed", "rho in", "jumps"]
    assert said.rows == [
        ["25.4 a", 10.0, "in/s", "25.4", "±0.1", 1.0, "43"],
        ["b", 30.0, "deg", "1", None, "2", "0.5"],
    ]


def test_what_is_printed_in_inches_is_what_is_printed_in_mm() -> None:
    mm = runner.invoke(cli.app, ["analyse", "p2-as-given"]).stdout
    inches = runner.invoke(cli.app, ["analyse", "p2-as-given", "--units", "inch"]).stdout
    assert " mm" in mm
    assert " mm" not in inches
    assert inches.count("in/s²") == mm.count("mm/s²") > 0


@pytest.mark.parametrize(
    ("command", "given", "words"),
    [
        (["costs"], "question", "is a question, not a design. Design it first: camwright design"),
        (["design"], "answer", 'is a design already. Its question is under "spec".'),
    ],
)
def test_a_question_in_place_of_a_design_is_told_so(
    command: list[str], given: str, words: str, tmp_path: Path
) -> None:
    path = tmp_path / "given.json"
    question = json.loads(FIXED)
    path.write_text(json.dumps(question if given == "question" else
                               {"spec": question, "certificate": {}}))  # fmt: skip
    run = runner.invoke(cli.app, [*command, str(path)])
    assert run.exit_code == 2
    assert run.output.count("\n") == 1
    assert words in run.output


def test_examples_are_questions_by_name() -> None:
    listed = runner.invoke(cli.app, ["examples"]).stdout
    for name in example_paths():
        assert f"  {name} " in listed
    one = runner.invoke(cli.app, ["examples", "fixed-laws"])
    assert json.loads(one.stdout) == json.loads(FIXED)
    for question in (["examples", "nonsense"], ["design", "nonsense"]):
        none = runner.invoke(cli.app, question)
        assert none.exit_code == 2
        assert "camwright examples lists them" in none.output


def test_kinds_of_linkages_are_those_of_the_core() -> None:
    assert get_args(LinkageKind) == tuple(LINKAGES)


@pytest.mark.parametrize("words", [[], ["design"], ["export"], ["linkage"], ["serve"], ["sweep"]])
def test_help_loads_nothing_heavy(words: list[str]) -> None:
    """Whatever the machine's speed: 0.15 s of processor time are Python's, typer's and ours."""
    code = "import sys; from service import cli\ntry: cli.app()\nexcept SystemExit: pass\n"
    code += "print('LOADED', *sys.modules)"
    command = [sys.executable, "-c", code, *words, "--help"]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    loaded = {name.partition(".")[0] for name in run.stdout.partition("LOADED ")[2].split()}
    assert "typer" in loaded
    assert not loaded & HEAVY


def test_options_of_export_are_those_of_the_formats() -> None:
    """`make openapi` writes them anew."""
    assert OPTIONS.read_text(encoding="utf-8") == options_text()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("camwright des", {"design"}),
        ("camwright design p2-", {"p2-sized", "p2-as-given"}),
        ("camwright design --un", {"--units"}),
        ("camwright design --units i", {"inch"}),
        ("camwright export x --part so", {"solid"}),
        ("camwright linkage pal", {"palletising-arms"}),
    ],
)
def test_the_shell_completes(words: str, expected: set[str], tmp_path: Path) -> None:
    environment = {
        **os.environ, "_CAMWRIGHT_COMPLETE": "complete_bash", "COMP_WORDS": words,
        "COMP_CWORD": str(words.count(" ")),
    }  # fmt: skip
    environment["PYTHONPATH"] = str(Path(cli.__file__).parents[1])
    code = "from service.cli import app; app(prog_name='camwright')"
    command = [sys.executable, "-c", code]
    run = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert set(run.stdout.split()) == expected, run.stderr
