"""What an installation takes on disk, with each extra: `python -m tests.architecture.sizes`.

Counts the files of every package that the plain installation, or an extra, brings along, as they
lie in the environment in which it runs (`make test` installs all), compiled modules too.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator
from importlib.metadata import Distribution, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
BLOCK = 512  # bytes: the unit of st_blocks
MB = 2**20  # bytes: as `du -m` counts
Packages = dict[str, Distribution]


def packages(lines: Iterable[str]) -> Packages:
    """The packages that these requirements bring along, by name."""
    found: Packages = {}
    asked: set[tuple[str, frozenset[str]]] = set()
    todo = [Requirement(line) for line in lines]
    while todo:
        one = todo.pop()
        key = canonicalize_name(one.name), frozenset(one.extras)
        if key not in asked:
            asked.add(key)
            found[key[0]] = distribution(one.name)
            todo += _needed(found[key[0]], one.extras)
    return found


def _needed(package: Distribution, extras: Iterable[str]) -> Iterator[Requirement]:
    for line in package.requires or ():
        one = Requirement(line)
        if one.marker is None or any(one.marker.evaluate({"extra": e}) for e in ("", *extras)):
            yield one


def size(package: Distribution) -> float:
    """What its files take on disk [MB]."""
    paths = [Path(str(package.locate_file(file))) for file in package.files or ()]
    return sum(path.stat().st_blocks * BLOCK for path in paths if path.is_file()) / MB


def sizes() -> dict[str, float]:
    """The plain installation's packages without Camwright's own, and each extra's besides [MB]."""
    plain = packages(PROJECT["dependencies"])
    found = {"": sum(map(size, plain.values()))}
    for extra, lines in PROJECT["optional-dependencies"].items():
        if extra != "dev":
            more = packages(lines)
            found[extra] = sum(size(more[name]) for name in more.keys() - plain.keys())
    return found


if __name__ == "__main__":
    for name, taken in sizes().items():
        print(f"{name or 'plain':10}{taken:6.0f} MB")
    own = packages(PROJECT["dependencies"])
    for name in sorted(own, key=lambda one: -size(own[one]))[:12]:
        print(f"  {name:20}{size(own[name]):6.0f} MB")
