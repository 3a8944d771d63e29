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


@cache
def examples(part: str = "") -> dict[str, dict[str, Any]]:
    """By file name: summary, description and value, the spec.

    Those of ``part`` stand in a folder of this name, those of designs above the folders.
    """
    files = sorted((_folder() / part).glob("*.json"))
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
