"""Fidelity as it is told: a block of JSON, and one line for a header or a comment."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from synthesis.exporters.fidelity.measure import Fidelity, Worst, fidelities
from synthesis.exporters.options import PointOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.columns import named
from synthesis.exporters.samples.sampling import Written
from synthesis.units import DEGREE, FULL_TURN

METHOD = (
    "Each reader's curve through the written points, cubic splines over the chords' lengths. form: "
    "greatest distance from the true curve along its normal. velocity, acceleration: greatest "
    "error of the motion of a follower that rolls or slides on the reader's curve, derived from "
    "its position, direction and curvature; part: of the true peak; null: infinite, as the "
    "velocity jumps. seam_corner: angle in which the ends of a curve that is not periodic meet; "
    "the knock there is not counted."
)
LOOKED_AT = 3600  # places where the true peak is taken


def fidelity_block(cam: Cam, written: Written, options: PointOptions) -> dict[str, Any]:
    """What every reader makes of the points, in the units of the wire."""
    found = fidelities(cam, written, options.turn_deg, options.overlap_points)
    theta = np.union1d(FULL_TURN * np.arange(LOOKED_AT) / LOOKED_AT, cam.joints.theta)
    peaks = np.max(np.abs(cam.motion.derivatives(theta, 2)), axis=1)
    return {
        "points": len(written.points),
        "decimals": options.decimals,
        "overlap_points": options.overlap_points,
        "method": METHOD,
        "readers": [_told(cam, each, peaks) for each in found],
    }


def fidelity_line(block: dict[str, Any]) -> str:
    """The same in one line of ASCII."""
    told = []
    for each in block["readers"]:
        part = each["acceleration_part"]
        error = "infinite" if part is None else f"{100.0 * part:.3g} %"
        told.append(f"{each['reader']}: form {each['form_um']:.3g} um, acceleration {error}")
    return "; ".join(told)


def _told(cam: Cam, found: Fidelity, peaks: Any) -> dict[str, Any]:
    body: dict[str, Any] = {"reader": found.reader}
    body |= _worst("form_um", "form", found.form, 1e3)
    for order, name in ((1, "velocity"), (2, "acceleration")):
        worst: Worst = getattr(found, name)
        body |= _worst(named(name, cam.travel.derivative_unit(order)), name, worst, cam.rate(order))
        body[f"{name}_part"] = figure(worst.value / max(peaks[order], np.finfo(float).tiny))
    return body | {"seam_corner_deg": figure(found.corner / DEGREE)}


def _worst(key: str, name: str, worst: Worst, unit: float) -> dict[str, Any]:
    return {key: figure(worst.value * unit), f"{name}_at_deg": worst.angle_deg}


def figure(value: float) -> float | None:
    """Four digits, which is more than an error deserves; None where it is infinite."""
    return float(f"{value:.4g}") if math.isfinite(value) else None
