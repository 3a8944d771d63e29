"""The worked examples: documentation, fixtures of the tests and smoke tests at once."""

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


ANALYSES = "analyses"  # the folder of those that are given in full, for POST /v1/analyses
PROFILE_ANALYSES = "profile-analyses"  # the folder of those for POST /v1/profile-analyses
CAM_SETS = "cam-sets"  # the folder of those for POST /v1/cam-sets
SPATIAL_CAMS = "spatial-cams"  # the folder of those for POST /v1/spatial-cams
TRAINS = "train-responses"  # the folder of those for POST /v1/train-responses
LINKAGES = "linkages"  # the folder of folders, one for each kind of /v1/linkages
SWEEPS = "sweeps"  # the folder of those for POST /v1/sweeps


@cache
def examples(part: str = "") -> dict[str, dict[str, Any]]:
    """By file name: summary, description and value, the spec. Empty where none were installed.

    Args:
        part: the folder among the examples; those of designs stand at its top.
    """
    folder = next((folder / part for folder in FOLDERS if folder.is_dir()), None)
    files = sorted(folder.glob("*.json")) if folder else []
    return {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in files}
