"""From a measured profile to the motion of its follower, and the answer about it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal

import numpy as np

from synthesis.catalogue.fields import ends
from synthesis.catalogue.followers.base import flat_face
from synthesis.catalogue.profile import CamProfile, cam_profile
from synthesis.design.identity import engine_version
from synthesis.errors import InputError
from synthesis.exporters.samples.columns import column_name
from synthesis.numerics.maxima import maximise
from synthesis.numerics.periodic_spline import DEGREE as SPLINE_DEGREE
from synthesis.studies.measured.bodies import (
    ContactOffFace,
    Fit,
    MeasuredCam,
    ProfileAnalysis,
    ReadDwell,
    ReadPeak,
    ReadSpline,
)
from synthesis.studies.measured.contact import cyclic_runs, follow_outline
from synthesis.studies.measured.motion import (
    FittedMotion,
    derivative_uncertainty,
    find_dwells,
    fit_motion,
)
from synthesis.studies.measured.outline import outline
from synthesis.units import DEGREE, FULL_TURN, rad_per_s

MOTION_SHARE = 0.1  # of the tolerance: allowed distance of the spline from the positions
ANGLES = 7200  # at which the pressure angle is evaluated
STATIONARY = 1e-6  # of the stroke: travel within a dwell
CURVES = ("displacement", "velocity", "acceleration", "jerk")
SIDES: tuple[Literal["left", "right"], ...] = ("left", "right")


def read_back(cam: MeasuredCam) -> ProfileAnalysis:
    """The motion that a follower makes on a measured profile.

    Raises:
        InputError: a dimension of the follower is left free, or it is form-closed; the points are
            no closed curve around the axis, or scatter beyond the tolerance; the follower does not
            reach the profile.
    """
    _check_follower(cam)
    follower, travel = cam.follower, cam.follower.travel
    points = np.array(cam.points_mm, dtype=float) * np.array([cam.mirror, 1.0])
    shape = outline(points, cam.tolerance_mm)
    path = follow_outline(shape, cam)
    found = fit_motion(path, MOTION_SHARE * cam.tolerance_mm)
    size, curve = follower.size_at_lowest(found.lowest), found.motion.curve
    fine, table = (
        cam_profile(
            found.motion, follower, size, cam.rotation, FULL_TURN * np.arange(count) / count
        )
        for count in (ANGLES, math.ceil(360.0 * cam.rows_per_degree))
    )
    stroke = maximise(curve, (1.0,))[0]
    # A dwell is judged by the scatter, which is usually far below the tolerance.
    still = min(cam.tolerance_mm, 3.0 * shape.rms + 2.0 * found.off + STATIONARY * stroke)
    return ProfileAnalysis(
        name=cam.name,
        engine_version=engine_version(),
        dimensions={
            **follower.dimensions(size),
            **follower.motion_dimensions(found.motion, size),
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
            for start, length, level in find_dwells(found.motion, still)
        ],
        unreached_hollows=path.hollows,
        contact_off_face=list(_contact_off_face(cam, size, fine)),
        table=_table(cam, table),
    )


def _check_follower(cam: MeasuredCam) -> None:
    """Refuse a follower that is not given in full, or that touches the cam at several places."""
    follower = cam.follower
    searched = follower.searched_dimensions((-math.inf, math.inf)).items()
    free = {**follower.adjustable_dimensions(), **{name: value for name, (value, _) in searched}}
    for name, value in free.items():
        low, high = ends(value)
        if low != high:
            raise InputError(
                f"/follower/{name}", None, "A measured profile needs a follower given in full.",
                "Give this dimension as a number.",
            )  # fmt: skip
    if follower.active_closure.counter_paths or [one.side for one in follower.flanks] != [1]:
        raise InputError(
            "/follower/closure", cam.follower.kind,
            "A measured profile is read with one roller that touches it from outside.",
            "Leave closure out: for a groove send its inner flank, for a counter roller its own "
            "cam with its own follower.",
        )  # fmt: skip


def _contact_off_face(
    cam: MeasuredCam, size: tuple[float, ...], fine: CamProfile
) -> Iterator[ContactOffFace]:
    """Arcs along which contact lies beyond an end of the face; ``fine``: at many even angles."""
    width, face, degrees = cam.face_width, flat_face(cam.follower), fine.theta / DEGREE
    if width is None or face is None:
        return
    half = math.inf if width.width_mm is None else 0.5 * width.width_mm
    left, right = (min(half, each or math.inf) for each in (width.left_mm, width.right_mm))
    for side, row in zip(SIDES, face.contact_rows(left, right), strict=False):
        fixed = sum(c * z for c, z in zip(row.size, size, strict=False))
        beyond = np.array(row.coefficients) @ fine.s + fixed - row.upper
        for arc in cyclic_runs(beyond > 0.0):
            worst, whole = arc[np.argmax(beyond[arc])], len(arc) == len(beyond)
            yield ContactOffFace(
                side=side,
                from_deg=0.0 if whole else float(degrees[arc[0]]),
                to_deg=360.0 if whole else float(degrees[arc[-1]]),
                worst_deg=float(degrees[worst]),
                excess_mm=float(beyond[worst]),
            )


def _peaks(cam: MeasuredCam, found: FittedMotion, fine: CamProfile) -> Iterator[ReadPeak]:
    omega, travel, curve = rad_per_s(cam.speed_rpm), cam.follower.travel, found.motion.curve
    steepest = float(np.max(np.abs(fine.pressure_angle)))
    error = cam.tolerance_mm / max(math.cos(steepest), 1e-6) + found.off
    errors = (error, *(derivative_uncertainty(curve, error) if found.smooth else (math.inf,) * 3))
    for order, name in enumerate(CURVES):
        weights = (*(0.0,) * order, 1.0)
        (most, at), (least, low) = (
            maximise(curve, weights),
            maximise(curve, tuple(-w for w in weights)),
        )
        factor = travel.wire_factor(order, omega)
        yield ReadPeak(
            curve=name, unit=travel.derivative_unit(order), largest=factor * most,
            largest_deg=at / DEGREE,
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
        name = column_name(letter, travel.derivative_unit(order))
        columns[name] = at.s[order] * travel.wire_factor(order, omega)
    columns["pressure_angle_deg"] = at.pressure_angle / DEGREE
    return {name: values.tolist() for name, values in columns.items()}
