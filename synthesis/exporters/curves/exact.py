"""A curve of a cam as a B-spline within a tolerance of the true curve, placed; and as JSON."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from synthesis.design.design import Design
from synthesis.exporters.curves.contour import Contour
from synthesis.exporters.exporter import Exporter, FileContent, compact_json
from synthesis.exporters.options import CurveName, PlacedCurve
from synthesis.exporters.samples.cutting import checked_cam
from synthesis.exporters.samples.sampling import rotate
from synthesis.exporters.tables.formats import origin
from synthesis.numerics.geometry.closed_spline import ClosedSpline, fit_closed_spline
from synthesis.numerics.piecewise import Array

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

    tolerance_um: Annotated[
        float,
        Field(
            ge=MIN_ERROR_UM,
            le=1e3,
            description="Largest distance of the spline from the true curve, along its normal "
            "[µm]. What is reached is told in the header Camwright-Curve-Error-Mm.",
        ),
    ] = 1e-3

    @property
    def tolerance_mm(self) -> float:
        """The tolerance [mm]."""
        return 1e-3 * self.tolerance_um


@dataclass(frozen=True, eq=False)
class ExactCurve:
    """A closed curve for CAD.

    Attributes:
        name: of the curve. spline: in its place. z: position along the axis [mm].
    """

    name: CurveName
    spline: ClosedSpline
    z: float

    @classmethod
    def of(cls, design: Design, options: ExactOptions) -> ExactCurve:
        """The curve that the options name.

        Raises:
            InputError: there is no cam, no such curve, it crosses itself, or the tolerance is too
                fine.
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


NURBS_JSON = Exporter(
    "nurbs.json", "Exact curve as B-spline", "application/json", ".nurbs.json", _json, ExactOptions,
    "Degree, knots and control points of the exact curve, for programs: with its error, length and "
    "the area it encloses.",
    by_default=False,
)  # fmt: skip
