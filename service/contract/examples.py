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


@cache
def examples(part: str = "") -> dict[str, dict[str, Any]]:
    """By file name: summary, description and value, the spec. Empty where none were installed.

    Those of ``part`` stand in a folder of this name, those of designs above the folders.
    """
    folder = next((folder / part for folder in FOLDERS if folder.is_dir()), None)
    files = sorted(folder.glob("*.json")) if folder else []
    return {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in files}
