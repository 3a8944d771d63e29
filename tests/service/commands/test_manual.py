"""What `--help` says: examples that run, and exit codes."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer.core
import typer.main
from typer.testing import CliRunner

from service import cli

ROOT = Path(__file__).resolve().parents[3]
COMMANDS = typer.main.get_group(cli.app).commands


def shown(text: str) -> list[list[str]]:
    """The commands in a text, word by word."""
    lines = (line.strip() for line in text.splitlines())
    return [shlex.split(line)[1:] for line in lines if line.startswith("camwright ")]


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_each_command(name: str) -> None:
    said = CliRunner().invoke(cli.app, [name, "--help"], env={"COLUMNS": "100"})
    assert said.exit_code == 0
    flat = " ".join(said.stdout.split())
    assert f"camwright {name} " in flat or f"camwright {name}" in said.stdout
    assert "Exit codes: 0 " in flat
    for line in cli.HELP[name].splitlines():
        assert line.strip("\b ")[:40] in flat, line


@pytest.mark.parametrize("text", [cli.ROOT, *cli.HELP.values()])
def test_examples_are_real(text: str) -> None:
    found = shown(text)
    assert found
    for name, *words in found:
        command = COMMANDS[name]
        if isinstance(command, typer.core.TyperGroup):
            command = command.commands[words.pop(0)]
        options = {one for param in command.params for one in param.opts}
        for word in words:
            assert not word.startswith("--") or word in options, (name, word)
            if word.startswith("openapi/"):
                assert (ROOT / word).is_file(), word


def test_the_manual_is_of_the_commands_that_there_are() -> None:
    assert set(cli.HELP) == set(COMMANDS)
    root = CliRunner().invoke(cli.app, ["--help"], env={"COLUMNS": "100"}).stdout
    for name in COMMANDS:
        assert name in root
    for word in ("mm/s³", "Exit codes", "CAMWRIGHT_URL"):
        assert word in root


def test_the_package_takes_the_options_of_serve() -> None:
    """`python -m service --port x` once was heard by nobody."""
    question = [sys.executable, "-m", "service", "--port", "x"]
    done = subprocess.run(question, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "'x' is not a valid" in done.stderr
