"""From the follower's path to the answer: a smooth motion, its extremes, dwells and uncertainty."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from synthesis.catalogue.fields import ends
from synthesis.catalogue.followers.base import InverseKinematics, flat_face
from synthesis.catalogue.motion import Motion
from synthesis.catalogue.profile import CamProfile, cam_profile
from synthesis.design.identity import engine_version
from synthesis.errors import InputError
from synthesis.exporters.samples.columns import column_name
from synthesis.numerics.maxima import maximise
from synthesis.numerics.periodic_spline import DEGREE as SPLINE_DEGREE
from synthesis.numerics.periodic_spline import PeriodicSpline, fit_least_squares
from synthesis.numerics.piecewise import Array, Indices, Piecewise
from synthesis.studies.measured import bodies
from synthesis.studies.measured.bodies import MeasuredCam, ProfileAnalysis
from synthesis.studies.measured.follower_path import (
    FollowerPath,
    cyclic_runs,
    follow_outline,
    outline,
)
from synthesis.units import DEGREE, FULL_TURN, rad_per_s

MOTION_SHARE = 0.1  # of the tolerance: allowed distance of the spline from the positions
ANGLES = 7200  # at which the pressure angle is evaluated
STATIONARY = 1e-6  # of the stroke: travel within a dwell
CURVES = ("displacement", "velocity", "acceleration", "jerk")
SIDES: tuple[Literal["left", "right"], ...] = ("left", "right")
# tried in turn, until the positions are met
KNOT_COUNTS: Final = (24, 36, 54, 80, 120, 180, 270, 400, 600, 900)
DATA_PER_KNOT: Final = 4.0  # fewer positions do not determine a spline
KINK_CLEARANCE: Final = 0.3  # of a knot interval: a kink this near to a knot replaces it
# constants of Favard, K0 to K4, for Kolmogorov's inequality between derivatives
FAVARD: Final = (1.0, math.pi / 2.0, math.pi**2 / 8.0, math.pi**3 / 24.0, 5.0 * math.pi**4 / 384.0)
DWELL_ANGLES: Final = 3600  # at which ends of dwells are looked for: a tenth of a degree
SHORTEST_DWELL: Final = 4.0 * FULL_TURN / 360.0  # 4°: shorter arcs may be turning points


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
    fitted = fit_motion(path, MOTION_SHARE * cam.tolerance_mm)
    assert isinstance(follower, InverseKinematics)  # the path was found with them
    size, curve = follower.size_at_lowest(fitted.lowest), fitted.motion.curve
    fine, table = (
        cam_profile(
            fitted.motion, follower, size, cam.rotation, FULL_TURN * np.arange(count) / count
        )
        for count in (ANGLES, math.ceil(360.0 * cam.rows_per_degree))
    )
    stroke = maximise(curve, (1.0,))[0]
    # A dwell is judged by the scatter, which is usually far below the tolerance.
    still = min(cam.tolerance_mm, 3.0 * shape.rms + 2.0 * fitted.off + STATIONARY * stroke)
    return ProfileAnalysis(
        name=cam.name,
        engine_version=engine_version(),
        dimensions={
            **follower.dimensions(size),
            **follower.motion_dimensions(fitted.motion, size),
            f"stroke_{travel.unit}": stroke / travel.per_unit,
        },
        fit=bodies.Fit(
            points=shape.points, rms_mm=shape.rms, largest_mm=shape.largest, motion_mm=fitted.off
        ),
        spline=bodies.ReadSpline(
            degree=SPLINE_DEGREE,
            knots_deg=(fitted.spline.knots / DEGREE).tolist(),
            unit=travel.unit,
            coefficients=(fitted.spline.coefficients[:, 0] / travel.per_unit).tolist(),
        ),
        peaks=list(_peaks(cam, fitted, fine)),
        dwells=[
            bodies.ReadDwell(
                start_deg=start / DEGREE, angle_deg=length / DEGREE, s=level / travel.per_unit
            )
            for start, length, level in find_dwells(fitted.motion, still)
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
    if follower.closure.counter_paths or [one.side for one in follower.flanks] != [1]:
        raise InputError(
            "/follower/closure", cam.follower.kind,
            "A measured profile is read with one roller that touches it from outside.",
            "Leave closure out: for a groove send its inner flank, for a counter roller its own "
            "cam with its own follower.",
        )  # fmt: skip


def _contact_off_face(
    cam: MeasuredCam, size: tuple[float, ...], fine: CamProfile
) -> Iterator[bodies.ContactOffFace]:
    """Arcs along which contact lies beyond an end of the face; ``fine``: at many even angles."""
    width, face, degrees = cam.face_width, flat_face(cam.follower), fine.theta / DEGREE
    if width is None or face is None:
        return
    half = math.inf if width.width_mm is None else 0.5 * width.width_mm
    reaches = (min(half, each or math.inf) for each in (width.left_mm, width.right_mm))
    both = zip(SIDES, reaches, strict=True)
    rows = [(side, row) for side, reach in both for row in face.contact_rows(side, reach)]
    for side, row in rows:
        fixed = sum(c * z for c, z in zip(row.size, size, strict=False))
        beyond = np.array(row.coefficients) @ fine.s + fixed - row.upper
        for arc in cyclic_runs(beyond > 0.0):
            worst, whole = arc[np.argmax(beyond[arc])], len(arc) == len(beyond)
            yield bodies.ContactOffFace(
                side=side,
                from_deg=0.0 if whole else float(degrees[arc[0]]),
                to_deg=360.0 if whole else float(degrees[arc[-1]]),
                worst_deg=float(degrees[worst]),
                excess_mm=float(beyond[worst]),
            )


def _peaks(cam: MeasuredCam, fitted: FittedMotion, fine: CamProfile) -> Iterator[bodies.ReadPeak]:
    omega, travel, curve = rad_per_s(cam.speed_rpm), cam.follower.travel, fitted.motion.curve
    steepest = float(np.max(np.abs(fine.pressure_angle)))
    error = cam.tolerance_mm / max(math.cos(steepest), 1e-6) + fitted.off
    errors = (error, *(derivative_uncertainty(curve, error) if fitted.smooth else (math.inf,) * 3))
    for order, name in enumerate(CURVES):
        weights = (*(0.0,) * order, 1.0)
        (most, at), (least, low) = (
            maximise(curve, [sign * w for w in weights]) for sign in (1.0, -1.0)
        )
        factor = travel.wire_factor(order, omega)
        yield bodies.ReadPeak(
            curve=name, unit=travel.derivative_unit(order), largest=factor * most,
            largest_deg=at / DEGREE,
            smallest=-factor * least, smallest_deg=low / DEGREE,
            error=factor * errors[order] if math.isfinite(errors[order]) else None,
        )  # fmt: skip
    alpha = fine.pressure_angle / DEGREE
    top, bottom = int(np.argmax(alpha)), int(np.argmin(alpha))
    yield bodies.ReadPeak(
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


@dataclass(frozen=True, eq=False)
class FittedMotion:
    """The motion of the follower, 0 at its lowest, and the spline that it is [mm over rad].

    ``lowest``: position there; ``off``: largest distance of the spline from the positions [mm];
    ``smooth``: whether the velocity is continuous, as no hollow is spanned.
    """

    motion: Motion
    spline: PeriodicSpline
    lowest: float
    off: float
    smooth: bool


def fit_motion(path: FollowerPath, tolerance: float) -> FittedMotion:
    """The spline with the fewest even knots within a tolerance of all positions [mm].

    Where the follower touches both sides of a hollow its velocity jumps, and the spline may have a
    kink.
    """
    angles = np.array([math.radians(hollow.angle_deg) for hollow in path.hollows])
    kinks = np.unique(np.round(angles, 6))
    kinks = kinks[kinks < FULL_TURN]
    for count in KNOT_COUNTS:
        # Even knots, the first at 0; a kink is a knot of multiplicity p (C0) in place of near ones.
        even = FULL_TURN * np.arange(count) / count
        distance = np.abs(even[:, None] - kinks)
        nearest = np.minimum(distance, FULL_TURN - distance).min(axis=1, initial=FULL_TURN)
        smooth = (nearest > KINK_CLEARANCE * FULL_TURN / count) | (even == 0.0)
        knots = np.sort(np.concatenate([even[smooth], np.repeat(kinks, SPLINE_DEGREE)]))
        spline, residual = fit_least_squares(knots, FULL_TURN, path.theta, path.position[:, None])
        off = float(np.max(np.abs(residual)))
        if off <= tolerance or len(path.theta) < DATA_PER_KNOT * count:
            break
    curve = spline.piecewise()
    lowest = -maximise(curve, (-1.0,))[0]
    poly = curve.poly.copy()
    poly[:, 0] -= lowest
    # The basis functions sum to 1, so that coefficients shift the spline.
    level = replace(spline, coefficients=spline.coefficients - lowest)
    motion = Motion((), replace(curve, poly=poly))
    return FittedMotion(motion, level, lowest, off, len(kinks) == 0)


def derivative_uncertainty(curve: Piecewise, error: float) -> tuple[float, ...]:
    """Largest errors of s', s'', s''' that an error of s allows [per radian].

    Landau–Kolmogorov inequality on the line: ‖f⁽ᵏ⁾‖ ≤ K ‖f‖^{1−k/n} ‖f⁽ⁿ⁾‖^{k/n} with
    K = a_{n−k}/a_n^{1−k/n}, a_j the Favard constants (Kolmogorov 1939); here n = 4, f the
    difference of two motions whose fourth derivatives are no larger than the curve's.
    """
    fourth = [maximise(curve, (0.0, 0.0, 0.0, 0.0, sign))[0] for sign in (1.0, -1.0)]
    most, n = 2.0 * max(fourth), 4
    return tuple(
        FAVARD[n - k] / FAVARD[n] ** (1.0 - k / n) * error ** (1.0 - k / n) * most ** (k / n)
        for k in range(1, n)
    )


def find_dwells(motion: Motion, tolerance: float) -> list[tuple[float, float, float]]:
    """Longest arcs of at least 4° along which s varies by at most twice a tolerance.

    Start [rad], length [rad] and mean of s [mm] of each, in the order of the cam angle.
    """
    count, step = DWELL_ANGLES, FULL_TURN / DWELL_ANGLES
    s = motion.derivatives(step * np.arange(count), 0)[0]
    if float(np.ptp(s)) <= 2.0 * tolerance:
        return [(0.0, FULL_TURN, float(np.mean(s)))]
    reach = _longest_runs(np.tile(s, 2), 2.0 * tolerance)[:count]
    dwells: list[tuple[float, float, float]] = []
    used = np.zeros(count, dtype=bool)
    for i in np.argsort(-reach, kind="stable"):
        if reach[i] * step < SHORTEST_DWELL:
            break
        arc = (i + np.arange(reach[i] + 1)) % count
        if not used[arc].any():
            used[arc] = True
            dwells.append((i * step, float(reach[i] * step), float(np.mean(s[arc]))))
    return sorted(dwells)


def _longest_runs(s: Array, width: float) -> Indices:
    """(n,) number of following samples that stay within a width, by doubling."""
    # Extremes of 2^k samples from each one on.
    lows, highs = [s], [s]
    while 2 ** len(lows) <= len(s):
        half = 2 ** (len(lows) - 1)
        lows.append(np.minimum(lows[-1][:-half], lows[-1][half:]))
        highs.append(np.maximum(highs[-1][:-half], highs[-1][half:]))
    # Runs grow by the largest powers of two that keep them within the width.
    low, high, end = s, s, np.arange(len(s)) + 1
    for k in reversed(range(len(lows))):
        at = np.where(end + 2**k <= len(s), end, 0)
        lower, upper = np.minimum(low, lows[k][at]), np.maximum(high, highs[k][at])
        grows = (at > 0) & (upper - lower <= width)
        low, high = np.where(grows, lower, low), np.where(grows, upper, high)
        end = end + 2**k * grows
    return end - 1 - np.arange(len(s))
