"""The worked examples: documentation and test data. They are part of an installation too."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve()
FOLDERS = (
    HERE.parents[2] / "openapi" / "examples",  # a checkout
    HERE.parents[1] / "documents" / "openapi" / "examples",  # an installation
)
SELF_CHECK = "example-13-6-sized"
# From the simplest to the special, as the documentation lists them; those of each folder.
ORDER = [
    "start-everyday", "fixed-laws", "p2-sized", "example-13-6-sized", "undercut-limit",
    "infeasible-on-purpose", "norton-single-dwell", "quiet-then-small", "smoothness-price",
    "constant-velocity", "windows-and-points", "spot-weld", "table", "flat-face",
    "tilted-flat-face", "oscillating-roller", "free-arm", "p3-sized", "least-pressure-angle",
    "pivot-free", "oscillating-flat-face", "inside-contact", "grooved", "conjugate",
    "conjugate-arms", "hertz-limited", "spring-chosen", "no-residual-vibration", "start-fast",
    "start-heavy", "start-precise", "p2-as-given", "p3-opposite", "p3-same", "self-crossing",
    "feeder-and-press", "p3-set", "spare-roller", "cylindrical-groove", "cylindrical-rib",
    "cylindrical-indexer", "p4", "cylindrical-sized", "globoidal-sized", "press-feeder",
    "irb-660", "p5", "turning-guide", "sized", "impossible-on-purpose", "rollers-and-laws",
    "pressure-angle-and-jerk", "timing-at-random",
]  # fmt: skip
# These show what others of them show too: the document of the contract is shorter without them.
VARIANTS = frozenset({
    "conjugate", "conjugate-arms", "constant-velocity", "cylindrical-rib", "fixed-laws",
    "norton-single-dwell", "p3-opposite", "p3-same", "p3-set", "p3-sized", "quiet-then-small",
    "start-heavy", "tilted-flat-face",
})  # fmt: skip


@cache
def examples(part: str = "") -> dict[str, dict[str, Any]]:
    """By file name: summary, description and value, the spec.

    Those of ``part`` stand in a folder of this name, those of designs above the folders. Each says
    in one sentence what it shows.
    """
    files = sorted((_folder() / part).glob("*.json"), key=_place)
    return {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in files}


def example_paths() -> dict[str, tuple[str, Path]]:
    """Folder and file of all examples by name, those of designs, whose folder is "", first."""
    top = _folder()
    files = [*sorted(top.glob("*.json")), *sorted(top.glob("*/**/*.json"))]
    return {
        file.stem: (file.parent.relative_to(top).as_posix().lstrip("."), file) for file in files
    }


def example_path(name: str) -> Path | None:
    """The file of an example; None where there is none of this name."""
    return example_paths().get(name.removesuffix(".json"), ("", None))[1]


def _folder() -> Path:
    return next(folder for folder in FOLDERS if folder.is_dir())


def _place(file: Path) -> tuple[int, str]:
    known = file.stem in ORDER
    return ORDER.index(file.stem) if known else len(ORDER), file.stem
