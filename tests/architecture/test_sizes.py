"""Files stay small and are named after what they hold."""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted(
    path for package in ("synthesis", "service") for path in (ROOT / package).rglob("*.py")
)
MOST_LINES = 400
NAMES_THAT_SAY_NOTHING = {"utils", "util", "helpers", "helper", "common", "manager", "misc"}


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def test_there_are_sources() -> None:
    assert SOURCES


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_no_file_is_too_long(path: Path) -> None:
    lines = len(path.read_text(encoding="utf-8").splitlines())
    assert lines <= MOST_LINES, f"{name_of(path)} has {lines} lines; {MOST_LINES} is the most"


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_every_name_says_something(path: Path) -> None:
    parts = path.relative_to(ROOT).with_suffix("").parts
    empty = NAMES_THAT_SAY_NOTHING.intersection(parts)
    assert not empty, f"{name_of(path)}: name it after what it holds, not {empty.pop()!r}"
