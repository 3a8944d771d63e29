"""The worked examples: documentation and test data."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

FOLDERS = (
    Path(__file__).resolve().parents[2] / "openapi" / "examples",  # a checkout
    Path.cwd() / "openapi" / "examples",  # an installation, as in the container
)
SELF_CHECK = "example-13-6-sized"
# From the simplest to the special, as the documentation lists them; those of each folder.
ORDER = [
    "fixed-laws", "p2-sized", "example-13-6-sized", "undercut-limit", "infeasible-on-purpose",
    "norton-single-dwell", "quiet-then-small", "smoothness-price", "constant-velocity",
    "windows-and-points", "spot-weld", "table", "flat-face", "tilted-flat-face",
    "oscillating-roller", "free-arm", "p3-sized", "least-pressure-angle", "pivot-free",
    "oscillating-flat-face", "inside-contact", "grooved", "conjugate", "conjugate-arms",
    "hertz-limited", "spring-chosen", "no-residual-vibration", "p2-as-given", "p3-opposite",
    "p3-same", "self-crossing", "feeder-and-press", "p3-set", "spare-roller",
    "cylindrical-groove", "cylindrical-rib", "cylindrical-indexer", "p4", "cylindrical-sized",
    "globoidal-sized", "press-feeder", "irb-660", "p5", "turning-guide", "sized",
    "impossible-on-purpose", "rollers-and-laws", "pressure-angle-and-jerk", "timing-at-random",
]  # fmt: skip


@cache
def examples(part: str = "") -> dict[str, dict[str, Any]]:
    """By file name: summary, description and value, the spec. Empty where none were installed.

    Those of ``part`` stand in a folder of this name, those of designs above the folders. Each says
    in one sentence what it shows.
    """
    folder = next((folder / part for folder in FOLDERS if folder.is_dir()), None)
    files = sorted(folder.glob("*.json"), key=_place) if folder else []
    return {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in files}


def _place(file: Path) -> tuple[int, str]:
    known = file.stem in ORDER
    return ORDER.index(file.stem) if known else len(ORDER), file.stem
