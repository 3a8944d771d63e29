"""The ProfileAnalysis out of what was read: units and names of the wire."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from synthesis.design import engine_version
from synthesis.measured.contact import Bridge, Ride
from synthesis.measured.face import off_face
from synthesis.measured.motion import Read, dwells, hidden
from synthesis.measured.outline import Outline
from synthesis.measured.reading import (
    Fit,
    NotTouched,
    ProfileAnalysis,
    ReadDwell,
    ReadPeak,
    ReadSpline,
)
from synthesis.measured.spec import MeasuredCam
from synthesis.numerics.peaks import peak
from synthesis.numerics.periodic import DEGREE as SPLINE_DEGREE
from synthesis.profile import CamProfile, cam_profile
from synthesis.units import DEGREE, FULL_TURN, rad_per_s

FINE = 7200  # places at which the pressure angle is looked at
STILL = 1e-6  # of the stroke: travel that is none
CURVES = ("displacement", "velocity", "acceleration", "jerk")
RATES = ("", "_per_s", "_per_s2", "_per_s3")


def told(cam: MeasuredCam, shape: Outline, rode: Ride, found: Read) -> ProfileAnalysis:
    """Everything that was read, as it goes to the caller.

    Args:
        cam: the question. shape: the smooth profile. rode: the follower on it. found: its motion.
    """
    size, travel, curve = cam.follower.lowest(found.lowest), cam.follower.travel, found.motion.curve
    fine, table = (
        cam_profile(
            found.motion, cam.follower, size, cam.rotation, FULL_TURN * np.arange(count) / count
        )
        for count in (FINE, math.ceil(360.0 * cam.rows_per_degree))
    )
    stroke = peak(curve, (1.0,))[0]
    # what stands still is judged by the scatter, which is mostly far below the tolerance
    still = min(cam.tolerance_mm, 3.0 * shape.rms + 2.0 * found.off + STILL * stroke)
    return ProfileAnalysis(
        name=cam.name,
        engine_version=engine_version(),
        dimensions={
            **cam.follower.dimensions(size),
            **cam.follower.motion_dimensions(found.motion, size),
            f"stroke_{travel.unit}": stroke / travel.per_unit,
        },
        fit=Fit(
            points=shape.points, rms_mm=shape.rms, largest_mm=shape.largest, motion_mm=found.off
        ),
        spline=ReadSpline(
            degree=SPLINE_DEGREE,
            knots_deg=(found.spline.knots / DEGREE).tolist(),
            unit=travel.unit,
            coefficients=(found.spline.coefficients[:, 0] / travel.per_unit).tolist(),
        ),
        peaks=list(_peaks(cam, found, fine)),
        dwells=[
            ReadDwell(
                start_deg=start / DEGREE, angle_deg=length / DEGREE, s=level / travel.per_unit
            )
            for start, length, level in dwells(found.motion, still)
        ],
        not_touched=[_bridged(cam, bridge) for bridge in rode.bridges],
        off_face=off_face(cam.face_width, cam.follower, size, fine) if cam.face_width else [],
        table=_table(cam, table),
    )


def _bridged(cam: MeasuredCam, bridge: Bridge) -> NotTouched:
    return NotTouched(
        angle_deg=bridge.angle / DEGREE,
        hollow_radius_mm=bridge.hollow,
        roller_radius_mm=cam.follower.roller_radius,
        gap_mm=bridge.gap,
        x_mm=cam.mirror * bridge.x,
        y_mm=bridge.y,
    )


def _peaks(cam: MeasuredCam, found: Read, fine: CamProfile) -> Iterator[ReadPeak]:
    omega, travel, curve = rad_per_s(cam.speed_rpm), cam.follower.travel, found.motion.curve
    steepest = float(np.max(np.abs(fine.pressure_angle)))
    error = cam.tolerance_mm / max(math.cos(steepest), 1e-6) + found.off
    errors = (error, *(hidden(curve, error) if found.smooth else (math.inf,) * 3))
    for order, name in enumerate(CURVES):
        weights = (*(0.0,) * order, 1.0)
        (most, at), (least, low) = peak(curve, weights), peak(curve, tuple(-w for w in weights))
        factor = travel.rate(order, omega)
        yield ReadPeak(
            curve=name, unit=travel.told(order), largest=factor * most, largest_deg=at / DEGREE,
            smallest=-factor * least, smallest_deg=low / DEGREE,
            error=factor * errors[order] if math.isfinite(errors[order]) else None,
        )  # fmt: skip
    alpha = fine.pressure_angle / DEGREE
    top, bottom = int(np.argmax(alpha)), int(np.argmin(alpha))
    yield ReadPeak(
        curve="pressure_angle", unit="deg", largest=float(alpha[top]),
        largest_deg=float(fine.theta[top]) / DEGREE, smallest=float(alpha[bottom]),
        smallest_deg=float(fine.theta[bottom]) / DEGREE, error=None,
    )  # fmt: skip


def _table(cam: MeasuredCam, at: CamProfile) -> dict[str, list[float]]:
    """The motion by columns, named after what they hold and its unit."""
    travel, omega = cam.follower.travel, rad_per_s(cam.speed_rpm)
    columns = {"angle_deg": np.round(at.theta / DEGREE, 9)}
    for order, letter in enumerate("svaj"):
        name = f"{letter}_{travel.unit}{RATES[order]}"
        columns[name] = at.s[order] * travel.rate(order, omega)
    columns["pressure_angle_deg"] = at.pressure_angle / DEGREE
    return {name: values.tolist() for name, values in columns.items()}
