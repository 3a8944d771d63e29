"""Curves of a cam as B-splines within a stated distance of the true curve, placed as asked."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synthesis.design.design import Design
from synthesis.exporters.curves.contour import Contour
from synthesis.exporters.curves.exact_options import ExactOptions
from synthesis.exporters.options import CurveName
from synthesis.exporters.samples.cutting import chosen
from synthesis.exporters.samples.sampling import turned
from synthesis.numerics.geometry.closed_spline import ClosedSpline, fit_closed_spline
from synthesis.numerics.piecewise import Array


@dataclass(frozen=True, eq=False)
class ExactCurve:
    """A closed curve for CAD.

    Attributes:
        name: of the curve. spline: in its place. z: position along the axis [mm].
    """

    name: CurveName
    spline: ClosedSpline
    z: float

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


def exact_curve(design: Design, options: ExactOptions) -> ExactCurve:
    """The curve that is asked for.

    Raises:
        InputError: there is no cam, no such curve, it crosses itself, or the tolerance is too fine.
    """
    spline = fit_closed_spline(Contour.of(chosen(design, options)), options.tolerance_mm)
    x, y = turned(options.turn_deg, *spline.points.T)
    placed = replace(spline, points=np.column_stack([x, y]))
    return ExactCurve(options.curve, placed, options.z_mm or 0.0)


def facts(curve: ExactCurve) -> dict[str, str]:
    """What is told beside the file: how true it is, and how large."""
    spline = curve.spline
    return {
        "Curve-Error-Mm": f"{spline.error:.3g}",
        "Curve-Control-Points": str(len(spline.points)),
    }
