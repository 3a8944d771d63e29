"""Files stay small and are named after what they hold."""

from pathlib import Path

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


def test_no_file_is_too_long() -> None:
    lines = {name_of(path): len(path.read_text("utf-8").splitlines()) for path in SOURCES}
    assert {name: n for name, n in lines.items() if n > MOST_LINES} == {}, f"at most {MOST_LINES}"


def test_every_name_says_something() -> None:
    parts = {name_of(path): path.relative_to(ROOT).with_suffix("").parts for path in SOURCES}
    empty = [name for name, own in parts.items() if NAMES_THAT_SAY_NOTHING.intersection(own)]
    assert empty == [], "name them after what they hold"
