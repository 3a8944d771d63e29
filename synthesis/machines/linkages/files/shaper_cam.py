"""The ram's motion as a cam's spec: a DesignSpec for ``POST /v1/designs``."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated, Final

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.exporter import untold
from synthesis.exporters.options import Options
from synthesis.machines.linkages.files.linkage_file import LinkageFile
from synthesis.machines.linkages.files.shaper_tables import Rows
from synthesis.machines.linkages.shaper import SixBarShaper

TOLERANCE: Final = 1e-4  # of the stroke: default tolerance of the table
ROLLER: Final = 0.1  # of the stroke: default roller radius


@dataclass(frozen=True)
class CamOptions(Options):
    """The cam's follower and limits.

    Attributes:
        points: rows of the table. tolerance_mm: how far the follower may pass a row; None: a ten
            thousandth of the stroke. roller_radius_mm: None: a tenth of the stroke.
        pressure_angle_deg: the limit, on all of the turn.
    """

    points: Annotated[int, Field(ge=36, le=3600, description="Rows of the table.")] = 360
    tolerance_mm: Annotated[
        float | None,
        Field(
            ge=1e-7, le=1e3,
            description="How far the follower may pass a row; left out: 1e-4 of the stroke.",
        ),
    ] = None  # fmt: skip
    roller_radius_mm: Annotated[
        float | None,
        Field(gt=0.0, le=1e6, description="Of the follower; left out: a tenth of the stroke."),
    ] = None
    pressure_angle_deg: Annotated[
        float, Field(gt=0.0, lt=90.0, description="Largest pressure angle.")
    ] = 35.0


def _question(found: SixBarShaper, options: CamOptions) -> bytes:
    if found.spec.acceleration_rad_per_s2:
        raise InputError(
            "/acceleration_rad_per_s2", found.spec.acceleration_rad_per_s2,
            "A cam turns at constant speed and repeats its motion; this crank changes its speed.",
            "Request the linkage at constant speed, without the acceleration.",
        )  # fmt: skip
    rows = Rows.of(found, options.points, closed=False)
    stroke = float(found.stroke_mm or 0.0)
    ram = rows.motion.ram[0]
    spec = {
        "name": f"{found.name.strip() or 'shaper'}: motion of the ram",
        "speed_rpm": found.spec.speed_rpm,
        "rotation": found.spec.rotation,
        "program": [
            {
                "kind": "table",
                "angle_deg": 360.0,
                "angles_deg": np.degrees(rows.turned).tolist(),
                "displacements_mm": (ram - ram.min()).tolist(),
                "tolerance_mm": options.tolerance_mm or TOLERANCE * stroke,
            }
        ],
        "follower": {
            "kind": "translating_roller",
            "roller_radius_mm": options.roller_radius_mm or ROLLER * stroke,
        },
        "limits": [
            {
                "kind": "pressure_angle",
                "rise_deg": options.pressure_angle_deg,
                "return_deg": options.pressure_angle_deg,
            }
        ],
    }
    return json.dumps(spec, ensure_ascii=False, allow_nan=False).encode() + b"\n"


CAM = LinkageFile(
    "cam.json",
    "Question for a cam that moves its follower as the ram",
    "application/json",
    ".json",
    untold(_question),
    CamOptions,
    "A body for POST /v1/designs: the ram's motion as a table, a translating roller and a limit on "
    "the pressure angle, to be edited as needed.",
    suits=lambda found: not found.spec.acceleration_rad_per_s2,
)
