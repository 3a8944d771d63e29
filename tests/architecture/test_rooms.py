"""Tests lie in the rooms of the product: whoever changes a room finds its tests under its name."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# what is tested as a whole, and not in one room
WHOLE = {
    "architecture", "benchmarks", "checker", "hard", "mutants", "properties", "service/checks",
    "validation",
}  # fmt: skip


def test_every_folder_of_tests_is_named_after_a_room() -> None:
    folders = {path.parent.relative_to(ROOT / "tests") for path in ROOT.glob("tests/**/*.py")}
    rooms = {
        folder for folder in folders
        if folder.parts and folder.parts[0] not in WHOLE and folder.as_posix() not in WHOLE
    }  # fmt: skip
    strangers = [
        f"tests/{folder.as_posix()}"
        for folder in sorted(rooms)
        if not (ROOT / ("" if folder.parts[0] == "service" else "synthesis") / folder).is_dir()
    ]
    assert strangers == [], "no room of this name: tests move with the room that they test"
