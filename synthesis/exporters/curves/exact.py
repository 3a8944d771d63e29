"""A curve of a cam as a B-spline within a tolerance of the true curve; and as JSON.

Every curve lies at a constant distance g inwards from the traced curve p, which a roller's centre
or a face's point of contact draws: q = p − g n. With the curvature κ and the speed v of p it runs
at the speed v (1 − κ g) and has the curvature κ / (1 − κ g), so that no derivative of the motion is
needed that jumps where the law does. Where that speed turns negative the curve runs backwards: the
cam is undercut there, or the cutter does not fit its hollow.

Where the velocity jumps, so does the common normal, or a face's point of contact. The roller then
turns about its centre, which stands still, and the curve goes on along an arc about it; along a
face it goes on straight.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from synthesis.catalogue.profile import CamProfile
from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.exporter import FileContent, compact_json, design_format
from synthesis.exporters.options import CurveName, PlacedCurve
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.cutting import checked_cam
from synthesis.exporters.samples.sampling import nearby, rotate
from synthesis.exporters.tables import origin
from synthesis.numerics.geometry.closed_curve import ClosedCurve, CurvePoints
from synthesis.numerics.geometry.closed_spline import ClosedSpline, fit_closed_spline
from synthesis.numerics.piecewise import Array, Indices
from synthesis.units import DEGREE, FULL_TURN

SPACING = 2.0 * DEGREE  # of the angles at which the way forward is looked at, at most
BACKWARDS = 1e-9  # of the curve's size per radian: rounding
SAME_PLACE = 1e-11  # relative to the curve's size: rounding
SHARP = 1e300  # curvature of a cusp, if not infinite


@dataclass(frozen=True, eq=False)
class Bridge:
    """An arc, or a straight line, from where a curve stops to where it goes on.

    Attributes:
        start, end: (2,) [mm]. tangent: (2,) at the start.
        sweep: how far it turns, left positive [rad]; 0 where it is straight.
    """

    start: Array
    end: Array
    tangent: Array
    sweep: float

    @property
    def length(self) -> float:
        """Arc length [mm]."""
        chord = float(np.hypot(*(self.end - self.start)))
        half = 0.5 * abs(self.sweep)
        return chord if half == 0.0 else chord * half / float(np.sin(half))

    def course(self, fraction: Array) -> CurvePoints:
        """As for a ``ClosedCurve``."""
        turn = self.sweep * fraction
        cos, sin = np.cos(turn), np.sin(turn)
        tx, ty = self.tangent
        tangent = np.column_stack([cos * tx - sin * ty, sin * tx + cos * ty])
        bend = self.sweep / self.length
        if self.sweep == 0.0:
            points = self.start + np.outer(fraction, self.end - self.start)
        else:
            way = [sin * tx - (1.0 - cos) * ty, (1.0 - cos) * tx + sin * ty]
            points = self.start + np.column_stack(way) / bend
        full = np.full(len(fraction), 1.0)
        return CurvePoints(points, tangent, bend * full, self.length * full)


@dataclass(frozen=True, eq=False)
class Contour(ClosedCurve):
    """A cam's curve in the order of rising cam angle, from the cam's seam.

    Attributes:
        cam: the cam, with the curve that is meant.
        start, end: (m,) cam angles of each span [rad], within one turn from 0 to 2π.
        bridges: spans that stand still, by their number.
    """

    cam: Cam
    start: Array
    end: Array
    bridges: dict[int, Bridge]

    @classmethod
    def of(cls, cam: Cam, every: bool = True) -> Contour:
        """The contour of a cam; InputError where it runs backwards.

        ``every``: each piece of the motion is a span; otherwise they end where curvature jumps.
        """
        breaks = cam.motion.curve.breaks
        if not every:
            breaks = np.union1d(cam.joints.breaking(2), breaks[[0, -1]])
        seam = nearby(breaks, cam.seam)
        marks = np.union1d(breaks, [seam % FULL_TURN])
        first = int(np.searchsorted(marks, seam % FULL_TURN))
        start, end = np.roll(marks[:-1], -first), np.roll(marks[1:], -first)
        plain = cls(cam, start, end, {})
        plain._check()
        return plain._bridged()

    @property
    def span_sizes(self) -> Array:
        sizes = self.end - self.start
        for index, bridge in self.bridges.items():
            sizes[index] = abs(bridge.sweep)
        return sizes

    def at(self, span: Indices, fraction: Array) -> CurvePoints:
        start, width = self.start[span], (self.end - self.start)[span]
        theta = np.where(fraction == 1.0, self.end[span], start + width * fraction)
        cam = self.cam
        at = cam.at(theta, fraction == 1.0)
        forward, mirror = self._forward(at), -1.0 if cam.rotation == "cw" else 1.0
        with np.errstate(divide="ignore", over="ignore"):
            bend = -mirror * np.clip(at.curvature, -SHARP, SHARP) / forward
        tangent = mirror * np.column_stack([at.normal_y, -at.normal_x])
        speed = width * np.maximum(at.speed * forward, 0.0)
        course = CurvePoints(np.column_stack(cam.place(at)), tangent, bend, speed)
        for index, bridge in self.bridges.items():
            mine = span == index
            own = bridge.course(fraction[mine])
            course.points[mine], course.tangent[mine] = own.points, own.tangent
            course.curvature[mine], course.speed[mine] = own.curvature, own.speed
        return course

    def _forward(self, at: CamProfile) -> Array:
        """Speed of the curve over that of the traced one, 1 − κ g, (n,)."""
        return 1.0 - self.cam.gap * np.clip(at.curvature, -SHARP, SHARP)

    def _check(self) -> None:
        """Refuse a curve that runs backwards."""
        width = self.end - self.start
        each = np.maximum(2, np.ceil(width / SPACING)).astype(np.intp)
        parts = [
            np.linspace(a, b, 8 * int(n) + 1)
            for a, b, n in zip(self.start, self.end, each, strict=True)
        ]
        theta = np.concatenate(parts)
        left = np.concatenate([np.arange(len(part)) == len(part) - 1 for part in parts])
        at = self.cam.at(theta, left)
        speed = at.speed * self._forward(at)
        size = float(np.max(np.abs(speed)))
        worst = int(np.argmin(speed))
        if speed[worst] < -BACKWARDS * size:
            raise _runs_back(self.cam, float(theta[worst]))

    def _bridged(self) -> Contour:
        """The same with a bridge wherever the curve stops and goes on elsewhere."""
        count = len(self.start)
        ends, starts = (self.at(np.arange(count), np.full(count, end)) for end in (1.0, 0.0))
        size = float(np.max(np.abs(ends.points)))
        start, end, bridges = [], [], {}
        for k, after in enumerate(np.roll(np.arange(count), -1)):
            start.append(self.start[k])
            end.append(self.end[k])
            step = starts.points[after] - ends.points[k]
            if np.hypot(*step) > SAME_PLACE * size:
                (ax, ay), (bx, by) = before, behind = ends.tangent[k], starts.tangent[after]
                if float(step @ (before + behind)) < 0.0:
                    raise _runs_back(self.cam, float(self.end[k]))
                sweep = float(np.arctan2(ax * by - ay * bx, ax * bx + ay * by))
                place = ends.points[k], starts.points[after]
                bridges[len(start)] = Bridge(*place, before, sweep)
                start.append(self.end[k])
                end.append(self.end[k])
        return Contour(self.cam, np.array(start), np.array(end), bridges)


def _runs_back(cam: Cam, theta: float) -> InputError:
    return InputError(
        "/curve", f"{theta / DEGREE:.6g}°",
        "At this cam angle the curve would run backwards: the cam is undercut there, or the "
        "cutter does not fit into its hollow. A curve that crosses itself is no outline.",
        "Limit profile_radius or cutter_radius and size the cam again, take a smaller cutter, or "
        "take the points as txt or csv, which show it as it is.",
    )  # fmt: skip


MIN_ERROR_UM = 1e-6  # finest tolerance: rounding of coordinates is not much smaller
FINEST = 1e-7  # smallest distance that a reader may have to tell apart [mm]; kernels cannot below
MEANING = (
    "A clamped B-spline in the cam's frame, no weights: its parameter is the arc length in mm, its "
    "last control point is its first. Inner knots stand once where it has four continuous "
    "derivatives, three times where curvature is continuous, four times where curvature jumps, "
    "five times at a corner. error_mm is the largest distance from the true curve, along its "
    "normal, measured on every piece."
)


@dataclass(frozen=True, kw_only=True)
class ExactOptions(PlacedCurve):
    """Which curve, and how near to the true one.

    Attributes:
        tolerance_um: largest distance from the true curve, along its normal [µm].
        the rest as of ``PlacedCurve``.
    """

    tolerance_um: Annotated[float, Field(ge=MIN_ERROR_UM, le=1e3)] = 1e-3
    """Largest distance of the spline from the true curve, along its normal [µm]. What is reached is
    reported in the header Camwright-Curve-Error-Mm."""

    @property
    def tolerance_mm(self) -> float:
        """The tolerance [mm]."""
        return 1e-3 * self.tolerance_um


@dataclass(frozen=True, eq=False)
class ExactCurve:
    """A closed curve for CAD: its name, its spline in place, and z along the axis [mm]."""

    name: CurveName
    spline: ClosedSpline
    z: float

    @classmethod
    def of(cls, design: Design, options: ExactOptions) -> ExactCurve:
        """The curve that the options name.

        InputError: there is no cam, no such curve, it crosses itself, the tolerance is too fine.
        """
        spline = fit_closed_spline(Contour.of(checked_cam(design, options)), options.tolerance_mm)
        x, y = rotate(options.turn_deg, *spline.points.T)
        placed = replace(spline, points=np.column_stack([x, y]))
        return cls(options.curve, placed, options.z_mm or 0.0)

    @property
    def points(self) -> Array:
        """Control points (n, 3) [mm]."""
        plane = self.spline.points
        return np.column_stack([plane, np.full(len(plane), self.z)]) + 0.0  # no −0

    @property
    def knots(self) -> tuple[Array, NDArray[np.intp]]:
        """Knots, each once [mm], and how often each stands there."""
        knots, times = np.unique(self.spline.knots, return_counts=True)
        return knots, times

    def file(self, data: bytes) -> FileContent:
        """A file of the curve, with how true it is and how large."""
        error, count = f"{self.spline.error:.3g}", str(len(self.spline.points))
        return FileContent(data, {"Curve-Error-Mm": error, "Curve-Control-Points": count})


def _json(design: Design, options: ExactOptions) -> FileContent:
    curve = ExactCurve.of(design, options)
    spline = curve.spline
    body = {
        "kind": "exact_curve",
        "curve": curve.name,
        "meaning": MEANING,
        "design": origin(design),
        "tolerance_mm": options.tolerance_mm,
        "error_mm": spline.error,
        "length_mm": spline.length,
        "enclosed_area_mm2": spline.area,
        "nodes": spline.nodes,
        "turn_deg": options.turn_deg,
        "degree": spline.degree,
        "closed": True,
        "rational": False,
        "knots_mm": spline.knots.tolist(),
        "control_points_mm": curve.points.tolist(),
    }
    return curve.file(compact_json(body) + b"\n")


NURBS_JSON = design_format("profile", "nurbs.json", _json, ExactOptions)
