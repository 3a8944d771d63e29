"""What a drive makes of a table's rounded rows, by how it interpolates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.interpolate import BPoly

from synthesis.design.design import Design
from synthesis.exporters.drives.table import DriveOptions, DriveTable, drive_table
from synthesis.exporters.fidelity.block import figure
from synthesis.exporters.fidelity.readers import spline_through
from synthesis.exporters.fidelity.told import MOST
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.columns import named
from synthesis.exporters.samples.sampling import in_degrees
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

BETWEEN = np.linspace(0.0, 1.0, 33)  # places on each interval where it is measured
METHOD = (
    "What interpolation between the rows as written gives, against the true motion: greatest error "
    "of displacement, velocity and acceleration, and where. linear, cubic: from positions alone; "
    "quintic: with velocity and acceleration, as TwinCAT and CODESYS do. part: of the true peak; "
    "null: infinite, as the velocity jumps."
)


def drive_fidelity(design: Design, table: DriveTable, options: DriveOptions) -> dict[str, Any]:
    """What each way of interpolation makes of the rows, in the units of the wire."""
    cam = Cam.of(design)
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
    told = [_told(cam, name, curve, theta, true) for name, curve in curves.items()]
    return {"rows": len(table.master), "method": METHOD, "readers": told}


def drive_told(design: Design, options: DriveOptions) -> Mapping[str, str]:
    """The same in a line; of very many rows where to ask."""
    table = drive_table(design, options)
    if len(table.master) > MOST:
        return {"Fidelity": f"more than {MOST} rows: ask for motion.fidelity.json"}
    told = []
    for each in drive_fidelity(design, table, options)["readers"]:
        part = each["acceleration_part"]
        error = "infinite" if part is None else f"{100.0 * part:.3g} %"
        off = 100.0 * each["displacement_part"]
        told.append(f"{each['reader']}: displacement {off:.3g} %, acceleration {error}")
    return {"Fidelity": "; ".join(told)}


def _told(cam: Cam, reader: str, curve: Any, theta: Array, true: Array) -> dict[str, Any]:
    body: dict[str, Any] = {"reader": reader}
    jumps = reader == "linear" or len(cam.joints.breaking(1)) > 0
    for order, name in enumerate(("displacement", "velocity", "acceleration")):
        infinite = order == 2 and jumps
        error = np.abs(true[order]) if infinite else np.abs(curve(theta, order) - true[order])
        at, peak = int(np.argmax(error)), float(np.max(np.abs(true[order])))
        worst = np.inf if infinite else float(error[at])
        body[named(name, cam.travel.derivative_unit(order))] = figure(worst * cam.rate(order))
        body[f"{name}_at_deg"] = float(in_degrees(theta[at] % FULL_TURN))
        body[f"{name}_part"] = figure(worst / max(peak, np.finfo(float).tiny))
    return body
