"""What the readers of point files make of the points, as JSON, with the options of these files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from synthesis.design.design import Design
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.fidelity.block import fidelity_block
from synthesis.exporters.options import Options, PointOptions
from synthesis.exporters.samples.cutting import chosen
from synthesis.exporters.samples.sampling import written_points


def _profile(design: Design, options: PointOptions) -> bytes:
    cam = chosen(design, options)
    return fidelity_file(
        design, options, fidelity_block(cam, written_points(cam, options), options)
    )


def fidelity_file(design: Design, options: Options, found: Mapping[str, Any]) -> bytes:
    """What was found, with the design and the options that it belongs to."""
    body = {
        "kind": "fidelity",
        "design": {"id": design.id, "name": design.name, "engine_version": design.engine_version},
        "sampling": asdict(options),
        **found,
    }
    return json.dumps(body, ensure_ascii=False, allow_nan=False, indent=1).encode() + b"\n"


PROFILE = Exporter(
    "fidelity.json", "What readers make of the points", "application/json", ".fidelity.json",
    _profile, PointOptions,
    "Before a point file goes to CAD: what straight lines and periodic, not-a-knot and natural "
    "splines through its rounded points do to the form and to the follower's acceleration.",
    by_default=False,
)  # fmt: skip
