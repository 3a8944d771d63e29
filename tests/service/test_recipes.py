"""The recipes of docs/recipes.md do what they say, in the order in which they stand."""

from __future__ import annotations

import contextlib
import io
import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.service.conftest import Running

PAGE = Path(__file__).resolve().parents[2] / "docs" / "recipes.md"
ADDRESS = "http://127.0.0.1:8000"  # of the service in the recipes


def recipes() -> Iterator[tuple[str, str, str]]:
    """Title, program and what it prints."""
    for section in PAGE.read_text(encoding="utf-8").split("\n## ")[1:]:
        program, _, printed = section.partition("\nprints\n")
        yield section.partition("\n")[0], indented(program), indented(printed)


def indented(text: str) -> str:
    """The first block of indented lines."""
    block: list[str] = []
    for line in text.splitlines():
        if line.startswith("    ") or (block and not line):
            block.append(line)
        elif block:
            break
    return textwrap.dedent("\n".join(block)).strip() + "\n"


def test_the_recipes(
    real_service: Running, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    done = 0
    for title, program, printed in recipes():
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec(compile(program.replace(ADDRESS, real_service.url), title, "exec"), names)
        assert said.getvalue() == printed, title
        done += 1
    assert done == 5
    assert (tmp_path / "cam.csv").read_text().count("\n") > 360
