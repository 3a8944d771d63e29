"""What a drive makes of a table's rounded rows, by how it interpolates."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

import numpy as np
from scipy.interpolate import BPoly

from synthesis.design import Design
from synthesis.exporters.cam import Cam
from synthesis.exporters.columns import named
from synthesis.exporters.drives.table import DriveOptions, drive_table
from synthesis.exporters.exporter import Exporter, untold
from synthesis.exporters.fidelity.block import figure
from synthesis.exporters.fidelity.readers import spline_through
from synthesis.exporters.sampling import in_degrees
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

BETWEEN = np.linspace(0.0, 1.0, 33)  # places on each interval where it is measured
METHOD = (
    "What interpolation between the rows as written gives, against the true motion: greatest error "
    "of displacement, velocity and acceleration, and where. linear, cubic: from positions alone; "
    "quintic: with velocity and acceleration, as TwinCAT and CODESYS do. part: of the true peak; "
    "null: infinite, as the velocity jumps."
)


def _motion(design: Design, options: DriveOptions) -> bytes:
    cam, table = Cam.of(design), drive_table(design, options)
    scale = cam.travel.per_unit / options.slave_per_unit  # slave units to the core's mm
    per_master = FULL_TURN / options.master_per_turn
    s, v = table.slave * scale, table.rate * scale / per_master
    a = table.change * scale / per_master**2
    step = np.diff(table.theta)[:, None]
    theta = (table.theta[:-1, None] + BETWEEN * step).ravel()
    curves = {
        "linear": spline_through(table.theta, s, "polyline"),
        "periodic cubic": spline_through(table.theta, s, "periodic"),
        "natural cubic": spline_through(table.theta, s, "natural"),
        "quintic": BPoly.from_derivatives(table.theta, np.column_stack([s, v, a])),
    }
    true = cam.motion.derivatives(theta % FULL_TURN, 2)
    body = {
        "kind": "fidelity",
        "design": {"id": design.id, "name": design.name, "engine_version": design.engine_version},
        "sampling": asdict(options),
        "rows": len(table.master),
        "method": METHOD,
        "readers": [_told(cam, name, curve, theta, true) for name, curve in curves.items()],
    }
    return json.dumps(body, ensure_ascii=False, allow_nan=False, indent=1).encode() + b"\n"


def _told(cam: Cam, reader: str, curve: Any, theta: Array, true: Array) -> dict[str, Any]:
    body: dict[str, Any] = {"reader": reader}
    jumps = reader == "linear" or len(cam.joints.breaking(1)) > 0
    for order, name in enumerate(("displacement", "velocity", "acceleration")):
        infinite = order == 2 and jumps
        error = np.abs(true[order]) if infinite else np.abs(curve(theta, order) - true[order])
        at, peak = int(np.argmax(error)), float(np.max(np.abs(true[order])))
        worst = np.inf if infinite else float(error[at])
        body[named(name, cam.travel.told(order))] = figure(worst * cam.rate(order))
        body[f"{name}_at_deg"] = float(in_degrees(theta[at] % FULL_TURN))
        body[f"{name}_part"] = figure(worst / max(peak, np.finfo(float).tiny))
    return body


MOTION = Exporter(
    "fidelity.json", "What drives make of a table's rows", "application/json", ".fidelity.json",
    untold(_motion), DriveOptions,
    "Before a table goes to a drive: what linear, cubic and quintic interpolation of its rounded "
    "rows do to displacement, velocity and acceleration.",
    usual=False,
)  # fmt: skip
