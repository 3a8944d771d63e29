"""The lock files name one version of each package, with the hashes of its files and no address."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

PLAIN, IMAGE, EVERYTHING = (
    f"requirements{part}.lock" for part in ("", "-image", "-dev")
)  # fmt: skip
PACKAGE = re.compile(
    r"^([a-z0-9._-]+)==(\S+)( ; [^\\\n]+)?((?: \\\n    --hash=sha256:[0-9a-f]{64})+)$", re.M
)


def locked(name: str) -> dict[str, str]:
    """Versions by package; every line of the file is part of one that has hashes."""
    text = (ROOT / name).read_text(encoding="utf-8")
    assert not PACKAGE.sub("", text).strip()
    return {package: version for package, version, *_ in PACKAGE.findall(text)}


@pytest.mark.parametrize("name", [PLAIN, IMAGE])
def test_smaller_locks_have_the_versions_that_are_tested(name: str) -> None:
    found = locked(name)
    assert found
    assert found.items() <= locked(EVERYTHING).items()


def test_every_extra_that_the_image_promises_is_locked() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found = locked(IMAGE)
    for extra in ("dxf", "parquet", "postgres", "traces"):
        for wanted in project["optional-dependencies"][extra]:
            assert re.split(r"[\[>=<;]", wanted)[0] in found
    assert {"psycopg-binary", *locked(PLAIN)} <= found.keys()
