"""ProfileAnalysis: the response body of a measured profile, and how it is put together."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal

import numpy as np

from synthesis.catalogue.fields import AnswerModel, doc
from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.flat_face import flat_face
from synthesis.catalogue.limits.face_width import FaceWidth
from synthesis.catalogue.profile import CamProfile, cam_profile
from synthesis.design.identity import engine_version
from synthesis.numerics.maxima import maximise
from synthesis.numerics.periodic_spline import DEGREE as SPLINE_DEGREE
from synthesis.numerics.piecewise import Array
from synthesis.studies.measured.contact import Bridge, FollowerPath
from synthesis.studies.measured.motion import FittedMotion, derivative_uncertainty, find_dwells
from synthesis.studies.measured.outline import Outline
from synthesis.studies.measured.spec import MeasuredCam
from synthesis.units import DEGREE, FULL_TURN, rad_per_s


class Fit(AnswerModel):
    """How well the smooth curves fit the measurement."""

    points: int = doc("Points that were used.")
    rms_mm: float = doc("Root mean square of their distances from the smooth profile.")
    largest_mm: float = doc("Largest of these distances; within the tolerance.")
    motion_mm: float = doc("Largest distance of the motion's spline from the follower's positions.")


class ReadSpline(AnswerModel):
    """The displacement over the turn as a periodic B-spline.

    Coefficient i belongs to the basis function over the knots i − degree to i + 1, cyclic with 360°
    added per turn. A repeated knot is a kink.
    """

    degree: int = doc("Polynomial degree.")
    knots_deg: list[float] = doc("Knots in [0, 360), the first at 0.")
    unit: Literal["mm", "deg"] = doc("Unit of displacements: deg where the follower swings.")
    coefficients: list[float] = doc("One coefficient per knot, in this unit.")


class ReadPeak(AnswerModel):
    """The extremes of one curve of the motion."""

    curve: str = doc("displacement, velocity, acceleration, jerk or pressure_angle.")
    unit: str = doc("Unit of value and error.")
    largest: float = doc("Largest value.")
    largest_deg: float = doc("Cam angle of the largest value.")
    smallest: float = doc("Smallest value.")
    smallest_deg: float = doc("Cam angle of the smallest value.")
    error: float | None = doc(
        "Uncertainty from the tolerance: no motion within it differs by more, if its fourth "
        "derivative is nowhere larger than this motion's. Null where the velocity jumps, and for "
        "pressure_angle."
    )


class ReadDwell(AnswerModel):
    """An arc along which the follower dwells, within the tolerance."""

    start_deg: float = doc("Cam angle where it begins.")
    angle_deg: float = doc("Its cam angle.")
    s: float = doc("Displacement there, in the unit of the motion.")


class UnreachedHollow(AnswerModel):
    """A hollow that the follower spans: its bottom is never touched."""

    angle_deg: float = doc("Cam angle at which the follower touches both sides.")
    hollow_radius_mm: float | None = doc("Least concave radius there; null: an overhang.")
    roller_radius_mm: float = doc("Roller radius; 0 for a knife edge and a flat face.")
    gap_mm: float = doc("Largest distance between follower and profile.")
    x_mm: float = doc("The profile point farthest from the follower.")
    y_mm: float = doc("The profile point farthest from the follower.")


class ContactOffFace(AnswerModel):
    """An arc along which contact lies beyond the end of a flat face."""

    side: Literal["left", "right"] = doc("Which end, on a ccw cam.")
    from_deg: float = doc("Cam angle where contact leaves the face.")
    to_deg: float = doc("Cam angle where it returns; less than from_deg across 360°.")
    worst_deg: float = doc("Cam angle where it is farthest beyond the end.")
    excess_mm: float = doc("Largest distance beyond the end.")


class ProfileAnalysis(AnswerModel):
    """The motion that a measured profile gives a follower."""

    name: str = doc("Name from the request.")
    engine_version: str = doc("Version of Camwright that read it.")
    dimensions: dict[str, float] = doc(
        "Base radius, prime radius, offset, stroke, … of the measured cam."
    )
    fit: Fit = doc("How well the curves fit.")
    spline: ReadSpline = doc("The motion.")
    peaks: list[ReadPeak] = doc("Extremes of motion and pressure angle.")
    dwells: list[ReadDwell] = doc("Arcs along which the follower dwells.")
    unreached_hollows: list[UnreachedHollow] = doc(
        "Hollows too narrow for the roller, or under the face."
    )
    contact_off_face: list[ContactOffFace] = doc(
        "Arcs along which contact is beyond the given face."
    )
    table: dict[str, list[float]] = doc(
        "The motion from cam angle 0, by columns: `angle_deg`; `s_mm`, `v_mm_per_s`, "
        "`a_mm_per_s2`, `j_mm_per_s3`, or the same with deg where the follower swings; "
        "`pressure_angle_deg`."
    )


def contact_off_face(
    width: FaceWidth, follower: Follower, size: tuple[float, ...], fine: CamProfile
) -> list[ContactOffFace]:
    """Arcs along which contact lies beyond an end of the face.

    Args:
        width: of the face. follower, size: the follower. fine: the cam at many even angles.
    """
    half = math.inf if width.width_mm is None else 0.5 * width.width_mm
    left, right = (min(half, each or math.inf) for each in (width.left_mm, width.right_mm))
    found: list[ContactOffFace] = []
    sides: tuple[Literal["left", "right"], ...] = ("left", "right")
    face = flat_face(follower)
    rows = () if face is None else face.contact_rows(left, right)
    for side, row in zip(sides, rows, strict=False):
        fixed = sum(c * z for c, z in zip(row.size, size, strict=False))
        along = np.array(row.coefficients) @ fine.s + fixed
        if math.isfinite(row.upper):
            found += _arcs(side, along - row.upper, fine.theta / DEGREE)
    return found


def _arcs(side: Literal["left", "right"], beyond: Array, degrees: Array) -> list[ContactOffFace]:
    """Cyclic runs in which a function is positive."""
    over = beyond > 0.0
    if not over.any():
        return []
    if over.all():
        worst = int(np.argmax(beyond))
        return [
            ContactOffFace(
                side=side, from_deg=0.0, to_deg=360.0, worst_deg=float(degrees[worst]),
                excess_mm=float(beyond[worst]),
            )
        ]  # fmt: skip
    found = []
    for first in np.flatnonzero(over & ~np.roll(over, 1)):
        length = int(np.argmin(np.roll(over, -int(first))))
        arc = (first + np.arange(length)) % len(over)
        worst = int(arc[np.argmax(beyond[arc])])
        found.append(
            ContactOffFace(
                side=side, from_deg=float(degrees[arc[0]]), to_deg=float(degrees[arc[-1]]),
                worst_deg=float(degrees[worst]), excess_mm=float(beyond[worst]),
            )
        )  # fmt: skip
    return found


ANGLES = 7200  # at which the pressure angle is evaluated
STATIONARY = 1e-6  # of the stroke: travel within a dwell
CURVES = ("displacement", "velocity", "acceleration", "jerk")
RATES = ("", "_per_s", "_per_s2", "_per_s3")


def report_profile(
    cam: MeasuredCam, shape: Outline, path: FollowerPath, found: FittedMotion
) -> ProfileAnalysis:
    """The answer for a measured cam.

    Args:
        cam: the request. shape: the outline. path: the follower on it. found: its motion.
    """
    size, travel, curve = (
        cam.follower.size_at_lowest(found.lowest),
        cam.follower.travel,
        found.motion.curve,
    )
    fine, table = (
        cam_profile(
            found.motion, cam.follower, size, cam.rotation, FULL_TURN * np.arange(count) / count
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
            for start, length, level in find_dwells(found.motion, still)
        ],
        unreached_hollows=[_not_touched(cam, bridge) for bridge in path.bridges],
        contact_off_face=contact_off_face(cam.face_width, cam.follower, size, fine)
        if cam.face_width
        else [],
        table=_table(cam, table),
    )


def _not_touched(cam: MeasuredCam, bridge: Bridge) -> UnreachedHollow:
    return UnreachedHollow(
        angle_deg=bridge.angle / DEGREE,
        hollow_radius_mm=bridge.hollow,
        roller_radius_mm=cam.follower.roller_radius,
        gap_mm=bridge.gap,
        x_mm=cam.mirror * bridge.x,
        y_mm=bridge.y,
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
        name = f"{letter}_{travel.unit}{RATES[order]}"
        columns[name] = at.s[order] * travel.wire_factor(order, omega)
    columns["pressure_angle_deg"] = at.pressure_angle / DEGREE
    return {name: values.tolist() for name, values in columns.items()}
