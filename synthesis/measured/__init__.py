"""Measured profile points back to the motion that they give a follower.

points -> smooth outline -> postures of the follower -> motion -> ProfileAnalysis
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from synthesis.design import engine_version
from synthesis.errors import InputError
from synthesis.measured.contact import Ride, ride
from synthesis.measured.face import off_face
from synthesis.measured.motion import Read, dwells, hidden, read
from synthesis.measured.outline import Outline, outline
from synthesis.measured.reading import (
    Fit,
    NotTouched,
    ProfileAnalysis,
    ReadDwell,
    ReadPeak,
    ReadRow,
    ReadSpline,
)
from synthesis.measured.spec import MeasuredCam
from synthesis.numerics.peaks import peak
from synthesis.numerics.periodic import DEGREE as SPLINE_DEGREE
from synthesis.numerics.piecewise import Array
from synthesis.profile import CamProfile, cam_profile
from synthesis.ranges import ends
from synthesis.units import DEGREE, FULL_TURN, rad_per_s

__all__ = ["MeasuredCam", "ProfileAnalysis", "read_back"]

PROFILE_SHARE = 0.9  # of the tolerance, for the outline; the rest is the motion's
FINE = 7200  # places at which the pressure angle is looked at
CURVES = (
    ("displacement", "mm"), ("velocity", "mm/s"), ("acceleration", "mm/s²"), ("jerk", "mm/s³"),
)  # fmt: skip


def read_back(cam: MeasuredCam) -> ProfileAnalysis:
    """The motion that a follower makes on a measured profile.

    Raises:
        InputError: a dimension of the follower is left free; points that are no closed curve
            round the axis; a follower that does not reach them.
    """
    for name, value in cam.follower.adjustable().items():
        low, high = ends(value)
        if low != high:
            raise InputError(
                f"/follower/{name}", None, "A profile is read back for a follower that is given.",
                "Give this dimension as a number.",
            )  # fmt: skip
    sense = -1.0 if cam.rotation == "cw" else 1.0
    points = np.array(cam.points_mm, dtype=float) * np.array([sense, 1.0])
    shape = outline(points, PROFILE_SHARE * cam.tolerance_mm)
    rode = ride(shape, cam.follower)
    found = read(rode, (1.0 - PROFILE_SHARE) * cam.tolerance_mm)
    return _told(cam, points, shape, rode, found)


def _told(
    cam: MeasuredCam, points: Array, shape: Outline, rode: Ride, found: Read
) -> ProfileAnalysis:
    motion, size = found.motion, cam.follower.lowest(found.lowest)
    theta = FULL_TURN * np.arange(FINE) / FINE
    fine = cam_profile(motion, cam.follower, size, "ccw", theta)
    rows = (
        FULL_TURN
        * np.arange(math.ceil(360.0 * cam.rows_per_degree))
        / math.ceil(360.0 * cam.rows_per_degree)
    )
    table = cam_profile(motion, cam.follower, size, "ccw", rows)
    stroke = peak(motion.curve, (1.0,))[0]
    return ProfileAnalysis(
        name=cam.name,
        engine_version=engine_version(),
        dimensions={**cam.follower.dimensions(size), "stroke_mm": stroke},
        fit=Fit(
            points=len(points), rms_mm=shape.rms, largest_mm=shape.largest,
            motion_mm=found.off,
        ),
        spline=ReadSpline(
            degree=SPLINE_DEGREE, knots_deg=(found.spline.knots / DEGREE).tolist(),
            coefficients_mm=found.spline.coefficients[:, 0].tolist(),
        ),
        peaks=list(_peaks(cam, found, fine)),
        dwells=[
            ReadDwell(start_deg=start / DEGREE, angle_deg=length / DEGREE, s_mm=level)
            for start, length, level in dwells(motion, cam.tolerance_mm)
        ],
        not_touched=[
            NotTouched(
                angle_deg=bridge.angle / DEGREE, hollow_radius_mm=bridge.hollow,
                roller_radius_mm=cam.follower.roller_radius, gap_mm=bridge.gap,
                x_mm=-bridge.x if cam.rotation == "cw" else bridge.x, y_mm=bridge.y,
            )
            for bridge in sorted(rode.bridges, key=lambda bridge: bridge.angle)
        ],
        off_face=off_face(cam.face_width, cam.follower, size, fine) if cam.face_width else [],
        rows=_rows(table, rad_per_s(cam.speed_rpm)),
    )  # fmt: skip


def _peaks(cam: MeasuredCam, found: Read, fine: CamProfile) -> Iterator[ReadPeak]:
    omega, curve = rad_per_s(cam.speed_rpm), found.motion.curve
    steepest = float(np.max(np.abs(fine.pressure_angle)))
    error = cam.tolerance_mm / max(math.cos(steepest), 1e-6)
    errors = (error, *(hidden(curve, error) if found.smooth else (math.inf,) * 3))
    for order, (name, unit) in enumerate(CURVES):
        weights = (*(0.0,) * order, 1.0)
        (most, at), (least, low) = peak(curve, weights), peak(curve, tuple(-w for w in weights))
        factor = omega**order
        yield ReadPeak(
            curve=name, unit=unit, largest=factor * most, largest_deg=at / DEGREE,
            smallest=-factor * least, smallest_deg=low / DEGREE,
            error=factor * errors[order] if np.isfinite(errors[order]) else None,
        )  # fmt: skip
    alpha = fine.pressure_angle / DEGREE
    most, least = int(np.argmax(alpha)), int(np.argmin(alpha))
    yield ReadPeak(
        curve="pressure_angle", unit="deg", largest=float(alpha[most]),
        largest_deg=float(fine.theta[most]) / DEGREE, smallest=float(alpha[least]),
        smallest_deg=float(fine.theta[least]) / DEGREE, error=None,
    )  # fmt: skip


def _rows(table: CamProfile, omega: float) -> list[ReadRow]:
    s, v, a, j = (each * omega**order for order, each in enumerate(table.s))
    columns = zip(table.theta / DEGREE, s, v, a, j, table.pressure_angle / DEGREE, strict=True)
    return [
        ReadRow(
            angle_deg=round(float(angle), 9), s_mm=float(row[0]), v_mm_per_s=float(row[1]),
            a_mm_per_s2=float(row[2]), j_mm_per_s3=float(row[3]), pressure_angle_deg=float(row[4]),
        )
        for angle, *row in columns
    ]  # fmt: skip
