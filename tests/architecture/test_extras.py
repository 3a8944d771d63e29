"""What is optional: the same names and sizes wherever they are told, and advice that works."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from service.commands.examples import COMMANDS
from service.contract.examples import FOLDERS, example_paths
from synthesis.errors import EXTRAS, ExtraMissing
from tests.architecture.sizes import sizes

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PLAIN, OWN = 635, 17  # MB: of others' packages, and of Camwright itself, in a plain installation
NEAR = 0.15  # how far a size may be off: wheels of other machines, files that are not compiled
SOURCES = [path for part in ("service", "synthesis") for path in (ROOT / part).rglob("*.py")]


def test_extras_have_one_size_everywhere() -> None:
    declared = PROJECT["project"]["optional-dependencies"]
    assert set(EXTRAS) == set(declared) - {"dev"}
    assert declared["dev"][0] == f"camwright[{','.join(sorted(EXTRAS))}]"
    page = (ROOT / "docs" / "installation.md").read_text(encoding="utf-8")
    told = re.findall(r"^\| `(\w+)` \|.*\| (\d+) \|$", page, re.MULTILINE)
    assert {name: int(size) for name, size in told} == EXTRAS
    texts = "\n".join(path.read_text(encoding="utf-8") for path in SOURCES)
    for name, size in re.findall(r"camwright\[(\w+)\]'(?:[^\n]* \((\d+) MB\))?", texts):
        assert name in EXTRAS
        assert size in ("", str(EXTRAS[name]))


def test_sizes_are_those_of_the_packages() -> None:
    try:
        counted = sizes()
    except PackageNotFoundError as error:
        pytest.skip(f"{error} is not installed here")
    told = {**EXTRAS, "": PLAIN}
    assert told.keys() == counted.keys()
    wrong = {name: counted[name] for name in told if abs(counted[name] / told[name] - 1.0) > NEAR}
    assert wrong == {}
    page = (ROOT / "docs" / "installation.md").read_text(encoding="utf-8")
    assert f"the plain installation takes {PLAIN + OWN} MB" in page


@pytest.mark.parametrize("extra", EXTRAS)
def test_a_missing_extra_says_what_it_takes(extra: str) -> None:
    error = ExtraMissing("A file", extra)
    assert f"pip install 'camwright[{extra}]' ({EXTRAS[extra]} MB)" in str(error)
    kind, arguments = error.__reduce__()
    assert str(kind(*arguments)) == str(error)


def test_a_wheel_has_what_is_advised() -> None:
    """Examples and checker where an installation looks for them, and no advice of the checkout."""
    wheel = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert wheel["openapi/examples"] == FOLDERS[1].relative_to(ROOT).as_posix()
    assert wheel["checker/check.py"] == "synthesis/pipeline/proof_file/check.py"
    kept = (ROOT / ".dockerignore").read_text().splitlines()
    assert all(f"!{path.partition('/')[0]}" in kept for path in wheel)
    for path in (ROOT / "service" / "commands").glob("*.py"):
        assert "openapi/examples" not in path.read_text(encoding="utf-8"), path
    assert {folder.partition("/")[0] for folder, _ in example_paths().values()} == set(COMMANDS)
