"""The page on the walls of a cylindrical cam prints what its program prints."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "reference"


def test_the_page_is_up_to_date(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(FOLDER / "cylindrical_walls.py"), run_name="__main__")
    page = (FOLDER / "cylindrical-walls.md").read_text(encoding="utf-8")
    printed = capsys.readouterr().out.strip()
    assert printed.count("| --: |") >= 3
    for table in printed.split("\n\n"):
        assert table in page, "out of date: python docs/reference/cylindrical_walls.py"
