"""Fidelity in words: a block of JSON, a line for a header, and ``profile.fidelity.json``."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from typing import Any

import numpy as np

from synthesis.design.design import Design
from synthesis.exporters.exporter import design_format
from synthesis.exporters.fidelity.measure import Deviation, fidelities
from synthesis.exporters.options import CurveOptions, Options, PointOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.columns import column_name
from synthesis.exporters.samples.cutting import checked_cam
from synthesis.exporters.samples.sampling import Written, written_points
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

METHOD = (
    "Each reader's curve through the written points, cubic splines over the chords' lengths. form: "
    "greatest distance from the true curve along its normal. velocity, acceleration: greatest "
    "error of the motion of a follower that rolls or slides on the reader's curve, derived from "
    "its position, direction and curvature; part: of the true peak; null: infinite, as the "
    "velocity jumps. seam_corner: angle in which the ends of a curve that is not periodic meet; "
    "the knock there is not counted."
)
PEAK_ANGLES = 3600  # cam angles at which the true peak is taken
ALL_DECIMALS = 15  # decimals of a coordinate in mm: all that a double has
MAX_ROWS = 7200  # points for which fidelity is computed without being requested
DERIVATIVES = ("displacement", "velocity", "acceleration")


def fidelity_block(cam: Cam, written: Written, options: PointOptions) -> dict[str, Any]:
    """How true the curve of every reader is, in the units of the wire."""
    peaks = _peaks(cam)
    readers = []
    for each in fidelities(cam, written, options.turn_deg, options.overlap_points):
        velocity, acceleration = each.find_velocity(), each.acceleration
        if acceleration.angle_deg is None:
            acceleration = replace(acceleration, angle_deg=velocity.angle_deg)
        reader = {
            "reader": each.reader,
            "form_um": four_digits(1e3 * each.form.value),
            "form_at_deg": each.form.angle_deg,
            **deviation_fields(cam, 1, velocity, peaks[1]),
            **deviation_fields(cam, 2, acceleration, peaks[2]),
            "seam_corner_deg": four_digits(each.corner / DEGREE),
        }
        readers.append(reader)
    return {
        "points": len(written.points),
        "decimals": options.decimals,
        "overlap_points": options.overlap_points,
        "method": METHOD,
        "readers": readers,
    }


def _peaks(cam: Cam) -> Array:
    """The greatest |s|, |s'| and |s''| of the true motion (3,) [mm, per radian]."""
    theta = np.union1d(FULL_TURN * np.arange(PEAK_ANGLES) / PEAK_ANGLES, cam.joints.theta)
    return np.asarray(np.max(np.abs(cam.motion.derivatives(theta, 2)), axis=1))


def deviation_fields(cam: Cam, order: int, deviation: Deviation, peak: float) -> dict[str, Any]:
    """Of a derivative of s: its error in the unit of the wire, where, and as part of its peak."""
    name, worst = DERIVATIVES[order], four_digits(deviation.value * cam.rate(order))
    return {
        column_name(name, cam.travel.derivative_unit(order)): worst,
        f"{name}_at_deg": deviation.angle_deg,
        f"{name}_part": _part(deviation, peak),
    }


def _part(deviation: Deviation, peak: float) -> float | None:
    return four_digits(deviation.value / max(peak, np.finfo(float).tiny))


def four_digits(value: float) -> float | None:
    """Four digits, which is more than an error deserves; None where it is infinite."""
    return float(f"{value:.4g}") if math.isfinite(value) else None


def percentage(part: float | None) -> str:
    """A part of a peak for people."""
    return "infinite" if part is None else f"{100.0 * part:.3g} %"


def fidelity_header(design: Design, options: PointOptions) -> Mapping[str, str]:
    """Fidelity of a point file in a line of ASCII; of very many points where to ask for it."""
    cam = checked_cam(design, options)
    written = written_points(cam, options)
    if len(written.points) > MAX_ROWS:
        return {"Fidelity": f"more than {MAX_ROWS} points: ask for profile.fidelity.json"}
    peak = _peaks(cam)[2]
    lines = [
        f"{each.reader}: form {four_digits(1e3 * each.form.value):.3g} um, acceleration "
        f"{percentage(_part(each.acceleration, peak))}"
        for each in fidelities(cam, written, options.turn_deg, options.overlap_points)
    ]
    return {"Fidelity": "; ".join(lines)}


def as_points(options: CurveOptions) -> PointOptions:
    """The points of a table as those of a point file: once round, not rounded."""
    shared = {each.name: getattr(options, each.name) for each in fields(CurveOptions)}
    return PointOptions(decimals=ALL_DECIMALS, **shared)


def fidelity_file(design: Design, options: Options, body: Mapping[str, Any]) -> bytes:
    """A report of fidelity, with the design and the options that it belongs to."""
    head = {
        "kind": "fidelity",
        "design": {"id": design.id, "name": design.name, "engine_version": design.engine_version},
        "sampling": asdict(options),
    }
    text = json.dumps({**head, **body}, ensure_ascii=False, allow_nan=False, indent=1)
    return text.encode() + b"\n"


def _profile(design: Design, options: PointOptions) -> bytes:
    cam = checked_cam(design, options)
    block = fidelity_block(cam, written_points(cam, options), options)
    return fidelity_file(design, options, block)


PROFILE = design_format("profile", "fidelity.json", _profile, PointOptions)
